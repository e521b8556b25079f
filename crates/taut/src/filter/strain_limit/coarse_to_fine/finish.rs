//! The last few springs that cycles leave over their limit, put right one by one.
//!
//! Cycles bring nearly all springs below their limit soon, and then go on for the sake of a few: a short spring beside a corner that
//! bears the whole cloth. What such springs are too long is small, and around them springs are shorter than they may be by the
//! back-off. So particles are visited outwards from what is held. Each one is moved into the balls that its neighbours further in
//! allow it, and only it moves; those further out that are too far from it then are visited later. Where no place suits them all,
//! it and they move halfway to each other, and are visited again. The way dies out where the back-off has taken it up: tens to
//! hundreds of particles are touched in a step, most by less than a thousandth of a spring.
//!
//! This is the one-sided correction of the paper (section 3, step 6: the particle nearer to what is held stays) along the spring
//! instead of along the velocity. It drops reactions. For what is left here they are small, but not those of heavy points and hands: there
//! more cycles come first.

use glam::Vec3;

use super::Levels;
use super::queue::Queue;
use crate::model::{Adjacency, ClothRange, Model};

/// The balls around a particle are met by going to each of them in turn, so many times at most.
const ROUNDS: usize = 16;
/// Where more visits than this and a tenth of all find no place, or more moves are made than the cloth has particles, it is not nearly
/// done: what was moved is put back, since it would only disturb further cycles.
const FAILURES: usize = 8;
const VISITS_PER_FAILURE: usize = 10;
/// A particle goes further into a ball than it must by this part of its radius: rounding would ask for another round.
const INTO: f32 = 1e-6;

/// The springs of a cloth, and the order in which its particles are visited.
pub(super) struct Finish {
    /// The neighbours of each particle and the greatest lengths of the springs to them [m].
    around: Adjacency<(u32, f32)>,
    /// How far each particle is from what is held, along springs [m]; from the first particle where nothing is.
    depth: Vec<f32>,
    held: Vec<bool>,
    /// What bodies grip of it, and is held only as long as they do.
    gripped: Vec<usize>,
    queue: Queue,
    /// What was moved, and how far [m].
    moves: Vec<(u32, Vec3)>,
}

impl Finish {
    /// Of a cloth, whose springs of type 1 have limits.
    pub fn new(model: &Model, cloth: &ClothRange) -> Self {
        let first = cloth.first as u32;
        let held: Vec<bool> = cloth.particles().map(|particle| model.particles.inverse_mass[particle] == 0.0).collect();
        let moves = |&spring: &usize| !model.springs.ends[spring].iter().all(|end| held[(end - first) as usize]);
        let springs = cloth.springs.clone().filter(moves).flat_map(|spring| {
            let [a, b] = model.springs.ends[spring].map(|end| end - first);
            let limit = model.springs.greatest_length(spring);
            [(a, (b, limit)), (b, (a, limit))]
        });
        let around = Adjacency::new(cloth.count, springs);
        let mut queue = Queue::new(cloth.count);
        // As many moves as particles, and what one more visit may add.
        let room = (ROUNDS + 2) * (0..cloth.count).map(|particle| around.of(particle).len()).max().unwrap_or(0);
        let mut depth = vec![0.0; cloth.count];
        find_depths(&around, &held, &mut queue, &mut depth);
        Self { around, depth, held, gripped: Vec::new(), queue, moves: Vec::with_capacity(cloth.count + room) }
    }

    /// Starts from what bodies grip as well, in this step and until it is told otherwise.
    pub fn hold(&mut self, gripped: impl Iterator<Item = usize> + Clone) {
        if self.gripped.iter().copied().eq(gripped.clone()) {
            return;
        }
        self.gripped.drain(..).for_each(|particle| self.held[particle] = false);
        self.gripped.extend(gripped);
        self.gripped.iter().for_each(|&particle| self.held[particle] = true);
        find_depths(&self.around, &self.held, &mut self.queue, &mut self.depth);
    }

    /// The neighbours of each particle and the greatest lengths of the springs to them [m].
    pub fn around(&self) -> &Adjacency<(u32, f32)> {
        &self.around
    }

