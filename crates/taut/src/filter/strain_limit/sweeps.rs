//! Repeated symmetric, mass-weighted projections on to one spring after the other.
//!
//! Let P = X + V h. A spring with |P_uv| > R pulls both ends together along P_uv, each in proportion to its inverse
//! mass, until |P_uv| = R. That is the projection of P, in the mass norm, on to the convex set |P_uv| <= R; no such
//! projection leads further away from X if X is admissible, so the filter never adds kinetic energy
//! (docs/equations.md, "Sweeps"). Springs of one colour share no particle: they are projected in any order, or at
//! once, with the same result.

use rayon::prelude::*;

use super::StrainLimit;
use crate::filter::Limited;
use crate::geometry::{CHUNK, Pool, SharedVectors, Vectors};
use crate::model::Model;
use crate::state::State;

/// The limited springs, sorted by colour.
pub(super) struct Sweeps {
    springs: Vec<Spring>,
    /// Colour c holds `springs[starts[c]..starts[c + 1]]`.
    starts: Vec<usize>,
    /// P = X + V h [m].
    ends_of_step: Vectors,
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
struct Found {
    over: u32,
    /// Largest (|P_uv| / R)^2.
    worst: f32,
}

impl Found {
    /// Commutative and exact, so that the order of chunks cannot matter.
    fn and(self, other: Self) -> Self {
        Self { over: self.over + other.over, worst: self.worst.max(other.worst) }
    }
}

impl Sweeps {
    pub(super) fn new(model: &Model) -> Self {
        let (springs, weights) = (&model.springs, &model.particles.inverse_mass);
        let movable = (0..springs.type1).filter_map(|index| {
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
        let springs = coloured.into_iter().map(|(_, spring)| spring).collect();
        Self { springs, starts, ends_of_step: Vectors::zeros(model.particle_count()) }
    }

    fn sweep(&mut self, state: &mut State, step: f32, backwards: bool, pool: &Pool) -> Found {
        let (ends, velocities) = (self.ends_of_step.shared(), state.velocities.shared());
        let colours = self.starts.len() - 1;
        let mut found = Found::default();
        for colour in 0..colours {
            let colour = if backwards { colours - 1 - colour } else { colour };
            let springs = &self.springs[self.starts[colour]..self.starts[colour + 1]];
            found = found.and(if pool.pays_for(springs.len()) {
                let chunks = springs.par_chunks(CHUNK).map(|chunk| project(chunk, ends, velocities, step));
                chunks.reduce(Found::default, Found::and)
            } else {
                project(springs, ends, velocities, step)
            });
        }
        found
    }
}

impl StrainLimit for Sweeps {
    fn apply(&mut self, model: &Model, state: &mut State, pool: &Pool) -> Limited {
        let step = model.timing.step_length as f32;
        let (positions, velocities) = (&state.positions, &state.velocities);
        self.ends_of_step
            .for_each_chunk(pool, |chunk| chunk.map(|particle, _| positions.get(particle) + velocities.get(particle) * step));
        let allowed = (1.0 + model.solver.tolerance as f32).powi(2);
        let mut limited = Limited::default();
        while limited.sweeps < model.solver.iterations {
            let found = self.sweep(state, step, limited.sweeps % 2 == 1, pool);
            if limited.sweeps == 0 {
                limited.springs = found.over;
            }
            limited.sweeps += 1;
            if found.worst <= allowed {
                break;
            }
        }
        limited
    }
}

/// Projects each spring of one colour.
fn project(springs: &[Spring], ends_of_step: SharedVectors<'_>, velocities: SharedVectors<'_>, step: f32) -> Found {
    let mut found = Found::default();
    for spring in springs {
        let [u, v] = spring.ends.map(|end| end as usize);
        // SAFETY: springs of one colour share no particle, and all ends are particles of the model.
        let (p_u, p_v) = unsafe { (ends_of_step.get(u), ends_of_step.get(v)) };
        let p_uv = p_v - p_u;
        let square = p_uv.length_squared();
        let limit_squared = spring.limit * spring.limit;
        found.worst = found.worst.max(square / limit_squared);
        if square <= limit_squared {
            continue;
        }
        found.over += 1;
        let pull = p_uv * (1.0 - spring.limit / square.sqrt());
        let (pull_u, pull_v) = (pull * spring.share, pull * (spring.share - 1.0));
        // SAFETY: as above.
        unsafe {
            ends_of_step.set(u, p_u + pull_u);
            ends_of_step.set(v, p_v + pull_v);
            // The velocity takes the impulse itself; (P - X) / h would round small motions away.
            velocities.set(u, velocities.get(u) + pull_u / step);
            velocities.set(v, velocities.get(v) + pull_v / step);
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
