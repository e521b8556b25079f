//! Stokes drag in air at rest (paper, section 2.2, with N = 1).

/// `F_A / M = -k_A V` along one axis [m/s^2]; over a step of `step` seconds at most what brings the particle to rest.
#[inline(always)]
pub(super) fn acceleration(air_drag: f32, velocity: f32, step: f32) -> f32 {
    let most = 1.0 / step;
    velocity * -if air_drag < most { air_drag } else { most }
}
