//! Held particles go where their path or their target says, whatever pulls at them.

use glam::Vec3;

use crate::geometry::Vectors;
use crate::schedule::Stride;
use crate::state::State;

/// Gives each held particle the velocity that takes it to its place at the end of the step.
pub(super) fn hold(stride: Stride<'_>, state: &mut State) {
    let step = stride.plan.length as f32;
    let State { positions, velocities, clock, offsets, .. } = state;
    let ends = Ends { stride, positions, time: clock.time(), end: clock.next(stride.plan.length).time() };
    ends.for_each(
        |group| offsets[group].now.as_vec3(),
        |particle, place| {
            velocities.set(particle, (place - positions.get(particle)) / step);
        },
    );
}

/// Puts each held particle there.
pub(super) fn place(stride: Stride<'_>, state: &State, ends: &mut Vectors) {
    let State { positions, clock, offsets, .. } = state;
    let places = Ends { stride, positions, time: clock.time(), end: clock.next(stride.plan.length).time() };
    places.for_each(|group| offsets[group].now.as_vec3(), |particle, place| ends.set(particle, place));
}

/// Where held particles are at the end of a step.
struct Ends<'a> {
    stride: Stride<'a>,
    positions: &'a Vectors,
    /// When the step begins and ends [s].
    time: f64,
    end: f64,
}

impl Ends<'_> {
    /// Calls `work` with each held particle and its place [m]; `offset` is how far a pin group is off its path [m].
    fn for_each(&self, offset: impl Fn(usize) -> Vec3, mut work: impl FnMut(usize, Vec3)) {
        let Stride { model, inputs, plan } = self.stride;
        for (number, group) in model.pins.iter().enumerate() {
            let offset = offset(number);
            for (index, &particle) in group.particles.iter().enumerate() {
                work(particle as usize, inputs.pins.position(model, number, index, self.end) + offset);
            }
        }
        for (particle, target) in inputs.grips.held() {
            let from = self.positions.get(particle as usize);
            work(particle as usize, target.after(plan.length, self.time, from));
        }
    }
}
