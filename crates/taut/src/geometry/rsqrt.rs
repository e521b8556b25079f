//! Reciprocal square roots that give the same bits on every machine.

use pulp::Simd;

/// 1 / sqrt(`square`), lane by lane, within two units in the last place; a finite number where `square` is zero.
///
/// Processors have an instruction for this whose last bits differ between makers; dividing by a square root takes five
/// times as long. This starts from the exponent halved in integer arithmetic and takes three steps of Newton's method.
#[inline(always)]
#[must_use]
pub fn reciprocal_sqrt<S: Simd>(simd: S, square: S::f32s) -> S::f32s {
    const MAGIC: u32 = 0x5f37_59df;
    let halved = simd.wrapping_dyn_shr_u32s(simd.transmute_u32s_f32s(square), simd.splat_u32s(1));
    let mut root = simd.transmute_f32s_u32s(simd.sub_u32s(simd.splat_u32s(MAGIC), halved));
    let half = simd.mul_f32s(square, simd.splat_f32s(0.5));
    for _ in 0..3 {
        let error = simd.mul_f32s(simd.mul_f32s(half, root), root);
        root = simd.mul_f32s(root, simd.sub_f32s(simd.splat_f32s(1.5), error));
    }
    root
}

#[cfg(test)]
mod tests {
    use pulp::{Arch, WithSimd};

    use super::*;

    struct Roots<'a>(&'a mut [f32]);

    impl WithSimd for Roots<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            for value in self.0 {
                *value = simd.reduce_max_f32s(reciprocal_sqrt(simd, simd.splat_f32s(*value)));
            }
        }
    }

    #[test]
    fn agrees_with_dividing_by_the_square_root() {
        let squares: Vec<f32> = (0..4000).map(|step| 1e-12 * 1.01_f32.powi(step)).filter(|square| *square < 1e12).collect();
        let mut roots = squares.clone();
        Arch::new().dispatch(Roots(&mut roots));
        for (square, root) in squares.iter().zip(&roots) {
            let exact = 1.0 / f64::from(*square).sqrt();
            let error = (f64::from(*root) / exact - 1.0).abs();
            assert!(error < 2.5e-7, "1 / sqrt({square}) is off by {error}");
        }
    }

    #[test]
    fn of_zero_is_a_number() {
        let mut roots = [0.0];
        Arch::new().dispatch(Roots(&mut roots));
        assert!(roots[0].is_finite());
    }
}
