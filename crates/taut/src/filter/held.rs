//! Held particles go where their path or their target says, whatever pulls at them. Those that something in their way has held back go
//! along with their path, and come back to it by a little in each step: what is in their way must be able to give way.

use glam::{DVec3, Vec3};

use super::hands::next_pace;
use crate::geometry::Vectors;
use crate::model::ClothRange;
use crate::schedule::Stride;
use crate::state::{Clock, Offset, State};

/// What was held back, a pin or a body, comes nearer to its path by this part of what that moves in a step at most [1], or of a cell of the
/// cloth in an automatic step.
pub(super) const CATCHES_UP: f64 = 0.25;
/// Pins that end beside their places by more than this part of a cell have been held back [1]: places are rounded.
const LEAST_WAY: f64 = 1e-3;

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

/// Ends a step: pins that had to wait go on more slowly.
pub(super) fn finish(stride: Stride<'_>, state: &mut State, ends: &Vectors) {
    let Stride { model, inputs, .. } = stride;
    let least = (LEAST_WAY * model.contact.cell) as f32;
    for group in 0..state.offsets.len() {
        let State { origins, positions, clock, offsets, .. } = &*state;
        let places = Places { stride, origins, positions, offsets, clock: *clock };
        if places.may_wait(group) {
            let mut waited = false;
            places.of_group(group, &mut |particle, place| {
                let is_held = inputs.grips.particles().binary_search(&(particle as u32)).is_ok();
                waited |= !is_held && ends.get(particle).distance(place) > least;
            });
            state.offsets[group].pace = next_pace(state.offsets[group].pace, waited);
        }
    }
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
        (0..model.pins.len()).for_each(|group| self.of_group(group, &mut work));
        let start = self.clock.time();
        for (particle, target) in inputs.grips.held() {
            let particle = particle as usize;
            let place = (target.place - self.origins[model.cloth_of(particle)]).as_vec3();
            let part = target.part(plan.length, start);
            let from = self.positions.get(particle);
            work(particle, if part == 1.0 { place } else { from + (place - from) * part });
        }
    }

    /// The same of a pin group, whatever a user holds.
    fn of_group(&self, number: usize, work: &mut impl FnMut(usize, Vec3)) {
        let Stride { model, inputs, plan, .. } = self.stride;
        let group = &model.pins[number];
        let offset = self.offsets[number].now - (self.origins[group.cloth] - model.origins[group.cloth].at);
        let [from, to] =
            [self.clock.time(), self.clock.next(plan.length).time()].map(|time| inputs.pins.places(model, number, time));
        let (waits, pace) = (self.may_wait(number), self.offsets[number].pace);
        let cell = model.contact.cell * self.part_of_automatic(&model.cloths[group.cloth]);
        for (index, &particle) in group.particles.iter().enumerate() {
            let place = to.of(index) + offset;
            let at = self.positions.get(particle as usize).as_dvec3();
            let (way, back) = (to.of(index) - from.of(index), from.of(index) + offset - at);
            let most = CATCHES_UP * way.length().max(cell);
            let goes_on = !waits || pace == 1.0 && back.length() <= most;
            let place = if goes_on { place } else { at + (way + back.clamp_length_max(most)) * pace };
            work(particle as usize, place.as_vec3());
        }
    }

    /// Whether a pin group waits where something is in its way. Where nothing can be it goes back at once; and one that is moved off its path
    /// has a pace of its own (hands.rs).
    fn may_wait(&self, group: usize) -> bool {
        let Stride { model, inputs, .. } = self.stride;
        model.contact.is_on && inputs.grips.shifts().iter().all(|shift| shift.group != group)
    }

    /// The step as a part of the automatic one of a cloth, at most 1.
    fn part_of_automatic(&self, cloth: &ClothRange) -> f64 {
        if cloth.rates.is_empty() { 1.0 } else { self.stride.plan.of(cloth).relative.min(1.0) }
    }
}
