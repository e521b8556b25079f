//! Wind (paper, section 2.2), in the classical form on triangles (and whole cells of grids) and in the paper's cheaper
//! form on particles.
//!
//! Both act on the velocity relative to the moving air; see docs/equations.md, "Wind", for how the printed scalar formulas
//! are read. However long the step, the impulse only slows what moves against the air and never turns it round ("Steps that
//! are too long for the air").

use std::ops::Range;

use glam::{DVec3, Vec3, Vec4};
use pulp::{Simd, WithSimd};

use crate::geometry::{Pool, Vectors, VectorsChunk, arch, for_each_chunk, sine_of_turns};
use crate::inputs::{Air, OCTAVES, Wave};
use crate::model::{Model, Panels, Resistance};
use crate::scene::{WindLaw, WindModel};
use crate::schedule::Stride;
use crate::state::Moment;

/// What two first passes leave for the particles to gather; empty before there is wind.
#[derive(Debug, Default)]
pub(super) struct Wind {
    /// Velocity of each particle relative to the air around it [m/s].
    relative: Vectors,
    /// A corner's share of each panel: of its area vector [m^2] in the particle form, of its force [N] in the triangle form; and how
    /// long that is.
    panels: Vec<Vec4>,
    /// Phase of each gust wave at the origin of a cloth and the time of the step [turns].
    phases: [f32; OCTAVES],
    /// What gives way to an impulse on each panel [kg]; infinite where all corners are held.
    inertia: Vec<f32>,
    /// Which lines of [`LANES`] panels have corners that stand side by side, as in a row of a grid ..
    panels_in_row: Vec<bool>,
    /// .. and which lines of particles have four panels each that do.
    particles_in_row: Vec<bool>,
}

impl Wind {
    fn new(model: &Model) -> Self {
        let (particles, panels) = (model.particle_count(), model.panels.corners.len());
        let Panels { corners, around, .. } = &*model.panels;
        Self {
            relative: Vectors::zeros(particles),
            panels: vec![Vec4::ZERO; panels],
            phases: [0.0; OCTAVES],
            inertia: (0..panels).map(|panel| inertia_of_panel(model, panel)).collect(),
            panels_in_row: lines_in_row(panels, |panel| Some(corners[panel])),
            particles_in_row: lines_in_row(particles, |particle| around.of(particle).try_into().ok()),
        }
    }

    /// First passes: the relative velocities, then a value for each panel.
    pub(super) fn prepare(&mut self, stride: Stride<'_>, moment: Moment<'_>, pool: &Pool) {
        let (model, Some(air)) = (stride.model, &stride.inputs.air) else { return };
        if self.relative.is_empty() {
            *self = Self::new(model);
        }
        let strength = air.gusts(moment.time);
        for (cloth, &origin) in model.cloths.iter().zip(moment.origins) {
            for (phase, wave) in self.phases.iter_mut().zip(&air.waves) {
                let here = wave.turns_per_metre.as_dvec3().dot(origin);
                *phase = (wave.phase + here - wave.turns_per_second * moment.time).rem_euclid(1.0) as f32;
            }
            let gusts = Gusts { waves: &air.waves, phases: &self.phases, strength };
            let each = |mut chunk: VectorsChunk<'_>| relative_velocity(&mut chunk, air, gusts, origin, moment);
            self.relative.for_each_chunk_of(cloth.particles(), pool, each);
        }
        let mut panels = std::mem::take(&mut self.panels);
        for_each_chunk(&mut panels, pool, |first, shares| {
            arch().dispatch(OfPanels { stride, air, positions: moment.positions, wind: self, first, shares });
        });
        self.panels = panels;
    }

    /// Second pass: adds what the wind does to some particles, F_W / M [m/s^2].
    pub(super) fn accelerate(&self, stride: Stride<'_>, chunk: &mut VectorsChunk<'_>) {
        if let Some(air) = &stride.inputs.air {
            arch().dispatch(OnParticles { stride, air, wind: self, chunk });
        }
    }

