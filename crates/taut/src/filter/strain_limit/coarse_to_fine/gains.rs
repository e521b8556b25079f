//! What touches something gains no energy but what bodies and pins give it.
//!
//! The nearest admissible step in the mass norm is never further from one that is admissible than the proposed step was [Moreau65]. Going
//! with what carries the cloth is such a step, where all of that moves as one: seen from there, kinetic energy never rises. Sweeps and
//! cycles find an admissible step, and not always the nearest one, least of all where cloth has hardly any room. So what they find is
//! shortened to what the nearest one could have, and velocities as well (docs/equations.md, "Energy").

use glam::DVec3;

use super::brake::Lying;
use crate::contact::{Carried, RigidMotion};
use crate::geometry::{CHUNK, Vectors, sum_of_chunks};
use crate::schedule::Stride;
use crate::state::State;

/// Workspace: what there is of cloths that touch each other, at the first of them.
#[derive(Default)]
pub(super) struct Gains {
    groups: Vec<Group>,
    parts: Vec<[f64; NUMBERS]>,
    /// The part of its way that each cloth lost last, by its number [1].
    pub taken: Vec<f64>,
}

/// The mass, and four sums of four numbers each.
const NUMBERS: usize = 17;

#[derive(Clone, Copy, Default)]
struct Group {
    /// How what carries them goes, if anything does; and how far a part of that goes beside it, and brings apart what is too near [m].
    frame: Option<RigidMotion>,
    apart: f64,
    /// A limit that tightens does work.
    tightens: bool,
    mass: f64,
    ways: Gain,
    velocities: Gain,
}

/// What a step makes of ways or velocities.
#[derive(Clone, Copy, Default)]
struct Gain {
    before: Sum,
    after: Sum,
}

/// Sums of vectors times masses, and of their squares times masses.
#[derive(Clone, Copy, Default)]
struct Sum {
    all: DVec3,
    square: f64,
}

impl Gains {
    /// Bounds the kinetic energy of what touches something. `taken` says how much of its way each cloth loses.
    pub fn bound(
        &mut self,
        stride: Stride<'_>,
        lying: Lying<'_>,
        proposed: &Vectors,
        state: &mut State,
        ends: &mut Vectors,
        carried: &[Carried],
    ) {
        let Stride { model, .. } = stride;
        let step = f64::from(lying.length);
        self.find_frames(stride, lying, proposed, carried);
        let is_free = |particle: &usize| model.particles.inverse_mass[*particle] > 0.0;
        let way = |state: &State, ends: &Vectors, particle| (ends.get(particle) - state.positions.get(particle)).as_dvec3();
        for (cloth, carried) in model.cloths.iter().zip(carried) {
            let group = &mut self.groups[carried.first];
            let chunks = cloth.count.div_ceil(CHUNK);
            self.parts.resize(self.parts.len().max(chunks), [0.0; NUMBERS]);
            let numbers = sum_of_chunks(cloth.count, &mut self.parts[..chunks], lying.pool, |run| {
                let (mut all, mut sums) = (0.0, [Sum::default(); 4]);
                for particle in (cloth.first + run.start..cloth.first + run.end).filter(is_free) {
                    let mass = f64::from(model.particles.mass[particle]);
                    let with = group.with(lying.start[particle]);
                    all += mass;
                    let ways = [lying.proposed, &*ends].map(|ends| way(state, ends, particle) - with);
                    let velocities = [proposed, &state.velocities].map(|of| of.get(particle).as_dvec3() - with / step);
                    sums.iter_mut().zip(ways.into_iter().chain(velocities)).for_each(|(sum, vector)| sum.add(mass, vector));
                }
                let numbers = sums.iter().flat_map(|sum| [sum.all.x, sum.all.y, sum.all.z, sum.square]);
                let mut numbers = std::iter::once(all).chain(numbers);
                std::array::from_fn(|_| numbers.next().unwrap_or_default())
            });
            group.take(&numbers);
        }
        self.taken.clear();
        self.taken.resize(model.cloths.len(), 0.0);
        for ((cloth, carried), taken) in model.cloths.iter().zip(carried).zip(&mut self.taken) {
            let group = &self.groups[carried.first];
            let [of_ways, of_velocities] = group.parts_that_are_left(step);
            let [(mean, astray), (mean_velocity, astray_velocity)] = [group.mean(&group.ways), group.mean(&group.velocities)];
            *taken = 1.0 - of_ways;
            if of_ways >= 1.0 && of_velocities >= 1.0 && [astray, astray_velocity] == [DVec3::ZERO; 2] {
                continue;
            }
            for particle in cloth.particles().filter(is_free) {
                let with = group.with(lying.start[particle]);
                if of_ways < 1.0 || astray != DVec3::ZERO {
                    let with = with + mean;
                    let now = with + (way(state, ends, particle) - astray - with) * of_ways;
                    ends.set(particle, state.positions.get(particle) + now.as_vec3());
                }
                if of_velocities < 1.0 || astray_velocity != DVec3::ZERO {
                    let with = with / step + mean_velocity;
                    let now = with + (state.velocities.get(particle).as_dvec3() - astray_velocity - with) * of_velocities;
                    state.velocities.set(particle, now.as_vec3());
                }
            }
        }
    }

