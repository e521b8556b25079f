//! The two laws in vector registers: a force along or with the difference of two ends.

use glam::Vec3;
use pulp::Simd;

use super::row::Three;
use super::{damping, spring};
use crate::geometry::reciprocal_sqrts;
use crate::model::{Link, SpringRun};

/// What an end of a spring feels, from the difference `other - own` of a field.
pub(crate) trait Law: Copy + Sync {
    /// The constants that [`Self::factor`] needs, spring by spring.
    fn constants(self, run: &SpringRun) -> [&[f32]; 2];
    /// The forces are the differences times these.
    fn factors<S: Simd, const N: usize>(
        self,
        simd: S,
        differences: &[Three<S::f32s>; N],
        constants: [[S::f32s; 2]; N],
    ) -> [S::f32s; N];
    /// The force for one link.
    fn force(self, difference: Vec3, link: &Link) -> Vec3;
}

/// F_s.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hooke;

/// F_D.
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
        for (factor, [x, y, z]) in factors.iter_mut().zip(differences) {
            let flat = simd.add_f32s(simd.mul_f32s(*x, *x), simd.mul_f32s(*y, *y));
            *factor = simd.add_f32s(flat, simd.mul_f32s(*z, *z));
        }
        factors = reciprocal_sqrts(simd, factors);
        for (factor, [stiffness, stiffness_rest]) in factors.iter_mut().zip(constants) {
            *factor = simd.sub_f32s(stiffness, simd.mul_f32s(stiffness_rest, *factor));
        }
        factors
    }

    #[inline(always)]
    fn force(self, difference: Vec3, link: &Link) -> Vec3 {
        spring::force(difference, link.rest, link.stiffness)
    }
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
    fn force(self, difference: Vec3, link: &Link) -> Vec3 {
        damping::force(difference, link.damping)
    }
}
