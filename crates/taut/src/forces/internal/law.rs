//! The two laws (paper, section 2.1) in vector registers: a force along or with the difference of two ends.

use glam::Vec4;
use pulp::Simd;

use super::row::Three;
use crate::geometry::{reciprocal_sqrts, roots};
use crate::model::SpringRun;

/// What an end of a spring feels, from the difference `other - own` of a field.
pub(crate) trait Law: Copy + Sync {
    /// The constants that [`Self::factor`] needs, spring by spring.
    fn constants(self, run: &SpringRun) -> [&[f32]; 2];
    /// The forces are the differences times these, within 1e-6 of the greatest of their terms.
    fn factors<S: Simd, const N: usize>(
        self,
        simd: S,
        differences: &[Three<S::f32s>; N],
        constants: [[S::f32s; 2]; N],
    ) -> [S::f32s; N];
    /// The same of four springs, within rounding: where memory is waited for anyway, dividing costs nothing.
    fn factor_of_four(self, difference: Three<Vec4>, constants: [Vec4; 2]) -> Vec4;
}

/// Hooke's law: `F_s = k_s (1 - L / |X_uv|) X_uv` on u, `X_uv = X_v - X_u` [N]. Two particles at the same place have no direction
/// to push in; the force is zero there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hooke;

/// Linear damping of relative velocity: `F_D = k_D (V_v - V_u)` on u [N].
#[derive(Debug, Clone, Copy)]
pub(in crate::forces) struct Damper;

impl Law for Hooke {
    #[inline(always)]
    fn constants(self, run: &SpringRun) -> [&[f32]; 2] {
        [&run.stiffness, &run.stiffness_rest]
    }

    #[inline(always)]
    fn factors<S: Simd, const N: usize>(
        self,
        simd: S,
        differences: &[Three<S::f32s>; N],
        constants: [[S::f32s; 2]; N],
    ) -> [S::f32s; N] {
        let mut factors = [simd.splat_f32s(0.0); N];
        for (factor, difference) in factors.iter_mut().zip(differences) {
            *factor = square(simd, *difference);
        }
        factors = reciprocal_sqrts(simd, factors);
        for (factor, [stiffness, stiffness_rest]) in factors.iter_mut().zip(constants) {
            *factor = simd.sub_f32s(stiffness, simd.mul_f32s(stiffness_rest, *factor));
        }
        factors
    }

    #[inline(always)]
    fn factor_of_four(self, [x, y, z]: Three<Vec4>, [stiffness, stiffness_rest]: [Vec4; 2]) -> Vec4 {
        let length = roots(x * x + y * y + z * z);
        // The floor keeps two particles at the same place from dividing by zero.
        stiffness - stiffness_rest / length.max(Vec4::splat(1e-30))
    }
}

/// |X|^2.
#[inline(always)]
fn square<S: Simd>(simd: S, [x, y, z]: Three<S::f32s>) -> S::f32s {
    let flat = simd.add_f32s(simd.mul_f32s(x, x), simd.mul_f32s(y, y));
    simd.add_f32s(flat, simd.mul_f32s(z, z))
}

impl Law for Damper {
    #[inline(always)]
    fn constants(self, run: &SpringRun) -> [&[f32]; 2] {
        [&run.damping, &run.damping]
    }

    #[inline(always)]
    fn factors<S: Simd, const N: usize>(self, simd: S, _: &[Three<S::f32s>; N], constants: [[S::f32s; 2]; N]) -> [S::f32s; N] {
        let mut factors = [simd.splat_f32s(0.0); N];
        for (factor, [damping, _]) in factors.iter_mut().zip(constants) {
            *factor = damping;
        }
        factors
    }

    #[inline(always)]
    fn factor_of_four(self, _: Three<Vec4>, [damping, _]: [Vec4; 2]) -> Vec4 {
        damping
    }
}
