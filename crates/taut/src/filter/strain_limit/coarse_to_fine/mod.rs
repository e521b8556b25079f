//! The coarse-to-fine velocity constraint: a hard limit at any resolution.
//!
//! Sweeping springs one by one cannot carry a load across a fine mesh. Here every cloth has levels, each with fewer
//! particles than the one before and with springs that never contradict the finer ones; a cycle corrects the coarsest
//! level first and hands its displacements down. Cycles go on until every spring is within its limit; a certificate
//! measures the very positions that the integrator will write (docs/equations.md, "Coarse to fine").

mod certificate;
mod general;
mod lattice;

use glam::Vec3;

use super::StrainLimit;
use crate::filter::Limited;
use crate::geometry::{Pool, Vectors};
use crate::model::{ClothRange, Model};
use crate::state::State;
use certificate::Certificate;

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
    /// One pass over all levels, from the coarsest to the finest, after going on with `momentum`. Returns the largest
    /// |P_uv| / R then; less than `enough` is not worth further work.
    fn cycle(&mut self, model: &Model, momentum: f32, enough: f32) -> f32;
    /// Gives the corrected step back as velocities.
    fn store(&self, model: &Model, state: &mut State);
}

/// One cloth: its levels and its certificate.
struct Unit {
    certificate: Certificate,
    levels: Box<dyn Hierarchy>,
    /// Part of R below which the levels are done: the integrator will round the ends of the step once more.
    enough: f32,
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
        let strain = *model.springs.strain_limit.get(cloth.springs.clone())?.first()?;
        let delta = BACK_OFF * strain / (1.0 + strain);
        let levels: Box<dyn Hierarchy> = match cloth.lattice {
            Some(lattice) => Box::new(lattice::LatticeLevels::new(model, &model.lattices[lattice], strain, delta)),
            None => Box::new(general::GeneralLevels::new(model, cloth, delta)),
        };
        let enough = 1.0 - rounding(model, cloth).max(2e-5).min(0.5 * delta);
        Some(Self { certificate: Certificate::new(cloth), levels, enough })
    }

    fn apply(&mut self, model: &Model, state: &mut State, ends: &mut Vectors) -> Limited {
        let proposed = self.certificate.measure(model, state, ends);
        let mut limited = Limited { springs: proposed.over, ..Limited::default() };
        let mut worst = proposed.worst;
        if worst <= 1.0 || worst.is_nan() {
            return limited;
        }
        let frame = self.certificate.rigid_velocity(model, state);
        let energy = frame.map(|frame| self.certificate.kinetic_energy(model, &state.velocities, frame));
        self.levels.load(model, state);
        let mut since_restart = 0;
        while worst > self.enough && limited.sweeps < model.solver.iterations {
            let now = self.levels.cycle(model, if since_restart < 2 { 0.0 } else { MOMENTUM }, self.enough);
            limited.sweeps += 1;
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
        let after = self.certificate.kinetic_energy(model, &state.velocities, frame);
        if after > before {
            self.certificate.slow_down(model, &mut state.velocities, frame, (before / after).sqrt() as f32);
        }
    }

    /// Measures the ends of the step and goes only as far as all springs allow. Returns whether it had to cut.
    fn cut(&self, model: &Model, state: &mut State, ends: &mut Vectors, frame: Option<Vec3>) -> bool {
        // Rounding of the shortened step can ask for another round; the last one stays where X is.
        const ROUNDS: usize = 4;
        for round in 0..ROUNDS {
            if self.certificate.measure(model, state, ends).worst <= 1.0 {
                return round > 0;
            }
            let Some(frame) = frame else { break };
            let part =
                if round + 1 < ROUNDS { self.certificate.admissible_part(model, state, ends).min(1.0 - 1e-6) } else { 0.0 };
            self.certificate.slow_down(model, &mut state.velocities, frame, part);
        }
        true
    }
}

/// What rounding its two ends to single precision can add to the shortest spring of a cloth, as a part of its length.
fn rounding(model: &Model, cloth: &ClothRange) -> f32 {
    let largest = |column: &[f32]| column[cloth.particles()].iter().fold(0.0, |largest: f32, value| largest.max(value.abs()));
    let rest = &model.particles.rest;
    let extent = largest(&rest.x).max(largest(&rest.y)).max(largest(&rest.z));
    let shortest = model.springs.rest[cloth.springs.clone()].iter().fold(f32::INFINITY, |least, &rest| least.min(rest));
    4.0 * f32::EPSILON * extent / shortest
}
