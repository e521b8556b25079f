//! Positions and velocities in, forces out: F_INT + F_EXT of the paper (section 2).
//!
//! Each force is a kernel in a file of its own; this one adds them up, particle by particle, each particle gathering
//! from its springs and panels in a fixed order.

mod air_drag;
mod damping;
mod gravity;
mod internal;
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
    wind: wind::Wind,
}

impl Forces {
    /// Workspace for a model.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        Self { total: Vectors::zeros(model.particle_count()), wind: wind::Wind::new(model) }
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
    forces.total.for_each_chunk(pool, |mut chunk| {
        internal::fill(model, state, &mut chunk);
        chunk.map(|particle, internal| {
            if model.particles.inverse_mass[particle] == 0.0 {
                return Vec3::ZERO;
            }
            let (mass, velocity) = (model.particles.mass[particle], state.velocities.get(particle));
            internal
                + gravity::force(mass, model.gravity)
                + air_drag::force(mass, model.particles.air_drag[particle], velocity)
                + wind.on_particle(model, particle)
        });
    });
}
