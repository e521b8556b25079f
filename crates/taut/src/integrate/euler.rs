//! The paper's Euler method (section 3), velocity first: symplectic Euler in today's words.

use crate::geometry::{Pool, Vectors};
use crate::model::Model;
use crate::state::State;

/// `V^(t+h) = V^t + F h / M`.
pub(super) fn propose(model: &Model, state: &mut State, forces: &Vectors, pool: &Pool) {
    let step = model.timing.step_length as f32;
    let inverse_mass = &model.particles.inverse_mass;
    state.velocities.for_each_chunk(pool, |chunk| {
        chunk.map(|particle, velocity| velocity + forces.get(particle) * (step * inverse_mass[particle]));
    });
}

/// `X^(t+h) = X^t + V^(t+h) h` (printed with V on the left; see docs/equations.md).
pub(super) fn advance(model: &Model, state: &mut State, pool: &Pool) {
    let step = model.timing.step_length as f32;
    let velocities = &state.velocities;
    state.positions.for_each_chunk(pool, |chunk| chunk.map(|particle, position| position + velocities.get(particle) * step));
}
