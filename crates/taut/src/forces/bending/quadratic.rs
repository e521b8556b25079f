//! Quadratic bending (Bergou et al. 2006): a constant matrix Q, so that `F = -Q X`.
//!
//! The rows of Q add up to zero, hence `F_u = sum -Q_uv (X_v - X_u)`: pairs that pull or push in proportion to their distance.
//! Forces of a pair are equal and opposite to the last bit.

use glam::{Vec3, Vec4, Vec4Swizzles};

use crate::geometry::Vectors;
use crate::model::Bend;

/// On a particle, with places as quads [N].
#[inline]
pub(super) fn force(bends: &[Bend], places: &[Vec4], particle: usize) -> Vec3 {
    let here = places[particle];
    bends.iter().fold(Vec4::ZERO, |sum, bend| sum + (places[bend.other as usize] - here) * bend.weight).xyz()
}

/// Of all its pairs [J].
pub(super) fn energy(bends: &[Bend], positions: &Vectors, here: Vec3) -> f64 {
    let way = |bend: &Bend| (positions.get(bend.other as usize) - here).as_dvec3();
    bends.iter().map(|bend| 0.5 * f64::from(bend.weight) * way(bend).length_squared()).sum()
}
