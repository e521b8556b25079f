//! Quadratic bending (Bergou et al. 2006): a constant matrix Q, so that `F = -Q X`.
//!
//! The rows of Q add up to zero, hence `F_u = sum -Q_uv (X_v - X_u)`: pairs that pull or push in proportion to their distance.
//! Forces of a pair are equal and opposite to the last bit.

use glam::Vec3;

use crate::geometry::Vectors;
use crate::model::Bend;

/// On the particle that is `here` [N].
#[inline]
pub(super) fn force(bends: &[Bend], positions: &Vectors, here: Vec3) -> Vec3 {
    bends.iter().fold(Vec3::ZERO, |sum, bend| sum + (positions.get(bend.other as usize) - here) * bend.weight)
}

/// Of all its pairs [J].
pub(super) fn energy(bends: &[Bend], positions: &Vectors, here: Vec3) -> f64 {
    let way = |bend: &Bend| (positions.get(bend.other as usize) - here).as_dvec3();
    bends.iter().map(|bend| 0.5 * f64::from(bend.weight) * way(bend).length_squared()).sum()
}
