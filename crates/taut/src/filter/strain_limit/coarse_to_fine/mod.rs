//! The coarse-to-fine velocity constraint: a hard limit at any resolution.
//!
//! Sweeping springs one by one cannot carry a load across a fine mesh. Here every cloth has levels, each with fewer
//! particles than the one before and with springs that never contradict the finer ones; a cycle corrects the coarsest
//! level first and hands its displacements down. Cycles go on until every spring is within its limit; a certificate
//! measures the very positions that the integrator will write (docs/equations.md, "Coarse to fine").

mod certificate;
mod general;
mod lattice;

use std::ops::Range;

use glam::Vec3;

use super::StrainLimit;
use crate::filter::Limited;
use crate::geometry::{Pool, Vectors};
use crate::model::{ClothRange, Lattice, Model};
use crate::state::State;
use certificate::Extent;

/// How far below its limit R a corrected spring is aimed, as a part of the strain that R allows.
const BACK_OFF: f32 = 0.2;
/// Part of the last cycle's way that the next one starts with.
const MOMENTUM: f32 = 0.75;
/// A cycle that makes the worst spring this much worse ends the momentum.
const RESTART: f32 = 1.1;

/// Levels of one cloth.
trait Hierarchy: Send {
    /// Takes the proposed step from the state.
    fn load(&mut self, model: &Model, state: &State);
    /// One pass over all levels, from the coarsest to the finest, after going on with `momentum`.
    fn cycle(&mut self, momentum: f32);
    /// The largest |P_uv| / R now.
    fn worst(&self) -> f32;
    /// Gives the corrected step back as velocities.
    fn store(&self, model: &Model, state: &mut State);
}

/// One cloth: its levels and its certificate.
struct Unit {
    extent: Extent,
    levels: Box<dyn Hierarchy>,
}

/// All cloths.
pub(super) struct CoarseToFine {
    units: Vec<Unit>,
    /// X + V h, as the integrator will write it [m].
    ends: Vectors,
}

impl CoarseToFine {
    pub(super) fn new(model: &Model) -> Self {
        let units = model.cloths.iter().filter_map(|cloth| Unit::new(model, cloth)).collect();
        Self { units, ends: Vectors::zeros(model.particle_count()) }
    }
}

impl StrainLimit for CoarseToFine {
    fn apply(&mut self, model: &Model, state: &mut State, _: &Pool) -> Limited {
        let mut limited = Limited::default();
        for unit in &mut self.units {
            let done = unit.apply(model, state, &mut self.ends);
            limited.springs += done.springs;
            limited.sweeps += done.sweeps;
            limited.cuts += done.cuts;
        }
        limited
    }
}

impl Unit {
    /// A cloth; none if nothing in it is limited.
    fn new(model: &Model, cloth: &ClothRange) -> Option<Self> {
        let particles = cloth.first..cloth.first + cloth.count;
        let springs = springs_of(model, &particles)?;
        // Rounding of positions far from the origin must stay small against the room below the limit.
        let strain = model.springs.strain_limit[springs.start];
        let delta = BACK_OFF * strain / (1.0 + strain);
        let lattice = model.lattices.iter().find(|lattice| lattice.first == cloth.first);
        let levels: Box<dyn Hierarchy> = match lattice {
            Some(lattice) => Box::new(lattice::LatticeLevels::new(model, lattice, delta)),
            None => Box::new(general::GeneralLevels::new(model, particles.clone(), springs.clone(), delta)),
        };
        let lattice = lattice.map(|lattice| (lattice.clone(), limits_of(model, lattice, springs.clone())));
        Some(Self { extent: Extent { particles, springs, lattice }, levels })
    }

    fn apply(&mut self, model: &Model, state: &mut State, ends: &mut Vectors) -> Limited {
        let step = model.timing.step_length as f32;
        self.extent.ends_of_step(state, step, ends);
        let (over, mut worst) = self.extent.measure(model, ends);
        let mut limited = Limited { springs: over, ..Limited::default() };
        if worst <= 1.0 || worst.is_nan() {
            return limited;
        }
        let frame = self.extent.rigid_velocity(model, state);
        let energy = frame.map(|frame| self.extent.kinetic_energy(model, &state.velocities, frame));
        self.levels.load(model, state);
        let mut since_restart = 0;
        // The levels measure with less rounding than the integrator: ask for a little more than the limit.
        while worst > 1.0 - 2e-5 && limited.sweeps < model.solver.iterations {
            self.levels.cycle(if since_restart < 2 { 0.0 } else { MOMENTUM });
            limited.sweeps += 1;
            let now = self.levels.worst();
            since_restart = if now > RESTART * worst { 0 } else { since_restart + 1 };
            worst = now;
        }
        self.levels.store(model, state);
        if let (Some(frame), Some(energy)) = (frame, energy) {
            self.guard_energy(model, state, frame, energy);
        }
        limited.cuts = u32::from(self.cut(model, state, ends, frame));
        limited
    }

    /// Kinetic energy must not rise: shortening an admissible step keeps it admissible, because X is.
    fn guard_energy(&self, model: &Model, state: &mut State, frame: Vec3, before: f64) {
        let after = self.extent.kinetic_energy(model, &state.velocities, frame);
        if after > before {
            self.extent.slow_down(model, &mut state.velocities, frame, (before / after).sqrt() as f32);
        }
    }

    /// The certificate: measures the ends of the step and goes only as far as all springs allow. Returns whether it had to cut.
    fn cut(&self, model: &Model, state: &mut State, ends: &mut Vectors, frame: Option<Vec3>) -> bool {
        let step = model.timing.step_length as f32;
        let mut cut = false;
        // Each round leaves more room for the rounding of the ends.
        for _ in 0..4 {
            self.extent.ends_of_step(state, step, ends);
            if self.extent.measure(model, ends).1 <= 1.0 {
                break;
            }
            cut = true;
            let Some(frame) = frame else { break };
            let part = self.extent.admissible_part(model, state, ends);
            self.extent.slow_down(model, &mut state.velocities, frame, part.min(1.0 - 1e-6));
        }
        cut
    }
}

/// The type 1 springs of a cloth, which stand one after the other.
fn springs_of(model: &Model, particles: &Range<usize>) -> Option<Range<usize>> {
    let inside = |spring: &usize| particles.contains(&(model.springs.ends[*spring][0] as usize));
    let start = (0..model.springs.type1).find(inside)?;
    let count = (start..model.springs.type1).take_while(inside).count();
    Some(start..start + count)
}

/// Greatest lengths of a lattice's springs to the right, up, up-right and up-left; the least of each kind.
fn limits_of(model: &Model, lattice: &Lattice, springs: Range<usize>) -> [f32; 4] {
    let offsets = [1, lattice.columns, lattice.columns + 1, lattice.columns - 1];
    offsets.map(|offset| {
        let kind = springs.clone().filter(|&spring| {
            let [u, v] = model.springs.ends[spring];
            u.abs_diff(v) as usize == offset
        });
        kind.map(|spring| model.springs.greatest_length(spring)).fold(f32::INFINITY, f32::min)
    })
}
