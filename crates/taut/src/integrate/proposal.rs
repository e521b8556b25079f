//! A proposed step as one sees it who may change it before the filter does.

use glam::Vec3;

use super::Integrator;
use crate::geometry::Vectors;
use crate::model::Model;
use crate::schedule::Stride;
use crate::state::State;

/// A proposed step, or a part of one.
pub struct Proposal<'a> {
    stride: Stride<'a>,
    state: &'a mut State,
    ends: &'a mut Vectors,
    integrator: &'a mut Integrator,
}

impl<'a> Proposal<'a> {
    pub(crate) fn new(stride: Stride<'a>, state: &'a mut State, ends: &'a mut Vectors, integrator: &'a mut Integrator) -> Self {
        Self { stride, state, ends, integrator }
    }

    /// The model, and what is held in it: such particles have no inverse mass.
    #[must_use]
    pub fn model(&self) -> &Model {
        self.stride.model
    }

    /// Where it begins; its velocities are those of the proposal.
    #[must_use]
    pub fn state(&self) -> &State {
        self.state
    }

    /// How long it is [s].
    #[must_use]
    pub fn length(&self) -> f64 {
        self.stride.plan.length
    }

    /// How fast a particle goes to where the step leads [m/s].
    #[must_use]
    pub fn velocity(&self, particle: usize) -> Vec3 {
        (self.ends.get(particle) - self.state.positions.get(particle)) / self.length() as f32
    }

    /// Gives a particle another velocity from the start of the step on, by this difference [m/s]; what is held keeps its own.
    pub fn push(&mut self, particle: usize, by: Vec3) {
        if self.stride.model.particles.inverse_mass[particle] == 0.0 {
            return;
        }
        self.ends.set(particle, self.ends.get(particle) + by * self.length() as f32);
        self.state.velocities.set(particle, self.state.velocities.get(particle) + by);
        self.integrator.momentum.push(self.stride.model, particle, by);
        self.integrator.motion.push(particle, by);
    }
}
