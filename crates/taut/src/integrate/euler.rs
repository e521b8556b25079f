//! The paper's Euler method (section 3), velocity first: `V^(t+h) = V^t + F h / M`, `X^(t+h) = X^t + V^(t+h) h` (printed with V
//! on the left; see docs/equations.md). Order 1, symplectic without dampers and drag.
//!
//! Where the filter looks at several steps of the springs at once, leapfrog inside its step: its energy has no term in X V, so
//! that what dampers and filters take from V is always taken from the energy.

use super::wave::{self, Wave};
use super::{Method, Step};
use crate::forces::{self, Forces};
use crate::geometry::{Pool, Vectors};
use crate::model::{Model, Timing};
use crate::state::State;

/// One of the equal parts of a step: forces kick velocities, positions drift.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Part {
    /// How long forces act [s].
    pub kick: f32,
    /// How long positions drift after that [s]: the second half of this part and the first half of the next one.
    pub after: f32,
}

/// The parts of a step, and the workspace to go through them.
pub(super) struct Euler {
    /// How long positions drift before the first part [s].
    before: f32,
    parts: Vec<Part>,
    /// Where springs see the particles outside of lattices, if they look ahead [m].
    seen: Vectors,
    /// Those of the model's lattices.
    waves: Vec<Wave>,
}

impl Euler {
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

impl Method for Euler {
    /// What acts from outside and the dampers are looked at once.
    fn propose(&mut self, step: Step<'_>, forces: &mut Forces, pool: &Pool) -> u32 {
        let Step { model, state, ends } = step;
        forces::external(model, state, forces, pool); // x, v -> a
        forces::damp(model, &mut state.velocities, forces, pool); // v -> v
        self.go_through_parts(model, state, ends, forces, pool); // x, v, a -> x*, v*
        model.timing.spring_steps
    }
}

impl Euler {
    /// Springs, bending and the acceleration from outside.
    fn go_through_parts(&mut self, model: &Model, state: &mut State, ends: &mut Vectors, forces: &mut Forces, pool: &Pool) {
        let State { positions, velocities, .. } = state;
        let ahead = model.timing.springs_ahead as f32;
        let Self { before, parts, seen, waves } = self;
        let before = *before;
        for cloth in &model.cloths {
            let particles = cloth.particles();
            match cloth.lattice {
                Some(lattice) if !cloth.linked && !cloth.curved && !cloth.bends => {
                    let (lattice, wave) = (&model.lattices[lattice], &mut waves[lattice]);
                    let acceleration = forces.acceleration();
                    wave.run(wave::Step { lattice, before, parts, ahead, acceleration, positions, ends, velocities }, pool);
                }
                _ => {
                    ends.set_scaled(particles.clone(), positions, velocities, before, pool);
                    for part in &*parts {
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
}