    /// Finds from where the cloths that touch each other are seen.
    fn find_frames(&mut self, stride: Stride<'_>, lying: Lying<'_>, velocities: &Vectors, carried: &[Carried]) {
        let Stride { model, inputs, .. } = stride;
        self.groups.clear();
        self.groups.resize(model.cloths.len(), Group::default());
        for carried in carried {
            let group = &mut self.groups[carried.first];
            (group.frame, group.apart) = (carried.motion, carried.apart);
        }
        for (index, (cloth, carried)) in model.cloths.iter().zip(carried).enumerate() {
            let group = &mut self.groups[carried.first];
            group.tightens |= inputs.limits[index].changes();
            for particle in model.particles.held(cloth.particles()) {
                let way = velocities.get(particle).as_dvec3() * f64::from(lying.length);
                let frame = group.frame.get_or_insert(RigidMotion::along(way));
                group.apart = group.apart.max((way - frame.way(lying.start[particle])).length());
            }
        }
    }
}

impl Group {
    /// Takes the sums of a cloth.
    fn take(&mut self, numbers: &[f64; NUMBERS]) {
        self.mass += numbers[0];
        let Self { ways, velocities, .. } = self;
        let sums = [&mut ways.before, &mut ways.after, &mut velocities.before, &mut velocities.after];
        for (sum, own) in sums.into_iter().zip(numbers[1..].as_chunks::<4>().0) {
            sum.all += DVec3::from_slice(own);
            sum.square += own[3];
        }
    }

    /// How far a particle at a place would go along [m].
    fn with(&self, place: DVec3) -> DVec3 {
        self.frame.map_or(DVec3::ZERO, |frame| frame.way(place))
    }

    /// What nothing carries keeps its momentum: how it goes on the mean, and what cycles have added to that.
    fn mean(&self, gain: &Gain) -> (DVec3, DVec3) {
        match self.frame {
            Some(_) => (DVec3::ZERO, DVec3::ZERO),
            None => (gain.before.all / self.mass, (gain.after.all - gain.before.all) / self.mass),
        }
    }

    /// The parts of its ways and of its velocities that it may have. Where bodies and pins move apart no frame is known from which kinetic
    /// energy would not rise: it may be that of the largest speed with which one of them goes beside the others. So goes a rope over a
    /// pulley that is pulled away. So it may be where what is too near is brought apart.
    fn parts_that_are_left(&self, step: f64) -> [f64; 2] {
        let square = |sum: &Sum| match self.frame {
            Some(_) => sum.square,
            None => sum.square - sum.all.length_squared() / self.mass,
        };
        let part = |gain: &Gain, least: f64| {
            let (most, after) = (square(&gain.before).max(least), square(&gain.after));
            if after > most && !self.tightens { (most / after).sqrt() } else { 1.0 }
        };
        let speed = self.apart / step;
        [part(&self.ways, self.mass * self.apart * self.apart), part(&self.velocities, self.mass * speed * speed)]
    }
}

impl Sum {
    fn add(&mut self, mass: f64, vector: DVec3) {
        self.all += vector * mass;
        self.square += mass * vector.length_squared();
    }
}
