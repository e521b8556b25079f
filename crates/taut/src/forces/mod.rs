//! Positions and velocities in, forces out: F_INT + F_EXT of the paper (section 2).
//!
//! Each force is a kernel in a file of its own; this one adds them up, particle by particle, each particle gathering
//! from its springs and panels in a fixed order.

mod air_drag;
mod damping;
mod gravity;
mod spring;
mod wind;

use glam::Vec3;

use crate::geometry::{Pool, Vectors};
use crate::model::Model;
use crate::state::State;

pub use spring::elastic_energy;

/// Workspace and result.
#[derive(Debug)]
pub struct Forces {
    /// F on each particle [N]; zero on held ones.
    total: Vectors,
    wind: wind::OnPanels,
}

impl Forces {
    /// Workspace for a model.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        Self { total: Vectors::zeros(model.particle_count()), wind: wind::OnPanels::new(model) }
    }

    /// The forces that [`accumulate`] found [N].
    #[must_use]
    pub fn total(&self) -> &Vectors {
        &self.total
    }
}

/// Adds up all forces.
pub fn accumulate(model: &Model, state: &State, forces: &mut Forces, pool: &Pool) {
    forces.wind.prepare(model, state, pool);
    let wind = &forces.wind;
    forces.total.for_each_chunk(pool, |chunk| {
        chunk.map(|particle, _| {
            if model.particles.inverse_mass[particle] == 0.0 {
                return Vec3::ZERO;
            }
            let (mass, velocity) = (model.particles.mass[particle], state.velocities.get(particle));
            internal(model, state, particle)
                + gravity::force(mass, model.gravity)
                + air_drag::force(mass, model.particles.air_drag[particle], velocity)
                + wind.on_particle(model, state, particle)
        });
    });
}

/// F_INT: springs and damping, gathered over the links of a particle.
fn internal(model: &Model, state: &State, particle: usize) -> Vec3 {
    let (position, velocity) = (state.positions.get(particle), state.velocities.get(particle));
    let mut force = Vec3::ZERO;
    for link in model.links.of(particle) {
        let other = link.other as usize;
        force += spring::force(state.positions.get(other) - position, link.rest, link.stiffness);
        force += damping::force(state.velocities.get(other) - velocity, link.damping);
    }
    force
}
