//! Held particles go where their path or their target says, whatever pulls at them; but for what is in their way, where they stop
//! (`stopped.rs` of the rows of contact). Those that were held back come back by a little in each step: what is in their way must be able to
//! give way, and cloth is not thrown where nothing is in their way any more. Pins go along with their path meanwhile. Where cloth is stuck,
//! pins that have slowed down already go back on their path until it moves. Of what a user holds no path is known, only a place: it goes a
//! little further in each step than in the last one, until it is there.

use glam::{DVec3, Vec3};

use super::Limited;
use super::hands::{LEAST_PACE, PACE_DECREASE, PACE_INCREASE, next_pace};
use crate::geometry::Vectors;
use crate::inputs::Target;
use crate::schedule::Stride;
use crate::state::{Behind, State};

/// What was held back, a pin or a body, comes nearer to its path by this part of what that moves in a step at most [1], or of a cell of the
/// cloth in an automatic step.
pub(super) const CATCHES_UP: f64 = 0.25;
/// What is stuck goes back from there by this part of a cell in an automatic step [1].
const GOES_BACK: f64 = 0.05;
/// Cloth that loses more than this part of its motion where a step is cut is stuck [1].
const STUCK: f64 = 0.5;
/// The pace of pins that go back.
const BACK: f64 = -1.0;
/// So often the time is narrowed down when they were where they are, to two thirds each time.
const NARROWED: usize = 24;
/// What ends beside its place by more than this part of a cell has been held back [1]: places are rounded.
const LEAST_WAY: f64 = 1e-3;

/// Gives each held particle the velocity that takes it to its place at the end of the step.
pub(super) fn hold(stride: Stride<'_>, state: &mut State) {
    let step = stride.plan.length as f32;
    let mut velocities = std::mem::take(&mut state.velocities);
    Places { stride, state }.for_each(|particle, place| {
        velocities.set(particle, (place - state.positions.get(particle)) / step);
    });
    state.velocities = velocities;
}

/// Puts each held particle there.
pub(super) fn place(stride: Stride<'_>, state: &State, ends: &mut Vectors) {
    Places { stride, state }.for_each(|particle, place| ends.set(particle, place));
}

/// Ends a step: pins that had to wait where it was cut go on more slowly, or back, and so does what a user holds.
pub(super) fn finish(stride: Stride<'_>, state: &mut State, ends: &Vectors, limited: &Limited, lost: &[f64]) {
    let Stride { model, inputs, .. } = stride;
    if !model.contact.is_on {
        return;
    }
    let was_cut = limited.contact_cuts > 0 || limited.held_back_pins > 0;
    let least = (LEAST_WAY * model.contact.cell) as f32;
    let is_beside = |particle: usize, place: Vec3| ends.get(particle).distance(place) > least;
    for group in 0..state.offsets.len() {
        let places = Places { stride, state };
        if places.may_wait(group) {
            let mut waited = false;
            if was_cut {
                places.of_group(group, &mut |particle, place| {
                    let is_held = inputs.grips.particles().binary_search(&(particle as u32)).is_ok();
                    waited |= !is_held && is_beside(particle, place);
                });
            }
            let is_stuck = was_cut && lost.get(model.pins[group].cloth).is_some_and(|lost| *lost > STUCK);
            state.offsets[group].pace = match state.offsets[group].pace {
                pace if is_stuck && pace < 1.0 => BACK,
                BACK => LEAST_PACE,
                pace => next_pace(pace, waited),
            };
        }
    }
    state.behind.retain(|behind| inputs.grips.particles().binary_search(&behind.particle).is_ok());
    for (particle, target) in inputs.grips.held() {
        let (own, places) = (particle as usize, Places { stride, state });
        let place = places.of_target(own, target);
        let waited = was_cut && is_beside(own, places.on_its_way(own, place));
        let speed = is_beside(own, place).then(|| places.next_speed(own, place, ends.get(own), waited));
        match (state.behind.binary_search_by_key(&particle, |behind| behind.particle), speed) {
            (Ok(number), Some(speed)) => state.behind[number].speed = speed,
            (Err(number), Some(speed)) => state.behind.insert(number, Behind { particle, speed }),
            (Ok(number), None) => drop(state.behind.remove(number)),
            (Err(_), None) => {}
        }
    }
}

/// Where held particles are at the end of a step.
struct Places<'a> {
    stride: Stride<'a>,
    /// Before the step.
    state: &'a State,
}

