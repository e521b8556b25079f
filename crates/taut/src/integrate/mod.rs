//! Velocities in, positions out.

use crate::geometry::{Pool, Vectors};
use crate::state::State;

/// The paper's Euler method (section 3), velocity first (symplectic Euler in today's words):
/// `X^(t+h) = X^t + V^(t+h) h`, printed with V on the left; see docs/equations.md.
pub fn drift(positions: &mut Vectors, velocities: &Vectors, step: f32, pool: &Pool) {
    positions.add_scaled(velocities, step, pool);
}

/// The step has been admitted: its ends are the new positions, and the old ones are its ends.
pub fn advance(state: &mut State, ends: &mut Vectors) {
    std::mem::swap(&mut state.positions, ends);
    state.steps += 1;
}
