//! Springs sorted into colours: springs of one colour share no particle.
//!
//! They can be projected in any order, or at once, with the same result.

use std::ops::Range;

use rayon::prelude::*;

use crate::geometry::{CHUNK, Pool, SharedVectors, Vectors};
use crate::model::Model;

/// Type 1 springs with at least one free end, sorted by colour.
pub(super) struct ColouredSprings {
    springs: Vec<Spring>,
    /// Colour c holds `springs[starts[c]..starts[c + 1]]`.
    starts: Vec<usize>,
}

#[derive(Clone, Copy)]
struct Spring {
    ends: [u32; 2],
    /// R [m].
    limit: f32,
    /// w_u / (w_u + w_v); the other end has the rest.
    share: f32,
}

/// What a pass over some springs found, before it mended it.
#[derive(Clone, Copy, Default)]
pub(super) struct Found {
    /// Springs over their limit.
    pub over: u32,
    /// Largest (|P_uv| / R)^2.
    pub worst: f32,
}

impl Found {
    /// Commutative and exact, so that the order of chunks cannot matter.
    fn and(self, other: Self) -> Self {
        Self { over: self.over + other.over, worst: self.worst.max(other.worst) }
    }
}

impl ColouredSprings {
    /// The springs of a range of the model's.
    pub fn new(model: &Model, range: Range<usize>) -> Self {
        let (springs, weights) = (&model.springs, &model.particles.inverse_mass);
        let movable = range.filter_map(|index| {
            let ends = springs.ends[index];
            let [u, v] = ends.map(|end| weights[end as usize]);
            (u + v > 0.0).then(|| Spring { ends, limit: springs.greatest_length(index), share: u / (u + v) })
        });
        let mut coloured: Vec<(u32, Spring)> = colour(movable, model.particle_count());
        coloured.sort_by_key(|(colour, _)| *colour);
        let starts = std::iter::once(0)
            .chain(coloured.chunk_by(|a, b| a.0 == b.0).scan(0, |end, chunk| {
                *end += chunk.len();
                Some(*end)
            }))
            .collect();
        Self { springs: coloured.into_iter().map(|(_, spring)| spring).collect(), starts }
    }

    /// Projects every spring that is over `aim` times its limit to there, one colour after the other.
    ///
    /// `ends_of_step` is P = X + V h; the impulses are added to `velocities` as well.
    pub fn sweep(&self, ends_of_step: &mut Vectors, velocities: &mut Vectors, pass: Pass, pool: &Pool) -> Found {
        let (ends, velocities) = (ends_of_step.shared(), velocities.shared());
        let colours = self.starts.len() - 1;
        let mut found = Found::default();
        for colour in 0..colours {
            let colour = if pass.backwards { colours - 1 - colour } else { colour };
            let springs = &self.springs[self.starts[colour]..self.starts[colour + 1]];
            found = found.and(if pool.pays_for(springs.len()) {
                let chunks = springs.par_chunks(CHUNK).map(|chunk| project(chunk, ends, velocities, pass));
                chunks.reduce(Found::default, Found::and)
            } else {
                project(springs, ends, velocities, pass)
            });
        }
        found
    }
}

/// How to pass over the springs.
#[derive(Clone, Copy)]
pub(super) struct Pass {
    /// h [s].
    pub step: f32,
    /// Part of R to which springs are pulled.
    pub aim: f32,
    /// Last colour first.
    pub backwards: bool,
}

/// Projects each spring of one colour.
fn project(springs: &[Spring], ends_of_step: SharedVectors<'_>, velocities: SharedVectors<'_>, pass: Pass) -> Found {
    let mut found = Found::default();
    for spring in springs {
        let [u, v] = spring.ends.map(|end| end as usize);
        // SAFETY: springs of one colour share no particle, and all ends are particles of the model.
        let (p_u, p_v) = unsafe { (ends_of_step.get(u), ends_of_step.get(v)) };
        let p_uv = p_v - p_u;
        let square = p_uv.length_squared();
        found.worst = found.worst.max(square / (spring.limit * spring.limit));
        let reach = spring.limit * pass.aim;
        if square <= reach * reach {
            continue;
        }
        found.over += 1;
        let pull = p_uv * (1.0 - reach / square.sqrt());
        let (pull_u, pull_v) = (pull * spring.share, pull * (spring.share - 1.0));
        // SAFETY: as above.
        unsafe {
            ends_of_step.set(u, p_u + pull_u);
            ends_of_step.set(v, p_v + pull_v);
            // The velocity takes the impulse itself; (P - X) / h would round small motions away.
            velocities.set(u, velocities.get(u) + pull_u / pass.step);
            velocities.set(v, velocities.get(v) + pull_v / pass.step);
        }
    }
    found
}

/// Gives each spring the lowest colour that none of its neighbours has.
fn colour(springs: impl Iterator<Item = Spring>, particles: usize) -> Vec<(u32, Spring)> {
    let mut taken: Vec<Vec<u32>> = vec![Vec::new(); particles];
    springs
        .map(|spring| {
            let [u, v] = spring.ends.map(|end| end as usize);
            let colour = (0..).find(|colour| !taken[u].contains(colour) && !taken[v].contains(colour)).unwrap_or_default();
            taken[u].push(colour);
            taken[v].push(colour);
            (colour, spring)
        })
        .collect()
}