    /// A field at the corners of some panels, a line of them at most: coordinate by coordinate, corner by corner.
    #[inline(always)]
    fn corners(&self, model: &Model, panels: Range<usize>, field: &Vectors) -> [[Lanes; 4]; 3] {
        let corners = &model.panels.corners[panels.clone()];
        let in_row = self.panels_in_row.get(panels.start / LANES) == Some(&true);
        let mut found = [[[0.0; LANES]; 4]; 3];
        for (found, column) in found.iter_mut().zip([&field.x, &field.y, &field.z]) {
            if in_row {
                for (lanes, corner) in found.iter_mut().zip(corners[0]) {
                    lanes.copy_from_slice(&column[corner as usize..][..LANES]);
                }
            } else {
                for (lane, corners) in corners.iter().enumerate() {
                    for (lanes, corner) in found.iter_mut().zip(corners) {
                        lanes[lane] = column[*corner as usize];
                    }
                }
            }
        }
        found
    }

    /// Sums over the panels around some particles, a line of them at most, coordinate by coordinate.
    #[inline(always)]
    fn around(&self, model: &Model, particles: Range<usize>) -> [Lanes; 4] {
        let around = &model.panels.around;
        let in_row = particles.start.is_multiple_of(LANES) && self.particles_in_row.get(particles.start / LANES) == Some(&true);
        let mut sums = [Vec4::ZERO; LANES];
        if in_row {
            for &panel in around.of(particles.start) {
                for (sum, share) in sums.iter_mut().zip(&self.panels[panel as usize..][..LANES]) {
                    *sum += *share;
                }
            }
        } else {
            for (sum, particle) in sums.iter_mut().zip(particles) {
                *sum = around.of(particle).iter().map(|&panel| self.panels[panel as usize]).sum();
            }
        }
        let mut columns = [[0.0; LANES]; 4];
        for (lane, sum) in sums.iter().enumerate() {
            (columns[0][lane], columns[1][lane], columns[2][lane], columns[3][lane]) = (sum.x, sum.y, sum.z, sum.w);
        }
        columns
    }
}

/// Which lines of [`LANES`] items have four numbers each of which grows by one from item to item.
fn lines_in_row(items: usize, numbers: impl Fn(usize) -> Option<[u32; 4]>) -> Vec<bool> {
    let follows =
        |item: usize| matches!((numbers(item - 1), numbers(item)), (Some(one), Some(next)) if one.map(|one| one + 1) == next);
    (0..items / LANES).map(|line| (line * LANES + 1..(line + 1) * LANES).all(follows)).collect()
}

/// The wind force [N] on an area [m^2] whose velocity relative to the air is V_rel. `most` is the inertia that it acts on over
/// the length of the step [kg/s].
#[inline(always)]
fn force(air: &Air, law: WindLaw, resistance: &Resistance, relative: Vec3, normal: Vec3, area: f32, most: f32) -> Vec3 {
    let across = match law {
        WindLaw::Pressure => pressure(relative, normal, area, air.density * resistance.drag, most),
        WindLaw::DragLift => drag_and_lift(relative, normal, 0.5 * air.density * area, resistance, most),
    };
    across + friction(relative, normal, 0.5 * air.density * resistance.friction * area, most)
}

/// `F_W = -1/2 rho C_d A |V_rel| (V_rel . N) N` (paper, section 2.2).
#[inline(always)]
fn pressure(relative: Vec3, normal: Vec3, area: f32, density_drag: f32, most: f32) -> Vec3 {
    normal * (-least(0.5 * density_drag * area * relative.length(), most) * relative.dot(normal))
}