    /// Makes all springs at most `enough` of their limit long. Returns whether that was done: where it was not, too many particles found
    /// no place that suits all their neighbours further in.
    pub fn run(&mut self, levels: &mut dyn Levels, enough: f32) -> bool {
        let Self { around, depth, held, queue, moves, .. } = self;
        levels.over(enough, &mut |[a, b]| {
            let outer = if comes_before(depth, a, b) { b } else { a };
            // A spring between two held ends is as long as these ask for.
            if !held[outer] {
                queue.put(outer, depth[outer]);
            }
        });
        moves.clear();
        let (mut visits, mut failures) = (0, 0);
        while let Some(particle) = queue.take() {
            debug_assert!(!held[particle], "what is held comes before all that its springs lead to");
            let inwards = around.of(particle).iter().filter(|(other, _)| comes_before(depth, *other as usize, particle));
            let mut rounds = 0..ROUNDS;
            let fits = rounds.any(|_| go_into(levels, particle, inwards.clone(), enough, moves));
            visits += 1;
            if !fits {
                failures += 1;
                let too_far = inwards.filter(|(other, _)| !held[*other as usize]);
                too_far.for_each(|&(other, limit)| {
                    if come_closer(levels, [particle, other as usize], enough * limit, moves) {
                        queue.put(other as usize, depth[other as usize]);
                    }
                });
                queue.put(particle, depth[particle]);
            }
            if failures > FAILURES + visits / VISITS_PER_FAILURE || moves.len() > held.len() {
                queue.clear();
                moves.drain(..).rev().for_each(|(particle, way)| levels.shift(particle as usize, -way));
                return false;
            }
            for &(other, limit) in around.of(particle) {
                let other = other as usize;
                let reach = enough * limit;
                if comes_before(depth, particle, other) && levels.between(particle, other).length_squared() > reach * reach {
                    queue.put(other, depth[other]);
                }
            }
        }
        true
    }
}

/// Moves a particle into the balls around others, one after the other, and notes each of the `moves`. Returns whether it was in all of them.
fn go_into<'a>(
    levels: &mut dyn Levels,
    particle: usize,
    balls: impl Iterator<Item = &'a (u32, f32)>,
    enough: f32,
    moves: &mut Vec<(u32, Vec3)>,
) -> bool {
    let mut inside = true;
    for &(other, radius) in balls {
        let way = levels.between(particle, other as usize);
        let (square, reach) = (way.length_squared(), enough * radius);
        if square > reach * reach {
            let way = way * (1.0 - (1.0 - INTO) * reach / square.sqrt());
            levels.shift(particle, way);
            moves.push((particle as u32, way));
            inside = false;
        }
    }
    inside
}

/// Moves two particles that are more than `reach` apart halfway to each other, and notes that in `moves`. Returns whether they were.
fn come_closer(levels: &mut dyn Levels, [a, b]: [usize; 2], reach: f32, moves: &mut Vec<(u32, Vec3)>) -> bool {
    let way = levels.between(a, b);
    let length = way.length();
    if length <= reach {
        return false;
    }
    let way = way * (0.5 * (1.0 - (1.0 - INTO) * reach / length));
    for (particle, way) in [(a, way), (b, -way)] {
        levels.shift(particle, way);
        moves.push((particle as u32, way));
    }
    true
}

/// Whether `a` is visited before `b`.
fn comes_before(depth: &[f32], a: usize, b: usize) -> bool {
    (depth[a], a) < (depth[b], b)
}

/// Shortest ways along springs (Dijkstra); pieces without anything held begin at their first particle.
fn find_depths(around: &Adjacency<(u32, f32)>, held: &[bool], queue: &mut Queue, depth: &mut [f32]) {
    depth.iter_mut().zip(held).for_each(|(depth, held)| *depth = if *held { 0.0 } else { f32::INFINITY });
    let starts = (0..held.len()).filter(|&particle| held[particle]);
    starts.for_each(|particle| queue.put(particle, 0.0));
    for next in 0..=held.len() {
        while let Some(particle) = queue.take() {
            for &(other, length) in around.of(particle) {
                let through = depth[particle] + length;
                if through < depth[other as usize] {
                    depth[other as usize] = through;
                    queue.put(other as usize, through);
                }
            }
        }
        if depth.get(next) == Some(&f32::INFINITY) {
            depth[next] = 0.0;
            queue.put(next, 0.0);
        }
    }
}
