//! Cloth that hangs, or lies on something, comes to rest.
//!
//! Where its ways turn back on each other, each step is the mean of staying and of going where the limit and the rows lead. What no
//! projection brings further apart comes to rest so [Krasnoselskii55], where going all the way it may turn for ever. Staying means to go
//! with what carries the cloth.

use std::ops::Range;

use glam::{DVec3, Vec3};
use pulp::{Simd, WithSimd};

use super::motion::{BLOCK, LANES};
use crate::contact::RigidMotion;
use crate::geometry::{Pool, Vectors, arch, sum_of_chunks};
use crate::model::{ClothRange, Model};
use crate::schedule::Stride;
use crate::state::State;

/// Where ways turn back, their cosine with the last ones being below the first of these, steps go on by less of their way, down to the
/// least; where they go on, the cosine being above the second, by so much more.
const TURNED: f64 = 0.5;
const ONWARD: f64 = 0.9;
const FASTER: f32 = 1.5;
const LEAST_WAY: f32 = 0.005;

/// How the ways of a cloth become less.
pub(super) struct Slows {
    /// So much of its way goes the first step that turns back, and so many times the part that the last one went those that follow [1].
    first: f32,
    then: f32,
}

/// Of cloth that lies on something. It slides as far as another load asks for before it is held.
pub(super) const LIES: Slows = Slows { first: 0.9, then: 0.9 };
/// Of cloth that hangs. A swing that turns round, and a jerk, turn back once: then it goes nearly all of its way.
pub(super) const HANGS: Slows = Slows { first: 0.999, then: 0.8 };

/// Cloth that hardly moves, the brake being this at least, shows its load. The brake lets go where that changes by such a part: ways that
/// turn back would hide what another load asks for.
const FIRM: f32 = 0.95;
const OTHER_LOAD: f32 = 0.01;

/// What is left of the brake of a cloth under the load of a step, which is what this accelerates the cloth by in the mean. Keeps the load
/// under which the brake became firm.
pub(super) fn left_under_load(brake: f32, stride: Stride<'_>, index: usize, state: &mut State, proposed: &Vectors) -> f32 {
    // Without the velocities of the last motion nothing tells what has been gained.
    if brake == 0.0 || state.motion.is_empty() {
        state.loads[index] = Vec3::ZERO;
        return brake;
    }
    let (particles, length) = (&stride.model.particles, stride.plan.length as f32);
    let (mut gained, mut mass) = (DVec3::ZERO, 0.0);
    for particle in stride.model.cloths[index].particles().filter(|&particle| particles.inverse_mass[particle] > 0.0) {
        let velocity = (proposed.get(particle) - state.positions.get(particle)) / length;
        let own = f64::from(particles.mass[particle]);
        gained += own * (velocity - state.motion.get(particle)).as_dvec3();
        mass += own;
    }
    let (load, held) = ((gained / (mass * stride.plan.length)).as_vec3(), &mut state.loads[index]);
    let is_other = brake >= FIRM && (load - *held).length() > OTHER_LOAD * held.length();
    if is_other || brake < FIRM {
        *held = load;
    }
    if is_other { 0.0 } else { brake }
}

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

impl<'a> Lying<'a> {
    /// The ways of one of its cloths.
    pub fn ways(self, cloth: &'a ClothRange, frame: RigidMotion) -> Ways<'a, impl Fn(usize) -> Vec3 + Sync> {
        let Self { model, length, start, pool, .. } = self;
        Ways { model, cloth, length, with: move |particle: usize| frame.way(start[particle]).as_vec3(), pool }
    }
}

/// The ways of a cloth in a step, as seen from what carries it.
pub(super) struct Ways<'a, F> {
    pub model: &'a Model,
    pub cloth: &'a ClothRange,
    /// How long the step is [s].
    pub length: f32,
    /// How far a particle would go with what carries it [m].
    pub with: F,
    pub pool: &'a Pool,
}

