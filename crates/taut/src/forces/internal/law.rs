//! The two laws in vector registers: a force along or with the difference of two ends.

use glam::Vec3;
use pulp::Simd;

use super::{damping, spring};
use crate::geometry::reciprocal_sqrt;
use crate::model::{Link, SpringRun};

/// What an end of a spring feels, from the difference `other - own` of a field.
pub(in crate::forces) trait Law: Copy + Sync {
    /// The constants that [`Self::factor`] needs, spring by spring.
    fn constants(self, run: &SpringRun) -> [&[f32]; 2];
    /// The force is the difference times this.
    fn factor<S: Simd>(self, simd: S, difference: [S::f32s; 3], constants: [S::f32s; 2]) -> S::f32s;
    /// The force for one link.
    fn force(self, difference: Vec3, link: &Link) -> Vec3;
}

/// F_s.
#[derive(Debug, Clone, Copy)]
pub(in crate::forces) struct Hooke;

/// F_D.
#[derive(Debug, Clone, Copy)]
pub(in crate::forces) struct Damper;

impl Law for Hooke {
    #[inline(always)]
    fn constants(self, run: &SpringRun) -> [&[f32]; 2] {
        [&run.stiffness, &run.stiffness_rest]
    }

    #[inline(always)]
    fn factor<S: Simd>(self, simd: S, [x, y, z]: [S::f32s; 3], [stiffness, stiffness_rest]: [S::f32s; 2]) -> S::f32s {
        let square = simd.add_f32s(simd.add_f32s(simd.mul_f32s(x, x), simd.mul_f32s(y, y)), simd.mul_f32s(z, z));
        simd.sub_f32s(stiffness, simd.mul_f32s(stiffness_rest, reciprocal_sqrt(simd, square)))
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
    fn factor<S: Simd>(self, _: S, _: [S::f32s; 3], [damping, _]: [S::f32s; 2]) -> S::f32s {
        damping
    }

    #[inline(always)]
    fn force(self, difference: Vec3, link: &Link) -> Vec3 {
        damping::force(difference, link.damping)
    }
}
