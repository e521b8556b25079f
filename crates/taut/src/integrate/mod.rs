//! Velocities in, positions out.

use crate::geometry::{Pool, Vectors};
use crate::model::Timing;
use crate::state::State;

/// One of the equal parts of a step: positions drift, forces kick velocities, positions drift again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// How long positions drift before the kick [s].
    pub before: f32,
    /// How long forces act [s].
    pub kick: f32,
    /// How long positions drift after it [s].
    pub after: f32,
}

/// The parts of a step.
///
/// Where the filter looks at every part, the paper's Euler method (section 3), velocity first: `V^(t+h) = V^t + F h / M`,
/// `X^(t+h) = X^t + V^(t+h) h` (printed with V on the left; see docs/equations.md). Where it looks at several at once,
/// leapfrog: its energy has no term in X V, so that what dampers and filters take from V is always taken from the energy.
/// The second half of one part's drift and the first half of the next are one.
pub fn parts(timing: &Timing) -> impl Iterator<Item = Part> {
    let count = timing.spring_steps;
    let length = (timing.step_length / f64::from(count)) as f32;
    let half = if count > 1 { 0.5 * length } else { 0.0 };
    (0..count).map(move |part| Part {
        before: if part == 0 { half } else { 0.0 },
        kick: length,
        after: if part + 1 == count { length - half } else { length },
    })
}

/// `X += V h`.
pub fn drift(positions: &mut Vectors, velocities: &Vectors, step: f32, pool: &Pool) {
    if step > 0.0 {
        positions.add_scaled(velocities, step, pool);
    }
}

/// The step has been admitted: its ends are the new positions, and the old ones are its ends.
pub fn advance(state: &mut State, ends: &mut Vectors) {
    std::mem::swap(&mut state.positions, ends);
    state.steps += 1;
}
