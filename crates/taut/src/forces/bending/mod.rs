//! Resistance to bending, one file a method. Each turns positions into forces on particles.

mod choi_ko;
mod curved;
mod quadratic;

use glam::Vec3;

use crate::geometry::{Pool, Vectors};
use crate::model::{ClothRange, Model};

/// What [`force`] needs beforehand for a cloth: the pulls of its rows of second derivatives, if it bends along a curve.
pub(super) fn prepare(model: &Model, cloth: &ClothRange, positions: &Vectors, pulls: &mut Vectors, pool: &Pool) {
    curved::pulls(&model.bending.curved, cloth, positions, pulls, pool);
}

/// F_B on a particle [N].
#[inline]
pub(super) fn force(model: &Model, positions: &Vectors, pulls: &Vectors, particle: usize) -> Vec3 {
    let here = positions.get(particle);
    quadratic::force(model.bending.quadratic.of(particle), positions, here)
        + choi_ko::force(model.bending.buckling.of(particle), positions, here)
        + curved::force(model.bending.curved.rows.of(particle), pulls)
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
