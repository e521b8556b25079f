//! Velocities in, positions out.
//!
//! Where the filter looks at every step of the springs, the paper's Euler method (section 3), velocity first:
//! `V^(t+h) = V^t + F h / M`, `X^(t+h) = X^t + V^(t+h) h` (printed with V on the left; see docs/equations.md). Where it looks
//! at several at once, leapfrog: its energy has no term in X V, so that what dampers and filters take from V is always taken
//! from the energy.

mod wave;

use crate::forces::{self, Forces};
use crate::geometry::{Pool, Vectors};
use crate::model::{Model, Timing};
use crate::state::State;
use wave::{Step, Wave};

/// One of the equal parts of a step: forces kick velocities, positions drift.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Part {
    /// How long forces act [s].
    kick: f32,
    /// How long positions drift after that [s]: the second half of this part and the first half of the next one.
    after: f32,
}

/// The parts of a step, and the workspace to go through them.
#[derive(Debug)]
pub struct Integrator {
    /// How long positions drift before the first part [s].
    before: f32,
    parts: Vec<Part>,
    /// Where springs see the particles outside of lattices, if they look ahead [m].
    seen: Vectors,
    /// Those of the model's lattices.
    waves: Vec<Wave>,
}

impl Integrator {
    /// The integrator of a model, on so many threads.
    #[must_use]
    pub fn new(model: &Model, threads: usize) -> Self {
        let (before, parts) = parts(&model.timing);
        let waves = model.lattices.iter().map(|lattice| Wave::new(model, lattice, parts.len(), threads)).collect();
        Self { before, parts, seen: Vectors::zeros(model.particle_count()), waves }
    }
}

fn parts(timing: &Timing) -> (f32, Vec<Part>) {
    let count = timing.spring_steps;
    let length = (timing.step_length / f64::from(count)) as f32;
    let half = if count > 1 { 0.5 * length } else { 0.0 };
    let part = |part| Part { kick: length, after: if part + 1 == count { length - half } else { length } };
    (half, (0..count).map(part).collect())
}

/// A step of positions and velocities under springs and external forces: from `state` to `ends` and new velocities.
pub fn propose(
    model: &Model,
    state: &mut State,
    ends: &mut Vectors,
    forces: &mut Forces,
    integrator: &mut Integrator,
    pool: &Pool,
) {
    let State { positions, velocities, .. } = state;
    let ahead = model.timing.springs_ahead as f32;
    for cloth in &model.cloths {
        let particles = cloth.particles();
        match cloth.lattice {
            Some(lattice) if !cloth.linked && !cloth.curved && !cloth.bends => {
                let Integrator { before, parts, waves, .. } = integrator;
                let (lattice, wave, before) = (&model.lattices[lattice], &mut waves[lattice], *before);
                let acceleration = forces.acceleration();
                wave.run(Step { lattice, before, parts, ahead, acceleration, positions, ends, velocities }, pool);
            }
            _ => {
                let Integrator { before, parts, seen, .. } = &mut *integrator;
                ends.set_scaled(particles.clone(), positions, velocities, *before, pool);
                for part in parts {
                    let springs_see = if ahead > 0.0 {
                        seen.set_scaled(particles.clone(), ends, velocities, ahead, pool);
                        &*seen
                    } else {
                        &*ends
                    };
                    forces::kick(model, cloth, springs_see, velocities, part.kick, forces, pool);
                    ends.add_scaled(particles.clone(), velocities, part.after, pool);
                }
            }
        }
    }
}

/// The step has been admitted: its ends are the new positions, and the old ones are its ends.
pub fn advance(state: &mut State, ends: &mut Vectors) {
    std::mem::swap(&mut state.positions, ends);
    state.steps += 1;
}
