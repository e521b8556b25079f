//! What rounding takes from the momentum of cloths that nothing holds, given back.
//!
//! Springs, dampers and filters only hand momentum on. But each of them rounds the velocities of all particles, and in thousands
//! of steps that adds up. So the momentum of a free cloth is summed up in double precision before and after a step. One
//! particle takes what is missing: the slowest one, whose velocity is rounded least.

use glam::{DVec3, Vec3};

use crate::geometry::Vectors;
use crate::model::{ClothRange, Model};
use crate::scene::IntegratorKind;
use crate::schedule::Stride;
use crate::state::State;

/// Differences up to this part of the sum of all M |V| are rounding; larger ones have a reason, such as a hand that pulls.
const ROUNDING: f64 = 1e-5;

/// The momenta of the free cloths.
pub(super) struct Momentum {
    /// Which cloths these are, and what they should have after the step [kg m/s].
    free: Vec<(usize, DVec3)>,
}

impl Momentum {
    /// Nothing is kept with methods that look at the forces from outside several times a step.
    pub fn new(model: &Model) -> Self {
        let is_free = |cloth: &ClothRange| cloth.particles().all(|particle| model.particles.inverse_mass[particle] > 0.0);
        let cloths = model.cloths.iter().enumerate().filter(|(_, cloth)| is_free(cloth));
        let known = model.solver.integrator == IntegratorKind::Euler;
        Self { free: cloths.filter(|_| known).map(|(index, _)| (index, DVec3::ZERO)).collect() }
    }

    /// Takes down what there is before the step.
    pub fn note(&mut self, model: &Model, state: &State) {
        for (cloth, momentum) in &mut self.free {
            *momentum = sum(model, &model.cloths[*cloth], &state.velocities);
        }
    }

    /// Counts in what someone outside gave a particle besides [m/s].
    pub fn push(&mut self, model: &Model, particle: usize, by: Vec3) {
        let own = self.free.iter_mut().find(|(cloth, _)| model.cloths[*cloth].particles().contains(&particle));
        own.into_iter().for_each(|(_, momentum)| *momentum += by.as_dvec3() * f64::from(model.particles.mass[particle]));
    }

    /// Gives back what is missing after the step, in which `acceleration` [m/s^2] acted from outside. Returns how much, of all cloths
    /// [kg m/s].
    pub fn keep(&self, stride: Stride<'_>, state: &mut State, acceleration: &Vectors) -> DVec3 {
        let (model, velocities) = (stride.model, &mut state.velocities);
        let mut given = DVec3::ZERO;
        for &(cloth, before) in &self.free {
            let cloth = &model.cloths[cloth];
            let missing = before + sum(model, cloth, acceleration) * stride.plan.length - sum(model, cloth, velocities);
            let masses = &model.particles.mass;
            let size: f64 = cloth.particles().map(|at| f64::from(masses[at] * velocities.get(at).length())).sum();
            // Also false where a velocity is not finite, which will be reported.
            if missing.length() <= ROUNDING * size {
                given += missing;
                for (axis, missing) in missing.to_array().into_iter().enumerate() {
                    give(model, cloth, velocities, axis, missing);
                }
            }
        }
        given
    }
}

/// Sum of M times a vector.
fn sum(model: &Model, cloth: &ClothRange, vectors: &Vectors) -> DVec3 {
    cloth.particles().map(|at| vectors.get(at).as_dvec3() * f64::from(model.particles.mass[at])).sum()
}

/// Adds to the velocity of the particle that is slowest along an axis.
fn give(model: &Model, cloth: &ClothRange, velocities: &mut Vectors, axis: usize, missing: f64) {
    let speed = |at: usize| velocities.get(at)[axis].abs();
    let Some(slowest) = cloth.particles().min_by(|a, b| speed(*a).total_cmp(&speed(*b))) else { return };
    let mut velocity: Vec3 = velocities.get(slowest);
    velocity[axis] = (f64::from(velocity[axis]) + missing / f64::from(model.particles.mass[slowest])) as f32;
    velocities.set(slowest, velocity);
}
