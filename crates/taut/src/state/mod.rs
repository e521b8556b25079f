//! What changes while a scene runs: positions, velocities and the number of steps taken.

mod snapshot;
mod stretch;

use glam::Vec3;
use xxhash_rust::xxh3::Xxh3;

pub use snapshot::SnapshotError;
pub use stretch::{Stretch, measure, worst_spring};

use crate::geometry::Vectors;
use crate::model::Model;

/// Positions, velocities and time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct State {
    /// X [m].
    pub positions: Vectors,
    /// V [m/s].
    pub velocities: Vectors,
    /// Steps taken since the start, from which the time follows without rounding.
    pub steps: u64,
}

impl State {
    /// The model at rest where the scene put it.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        Self { positions: model.particles.rest.clone(), velocities: Vectors::zeros(model.particle_count()), steps: 0 }
    }

    /// Time since the start [s].
    #[must_use]
    pub fn time(&self, model: &Model) -> f64 {
        self.steps as f64 * model.timing.step_length
    }

    /// Makes this a copy of `other`, without allocating when the sizes agree.
    pub fn copy_from(&mut self, other: &Self) {
        self.positions.copy_from(&other.positions);
        self.velocities.copy_from(&other.velocities);
        self.steps = other.steps;
    }

    /// XXH3 hash of all positions and then all velocities, each as x, y, z in little-endian `f32`.
    #[must_use]
    pub fn hash(&self) -> u64 {
        hash_vectors(self.positions.iter().chain(self.velocities.iter()))
    }
}

/// XXH3 hash of vectors as x, y, z in little-endian `f32`.
#[must_use]
pub fn hash_vectors(vectors: impl Iterator<Item = Vec3>) -> u64 {
    let mut hash = Xxh3::new();
    for vector in vectors {
        let mut bytes = [0; 12];
        for (place, part) in bytes.chunks_exact_mut(4).zip(vector.to_array()) {
            place.copy_from_slice(&part.to_le_bytes());
        }
        hash.update(&bytes);
    }
    hash.digest()
}
