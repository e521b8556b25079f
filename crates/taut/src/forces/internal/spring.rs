//! The energy of a spring by Hooke's law (paper, section 2.1).

/// Energy stored in a spring of `length` [m]: `k_s (|X_uv| - L)^2 / 2` [J].
#[inline]
#[must_use]
pub fn elastic_energy(stiffness: f32, rest: f32, length: f32) -> f64 {
    let extension = f64::from(length - rest);
    0.5 * f64::from(stiffness) * extension * extension
}
