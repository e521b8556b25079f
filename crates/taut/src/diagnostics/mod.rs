//! How the cloth is doing: a glance after every step, a full examination on demand.

mod grid;
mod tension;

use std::ops::Range;

use glam::{DVec3, Vec3};
use pulp::{Simd, WithSimd};

use crate::filter::Limited;
use crate::forces::{bending_energy, curved_energy, elastic_energy};
pub use crate::geometry::Times;
use crate::geometry::{CHUNK, Pool, Vectors, arch, for_each_piece, items, sum_of_runs};
use crate::inputs::Inputs;
use crate::model::{ClothRange, Model};
use crate::state::{State, longest_of, measure_squares};
use grid::{Band, GridSprings};
pub use tension::tensions;

/// What a step did.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StepReport {
    /// How often the integrator looked at all springs.
    pub evaluations: u32,
    /// What the filter did.
    pub limited: Limited,
    /// The momentum that rounding took from free cloths, and that was given back [kg m/s].
    pub repaired: DVec3,
    /// Whether contact had it taken in more parts than the speed of bodies asks for: 1, or 0.
    pub halved: u32,
    /// How fast the fastest particle went [m/s]; zero where nothing is to sleep.
    pub fastest: f32,
    /// Whether nothing was done, as everything sleeps.
    pub asleep: bool,
    /// What its filter spent its time on, in parts that were given up, too.
    pub times: Times,
}

impl StepReport {
    /// What two parts of a step did.
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            evaluations: self.evaluations + other.evaluations,
            limited: self.limited.and(other.limited),
            repaired: self.repaired + other.repaired,
            halved: self.halved.max(other.halved),
            fastest: self.fastest.max(other.fastest),
            asleep: self.asleep && other.asleep,
            times: self.times.and(other.times),
        }
    }
}

/// What is seen of a state at a glance.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Glance {
    /// Largest |X_uv| / L - 1 over the type 1 springs [1]; 0 if there are none.
    pub worst_stretch: f64,
    /// The spring that has it.
    pub worst_spring: Option<u32>,
    /// Whether every particle is at a finite place.
    pub finite: bool,
}

/// A state, examined.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StateReport {
    /// Largest |X_uv| / L - 1 over the type 1 springs [1]; 0 if there are none.
    pub worst_stretch: f64,
    /// The spring that has it.
    pub worst_spring: Option<u32>,
    /// Sum of M V^2 / 2 over the free particles [J].
    pub kinetic_energy: f64,
    /// Sum of k_s (|X_uv| - L)^2 / 2 over the springs, and the energy of bending [J].
    pub elastic_energy: f64,
    /// Sum of -M g.X over the free particles, relative to the origin [J].
    pub potential_energy: f64,
    /// The first particle with a coordinate or velocity that is not a finite number.
    pub non_finite: Option<u32>,
}

/// A velocity that is not finite has made its position so in the same step.
fn all_finite(positions: &Vectors, pool: &Pool) -> bool {
    let finite = |run: &[f32]| arch().dispatch(AllFinite(run));
    [&positions.x, &positions.y, &positions.z].into_iter().all(|column| sum_of_runs(column, pool, true, finite, |a, b| a && b))
}

struct AllFinite<'a>(&'a [f32]);

impl WithSimd for AllFinite<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        const EXPONENT: u32 = 0x7f80_0000;
        let wrong = self.0.iter().fold(0, |wrong, value| wrong | u32::from(value.to_bits() & EXPONENT == EXPONENT));
        wrong == 0
    }
}

/// Workspace: a partial result for every part, combined in their order.
#[derive(Debug)]
pub struct Diagnostics {
    grids: Vec<GridSprings>,
    bands: Vec<Band>,
    /// Springs that are in no grid.
    chunks: Vec<(Range<usize>, SpringPart)>,
    particles: Vec<ParticlePart>,
    /// Of each cloth what is not held [kg].
    free_mass: Vec<f64>,
}

#[derive(Debug, Clone, Copy, Default)]
struct SpringPart {
    /// Largest (|X_uv| / L)^2 and its spring.
    worst: f32,
    spring: u32,
    elastic: f64,
}

#[derive(Debug, Clone, Copy, Default)]
struct ParticlePart {
    kinetic: f64,
    potential: f64,
    /// Of springs that follow curves, and of bending.
    elastic: f64,
    non_finite: Option<u32>,
}