/// Drag and lift of Keckeisen et al. 2004, with `V_n = (V_rel . N) N`. Drag acts against V_rel on the area that the flow sees,
/// `-1/2 rho C_d A |V_n| V_rel`. Lift acts at right angles to V_rel in its plane with the normal,
/// `-1/2 rho C_l A |V_rel| (V_n - |V_n|^2 / |V_rel|^2 V_rel)`.
#[inline(always)]
fn drag_and_lift(relative: Vec3, normal: Vec3, factor: f32, resistance: &Resistance, most: f32) -> Vec3 {
    let square = relative.length_squared();
    let speed = square.sqrt();
    let factor = least(factor, most / (speed * (resistance.drag + resistance.lift)));
    let across = relative.dot(normal);
    // Where nothing moves against the air, that is 0 / 0 without the floor.
    let lift =
        normal * across - relative * (across * across / if square > f32::MIN_POSITIVE { square } else { f32::MIN_POSITIVE });
    relative * (-factor * resistance.drag * across.abs()) - lift * (factor * resistance.lift * speed)
}

/// Skin friction `-1/2 rho C_f A |V_rel| V_t` along the cloth, `V_t = V_rel - (V_rel . N) N`.
#[inline(always)]
fn friction(relative: Vec3, normal: Vec3, factor: f32, most: f32) -> Vec3 {
    (relative - normal * relative.dot(normal)) * -least(factor * relative.length(), most)
}

/// The smaller one; `most` if that cannot be told. One instruction in vector registers, as `f32::min` is not.
#[inline(always)]
fn least(value: f32, most: f32) -> f32 {
    if value < most { value } else { most }
}

/// `1 / m = sum of (share^2 n / M)` over the corners, n being the number of panels around each.
fn inertia_of_panel(model: &Model, panel: usize) -> f32 {
    let corners = model.panels.corners[panel];
    let distinct = if corners[2] == corners[3] { &corners[..3] } else { &corners[..] };
    let share = model.panels.share[panel];
    let give = |&corner: &u32| {
        let corner = corner as usize;
        share * share * model.panels.around.of(corner).len() as f32 * model.particles.inverse_mass[corner]
    };
    1.0 / distinct.iter().map(give).sum::<f32>()
}

/// The gusts at one moment.
#[derive(Clone, Copy)]
struct Gusts<'a> {
    waves: &'a [Wave],
    /// [turns]
    phases: &'a [f32],
    /// The part of their amplitudes that they have [1].
    strength: f32,
}

/// V_rel = V - W(X), W being the mean wind, the gusts and the flows.
fn relative_velocity(chunk: &mut VectorsChunk<'_>, air: &Air, gusts: Gusts<'_>, origin: DVec3, moment: Moment<'_>) {
    let run = chunk.first..chunk.first + chunk.x.len();
    let (mean, len) = (air.velocity(moment.time), run.len());
    let (out_x, out_y, out_z) = (&mut chunk.x[..len], &mut chunk.y[..len], &mut chunk.z[..len]);
    let [x, y, z] = [&moment.positions.x, &moment.positions.y, &moment.positions.z].map(|column| &column[run.clone()]);
    let [u, v, w] = [&moment.velocities.x, &moment.velocities.y, &moment.velocities.z].map(|column| &column[run.clone()]);
    for (out, velocity, mean) in [(&mut *out_x, u, mean.x), (&mut *out_y, v, mean.y), (&mut *out_z, w, mean.z)] {
        out.iter_mut().zip(velocity).for_each(|(out, velocity)| *out = velocity - mean);
    }
    arch().dispatch(TakeAir { air, gusts, origin, x, y, z, out: [out_x, out_y, out_z] });
}

/// V_rel -= V of the gusts and the flows.
struct TakeAir<'a> {
    air: &'a Air,
    gusts: Gusts<'a>,
    origin: DVec3,
    x: &'a [f32],
    y: &'a [f32],
    z: &'a [f32],
    out: [&'a mut [f32]; 3],
}

