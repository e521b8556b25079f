//! Held particles go where their path or their target says, whatever pulls at them.

use glam::{DVec3, Vec3};

use crate::geometry::Vectors;
use crate::schedule::Stride;
use crate::state::{Clock, Offset, State};

/// Gives each held particle the velocity that takes it to its place at the end of the step.
pub(super) fn hold(stride: Stride<'_>, state: &mut State) {
    let step = stride.plan.length as f32;
    let State { origins, positions, velocities, clock, offsets, .. } = state;
    Places { stride, origins, positions, offsets, clock: *clock }.for_each(|particle, place| {
        velocities.set(particle, (place - positions.get(particle)) / step);
    });
}

/// Puts each held particle there.
pub(super) fn place(stride: Stride<'_>, state: &State, ends: &mut Vectors) {
    let State { origins, positions, clock, offsets, .. } = state;
    Places { stride, origins, positions, offsets, clock: *clock }.for_each(|particle, place| ends.set(particle, place));
}

/// Where held particles are at the end of a step.
struct Places<'a> {
    stride: Stride<'a>,
    origins: &'a [DVec3],
    positions: &'a Vectors,
    offsets: &'a [Offset],
    /// Before the step.
    clock: Clock,
}

impl Places<'_> {
    /// Calls `work` with each held particle and its place, from the origin of its cloth [m].
    fn for_each(&self, mut work: impl FnMut(usize, Vec3)) {
        let Stride { model, inputs, plan, .. } = self.stride;
        let end = self.clock.next(plan.length).time();
        for (number, group) in model.pins.iter().enumerate() {
            let offset = self.offsets[number].now - (self.origins[group.cloth] - model.origins[group.cloth].at);
            let places = inputs.pins.places(model, number, end);
            for (index, &particle) in group.particles.iter().enumerate() {
                work(particle as usize, (places.of(index) + offset).as_vec3());
            }
        }
        let start = self.clock.time();
        for (particle, target) in inputs.grips.held() {
            let particle = particle as usize;
            let place = (target.place - self.origins[model.cloth_of(particle)]).as_vec3();
            let part = target.part(plan.length, start);
            let from = self.positions.get(particle);
            work(particle, if part == 1.0 { place } else { from + (place - from) * part });
        }
    }
}
