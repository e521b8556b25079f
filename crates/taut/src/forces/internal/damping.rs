//! Linear damping of relative velocity (paper, section 2.1).

use glam::Vec3;

/// Force on u of its spring to v: `F_D = k_D (V_v - V_u)` [N].
#[inline]
pub(super) fn force(v_uv: Vec3, damping: f32) -> Vec3 {
    v_uv * damping
}