impl<F: Fn(usize) -> Vec3 + Sync> Ways<'_, F> {
    /// The part of the kinetic energy of the proposal that is left [1].
    pub fn left_of_energy(&self, state: &State, proposed: &Vectors, ends: &Vectors) -> f64 {
        let (mut before, mut after) = (0.0, 0.0);
        for particle in self.free() {
            let mass = f64::from(self.model.particles.mass[particle]);
            let square = |ends: &Vectors| mass * f64::from(self.way(state, ends, particle).length_squared());
            before += square(proposed);
            after += square(ends);
        }
        if before > 0.0 { after / before } else { 1.0 }
    }

    /// Leaves a part of the way out, and returns it: more than `before`, the last one, where the way turns back, less where it goes on.
    /// `parts` is workspace, a place for every chunk of particles.
    pub fn brake(&self, before: f32, slows: Slows, state: &mut State, ends: &mut Vectors, parts: &mut [[f64; 3]]) -> f32 {
        let goes = 1.0 - before;
        let goes = match self.cosine(state, ends, parts) {
            cosine if cosine < TURNED && before == 0.0 => slows.first,
            cosine if cosine < TURNED => (goes * slows.then).max(LEAST_WAY),
            cosine if cosine > ONWARD => (goes * FASTER).min(1.0),
            _ => goes,
        };
        let brake = 1.0 - goes;
        if brake > 0.0 {
            for particle in self.free() {
                let back = self.way(state, ends, particle) * -brake;
                ends.set(particle, ends.get(particle) + back);
                state.velocities.set(particle, state.velocities.get(particle) + back / self.length);
            }
        }
        brake
    }

    /// The cosine between this way and the last one, of all particles together by mass [1].
    fn cosine(&self, state: &State, ends: &Vectors, parts: &mut [[f64; 3]]) -> f64 {
        let (positions, motion) = (&state.positions, state.of_motion());
        let [both, now, then] = sum_of_chunks(self.cloth.count, parts, self.pool, |run| {
            let run = self.cloth.first + run.start..self.cloth.first + run.end;
            arch().dispatch(Products { ways: self, run, positions, ends, motion })
        });
        if now > 0.0 && then > 0.0 { both / (now * then).sqrt() } else { 1.0 }
    }

    fn way(&self, state: &State, ends: &Vectors, particle: usize) -> Vec3 {
        ends.get(particle) - state.positions.get(particle) - (self.with)(particle)
    }

    fn free(&self) -> impl Iterator<Item = usize> {
        self.cloth.particles().filter(|&particle| self.model.particles.inverse_mass[particle] > 0.0)
    }
}

/// Sums of M D D', M D D and M D' D', D' being the last way. What is held goes with what carries it: it adds nothing.
struct Products<'a, F> {
    ways: &'a Ways<'a, F>,
    run: Range<usize>,
    positions: &'a Vectors,
    ends: &'a Vectors,
    motion: &'a Vectors,
}

impl<F: Fn(usize) -> Vec3 + Sync> WithSimd for Products<'_, F> {
    type Output = [f64; 3];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [f64; 3] {
        let with = &self.ways.with;
        let along_x = self.along(|vectors| &vectors.x, |particle| with(particle).x);
        let along_y = self.along(|vectors| &vectors.y, |particle| with(particle).y);
        let along_z = self.along(|vectors| &vectors.z, |particle| with(particle).z);
        std::array::from_fn(|sum| along_x[sum] + along_y[sum] + along_z[sum])
    }
}

impl<F: Fn(usize) -> Vec3 + Sync> Products<'_, F> {
    /// Along one of the axes.
    #[inline(always)]
    fn along(&self, column: impl Fn(&Vectors) -> &[f32], with: impl Fn(usize) -> f32) -> [f64; 3] {
        let Ways { model, length, .. } = self.ways;
        let [starts, ends, velocities] = [self.positions, self.ends, self.motion].map(column);
        let masses = &model.particles.mass;
        let mut sums = [0.0; 3];
        for first in self.run.clone().step_by(BLOCK) {
            let block = first..self.run.end.min(first + BLOCK);
            let mut lanes = [[0.0_f32; LANES]; 3];
            let columns = [starts, ends, velocities, masses].map(|column| column[block.clone()].as_chunks::<LANES>());
            let [starts, ends, velocities, masses] = columns.map(|(lines, _)| lines);
            for (line, (((starts, ends), velocities), masses)) in starts.iter().zip(ends).zip(velocities).zip(masses).enumerate()
            {
                for lane in 0..LANES {
                    let with = with(first + line * LANES + lane);
                    add(&mut lanes, lane, ends[lane] - starts[lane] - with, velocities[lane] * length - with, masses[lane]);
                }
            }
            let [starts, ends, velocities, masses] = columns.map(|(_, rest)| rest);
            for lane in 0..starts.len().min(LANES) {
                let with = with(block.end - starts.len() + lane);
                add(&mut lanes, lane, ends[lane] - starts[lane] - with, velocities[lane] * length - with, masses[lane]);
            }
            sums.iter_mut().zip(lanes).for_each(|(sum, lanes)| lanes.iter().for_each(|lane| *sum += f64::from(*lane)));
        }
        sums
    }
}

#[inline(always)]
fn add(sums: &mut [[f32; LANES]; 3], lane: usize, now: f32, then: f32, mass: f32) {
    sums[0][lane] += mass * now * then;
    sums[1][lane] += mass * now * now;
    sums[2][lane] += mass * then * then;
}
