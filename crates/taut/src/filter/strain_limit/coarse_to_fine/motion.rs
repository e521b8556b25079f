//! The displacements of a cloth's particles in one step, in whatever order its levels keep them.

use glam::{DVec3, Vec3};
use pulp::{Arch, Simd, WithSimd};

use crate::geometry::Vectors;

/// Displacements and inverse masses; what has no inverse mass is held, or is no particle at all.
pub(super) struct Motion<'a> {
    /// D [m].
    pub d: &'a mut Vectors,
    /// [1/kg]
    pub weights: &'a [f32],
}

/// So many squares are summed in single precision before the sum goes on in double precision.
const BLOCK: usize = 256;

impl Motion<'_> {
    /// Sum of M |D - frame|^2 [kg m^2]: twice the kinetic energy in a moving frame, times the square of the step.
    pub fn energy(&self, frame: Vec3) -> f64 {
        let columns = [(&self.d.x, frame.x), (&self.d.y, frame.y), (&self.d.z, frame.z)];
        columns.map(|(d, frame)| Arch::new().dispatch(Energy { d, weights: self.weights, frame })).iter().sum()
    }

    /// The displacement of the centre of mass [m].
    pub fn mean(&self) -> Vec3 {
        let (mut sum, mut mass) = (DVec3::ZERO, 0.0);
        for (d, &weight) in self.d.iter().zip(self.weights).filter(|(_, weight)| **weight > 0.0) {
            sum += d.as_dvec3() / f64::from(weight);
            mass += 1.0 / f64::from(weight);
        }
        (sum / mass.max(f64::MIN_POSITIVE)).as_vec3()
    }

    /// Leaves `part` of the motion relative to `frame`.
    pub fn slow_down(&mut self, frame: Vec3, part: f32) {
        let columns = [(&mut self.d.x, frame.x), (&mut self.d.y, frame.y), (&mut self.d.z, frame.z)];
        for (d, frame) in columns {
            for (d, _) in d.iter_mut().zip(self.weights).filter(|(_, weight)| **weight > 0.0) {
                *d = frame + (*d - frame) * part;
            }
        }
    }
}

struct Energy<'a> {
    d: &'a [f32],
    weights: &'a [f32],
    frame: f32,
}

impl WithSimd for Energy<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let (frame, zero) = (simd.splat_f32s(self.frame), simd.splat_f32s(0.0));
        let term = |d: S::f32s, weight: S::f32s| {
            let way = simd.sub_f32s(d, frame);
            let energy = simd.div_f32s(simd.mul_f32s(way, way), weight);
            simd.select_f32s(simd.greater_than_f32s(weight, zero), energy, zero)
        };
        let blocks = self.d.chunks(BLOCK).zip(self.weights.chunks(BLOCK));
        let sums = blocks.map(|(d, weights)| {
            let ((d, d_tail), (weights, weights_tail)) = (S::as_simd_f32s(d), S::as_simd_f32s(weights));
            let tail = term(simd.partial_load_f32s(d_tail), simd.partial_load_f32s(weights_tail));
            let sum = d.iter().zip(weights).fold(tail, |sum, (&d, &weight)| simd.add_f32s(sum, term(d, weight)));
            f64::from(simd.reduce_sum_f32s(sum))
        });
        sums.sum()
    }
}
