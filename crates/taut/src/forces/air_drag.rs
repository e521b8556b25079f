//! Stokes drag in air at rest (paper, section 2.2, with N = 1).

use glam::Vec3;

/// `F_A = -M k_A V` [N].
#[inline]
pub(super) fn force(mass: f32, air_drag: f32, velocity: Vec3) -> Vec3 {
    velocity * (-mass * air_drag)
}
