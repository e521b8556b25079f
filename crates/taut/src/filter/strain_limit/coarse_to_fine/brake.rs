//! Cloth that lies on something comes to rest.
//!
//! Where its ways turn back on each other, each step is the mean of staying and of going where the limit and the rows lead. What no
//! projection brings further apart comes to rest so [Krasnoselskii55], where going all the way it may turn for ever. Staying means to go
//! with what carries the cloth.

use glam::{DVec3, Vec3};

use crate::contact::RigidMotion;
use crate::geometry::{Pool, Vectors};
use crate::model::{ClothRange, Model};
use crate::state::State;

/// Where ways of cloth that lies on something turn back, their cosine with the last ones being below the first of these, steps go on
/// by so much less of their way, down to the least; where they go on, the cosine being above the second, by so much more.
const TURNED: f64 = 0.5;
const ONWARD: f64 = 0.9;
const SLOWER: f32 = 0.8;
const FASTER: f32 = 1.5;
const LEAST_WAY: f32 = 0.02;

/// A step that is about to be braked.
#[derive(Clone, Copy)]
pub(super) struct Lying<'a> {
    pub model: &'a Model,
    /// Its length [s].
    pub length: f32,
    /// Where particles start, from the place that frames are told from, and where they are proposed to end, from their origins [m].
    pub start: &'a [DVec3],
    pub proposed: &'a Vectors,
    pub pool: &'a Pool,
}

impl Lying<'_> {
    /// The part of the kinetic energy of the proposal that is left, seen from a frame [1].
    pub fn left_of_energy(self, cloth: &ClothRange, state: &State, ends: &Vectors, frame: &RigidMotion) -> f64 {
        let (mut before, mut after) = (0.0, 0.0);
        for particle in self.free(cloth) {
            let (mass, with) = (f64::from(self.model.particles.mass[particle]), self.with(frame, particle));
            let square =
                |ends: &Vectors| mass * f64::from((ends.get(particle) - state.positions.get(particle) - with).length_squared());
            before += square(self.proposed);
            after += square(ends);
        }
        if before > 0.0 { after / before } else { 1.0 }
    }

    /// The brake of a cloth after one of `before`, as its way goes on as the last one did, or turns back.
    pub fn brake_from_now(self, before: f32, cloth: &ClothRange, state: &State, ends: &Vectors, frame: &RigidMotion) -> f32 {
        let goes = 1.0 - before;
        let goes = match self.coherence(cloth, state, ends, frame) {
            onward if onward < TURNED => goes * SLOWER,
            onward if onward > ONWARD => (goes * FASTER).min(1.0),
            _ => goes,
        };
        1.0 - goes.max(LEAST_WAY)
    }

    /// Leaves out such a part of the way.
    pub fn brake(self, brake: f32, cloth: &ClothRange, state: &mut State, ends: &mut Vectors, frame: &RigidMotion) {
        for particle in self.free(cloth) {
            let end = ends.get(particle);
            let back = (end - state.positions.get(particle) - self.with(frame, particle)) * -brake;
            ends.set(particle, end + back);
            state.velocities.set(particle, state.velocities.get(particle) + back / self.length);
        }
    }

    /// The cosine between this way and the last one, of all particles together by mass, seen from a frame [1].
    fn coherence(self, cloth: &ClothRange, state: &State, ends: &Vectors, frame: &RigidMotion) -> f64 {
        let (mut both, mut now, mut then) = (0.0, 0.0, 0.0);
        for particle in self.free(cloth) {
            let (mass, with) = (f64::from(self.model.particles.mass[particle]), self.with(frame, particle));
            let way = (ends.get(particle) - state.positions.get(particle) - with).as_dvec3();
            let last = (state.of_motion().get(particle) * self.length - with).as_dvec3();
            both += mass * way.dot(last);
            now += mass * way.length_squared();
            then += mass * last.length_squared();
        }
        if now > 0.0 && then > 0.0 { both / (now * then).sqrt() } else { 1.0 }
    }

    fn free(self, cloth: &ClothRange) -> impl Iterator<Item = usize> {
        cloth.particles().filter(move |&particle| self.model.particles.inverse_mass[particle] > 0.0)
    }

    fn with(self, frame: &RigidMotion, particle: usize) -> Vec3 {
        frame.way(self.start[particle]).as_vec3()
    }
}
