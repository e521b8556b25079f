//! Linearised backward Euler (Baraff & Witkin, *Large steps in cloth simulation*, 1998, equation 6).
//!
//! A step is `V' = V + F(X', V') h / M`, `X' = X + V' h`. The forces of its end are taken as linear around its beginning:
//! `(M - h dF/dV - h^2 dF/dX) U = h (F + h dF/dX V)`, `V' = V + U`. The method has order 1 and is stable for springs, bending and
//! dampers at any step. It damps: a vibration with h w = 1 loses half of its energy in every step. The wind is taken at the beginning.

use super::{LinearSystem, Method, Step};
use crate::forces::{self, Forces};
use crate::geometry::{Pool, Vectors};
use crate::model::Model;
use crate::state::State;

/// A linear system for each cloth, and workspace.
pub(super) struct ImplicitEuler {
    systems: Vec<LinearSystem>,
    /// U [m/s].
    changes: Vectors,
}

impl ImplicitEuler {
    pub fn new(model: &Model) -> Self {
        let systems = model.cloths.iter().map(|cloth| LinearSystem::new(model, cloth)).collect();
        Self { systems, changes: Vectors::zeros(model.particle_count()) }
    }
}

impl Method for ImplicitEuler {
    fn propose(&mut self, step: Step<'_>, forces: &mut Forces, pool: &Pool) -> u32 {
        let Step { stride, state, ends } = step;
        let (all, length) = (0..stride.model.particle_count(), stride.plan.length);
        forces::all(stride, state.moment(), forces, pool);
        let State { positions, velocities, .. } = state;
        let mut passes = 1;
        for system in &mut self.systems {
            system.look(positions, length, pool);
            passes += system.solve(|own, particle| own.force(forces, particle) + own.pull_of(velocities, particle), pool);
            system.write_changes(&mut self.changes, pool);
        }
        velocities.add_scaled(all.clone(), &self.changes, 1.0, pool);
        ends.set_scaled(all, positions, velocities, length as f32, pool);
        passes
    }
}
