//! Projections of whole runs of springs at once, in vector registers.
//!
//! The springs of a run join the particles `a[i]` and `b[i]`; no particle is in a run twice. Every run is a whole number of
//! blocks long. Places are relative to a particle of the cloth: far from the origin single precision is coarse.

use pulp::Simd;
use pulp::bytemuck::cast_slice;

use crate::geometry::{Vectors, reciprocal_sqrt};

/// Runs are filled up to a multiple of this, the widest vector register there is (AVX-512).
pub(super) const BLOCK: usize = 16;

/// One end of the springs of a run.
pub(super) struct End<'a> {
    /// Where the step begins [m].
    pub x: [&'a [f32]; 3],
    /// Where it ends so far [m].
    pub p: [&'a mut [f32]; 3],
    /// Inverse masses, zero for what is held.
    pub w: &'a [f32],
}

/// How far a spring is pulled together.
#[derive(Clone, Copy)]
pub(super) struct LatticePull {
    /// Springs longer than this part of their greatest length R are pulled to it. A pull is a projection onto a ball, which brings no two
    /// places further apart: cloth at rest stays at rest. Springs that are pulled further than what makes them too long would jerk.
    pub aim: f32,
    /// Along X, their direction at the start of the step, instead of P, that at its end: only if D = P - X, what the step
    /// has turned and stretched them by, is short against them.
    pub at_start: bool,
}

/// Springs whose |D|^2 is a larger part of |P|^2 than this are pulled along P in any case: they turn so far that their
/// direction at the start says little [1].
pub(super) const TURNED: f32 = 0.01;

/// The greatest lengths of the springs of a run.
#[derive(Clone, Copy)]
pub(super) struct Limits<'a> {
    /// R [m].
    pub length: &'a [f32],
    /// 1 / R^2 [1/m^2].
    pub inverse_square: &'a [f32],
}

/// Projects every spring of a run that is over its aim. Where none of a register's springs is, nothing is stored.
#[inline(always)]
pub(super) fn project<S: Simd>(simd: S, a: End<'_>, b: End<'_>, limits: Limits<'_>, pull: LatticePull) {
    let (limit, inverse) = (lanes::<S>(limits.length), lanes::<S>(limits.inverse_square));
    let len = limit.len();
    let inverse = &inverse[..len];
    let [ax, ay, az] = a.x.map(|values| &lanes::<S>(values)[..len]);
    let [bx, by, bz] = b.x.map(|values| &lanes::<S>(values)[..len]);
    let [ap, aq, ar] = a.p.map(|values| &mut S::as_mut_simd_f32s(values).0[..len]);
    let [bp, bq, br] = b.p.map(|values| &mut S::as_mut_simd_f32s(values).0[..len]);
    let [wa, wb] = [a.w, b.w].map(|values| &lanes::<S>(values)[..len]);
    let [reach, aim, one] = [pull.aim * pull.aim, pull.aim, 1.0].map(|value| simd.splat_f32s(value));
    // The floor keeps two held ends, and the empty lanes at the end of a run, from dividing by zero.
    let (floor, zero) = (simd.splat_f32s(1e-30), simd.splat_f32s(0.0));
    let (add, sub, mul) = (|a, b| simd.add_f32s(a, b), |a, b| simd.sub_f32s(a, b), |a, b| simd.mul_f32s(a, b));
    for i in 0..len {
        let [x, y, z] = [sub(bp[i], ap[i]), sub(bq[i], aq[i]), sub(br[i], ar[i])];
        let square = add(add(mul(x, x), mul(y, y)), mul(z, z));
        let over = simd.greater_than_f32s(mul(square, inverse[i]), reach);
        if simd.first_true_m32s(over) >= S::F32_LANES {
            continue;
        }
        let mut excess = sub(one, mul(mul(limit[i], aim), reciprocal_sqrt(simd, square)));
        let mut along = [x, y, z];
        if pull.at_start {
            let start = [sub(bx[i], ax[i]), sub(by[i], ay[i]), sub(bz[i], az[i])];
            let [u, v, w] = [sub(x, start[0]), sub(y, start[1]), sub(z, start[2])];
            let moved = add(add(mul(u, u), mul(v, v)), mul(w, w));
            let little = simd.less_than_f32s(moved, mul(simd.splat_f32s(TURNED), square));
            along = [
                simd.select_f32s(little, start[0], x),
                simd.select_f32s(little, start[1], y),
                simd.select_f32s(little, start[2], z),
            ];
            // The length still shrinks by the same.
            let part = add(add(mul(x, along[0]), mul(y, along[1])), mul(z, along[2]));
            excess = simd.div_f32s(mul(excess, square), part);
        }
        let weight = simd.max_f32s(add(wa[i], wb[i]), floor);
        let share = simd.select_f32s(over, simd.div_f32s(excess, weight), zero);
        let (share_a, share_b) = (mul(share, wa[i]), mul(share, wb[i]));
        ap[i] = add(ap[i], mul(share_a, along[0]));
        aq[i] = add(aq[i], mul(share_a, along[1]));
        ar[i] = add(ar[i], mul(share_a, along[2]));
        bp[i] = sub(bp[i], mul(share_b, along[0]));
        bq[i] = sub(bq[i], mul(share_b, along[1]));
        br[i] = sub(br[i], mul(share_b, along[2]));
    }
}

/// Largest (|P_uv| / R)^2, lane by lane, of `worst` and the run whose ends begin at `a` and `b`; where it is over `enough`, calls
/// `mark` with the place of a register's first spring and 1 for each of its springs that are, 0 for the others. `inverse` holds
/// 1 / R^2.
#[inline(always)]
pub(super) fn worst<S: Simd>(
    simd: S,
    p: &Vectors,
    [a, b]: [usize; 2],
    inverse: &[f32],
    worst: S::f32s,
    enough: f32,
    mut mark: impl FnMut(usize, &[f32]),
) -> S::f32s {
    let run = |from: usize| from..from + inverse.len();
    let inverse = lanes::<S>(inverse);
    let len = inverse.len();
    let [ap, aq, ar] = [&p.x, &p.y, &p.z].map(|column| &lanes::<S>(&column[run(a)])[..len]);
    let [bp, bq, br] = [&p.x, &p.y, &p.z].map(|column| &lanes::<S>(&column[run(b)])[..len]);
    let (add, sub, mul) = (|a, b| simd.add_f32s(a, b), |a, b| simd.sub_f32s(a, b), |a, b| simd.mul_f32s(a, b));
    let [enough, one, zero] = [enough, 1.0, 0.0].map(|value| simd.splat_f32s(value));
    let mut worst = worst;
    for i in 0..len {
        let [x, y, z] = [sub(bp[i], ap[i]), sub(bq[i], aq[i]), sub(br[i], ar[i])];
        let ratio = mul(add(add(mul(x, x), mul(y, y)), mul(z, z)), inverse[i]);
        worst = simd.max_f32s(worst, ratio);
        let over = simd.greater_than_f32s(ratio, enough);
        // Which lane is the first that is over is counted from different ends by different registers.
        if simd.first_true_m32s(over) < S::F32_LANES {
            mark(i * S::F32_LANES, cast_slice(&[simd.select_f32s(over, one, zero)]));
        }
    }
    worst
}

#[inline(always)]
fn lanes<S: Simd>(values: &[f32]) -> &[S::f32s] {
    S::as_simd_f32s(values).0
}
