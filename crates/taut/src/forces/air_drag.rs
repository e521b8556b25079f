//! Stokes drag in air at rest (paper, section 2.2, with N = 1).

use glam::Vec3;

/// `F_A / M = -k_A V` [m/s^2]; over a step of `step` seconds at most what brings the particle to rest.
#[inline]
pub(super) fn acceleration(air_drag: f32, velocity: Vec3, step: f32) -> Vec3 {
    velocity * -air_drag.min(1.0 / step)
}
