//! Held particles go where their path says, whatever pulls at them.

use crate::model::Model;
use crate::state::State;

/// Gives each held particle the velocity that takes it to its place at the end of the step.
pub(super) fn apply(model: &Model, state: &mut State) {
    let step = model.timing.step_length;
    let end = (state.steps + 1) as f64 * step;
    for group in &model.pins {
        for (index, &particle) in group.particles.iter().enumerate() {
            let particle = particle as usize;
            let way = group.position(index, end) - state.positions.get(particle);
            state.velocities.set(particle, way / step as f32);
        }
    }
}
