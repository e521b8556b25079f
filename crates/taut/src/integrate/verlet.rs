//! Velocity Verlet (Swope, Andersen, Berens & Wilson 1982): kick, drift, kick.
//!
//! `V' = V + A(t) h / 2`, `X^(t+h) = X + V' h`, `V^(t+h) = V' + A(t+h) h / 2`. Order 2, symplectic without dampers and drag. Forces
//! that depend on velocities would make the second kick implicit; they see the predicted velocity V + A(t) h instead, which
//! keeps the order. The accelerations at the end are not kept for the next step: filters and pins change what they belong
//! to, and they would have to be part of the state.

use super::{Method, Step};
use crate::forces::{self, Forces};
use crate::geometry::{Pool, Vectors};
use crate::model::Model;
use crate::state::{Moment, State};

/// Workspace.
pub(super) struct Verlet {
    /// V + A(t) h [m/s].
    predicted: Vectors,
}

impl Verlet {
    pub fn new(model: &Model) -> Self {
        Self { predicted: Vectors::zeros(model.particle_count()) }
    }
}

impl Method for Verlet {
    fn propose(&mut self, step: Step<'_>, forces: &mut Forces, pool: &Pool) -> u32 {
        let Step { stride, state, ends } = step;
        let (all, length, start) = (0..stride.model.particle_count(), stride.plan.length, state.time());
        let half = (0.5 * length) as f32;
        forces::all(stride, state.moment(), forces, pool);
        let State { origins, positions, velocities, .. } = state;
        velocities.add_scaled(all.clone(), forces.acceleration(), half, pool);
        ends.set_scaled(all.clone(), positions, velocities, length as f32, pool);
        self.predicted.set_scaled(all.clone(), velocities, forces.acceleration(), half, pool);
        let moment = Moment { origins, positions: ends, velocities: &self.predicted, time: start + length };
        forces::all(stride, moment, forces, pool);
        velocities.add_scaled(all, forces.acceleration(), half, pool);
        2
    }
}
