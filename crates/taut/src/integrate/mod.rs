//! Forces in, proposed velocities out; admissible velocities in, positions out.

mod euler;

use crate::geometry::{Pool, Vectors};
use crate::model::Model;
use crate::scene::IntegratorKind;
use crate::state::State;

/// Replaces the velocities by what the forces alone would make of them (V*).
pub fn propose(model: &Model, state: &mut State, forces: &Vectors, pool: &Pool) {
    match model.solver.integrator {
        IntegratorKind::Euler => euler::propose(model, state, forces, pool),
    }
}

/// Moves the positions with the admissible velocities and counts the step.
pub fn advance(model: &Model, state: &mut State, pool: &Pool) {
    match model.solver.integrator {
        IntegratorKind::Euler => euler::advance(model, state, pool),
    }
    state.steps += 1;
}
