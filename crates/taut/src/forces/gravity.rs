//! Weight (paper, section 2.2).

use glam::Vec3;

/// `F_G = M g` [N].
#[inline]
pub(super) fn force(mass: f32, gravity: Vec3) -> Vec3 {
    gravity * mass
}
