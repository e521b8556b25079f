//! Held particles go where their path says, whatever pulls at them.

use glam::{DVec3, Vec3};

use super::Hands;
use crate::geometry::Vectors;
use crate::schedule::Stride;
use crate::state::State;

/// Gives each held particle the velocity that takes it to its place at the end of the step.
pub(super) fn hold(stride: Stride<'_>, state: &mut State, hands: &Hands) {
    let (step, end) = (stride.plan.length as f32, state.clock.next(stride.plan.length).time());
    let State { origins, positions, velocities, .. } = state;
    for_each(stride, end, origins, hands, |particle, place| {
        let way = place - positions.get(particle);
        velocities.set(particle, way / step);
    });
}

/// Puts each held particle there.
pub(super) fn place(stride: Stride<'_>, state: &State, hands: &Hands, ends: &mut Vectors) {
    let end = state.clock.next(stride.plan.length).time();
    for_each(stride, end, &state.origins, hands, |particle, place| ends.set(particle, place));
}

/// Calls `work` with each held particle and its place at the end of the step [m], which is at the time `end` [s].
fn for_each(stride: Stride<'_>, end: f64, origins: &[DVec3], hands: &Hands, mut work: impl FnMut(usize, Vec3)) {
    let Stride { model, inputs, .. } = stride;
    for (number, group) in model.pins.iter().enumerate() {
        let offset = hands.offset(number) - (origins[group.cloth] - model.origins[group.cloth].at);
        for (index, &particle) in group.particles.iter().enumerate() {
            work(particle as usize, (inputs.pins.position(model, number, index, end) + offset).as_vec3());
        }
    }
}
