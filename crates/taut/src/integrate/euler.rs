//! The paper's Euler method (section 3), velocity first: `V^(t+h) = V^t + F h / M`, `X^(t+h) = X^t + V^(t+h) h` (printed with V
//! on the left; see docs/equations.md). Order 1, symplectic without dampers and drag.
//!
//! Where the filter looks at several steps of the springs at once, leapfrog inside its step: its energy has no term in X V, so
//! that what dampers and filters take from V is always taken from the energy.

use super::wave::{self, Wave};
use super::{MassScaling, Method, Step};
use crate::forces::{self, Forces};
use crate::geometry::{Pool, Vectors};
use crate::model::{ClothRange, Model};
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
    /// Where springs see particles, if they look ahead [m].
    seen: Vectors,
    /// Those of the model's lattices that go through all parts.
    waves: Vec<Wave>,
    /// For cloths that take fewer parts.
    scaled: Option<Scaled>,
}

/// Steps with scaled masses.
struct Scaled {
    before: f32,
    parts: Vec<Part>,
    /// How far ahead springs look [s].
    ahead: f32,
    /// Those of each cloth, if they are scaled.
    masses: Vec<Option<MassScaling>>,
    /// What velocities would gain with the masses as they are [m/s].
    gains: Vectors,
}

impl Euler {
    pub fn new(model: &Model, threads: usize) -> Self {
        let (before, parts) = parts(model.timing.step_length, model.timing.spring_steps);
        let scaled = Scaled::new(model);
        let waves = if scaled.is_some() { &[][..] } else { &model.lattices };
        let waves = waves.iter().map(|lattice| Wave::new(model, lattice, parts.len(), threads)).collect();
        Self { before, parts, seen: Vectors::zeros(model.particle_count()), waves, scaled }
    }
}

impl Scaled {
    fn new(model: &Model) -> Option<Self> {
        let timing = model.timing.scaled?;
        let (before, parts) = parts(model.timing.step_length, timing.parts);
        let masses = model.cloths.iter().map(|cloth| MassScaling::new(model, cloth)).collect();
        let (ahead, gains) = (timing.springs_ahead as f32, Vectors::zeros(model.particle_count()));
        Some(Self { before, parts, ahead, masses, gains })
    }
}

fn parts(step: f64, count: u32) -> (f32, Vec<Part>) {
    let length = (step / f64::from(count)) as f32;
    let half = if count > 1 { 0.5 * length } else { 0.0 };
    let part = |part| Part { kick: length, after: if part + 1 == count { length - half } else { length } };
    (half, (0..count).map(part).collect())
}

impl Method for Euler {
    /// What acts from outside and the dampers are looked at once.
    fn propose(&mut self, step: Step<'_>, forces: &mut Forces, pool: &Pool) -> u32 {
        let Step { model, state, ends } = step;
        forces::external(model, state, forces, pool); // x, v -> a
        self.damp(model, &mut state.velocities, forces, pool); // v -> v
        for (index, cloth) in model.cloths.iter().enumerate() {
            match &mut self.scaled {
                Some(scaled) if scaled.masses[index].is_some() => {
                    scaled.go_through_parts(model, index, state, ends, &mut self.seen, forces, pool);
                }
                _ => self.go_through_parts(model, cloth, state, ends, forces, pool), // x, v, a -> x*, v*
            }
        }
        model.cloths.iter().map(|cloth| model.parts(cloth)).max().unwrap_or_default()
    }
}

impl Euler {
    fn damp(&mut self, model: &Model, velocities: &mut Vectors, forces: &mut Forces, pool: &Pool) {
        let Some(Scaled { masses, gains, .. }) = &mut self.scaled else {
            return forces::damp(model, &model.cloths, velocities, forces, pool);
        };
        if model.timing.damping_stages == 0 {
            return;
        }
        for (cloth, masses) in model.cloths.iter().zip(masses) {
            match masses.as_mut().filter(|masses| masses.scale_dampers()) {
                Some(masses) => {
                    forces::damping_gains(model, cloth, velocities, gains, forces, pool);
                    masses.add_damping(gains, velocities, pool);
                }
                None => forces::damp(model, std::slice::from_ref(cloth), velocities, forces, pool),
            }
        }
    }

    /// Springs, bending and the acceleration from outside.
    fn go_through_parts(
        &mut self,
        model: &Model,
        cloth: &ClothRange,
        state: &mut State,
        ends: &mut Vectors,
        forces: &mut Forces,
        pool: &Pool,
    ) {
        let State { positions, velocities, .. } = state;
        let ahead = model.timing.springs_ahead as f32;
        let Self { before, parts, seen, waves, .. } = self;
        let (before, particles) = (*before, cloth.particles());
        match cloth.lattice {
            Some(lattice) if cloth.linked.is_none() && !cloth.curved && !cloth.bends => {
                let (lattice, wave) = (&model.lattices[lattice], &mut waves[lattice]);
                let acceleration = forces.acceleration();
                wave.run(wave::Step { lattice, before, parts, ahead, acceleration, positions, ends, velocities }, pool);
            }
            _ => {
                ends.set_scaled(particles.clone(), positions, velocities, before, pool);
                for part in &*parts {
                    let springs_see = look_ahead(seen, ends, cloth, velocities, ahead, pool);
                    forces::kick(model, cloth, springs_see, velocities, part.kick, forces, pool);
                    ends.add_scaled(particles.clone(), velocities, part.after, pool);
                }
            }
        }
    }
}

impl Scaled {
    #[expect(clippy::too_many_arguments, reason = "the parts of a step that both ways of taking it share")]
    fn go_through_parts(
        &mut self,
        model: &Model,
        index: usize,
        state: &mut State,
        ends: &mut Vectors,
        seen: &mut Vectors,
        forces: &mut Forces,
        pool: &Pool,
    ) {
        let State { positions, velocities, .. } = state;
        let (cloth, Some(masses)) = (&model.cloths[index], &mut self.masses[index]) else { return };
        let particles = cloth.particles();
        ends.set_scaled(particles.clone(), positions, velocities, self.before, pool);
        for part in &self.parts {
            let springs_see = look_ahead(seen, ends, cloth, velocities, self.ahead, pool);
            forces::gains(model, cloth, springs_see, &mut self.gains, part.kick, forces, pool);
            masses.add(&self.gains, velocities, pool);
            ends.add_scaled(particles.clone(), velocities, part.after, pool);
        }
    }
}

/// Where springs see the particles of a cloth.
fn look_ahead<'a>(
    seen: &'a mut Vectors,
    ends: &'a Vectors,
    cloth: &ClothRange,
    velocities: &Vectors,
    ahead: f32,
    pool: &Pool,
) -> &'a Vectors {
    if ahead == 0.0 {
        return ends;
    }
    seen.set_scaled(cloth.particles(), ends, velocities, ahead, pool);
    seen
}