impl WithSimd for TakeAir<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { air, gusts: Gusts { waves, phases, strength }, origin, x, y, z, out: [u, v, w] } = self;
        for (Wave { amplitude, turns_per_metre, .. }, &phase) in waves.iter().zip(phases) {
            let amplitude = *amplitude * strength;
            take(x, y, z, [&mut *u, &mut *v, &mut *w], |[x, y, z]| {
                let sine = sine_of_turns(turns_per_metre.x * x + turns_per_metre.y * y + turns_per_metre.z * z + phase);
                [amplitude.x * sine, amplitude.y * sine, amplitude.z * sine]
            });
        }
        for vortex in &air.flows.vortices {
            let centre = (vortex.centre - origin).as_vec3();
            take(x, y, z, [&mut *u, &mut *v, &mut *w], |[x, y, z]| vortex.velocity([x - centre.x, y - centre.y, z - centre.z]));
        }
        for outflow in &air.flows.outflows {
            let centre = (outflow.centre - origin).as_vec3();
            take(x, y, z, [&mut *u, &mut *v, &mut *w], |[x, y, z]| outflow.velocity([x - centre.x, y - centre.y, z - centre.z]));
        }
    }
}

#[inline(always)]
fn take(x: &[f32], y: &[f32], z: &[f32], [u, v, w]: [&mut [f32]; 3], velocity: impl Fn([f32; 3]) -> [f32; 3]) {
    let len = x.len();
    let (y, z, u, v, w) = (&y[..len], &z[..len], &mut u[..len], &mut v[..len], &mut w[..len]);
    for i in 0..len {
        let air = velocity([x[i], y[i], z[i]]);
        (u[i], v[i], w[i]) = (u[i] - air[0], v[i] - air[1], w[i] - air[2]);
    }
}

/// So many panels, or particles, are looked at together.
const LANES: usize = 16;

/// A number of each of them.
type Lanes = [f32; LANES];

/// What some panels, or particles, put in the way of the wind.
#[derive(Default)]
struct Obstacles {
    /// Area vectors [m^2] ..
    vectors: [Lanes; 3],
    /// .. and areas [m^2]: of a panel the length of its vector, of a particle the sum of those around it.
    areas: Lanes,
    /// V_rel [m/s].
    relative: [Lanes; 3],
    resistance: [Resistance; LANES],
    /// [kg/s]
    most: Lanes,
}

impl Obstacles {
    /// The wind forces [N].
    #[inline(always)]
    fn forces(&self, air: &Air) -> [Lanes; 3] {
        // The laws are told apart out here, so that a loop has one of them.
        match air.law {
            WindLaw::Pressure => self.forces_by(air, WindLaw::Pressure),
            WindLaw::DragLift => self.forces_by(air, WindLaw::DragLift),
        }
    }

    #[inline(always)]
    fn forces_by(&self, air: &Air, law: WindLaw) -> [Lanes; 3] {
        let mut forces = [[0.0; LANES]; 3];
        for (lane, area) in self.areas.iter().enumerate() {
            let vector = Vec3::new(self.vectors[0][lane], self.vectors[1][lane], self.vectors[2][lane]);
            let length = vector.length();
            // Without an area, or where those of all panels around cancel, there is no normal, and no force.
            let normal = vector / if length > f32::MIN_POSITIVE { length } else { f32::MIN_POSITIVE };
            let relative = Vec3::new(self.relative[0][lane], self.relative[1][lane], self.relative[2][lane]);
            let force = force(air, law, &self.resistance[lane], relative, normal, *area, self.most[lane]);
            (forces[0][lane], forces[1][lane], forces[2][lane]) = (force.x, force.y, force.z);
        }
        forces
    }
}

/// What each corner gets of some panels: their area vectors [m^2] or the forces on them [N].
struct OfPanels<'a> {
    stride: Stride<'a>,
    air: &'a Air,
    positions: &'a Vectors,
    wind: &'a Wind,
    /// Of the panels from this one on.
    first: usize,
    shares: &'a mut [Vec4],
}

