//! What velocities take of the corrections of positions.
//!
//! Where a cloth moves smoothly, V = D / h, and a correction C of the displacement D is one of C / h to V. Springs that vibrate
//! faster than the filter looks have turned round meanwhile: V is not D / h, and C / h would add to a velocity that points
//! inwards already (docs/equations.md, "Vibrations faster than H"). So velocities take the part of C / h that leaves the
//! least kinetic energy, and never more than all of it. A single part for the whole cloth: momentum stays what it is.

use glam::Vec3;
use pulp::{Arch, Simd, WithSimd};

use crate::geometry::Vectors;
use crate::model::{ClothRange, Model};

/// The factor [1/s] of corrections [m] in what velocities take of them: c / h, c being the place of the smallest
/// sum of M |V + c C / h - F / h|^2 in [0, 1]. `frame` is F, the displacement [m] of what is held; if held particles move
/// differently, there is no frame in which pulling them along costs nothing, and c is 1. It is 1 as well where a step is not
/// divided: there V is D / h, and stays so.
pub(super) fn rate(model: &Model, cloth: &ClothRange, velocities: &Vectors, corrections: &Vectors, frame: Option<Vec3>) -> f32 {
    let step = model.timing.step_length as f32;
    let frame = match frame {
        Some(frame) if model.timing.spring_steps > 1 => frame / step,
        _ => return 1.0 / step,
    };
    let run = cloth.particles();
    let masses = &model.particles.mass[run.clone()];
    let columns = [
        (&velocities.x, &corrections.x, frame.x),
        (&velocities.y, &corrections.y, frame.y),
        (&velocities.z, &corrections.z, frame.z),
    ];
    let (mut against, mut square) = (0.0, 0.0);
    for (velocities, corrections, frame) in columns {
        let (velocities, corrections) = (&velocities[run.clone()], &corrections[run.clone()]);
        let products = Arch::new().dispatch(Products { velocities, corrections, masses, frame });
        against -= products[0];
        square += products[1];
    }
    let step = f64::from(step);
    if square > 0.0 { (against / square).clamp(0.0, 1.0 / step) as f32 } else { 0.0 }
}

/// So many products are summed in single precision before the sum goes on in double precision.
const BLOCK: usize = 256;

/// Sums of M (V - frame) C and M C C.
struct Products<'a> {
    velocities: &'a [f32],
    corrections: &'a [f32],
    masses: &'a [f32],
    frame: f32,
}

impl WithSimd for Products<'_> {
    type Output = [f64; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; 2] {
        let Self { velocities, corrections, masses, frame } = self;
        let frame = simd.splat_f32s(frame);
        let mut sums = [0.0; 2];
        let blocks = velocities.chunks(BLOCK).zip(corrections.chunks(BLOCK)).zip(masses.chunks(BLOCK));
        for ((velocities, corrections), masses) in blocks {
            let ((v, v_tail), (c, c_tail)) = (S::as_simd_f32s(velocities), S::as_simd_f32s(corrections));
            let (m, m_tail) = S::as_simd_f32s(masses);
            let (v_tail, c_tail) = (simd.partial_load_f32s(v_tail), simd.partial_load_f32s(c_tail));
            let weighted = simd.mul_f32s(c_tail, simd.partial_load_f32s(m_tail));
            let mut along = simd.mul_f32s(simd.sub_f32s(v_tail, frame), weighted);
            let mut square = simd.mul_f32s(c_tail, weighted);
            for ((v, c), m) in v.iter().zip(c).zip(m) {
                let weighted = simd.mul_f32s(*c, *m);
                along = simd.add_f32s(along, simd.mul_f32s(simd.sub_f32s(*v, frame), weighted));
                square = simd.add_f32s(square, simd.mul_f32s(*c, weighted));
            }
            sums[0] += f64::from(simd.reduce_sum_f32s(along));
            sums[1] += f64::from(simd.reduce_sum_f32s(square));
        }
        sums
    }
}
