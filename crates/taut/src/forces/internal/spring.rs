//! Hooke's law (paper, section 2.1).

use glam::Vec3;

/// Force on u of its spring to v: `F_s = k_s (1 - L / |X_uv|) X_uv`, `X_uv = X_v - X_u` [N].
///
/// Two particles at the same place have no direction to push in; the force is zero there.
#[inline]
pub(super) fn force(x_uv: Vec3, rest: f32, stiffness: f32) -> Vec3 {
    let length = x_uv.length();
    if length > 0.0 { x_uv * (stiffness * (1.0 - rest / length)) } else { Vec3::ZERO }
}

/// Energy stored in a spring of `length` [m]: `k_s (|X_uv| - L)^2 / 2` [J].
#[inline]
#[must_use]
pub fn elastic_energy(stiffness: f32, rest: f32, length: f32) -> f64 {
    let extension = f64::from(length - rest);
    0.5 * f64::from(stiffness) * extension * extension
}
