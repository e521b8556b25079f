//! Springs sorted into colours: springs of one colour share no particle.
//!
//! They can be corrected in any order, or at once, with the same result.
//!
//! Most springs of a cloth are slack, and stay so. Local correction (the paper's future work) visits a spring again only if
//! one of its ends has moved since it was visited: otherwise there is still nothing to correct, and the result is the same to
//! the last bit.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

use glam::Vec3;

use crate::geometry::{CHUNK, Pool, SharedVectors, Vectors, chunks, sum_in_any_order};
use crate::model::Model;

/// Type 1 springs with at least one free end, sorted by colour, each with what a method keeps about it.
pub(super) struct ColouredSprings<T> {
    springs: Vec<Coloured<T>>,
    /// Colour c holds `springs[starts[c]..starts[c + 1]]`.
    starts: Vec<usize>,
    /// When each particle was moved last, on a clock that ticks with every colour of every pass over one step.
    moved: Vec<AtomicU32>,
    clock: u32,
}

struct Coloured<T> {
    colour: u32,
    ends: [u32; 2],
    /// When it was visited last.
    visited: u32,
    kept: T,
}

/// What a pass over some springs found, before it mended it.
#[derive(Clone, Copy, Default)]
pub(super) struct Found {
    /// Springs that were corrected.
    pub over: u32,
    /// The largest violation, as the method measures it.
    pub worst: f32,
}

impl Found {
    /// Commutative and exact, so that the order of chunks cannot matter.
    fn and(self, other: Self) -> Self {
        Self { over: self.over + other.over, worst: self.worst.max(other.worst) }
    }
}

/// How to pass over the springs.
#[derive(Clone, Copy)]
pub(super) struct Pass {
    /// h [s].
    pub step: f32,
    /// Last colour first.
    pub backwards: bool,
    /// Visit only springs whose ends have moved: where a spring that was left alone and did not move would be left alone
    /// again. Never so in the first pass over a step.
    pub local: bool,
}

impl<T: Send> ColouredSprings<T> {
    /// The springs of a range of the model's; `keep` is given a spring and the inverse masses of its ends.
    pub fn new(model: &Model, range: Range<usize>, keep: impl Fn(usize, [f32; 2]) -> T) -> Self {
        let weights = &model.particles.inverse_mass;
        let mut taken: Vec<Vec<u32>> = vec![Vec::new(); model.particle_count()];
        let movable = range.filter_map(|spring| {
            let ends = model.springs.ends[spring];
            let [u, v] = ends.map(|end| weights[end as usize]);
            (u + v > 0.0).then(|| Coloured { colour: colour(&mut taken, ends), ends, visited: 0, kept: keep(spring, [u, v]) })
        });
        let mut springs: Vec<Coloured<T>> = movable.collect();
        springs.sort_by_key(|spring| spring.colour);
        let starts = std::iter::once(0)
            .chain(springs.chunk_by(|a, b| a.colour == b.colour).scan(0, |end, chunk| {
                *end += chunk.len();
                Some(*end)
            }))
            .collect();
        let moved = (0..model.particle_count()).map(|_| AtomicU32::new(0)).collect();
        Self { springs, starts, moved, clock: 0 }
    }

    /// Gives every spring to `correct`, one colour after the other, with P_uv, what is kept about it and what was found
    /// so far; moves its ends by what comes back.
    ///
    /// `ends_of_step` is P = X + V h; the impulses are added to `velocities` as well.
    pub fn sweep(
        &mut self,
        ends_of_step: &mut Vectors,
        velocities: &mut Vectors,
        pass: Pass,
        pool: &Pool,
        correct: impl Fn(Vec3, &mut T, &mut Found) -> Option<[Vec3; 2]> + Sync,
    ) -> Found {
        let (ends, velocities) = (ends_of_step.shared(), velocities.shared());
        let colours = self.starts.len() - 1;
        let mut found = Found::default();
        if !pass.local {
            self.clock = 0;
            self.moved.iter_mut().for_each(|moved| *moved.get_mut() = 0);
        }
        for colour in 0..colours {
            let colour = if pass.backwards { colours - 1 - colour } else { colour };
            let springs = &mut self.springs[self.starts[colour]..self.starts[colour + 1]];
            self.clock += 1;
            let visit = Visit { ends, velocities, step: pass.step, local: pass.local, now: self.clock, moved: &self.moved };
            let (in_parallel, runs) = (pool.pays_for(springs.len()), chunks(springs, CHUNK));
            let all = |_, springs: &mut [Coloured<T>]| visit.all(springs, &correct);
            found = found.and(sum_in_any_order(runs, in_parallel, Found::default(), all, Found::and));
        }
        found
    }

    /// Calls `work` with what is kept about each spring.
    pub fn for_each(&mut self, work: impl Fn(&mut T)) {
        self.springs.iter_mut().for_each(|spring| work(&mut spring.kept));
    }
}

/// A visit to springs of one colour.
struct Visit<'a> {
    ends: SharedVectors<'a>,
    velocities: SharedVectors<'a>,
    step: f32,
    local: bool,
    now: u32,
    moved: &'a [AtomicU32],
}

impl Visit<'_> {
    /// Corrects each spring.
    fn all<T>(&self, springs: &mut [Coloured<T>], correct: &impl Fn(Vec3, &mut T, &mut Found) -> Option<[Vec3; 2]>) -> Found {
        let mut found = Found::default();
        for spring in springs {
            let [u, v] = spring.ends.map(|end| end as usize);
            // Colours come one after the other, and springs of one colour share no particle: nobody writes these now.
            let rests = |particle: usize| self.moved[particle].load(Ordering::Relaxed) < spring.visited;
            if self.local && rests(u) && rests(v) {
                continue;
            }
            spring.visited = self.now;
            // SAFETY: springs of one colour share no particle, and all ends are particles of the model.
            let (p_u, p_v) = unsafe { (self.ends.get(u), self.ends.get(v)) };
            let Some([pull_u, pull_v]) = correct(p_v - p_u, &mut spring.kept, &mut found) else { continue };
            self.moved[u].store(self.now, Ordering::Relaxed);
            self.moved[v].store(self.now, Ordering::Relaxed);
            // SAFETY: as above.
            unsafe {
                self.ends.set(u, p_u + pull_u);
                self.ends.set(v, p_v + pull_v);
                // The velocity takes the impulse itself; (P - X) / h would round small motions away.
                self.velocities.set(u, self.velocities.get(u) + pull_u / self.step);
                self.velocities.set(v, self.velocities.get(v) + pull_v / self.step);
            }
        }
        found
    }
}

/// The lowest colour that no spring at either end has so far.
fn colour(taken: &mut [Vec<u32>], ends: [u32; 2]) -> u32 {
    let [u, v] = ends.map(|end| end as usize);
    let colour = (0..).find(|colour| !taken[u].contains(colour) && !taken[v].contains(colour)).unwrap_or_default();
    taken[u].push(colour);
    taken[v].push(colour);
    colour
}
