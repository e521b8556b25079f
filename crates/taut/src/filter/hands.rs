//! Particles led by hand, and pins on their way to places beside their paths.

use glam::Vec3;

use crate::geometry::Vectors;
use crate::inputs::Lead;
use crate::model::Model;
use crate::schedule::Stride;
use crate::state::State;

/// A hand closes a gap to its target in about this time [s], unless that is above its speed: hands are as quick before small cloth as
/// before large.
const RESPONSE: f32 = 1.0 / 60.0;
/// What is held and had to wait asks for this part of its speed in the next step, ..
pub(super) const PACE_DECREASE: f64 = 0.25;
/// .. and for this much more in every step in which they did not.
pub(super) const PACE_INCREASE: f64 = 1.1;
/// Less of its speed a pin never asks for: it must notice that the cloth lets it go on.
pub(super) const LEAST_PACE: f64 = 1e-3;

/// Starts a step: pins go on towards their places.
pub(super) fn start(stride: Stride<'_>, state: &mut State) {
    for shift in stride.inputs.grips.shifts() {
        let offset = &mut state.offsets[shift.group];
        if offset.target != shift.target {
            (offset.target, offset.pace) = (shift.target, 1.0);
        }
        let way = shift.target - offset.now;
        // What had to go back on its path (held.rs) sets out again.
        let most = shift.speed * offset.pace.max(LEAST_PACE) * stride.plan.length;
        offset.now = if shift.speed.is_finite() { offset.now + way.clamp_length_max(most) } else { shift.target };
    }
}

/// Gives led particles the velocities that take them where they shall be at the end of the step.
pub(super) fn hold(stride: Stride<'_>, state: &mut State) {
    let step = stride.plan.length as f32;
    for lead in free(stride) {
        let way = way(lead, stride.model, state, step);
        state.velocities.set(lead.particle as usize, way / step);
    }
}

/// Puts them there, and asks for those velocities again: forces have changed them.
pub(super) fn place(stride: Stride<'_>, state: &mut State, ends: &mut Vectors) {
    let step = stride.plan.length as f32;
    for lead in free(stride) {
        let (particle, way) = (lead.particle as usize, way(lead, stride.model, state, step));
        ends.set(particle, state.positions.get(particle) + way);
        state.velocities.set(particle, way / step);
    }
}

/// Ends a step: where pins had to wait, they go on from where they are, and more slowly.
pub(super) fn finish(stride: Stride<'_>, state: &mut State, ends: &Vectors, held_back: bool) {
    let Stride { model, inputs, plan, .. } = stride;
    let time = state.clock.next(plan.length).time();
    for shift in inputs.grips.shifts() {
        let offset = &mut state.offsets[shift.group];
        offset.pace = next_pace(offset.pace, held_back);
        if let (true, Some(&particle)) = (held_back, model.pins[shift.group].particles.first()) {
            let cloth = model.pins[shift.group].cloth;
            let gone = state.origins[cloth] - model.origins[cloth].at;
            let on_path = inputs.pins.position(model, shift.group, 0, time);
            offset.now = ends.get(particle as usize).as_dvec3() + gone - on_path;
        }
    }
}

/// The part of their speed that pins ask for in the next step [1].
pub(super) fn next_pace(pace: f64, held_back: bool) -> f64 {
    if held_back { (pace * PACE_DECREASE).max(LEAST_PACE) } else { (pace * PACE_INCREASE).min(1.0) }
}

/// The hands on what is neither pinned nor held.
fn free(stride: Stride<'_>) -> impl Iterator<Item = &Lead> {
    let Stride { model, inputs, .. } = stride;
    inputs.grips.leads().iter().filter(|lead| model.particles.inverse_mass[lead.particle as usize] > 0.0)
}

/// The way of a step [m].
fn way(lead: &Lead, model: &Model, state: &State, step: f32) -> Vec3 {
    let particle = lead.particle as usize;
    let target = (lead.target - state.origins[model.cloth_of(particle)]).as_vec3();
    let gap = target - state.positions.get(particle);
    (gap * (step / RESPONSE).min(1.0)).clamp_length_max(lead.speed * step)
}
