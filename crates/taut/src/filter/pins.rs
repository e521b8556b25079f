//! Held particles go where their path says, whatever pulls at them.

use glam::Vec3;

use super::Hands;
use crate::geometry::Vectors;
use crate::model::Model;
use crate::state::State;

/// Gives each held particle the velocity that takes it to its place at the end of the step.
pub(super) fn hold(model: &Model, state: &mut State, hands: &Hands) {
    let step = model.timing.step_length as f32;
    for_each(model, state.steps, hands, |particle, end| {
        let way = end - state.positions.get(particle);
        state.velocities.set(particle, way / step);
    });
}

/// Puts each held particle there.
pub(super) fn place(model: &Model, state: &State, hands: &Hands, ends: &mut Vectors) {
    for_each(model, state.steps, hands, |particle, end| ends.set(particle, end));
}

/// Calls `work` with each held particle and its place at the end of the step [m].
fn for_each(model: &Model, steps: u64, hands: &Hands, mut work: impl FnMut(usize, Vec3)) {
    let end = (steps + 1) as f64 * model.timing.step_length;
    for (number, group) in model.pins.iter().enumerate() {
        let offset = hands.offset(number).as_vec3();
        for (index, &particle) in group.particles.iter().enumerate() {
            work(particle as usize, group.position(index, end) + offset);
        }
    }
}