impl WithSimd for OfPanels<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { stride: Stride { model, plan, .. }, air, positions, wind, first, shares } = self;
        let per_step = 1.0 / plan.length as f32;
        let mut obstacles = Obstacles::default();
        let mut share_of = [0.0; LANES];
        for (line, shares) in shares.chunks_mut(LANES).enumerate() {
            let first = first + line * LANES;
            let panels = first..first + shares.len();
            share_of[..panels.len()].copy_from_slice(&model.panels.share[panels.clone()]);
            let Obstacles { vectors, areas, .. } = &mut obstacles;
            set_area_vectors(vectors, &wind.corners(model, panels.clone(), positions));
            for (lane, area) in areas.iter_mut().enumerate() {
                *area = Vec3::new(vectors[0][lane], vectors[1][lane], vectors[2][lane]).length();
            }
            let [x, y, z] = match air.model {
                WindModel::Particle => obstacles.vectors,
                WindModel::Triangle => {
                    let corners = wind.corners(model, panels.clone(), &wind.relative);
                    for (middle, [a, b, c, d]) in obstacles.relative.iter_mut().zip(&corners) {
                        for lane in 0..LANES {
                            // A triangle has its last corner twice; it counts once.
                            let last = if share_of[lane] > 0.25 { 0.0 } else { d[lane] };
                            middle[lane] = (a[lane] + b[lane] + c[lane] + last) * share_of[lane];
                        }
                    }
                    for (lane, panel) in panels.enumerate() {
                        obstacles.most[lane] = wind.inertia[panel] * per_step;
                        obstacles.resistance[lane] = model.particles.wind[model.panels.corners[panel][0] as usize];
                    }
                    obstacles.forces(air)
                }
            };
            for (lane, share) in shares.iter_mut().enumerate() {
                *share = Vec4::new(x[lane], y[lane], z[lane], obstacles.areas[lane]) * share_of[lane];
            }
        }
    }
}

/// Half the cross products of the diagonals.
#[inline(always)]
fn set_area_vectors(vectors: &mut [Lanes; 3], [x, y, z]: &[[Lanes; 4]; 3]) {
    for lane in 0..LANES {
        let diagonal = |from: usize| {
            let to = from + 2;
            Vec3::new(x[to][lane] - x[from][lane], y[to][lane] - y[from][lane], z[to][lane] - z[from][lane])
        };
        let vector = 0.5 * diagonal(0).cross(diagonal(1));
        (vectors[0][lane], vectors[1][lane], vectors[2][lane]) = (vector.x, vector.y, vector.z);
    }
}

/// What the wind does to some particles.
struct OnParticles<'a, 'b> {
    stride: Stride<'a>,
    air: &'a Air,
    wind: &'a Wind,
    chunk: &'a mut VectorsChunk<'b>,
}

impl WithSimd for OnParticles<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { stride: Stride { model, plan, .. }, air, wind, chunk: VectorsChunk { first, x, y, z } } = self;
        let per_step = 1.0 / plan.length as f32;
        let mut obstacles = Obstacles::default();
        let lines = x.chunks_mut(LANES).zip(y.chunks_mut(LANES)).zip(z.chunks_mut(LANES));
        for (line, ((x, y), z)) in lines.enumerate() {
            let first = *first + line * LANES;
            let particles = first..first + x.len();
            let [u, v, w, areas] = wind.around(model, particles.clone());
            let forces = match air.model {
                WindModel::Triangle => [u, v, w],
                WindModel::Particle => {
                    (obstacles.vectors, obstacles.areas) = ([u, v, w], areas);
                    let relative = [&wind.relative.x, &wind.relative.y, &wind.relative.z];
                    for (lanes, column) in obstacles.relative.iter_mut().zip(relative) {
                        lanes[..x.len()].copy_from_slice(&column[particles.clone()]);
                    }
                    obstacles.resistance[..x.len()].copy_from_slice(&model.particles.wind[particles.clone()]);
                    for (most, mass) in obstacles.most.iter_mut().zip(&model.particles.mass[particles.clone()]) {
                        *most = mass * per_step;
                    }
                    obstacles.forces(air)
                }
            };
            let weights = &model.particles.inverse_mass[particles];
            for (column, forces) in [x, y, z].into_iter().zip(&forces) {
                for ((value, force), weight) in column.iter_mut().zip(forces).zip(weights) {
                    *value += force * weight;
                }
            }
        }
    }
}