impl Diagnostics {
    /// Workspace for a model.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        let of_grids = model.cloths.iter().filter_map(|cloth| Some((cloth, cloth.lattice?)));
        let grids: Vec<_> = of_grids.clone().map(|(cloth, lattice)| GridSprings::new(model, cloth, lattice)).collect();
        let ends = of_grids.clone().map(|(cloth, _)| cloth.springs.end);
        let begins = of_grids.map(|(cloth, _)| cloth.springs.start).chain([model.springs.len()]);
        let others = std::iter::once(0).chain(ends).zip(begins).map(|(start, end)| start..end);
        let chunks = |run: Range<usize>| {
            let chunk = move |first| (first..run.end.min(first + CHUNK), SpringPart::default());
            run.clone().step_by(CHUNK).map(chunk).collect::<Vec<_>>()
        };
        Self {
            bands: grids.iter().enumerate().flat_map(|(index, grid)| grid.bands(model, index)).collect(),
            chunks: others.flat_map(chunks).collect(),
            grids,
            free_mass: model.cloths.iter().map(|cloth| free_mass(model, cloth)).collect(),
            particles: vec![ParticlePart::default(); model.particle_count().div_ceil(CHUNK)],
        }
    }
}

/// A glance between two steps: the springs alone, and no energies but where they cost nothing.
pub fn glance(model: &Model, state: &State, diagnostics: &mut Diagnostics, pool: &Pool) -> Glance {
    let (worst_stretch, worst_spring) = diagnostics.measure(model, state, false, pool);
    Glance { worst_stretch, worst_spring, finite: all_finite(&state.positions, pool) }
}

/// Examines a state.
pub fn inspect(model: &Model, state: &State, inputs: &Inputs, diagnostics: &mut Diagnostics, pool: &Pool) -> StateReport {
    let gravity = inputs.gravity.at(state.time()).as_vec3();
    let (worst_stretch, worst_spring) = diagnostics.measure(model, state, true, pool);
    let Diagnostics { bands, chunks, particles, free_mass, .. } = diagnostics;
    for_each_piece(items(particles), pool.pays_for(model.particle_count()), |chunk, part| {
        *part = particles_of(chunk, model, state, gravity)
    });
    let elastic_energy = bands.iter().map(|band| band.elastic).chain(chunks.iter().map(|(_, part)| part.elastic)).sum();
    let mut report = StateReport { worst_stretch, worst_spring, elastic_energy, ..StateReport::default() };
    for part in particles {
        report.kinetic_energy += part.kinetic;
        report.potential_energy += part.potential;
        report.elastic_energy += part.elastic;
        report.non_finite = report.non_finite.or(part.non_finite);
    }
    for (mass, origin) in free_mass.iter().zip(&state.origins) {
        report.potential_energy -= mass * gravity.as_dvec3().dot(*origin);
    }
    report
}

fn free_mass(model: &Model, cloth: &ClothRange) -> f64 {
    let masses = model.particles.mass[cloth.particles()].iter().zip(&model.particles.inverse_mass[cloth.particles()]);
    masses.filter(|(_, weight)| **weight > 0.0).map(|(mass, _)| f64::from(*mass)).sum()
}

impl Diagnostics {
    /// Measures all springs: the largest |X_uv| / L - 1 over those of type 1, and the spring that has it. Bands and chunks have their
    /// elastic energy after that, if it is asked for.
    fn measure(&mut self, model: &Model, state: &State, energies: bool, pool: &Pool) -> (f64, Option<u32>) {
        let Self { grids, bands, chunks, .. } = self;
        let spread = pool.pays_for(model.particle_count());
        for_each_piece(items(bands), spread, |_, band| grids[band.grid].examine(model, &state.positions, band));
        for_each_piece(items(chunks), spread, |_, (run, part)| *part = springs_of(run.clone(), model, state, energies));
        let mut worst = 0.0;
        let mut in_band = None;
        for band in &*bands {
            if band.worst > worst {
                worst = band.worst;
                in_band = Some(band);
            }
        }
        let mut spring = in_band.and_then(|band| grids[band.grid].find(model, &state.positions, band));
        for (_, part) in chunks {
            if part.worst > worst {
                worst = part.worst;
                spring = Some(part.spring);
            }
        }
        (if spring.is_some() { f64::from(worst).sqrt() - 1.0 } else { 0.0 }, spring)
    }
}

