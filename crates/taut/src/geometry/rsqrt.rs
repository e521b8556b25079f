//! Reciprocal square roots that give the same bits on every machine.

use pulp::Simd;

/// 1 / sqrt(`square`), lane by lane, within 1e-6 of it; a finite number where `square` is zero.
///
/// Processors have an instruction for this whose last bits differ between makers. Dividing by a square root takes five
/// times as long. This starts from the exponent halved in integer arithmetic: y with y^2 = (1 - e) / square and |e| < 0.07.
/// It multiplies y by a cubic that is (1 - e)^(-1/2) within 7.5e-7 there (a least-squares fit, reweighted to the
/// smallest maximum).
#[inline(always)]
#[must_use]
pub fn reciprocal_sqrt<S: Simd>(simd: S, square: S::f32s) -> S::f32s {
    let [root] = reciprocal_sqrts(simd, [square]);
    root
}

/// [`reciprocal_sqrt`] of several registers at once. Each operation waits for the one before. The processor does those of
/// the other registers meanwhile, if they stand next to it in the program.
#[inline(always)]
#[must_use]
pub fn reciprocal_sqrts<S: Simd, const N: usize>(simd: S, squares: [S::f32s; N]) -> [S::f32s; N] {
    const MAGIC: u32 = 0x5f37_59df;
    const CUBIC: [f32; 4] = [0.999_999_2, 0.500_000_36, 0.376_278_88, 0.313_082_88];
    let [a, b, c, d] =
        [simd.splat_f32s(CUBIC[0]), simd.splat_f32s(CUBIC[1]), simd.splat_f32s(CUBIC[2]), simd.splat_f32s(CUBIC[3])];
    let (magic, one) = (simd.splat_u32s(MAGIC), simd.splat_f32s(1.0));
    let mut roots = squares;
    for root in &mut roots {
        let halved = simd.wrapping_dyn_shr_u32s(simd.transmute_u32s_f32s(*root), simd.splat_u32s(1));
        *root = simd.transmute_f32s_u32s(simd.sub_u32s(magic, halved));
    }
    let mut errors = squares;
    for i in 0..N {
        errors[i] = simd.mul_f32s(errors[i], roots[i]);
    }
    for i in 0..N {
        errors[i] = simd.mul_f32s(errors[i], roots[i]);
    }
    for error in &mut errors {
        *error = simd.sub_f32s(one, *error);
    }
    let mut cubics = errors;
    for cubic in &mut cubics {
        *cubic = simd.add_f32s(simd.mul_f32s(d, *cubic), c);
    }
    for i in 0..N {
        cubics[i] = simd.add_f32s(simd.mul_f32s(cubics[i], errors[i]), b);
    }
    for i in 0..N {
        cubics[i] = simd.add_f32s(simd.mul_f32s(cubics[i], errors[i]), a);
    }
    for i in 0..N {
        roots[i] = simd.mul_f32s(roots[i], cubics[i]);
    }
    roots
}

#[cfg(test)]
mod tests {
    use pulp::WithSimd;

    use super::super::arch;
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
        arch().dispatch(Roots(&mut roots));
        for (square, root) in squares.iter().zip(&roots) {
            let exact = 1.0 / f64::from(*square).sqrt();
            let error = (f64::from(*root) / exact - 1.0).abs();
            assert!(error < 1e-6, "1 / sqrt({square}) is off by {error}");
        }
    }

    #[test]
    fn of_zero_is_a_number() {
        let mut roots = [0.0];
        arch().dispatch(Roots(&mut roots));
        assert!(roots[0].is_finite());
    }
}
