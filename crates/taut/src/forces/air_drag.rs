//! Stokes drag in air at rest (paper, section 2.2, with N = 1).

use glam::Vec3;

/// `F_A / M = -k_A V` [m/s^2].
#[inline]
pub(super) fn acceleration(air_drag: f32, velocity: Vec3) -> Vec3 {
    velocity * -air_drag
}
