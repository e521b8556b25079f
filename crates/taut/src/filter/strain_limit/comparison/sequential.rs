//! The paper's algorithm to the letter (section 3, steps 1 to 6).
//!
//! The paper leaves the order open; ours is breadth-first from the pins (from the lowest particle where a piece has
//! none), each particle once per neighbour that was visited before it. Known faults, kept on purpose: a taut spring
//! admits no sideways motion at all, and only v is corrected, so momentum is not conserved.

use std::collections::VecDeque;

use super::StrainLimit;
use crate::filter::Limited;
use crate::geometry::{Pool, Vectors};
use crate::model::{Adjacency, Model};
use crate::schedule::Stride;
use crate::state::State;

/// A spring in the order of the walk.
struct Visit {
    /// The particle visited before.
    u: u32,
    /// The particle whose velocity is corrected.
    v: u32,
    /// R = (1 + lambda) L [m].
    limit: f32,
}

/// The walk over the springs.
pub(in super::super) struct Sequential {
    walk: Vec<Visit>,
}

impl Sequential {
    pub(in super::super) fn new(model: &Model) -> Self {
        let springs = &model.springs;
        let both = (0..springs.type1).flat_map(|spring| {
            let [a, b] = springs.ends[spring];
            [(a, (b, spring as u32)), (b, (a, spring as u32))]
        });
        let neighbours = Adjacency::new(model.particle_count(), both);
        let order = breadth_first(model, &neighbours);
        let mut rank = vec![0; order.len()];
        for (place, &particle) in order.iter().enumerate() {
            rank[particle as usize] = place;
        }
        let free = |particle: u32| model.particles.inverse_mass[particle as usize] > 0.0;
        let walk = order.iter().filter(|&&v| free(v)).flat_map(|&v| {
            let before = neighbours.of(v as usize).iter().filter(|(u, _)| rank[*u as usize] < rank[v as usize]);
            before.map(move |&(u, spring)| Visit { u, v, limit: springs.greatest_length(spring as usize) }).collect::<Vec<_>>()
        });
        Self { walk: walk.collect() }
    }
}

/// All particles, each piece from its pins outwards.
fn breadth_first(model: &Model, neighbours: &Adjacency<(u32, u32)>) -> Vec<u32> {
    let count = model.particle_count();
    let (mut seen, mut order) = (vec![false; count], Vec::with_capacity(count));
    let pins = model.pins.iter().flat_map(|group| group.particles.iter().copied());
    let held = (0..count as u32).filter(|&particle| model.particles.inverse_mass[particle as usize] == 0.0);
    let mut queue = VecDeque::new();
    for particle in pins.chain(held) {
        if !std::mem::replace(&mut seen[particle as usize], true) {
            queue.push_back(particle);
        }
    }
    for start in 0..=count {
        while let Some(particle) = queue.pop_front() {
            order.push(particle);
            for &(other, _) in neighbours.of(particle as usize) {
                if !std::mem::replace(&mut seen[other as usize], true) {
                    queue.push_back(other);
                }
            }
        }
        if start < count && !std::mem::replace(&mut seen[start], true) {
            queue.push_back(start as u32);
        }
    }
    order
}

impl StrainLimit for Sequential {
    fn apply(&mut self, stride: Stride<'_>, state: &mut State, ends: &mut Vectors, pool: &Pool) -> Limited {
        let (model, step) = (stride.model, stride.plan.length as f32);
        let mut springs = 0;
        for &Visit { u, v, limit } in &self.walk {
            let (u, v) = (u as usize, v as usize);
            // Steps 1 to 3.
            let x_uv = state.positions.get(v) - state.positions.get(u);
            let v_uv = state.velocities.get(v) - state.velocities.get(u);
            // Step 4.
            if (x_uv + v_uv * step).length_squared() <= limit * limit {
                continue;
            }
            // Steps 5 and 6; particles that move alike leave nothing to scale.
            let speed = v_uv.length();
            if speed > 0.0 {
                let direction = v_uv / speed;
                let greatest = largest_speed(x_uv.dot(direction), x_uv.length_squared(), limit, step);
                state.velocities.set(v, state.velocities.get(u) + direction * greatest);
            }
            springs += 1;
        }
        let State { positions, velocities, .. } = state;
        ends.set_scaled(0..model.particle_count(), positions, velocities, step, pool);
        Limited { springs, sweeps: 1, ..Limited::default() }
    }
}

/// Largest s with `|X + s h d| <= R`: the greater root of `h^2 s^2 + 2 h s X.d + |X|^2 - R^2 = 0` [m/s].
///
/// `along` is X.d and `square` |X|^2. Where no speed along d is admissible, the one that comes nearest to u.
fn largest_speed(along: f32, square: f32, limit: f32, step: f32) -> f32 {
    let discriminant = along * along - square + limit * limit;
    (-along + discriminant.max(0.0).sqrt()) / step
}

#[cfg(test)]
mod tests {
    use super::largest_speed;

    #[test]
    fn the_root_is_the_one_of_the_quadratic() {
        // Straight outwards from half the limit: the rest of the way, R - |X|, in one step.
        assert!((largest_speed(0.5, 0.25, 1.0, 0.1) - 5.0).abs() < 1e-6);
        // A taut spring, sideways: nothing is admissible (the frozen pendulum).
        assert_eq!(largest_speed(0.0, 1.0, 1.0, 0.1), 0.0);
        // Over the limit, moving outwards: the root is negative, the opposite direction.
        assert!((largest_speed(1.2, 1.44, 1.0, 0.1) + 2.0).abs() < 1e-5);
        // Out of reach along d: the nearest point of the line.
        assert!((largest_speed(0.1, 4.0, 1.0, 0.1) + 1.0).abs() < 1e-6);
    }
}