impl Places<'_> {
    /// Calls `work` with each held particle and its place, from the origin of its cloth [m].
    fn for_each(&self, mut work: impl FnMut(usize, Vec3)) {
        let Stride { model, inputs, .. } = self.stride;
        (0..model.pins.len()).for_each(|group| self.of_group(group, &mut work));
        for (particle, target) in inputs.grips.held() {
            let particle = particle as usize;
            work(particle, self.on_its_way(particle, self.of_target(particle, target)));
        }
    }

    /// Where the target of a particle would have it, whatever is in its way [m].
    fn of_target(&self, particle: usize, target: Target) -> Vec3 {
        let Self { stride: Stride { model, plan, .. }, state } = *self;
        let place = (target.place - state.origins[model.cloth_of(particle)]).as_vec3();
        let part = target.part(plan.length, state.clock.time());
        let from = state.positions.get(particle);
        if part == 1.0 { place } else { from + (place - from) * part }
    }

    /// Where it goes on its way there [m].
    fn on_its_way(&self, particle: usize, place: Vec3) -> Vec3 {
        let from = self.state.positions.get(particle);
        let most = self.speed_of(particle).map_or(f32::INFINITY, |speed| speed * self.stride.plan.length as f32);
        if (place - from).length() > most { from + (place - from).clamp_length_max(most) } else { place }
    }

    /// How fast it may go, if it is behind its place [m/s].
    fn speed_of(&self, particle: usize) -> Option<f32> {
        let behind = &self.state.behind;
        behind.binary_search_by_key(&(particle as u32), |held| held.particle).ok().map(|number| behind[number].speed)
    }

    /// How fast it may go from now on, as it ends beside its place [m/s]: more slowly where it had to wait, else faster than it went, or
    /// as fast as pins come back.
    fn next_speed(&self, particle: usize, place: Vec3, end: Vec3, waited: bool) -> f32 {
        let Stride { model, plan, .. } = self.stride;
        let (from, step) = (self.state.positions.get(particle), plan.length as f32);
        if waited {
            return PACE_DECREASE as f32 * self.on_its_way(particle, place).distance(from) / step;
        }
        let cell = model.contact.cell * plan.part_of_automatic(&model.cloths[model.cloth_of(particle)]);
        let back = ((CATCHES_UP * cell) as f32 / step).min(self.speed_of(particle).unwrap_or(f32::INFINITY));
        PACE_INCREASE as f32 * back.max(end.distance(from) / step)
    }

    /// The same of a pin group, whatever a user holds.
    fn of_group(&self, number: usize, work: &mut impl FnMut(usize, Vec3)) {
        let Self { stride: Stride { model, inputs, plan, .. }, state } = *self;
        let group = &model.pins[number];
        let offset = state.offsets[number].now - (state.origins[group.cloth] - model.origins[group.cloth].at);
        let at = |time: f64| inputs.pins.places(model, number, time);
        let (start, to) = (state.clock.time(), at(state.clock.next(plan.length).time()));
        if !self.may_wait(number) {
            let all = group.particles.iter().enumerate();
            all.for_each(|(index, &particle)| work(particle as usize, (to.of(index) + offset).as_vec3()));
            return;
        }
        let (from, pace) = (at(start), state.offsets[number].pace);
        let cell = model.contact.cell * plan.part_of_automatic(&model.cloths[group.cloth]);
        let all =
            || group.particles.iter().map(|&particle| (particle, state.positions.get(particle as usize).as_dvec3())).enumerate();
        if pace == BACK {
            let then = self.when_nearest(number, offset);
            let (now, before) = (at(then), at((then - plan.length).max(0.0)));
            let way = |index: usize| now.of(index) - before.of(index);
            let longest = all().map(|(index, _)| way(index).length()).fold(0.0, f64::max);
            let part = if longest > 0.0 { GOES_BACK * cell / longest } else { 0.0 };
            all().for_each(|(index, (particle, at))| work(particle as usize, (at - way(index) * part).as_vec3()));
            return;
        }
        for (index, (particle, at)) in all() {
            let (way, back) = (to.of(index) - from.of(index), from.of(index) + offset - at);
            let most = CATCHES_UP * way.length().max(cell);
            let goes_on = pace == 1.0 && back.length() <= most;
            let place = if goes_on { to.of(index) + offset } else { at + (way + back.clamp_length_max(most)) * pace };
            work(particle as usize, place.as_vec3());
        }
    }

    /// When a pin group would have been about where it is, by its path, which is so far aside [m]: a time before the step [s].
    fn when_nearest(&self, number: usize, offset: DVec3) -> f64 {
        let Self { stride: Stride { model, inputs, plan, .. }, state } = *self;
        let (particles, start) = (&model.pins[number].particles, state.clock.time());
        let far = |ago: f64| {
            let path = inputs.pins.places(model, number, (start - ago).max(0.0));
            let from = |&particle: &u32| state.positions.get(particle as usize).as_dvec3() - offset;
            particles.iter().enumerate().map(|(index, particle)| path.of(index).distance_squared(from(particle))).sum::<f64>()
        };
        let (mut least, mut low, mut high) = (far(0.0), 0.0, plan.length);
        let mut ago = plan.length;
        while ago <= start {
            let here = far(ago);
            if here < least {
                (least, low, high) = (here, 0.5 * ago, 2.0 * ago);
            }
            ago *= 2.0;
        }
        for _ in 0..NARROWED {
            let third = (high - low) / 3.0;
            if far(low + third) <= far(high - third) { high -= third } else { low += third }
        }
        (start - 0.5 * (low + high)).max(0.0)
    }

    /// Whether a pin group waits where something is in its way. Where nothing can be it goes back at once; and one that is moved off its path
    /// has a pace of its own (hands.rs).
    fn may_wait(&self, group: usize) -> bool {
        let Stride { model, inputs, .. } = self.stride;
        model.contact.is_on && inputs.grips.shifts().iter().all(|shift| shift.group != group)
    }
}
