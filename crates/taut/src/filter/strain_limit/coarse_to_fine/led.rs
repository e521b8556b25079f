//! Where bodies go in a step: along their paths, and back to them where cloth has held them back.
//!
//! A body that presses cloth against something waits where the cloth cannot give way (touch.rs, `shorten`). From then on it goes with its
//! path, as far beside it as it is, and tries to come nearer by itself: twice as far after each step that went well; where one did
//! not, it does not try for a while. So what is pinched is not struck anew in every step. A rigid body is held back as a whole, one
//! whose vertices follow an array only where cloth holds them: its skin gives way there.

use glam::{DVec3, Vec3};

use crate::filter::CATCHES_UP;
use crate::model::{Body, Model};
use crate::schedule::Stride;
use crate::state::State;

/// The first try is this part of a cell [1]; so many steps pass before it where none was of use.
const FIRST_TRY: f64 = 1e-3;
const WAITS: f32 = 16.0;
/// A body goes along where its way is beside that of the cloth by this part of it at most [1].
const ALONG: f64 = 0.1;

/// Bodies of a step.
pub(super) struct Led {
    /// Where their vertices end [m].
    pub ends: Vec<DVec3>,
    /// Where their paths are at the start and at the end of the step [m].
    path: [Vec<DVec3>; 2],
    /// How far each body is behind its path as the step begins, where it is furthest [m].
    pub late: Vec<f64>,
    /// The part of its way that each body could go, where it could go least [1].
    went: Vec<f64>,
}

impl Led {
    pub fn new(model: &Model) -> Self {
        let vertices = || vec![DVec3::ZERO; model.bodies.rest.len()];
        let (ends, path) = (vertices(), [vertices(), vertices()]);
        let bodies = model.bodies.list.len();
        Self { ends, path, late: vec![0.0; bodies], went: vec![1.0; bodies] }
    }

    /// Says where bodies go in a step, such a part of an automatic one, and how far they turn, axis times angle [rad].
    pub fn aim(&mut self, Stride { model, inputs, plan, .. }: Stride<'_>, part: f64, state: &State, turns: &mut [DVec3]) {
        let times = [state.clock.time(), state.clock.next(plan.length).time()];
        inputs.bodies.turns(times, turns);
        for (path, time) in self.path.iter_mut().zip(times) {
            inputs.bodies.places(&model.bodies, time, path);
        }
        self.went.fill(1.0);
        let [from, to] = &self.path;
        for (index, body) in model.bodies.list.iter().enumerate() {
            let own = body.vertices.clone();
            let furthest = |a: &[DVec3], b: &[DVec3]| own.clone().map(|at| a[at].distance(b[at])).fold(0.0, f64::max);
            let (behind, asked) = (furthest(&state.bodies, from), furthest(from, to));
            self.late[index] = behind;
            let most = CATCHES_UP * asked.max(model.contact.cell * part);
            let tries = match state.paces.get(index) {
                Some(&pace) if pace != 0.0 => f64::from(pace).clamp(0.0, most),
                _ => most,
            };
            // Where its path comes back to it, it waits for that.
            let back: f64 = own.clone().map(|at| (to[at] - from[at]).dot(state.bodies[at] - from[at])).sum();
            let square: f64 = own.clone().map(|at| from[at].distance_squared(state.bodies[at])).sum();
            let stays = if behind > 0.0 { (1.0 - (back / square).max(0.0) - tries / behind).max(0.0) } else { 0.0 };
            for at in own {
                self.ends[at] = to[at] - (from[at] - state.bodies[at]) * stays;
            }
        }
    }

    /// Of each vertex, whether it is behind its path as the step begins, by more than the first try.
    pub fn behind(&self, model: &Model, state: &State) -> impl Iterator<Item = bool> {
        let first = FIRST_TRY * model.contact.cell;
        self.path[0].iter().zip(&state.bodies).map(move |(path, place)| path.distance(*place) > first)
    }

    /// Whether a body goes such a way, or some place of one that turns as well does [m].
    pub fn goes_along(&self, body: &Body, state: &State, way: DVec3) -> bool {
        let beside = |at: usize| (self.ends[at] - state.bodies[at]).distance(way);
        body.vertices.clone().any(|at| beside(at) <= ALONG * way.length())
    }

    /// Lets bodies go only the part of their ways that `factors` of their vertices say [1]; those that go along with a cloth, whose way
    /// is among `frames` [m], that part of what they go beside it.
    pub fn shorten(&mut self, Stride { model, inputs, .. }: Stride<'_>, state: &State, factors: &[f64], frames: &[Vec3]) {
        for (index, body) in model.bodies.list.iter().enumerate() {
            let own = body.vertices.clone();
            let least = factors[own.clone()].iter().copied().fold(1.0, f64::min);
            if least == 1.0 {
                continue;
            }
            self.went[index] *= least;
            let gives_way = inputs.bodies.deforms(index);
            let mut moving = frames.iter().map(|frame| frame.as_dvec3()).filter(|frame| *frame != DVec3::ZERO);
            let frame = moving.find(|frame| self.goes_along(body, state, *frame)).unwrap_or_default();
            for at in own {
                let part = if gives_way { factors[at] } else { least };
                self.ends[at] = (state.bodies[at] + frame).lerp(self.ends[at], part);
            }
        }
    }

    /// Lets them go nowhere.
    pub fn stop(&mut self, state: &State) {
        self.ends.clone_from(&state.bodies);
        self.went.fill(0.0);
    }

    /// Writes where they are now, and remembers what they tried. Returns how many are behind their paths.
    pub fn arrive(&self, model: &Model, part: f64, state: &mut State) -> u32 {
        // Cloth without springs has no cells.
        let cell = if model.contact.cell.is_finite() { model.contact.cell } else { 0.0 };
        let first = (FIRST_TRY * cell) as f32;
        let mut held_back = 0;
        for (index, body) in model.bodies.list.iter().enumerate() {
            let own = body.vertices.clone();
            let furthest = |a: &[DVec3], b: &[DVec3]| own.clone().map(|at| a[at].distance(b[at])).fold(0.0, f64::max);
            let behind = furthest(&self.ends, &self.path[1]);
            held_back += u32::from(behind > 0.0);
            let pace = &mut state.paces[index];
            *pace = if behind == 0.0 {
                0.0
            } else if self.went[index] < 1.0 {
                let way = furthest(&state.bodies, &self.ends) as f32;
                if way > 2.0 * first { way / 2.0 } else { -WAITS * first }
            } else if *pace < 0.0 {
                let next = *pace + first * part as f32;
                if next < 0.0 { next } else { first }
            } else {
                (2.0 * *pace).min(f32::MAX)
            };
        }
        state.bodies.clone_from(&self.ends);
        held_back
    }
}