fn springs_of(run: Range<usize>, model: &Model, state: &State, energies: bool) -> SpringPart {
    let springs = &model.springs;
    let mut squares = [0.0; CHUNK];
    let squares = &mut squares[..run.len()];
    measure_squares(model, run.clone(), &state.positions, squares);
    let limited = run.end.min(springs.type1).saturating_sub(run.start);
    let (worst, place) = longest_of(&squares[..limited], &springs.rest[run.start..][..limited]).unwrap_or_default();
    let (stiffness, rest) = (&springs.stiffness[run.clone()], &springs.rest[run.clone()]);
    let elastic = if energies { arch().dispatch(Elastic { squares, stiffness, rest }) } else { 0.0 };
    SpringPart { worst, spring: (run.start + place) as u32, elastic }
}

/// So many sums go on side by side, whatever the length of the vector registers, so that bits do not depend on it.
const LANES: usize = 8;

/// The elastic energy of some springs [J].
struct Elastic<'a> {
    squares: &'a [f32],
    stiffness: &'a [f32],
    rest: &'a [f32],
}

impl WithSimd for Elastic<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let mut lanes = [0.0; LANES];
        let springs = self.stiffness.chunks(LANES).zip(self.rest.chunks(LANES));
        for (squares, (stiffness, rest)) in self.squares.chunks(LANES).zip(springs) {
            let values = squares.iter().zip(stiffness.iter().zip(rest));
            for (lane, (square, (stiffness, rest))) in lanes.iter_mut().zip(values) {
                *lane += elastic_energy(*stiffness, *rest, square.sqrt());
            }
        }
        lanes.iter().sum()
    }
}

fn particles_of(chunk: usize, model: &Model, state: &State, gravity: Vec3) -> ParticlePart {
    let run = chunk * CHUNK..model.particle_count().min((chunk + 1) * CHUNK);
    let finite = |particle: &usize| {
        [&state.positions, &state.velocities, state.of_motion()].iter().all(|of| of.get(*particle).is_finite())
    };
    let mut part = arch().dispatch(Energies { model, state, gravity, run: run.clone() });
    if !part.kinetic.is_finite() || !part.potential.is_finite() {
        part.non_finite = run.clone().find(|particle| !finite(particle)).map(|particle| particle as u32);
    }
    if !model.curved.links.is_empty() || !model.bending.is_empty() {
        let of = |particle| curved_energy(model, &state.positions, particle) + bending_energy(model, &state.positions, particle);
        part.elastic = run.map(of).sum();
    }
    part
}

/// The energies of some particles, but for that of springs and bending.
struct Energies<'a> {
    model: &'a Model,
    state: &'a State,
    gravity: Vec3,
    run: Range<usize>,
}

impl WithSimd for Energies<'_> {
    type Output = ParticlePart;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> ParticlePart {
        let Self { model, state, gravity, run } = self;
        let (positions, velocities) = (&state.positions, state.of_motion());
        let particles = &model.particles;
        let axes = [
            (&positions.x, &velocities.x, gravity.x),
            (&positions.y, &velocities.y, gravity.y),
            (&positions.z, &velocities.z, gravity.z),
        ];
        let mut part = ParticlePart::default();
        for (positions, velocities, gravity) in axes {
            let (mut kinetic, mut potential) = ([0.0; LANES], [0.0; LANES]);
            let states = positions[run.clone()].chunks(LANES).zip(velocities[run.clone()].chunks(LANES));
            let masses = particles.mass[run.clone()].chunks(LANES).zip(particles.inverse_mass[run.clone()].chunks(LANES));
            for ((positions, velocities), (masses, weights)) in states.zip(masses) {
                let lanes = kinetic.iter_mut().zip(&mut potential);
                let values = positions.iter().zip(velocities).zip(masses.iter().zip(weights));
                for ((kinetic, potential), ((x, v), (mass, weight))) in lanes.zip(values) {
                    // What is held has no energy, but must be somewhere.
                    let mass = if *weight > 0.0 { f64::from(*mass) } else { 0.0 };
                    *kinetic += 0.5 * mass * (f64::from(*v) * f64::from(*v));
                    *potential -= mass * f64::from(gravity) * f64::from(*x);
                }
            }
            part.kinetic += kinetic.iter().sum::<f64>();
            part.potential += potential.iter().sum::<f64>();
        }
        part
    }
}
