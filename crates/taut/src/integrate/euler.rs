//! The paper's Euler method (section 3), velocity first: `V^(t+h) = V^t + F h / M`, `X^(t+h) = X^t + V^(t+h) h` (printed with V
//! on the left; see docs/equations.md). Order 1, symplectic without dampers and drag.
//!
//! Where the filter looks at several steps of the springs at once, they are leapfrog inside its step. The energy of leapfrog has no term
//! in X V. So what dampers and filters take from V is always taken from the energy.

use super::{MassScaling, Method, Step};
use crate::forces::{self, Forces};
use crate::geometry::{Pool, Vectors};
use crate::model::{ClothRange, Model};
use crate::schedule::{ClothPlan, Plan, Stride};
use crate::state::State;

/// One of the equal parts of a step: forces kick velocities, positions drift.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Part {
    /// How long forces act [s].
    kick: f32,
    /// How long positions drift after that [s]: the second half of this part and the first half of the next one.
    after: f32,
}

/// The parts of a step of some length.
#[derive(Debug, Clone, Copy)]
struct Parts {
    count: u32,
    /// How long each of them is, and half of it where there are several [s].
    length: f32,
    half: f32,
}

/// The workspace to go through the parts of a step.
pub(super) struct Euler {
    /// The step that it is set up for.
    plan: Plan,
    /// Where springs see particles, if they look ahead [m].
    seen: Vectors,
    /// For cloths that take fewer parts: the scaled masses of each that can have any.
    masses: Vec<Option<MassScaling>>,
    /// What velocities would gain with the masses as they are [m/s]; empty without scaled ones.
    gains: Vectors,
}

impl Euler {
    pub fn new(model: &Model, plan: &Plan) -> Self {
        let mut euler = Self {
            plan: Plan::default(),
            seen: Vectors::zeros(model.particle_count()),
            masses: model.cloths.iter().map(|_| None).collect(),
            gains: Vectors::default(),
        };
        euler.set_up(model, plan);
        euler
    }

    /// Gets ready for steps that are planned like this one.
    fn set_up(&mut self, model: &Model, plan: &Plan) {
        if *plan == self.plan {
            return;
        }
        self.plan.clone_from(plan);
        for (cloth, masses) in model.cloths.iter().zip(&mut self.masses) {
            let Some(timing) = &plan.of(cloth).scaled else { continue };
            match masses {
                Some(masses) => masses.share_out(model, cloth, timing),
                None => *masses = MassScaling::new(model, cloth, timing),
            }
        }
        if self.gains.is_empty() && plan.cloths.iter().any(|cloth| cloth.scaled.is_some()) {
            self.gains = Vectors::zeros(model.particle_count());
        }
    }
}

impl Parts {
    /// `count` equal parts of a step of `step` seconds.
    fn new(step: f64, count: u32) -> Self {
        let length = (step / f64::from(count)) as f32;
        Self { count, length, half: if count > 1 { 0.5 * length } else { 0.0 } }
    }

    fn iter(self) -> impl Iterator<Item = Part> {
        let Self { count, length, half } = self;
        (1..=count).map(move |part| Part { kick: length, after: if part == count { length - half } else { length } })
    }
}

impl Method for Euler {
    /// What acts from outside and the dampers are looked at once.
    fn propose(&mut self, step: Step<'_>, forces: &mut Forces, pool: &Pool) -> u32 {
        let Step { stride, state, ends } = step;
        let Stride { model, plan, .. } = stride;
        self.set_up(model, plan);
        forces::external(stride, state, forces, pool); // x, v -> a
        self.damp(stride, &mut state.velocities, forces, pool); // v -> v
        for index in 0..model.cloths.len() {
            self.go_through_parts(stride, index, state, ends, forces, pool); // x, v, a -> x*, v*
        }
        plan.cloths.iter().map(ClothPlan::parts).max().unwrap_or_default()
    }
}

impl Euler {
    fn damp(&mut self, stride: Stride<'_>, velocities: &mut Vectors, forces: &mut Forces, pool: &Pool) {
        let Stride { model, plan, .. } = stride;
        // Cloths that take the same stages are damped together.
        if let [first, others @ ..] = &plan.cloths[..]
            && plan.cloths.iter().all(|cloth| cloth.scaled.is_none())
            && others.iter().all(|cloth| cloth.damping_stages == first.damping_stages)
        {
            return forces::damp(stride, &model.cloths, first.damping_stages, velocities, forces, pool);
        }
        let Self { masses, gains, .. } = self;
        for (cloth, masses) in model.cloths.iter().zip(masses) {
            let ClothPlan { damping_stages: stages, scaled, .. } = *plan.of(cloth);
            if stages == 0 {
                continue;
            }
            match masses.as_mut().filter(|masses| scaled.is_some() && masses.scales_dampers()) {
                Some(masses) => {
                    forces::damping_gains(stride, cloth, velocities, gains, forces, pool);
                    masses.add_damping(gains, velocities, pool);
                }
                None => forces::damp(stride, std::slice::from_ref(cloth), stages, velocities, forces, pool),
            }
        }
    }

    /// Springs, bending and the acceleration from outside, for one of the cloths.
    fn go_through_parts(
        &mut self,
        stride: Stride<'_>,
        index: usize,
        state: &mut State,
        ends: &mut Vectors,
        forces: &mut Forces,
        pool: &Pool,
    ) {
        let Stride { model, plan, .. } = stride;
        let State { positions, velocities, .. } = state;
        let Self { seen, masses, gains, .. } = self;
        let cloth = &model.cloths[index];
        let particles = cloth.particles();
        let own = plan.of(cloth);
        let timing = own.scaled;
        let ahead = timing.map_or(own.springs_ahead, |timing| timing.springs_ahead) as f32;
        let parts = Parts::new(plan.length, own.parts());
        ends.set_scaled(particles.clone(), positions, velocities, parts.half, pool);
        for part in parts.iter() {
            let springs_see = look_ahead(seen, ends, cloth, velocities, ahead, pool);
            match masses[index].as_mut().filter(|_| timing.is_some()) {
                Some(masses) => {
                    forces::gains(model, cloth, springs_see, gains, part.kick, forces, pool);
                    masses.add(gains, velocities, pool);
                }
                None => forces::kick(model, cloth, springs_see, velocities, part.kick, forces, pool),
            }
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
