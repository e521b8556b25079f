//! Resistance to bending, one file a method. Each turns positions into forces on particles.

mod choi_ko;
mod curved;
mod quadratic;

use glam::{Vec3, Vec4};

use crate::geometry::{Pool, Vectors, fill_quads};
use crate::model::{ClothRange, Model};

/// What [`Workspace::force`] needs beforehand.
#[derive(Debug)]
pub(super) struct Workspace {
    /// Places, each of which is loaded at once [m]; none if no cloth bends.
    places: Vec<Vec4>,
    /// What rows of second derivatives pull with where bending follows a curve [N m].
    pulls: Vectors,
}

impl Workspace {
    pub fn new(model: &Model) -> Self {
        let count = if model.cloths.iter().any(|cloth| cloth.bends) { model.particle_count() } else { 0 };
        Self { places: vec![Vec4::ZERO; count], pulls: Vectors::zeros(model.bending.curved.len()) }
    }

    /// Takes where a cloth is.
    pub fn take(&mut self, model: &Model, cloth: &ClothRange, positions: &Vectors, pool: &Pool) {
        fill_quads(&mut self.places[cloth.particles()], positions, cloth.first, pool);
        curved::pulls(&model.bending.curved, cloth, positions, &mut self.pulls, pool);
    }

    /// F_B on a particle of that cloth [N].
    #[inline]
    pub fn force(&self, model: &Model, positions: &Vectors, particle: usize) -> Vec3 {
        quadratic::force(model.bending.quadratic.of(particle), &self.places, particle)
            + choi_ko::force(model.bending.buckling.of(particle), positions, positions.get(particle))
            + curved::force(model.bending.curved.rows.of(particle), &self.pulls)
    }
}

/// A particle's share of the energy of all the pairs and rows it is in [J].
#[must_use]
pub fn bending_energy(model: &Model, positions: &Vectors, particle: usize) -> f64 {
    if model.bending.is_empty() {
        return 0.0;
    }
    let here = positions.get(particle);
    0.5 * quadratic::energy(model.bending.quadratic.of(particle), positions, here)
        + 0.5 * choi_ko::energy(model.bending.buckling.of(particle), positions, here)
        + curved::energy(&model.bending.curved, positions, particle)
}
