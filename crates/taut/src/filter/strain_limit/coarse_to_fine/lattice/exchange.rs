//! Between the state, whose rows have their columns in order, and the finest level, which keeps even and odd ones apart.

use pulp::{Simd, WithSimd};

use super::level::Level;
use crate::geometry::Vectors;

/// Takes positions and displacements.
pub(super) struct Load<'a> {
    pub level: &'a mut Level,
    /// First particle of the cloth.
    pub first: usize,
    pub positions: &'a Vectors,
    pub ends: &'a Vectors,
}

impl WithSimd for Load<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { level, first, positions, ends } = self;
        for row in 0..level.rows {
            let columns = first + row * level.columns..first + (row + 1) * level.columns;
            let [even, odd] = [level.place(0, row), level.place(1, row)];
            let fields = [
                (&positions.x, &ends.x, &mut level.x.x, &mut level.d.x),
                (&positions.y, &ends.y, &mut level.x.y, &mut level.d.y),
                (&positions.z, &ends.z, &mut level.x.z, &mut level.d.z),
            ];
            for (from, to, x, d) in fields {
                let ((from, from_rest), (to, to_rest)) =
                    (from[columns.clone()].as_chunks::<2>(), to[columns.clone()].as_chunks::<2>());
                let pairs = from.len();
                let (x_even, x_odd) = x[even..odd + pairs].split_at_mut(odd - even);
                let (d_even, d_odd) = d[even..odd + pairs].split_at_mut(odd - even);
                for ((from, to), (x, d)) in from.iter().zip(to).zip(x_even.iter_mut().zip(d_even.iter_mut())) {
                    (*x, *d) = (from[0], to[0] - from[0]);
                }
                for ((from, to), (x, d)) in from.iter().zip(to).zip(x_odd.iter_mut().zip(d_odd.iter_mut())) {
                    (*x, *d) = (from[1], to[1] - from[1]);
                }
                if let ([from], [to]) = (from_rest, to_rest) {
                    (x_even[pairs], d_even[pairs]) = (*from, to - from);
                }
            }
        }
    }
}

/// Gives the corrected displacements back.
pub(super) struct Store<'a> {
    pub level: &'a Level,
    /// First particle of the cloth.
    pub first: usize,
    pub ends: &'a mut Vectors,
    /// What is added to the ends [m].
    pub corrections: &'a mut Vectors,
}

impl WithSimd for Store<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { level, first, ends, corrections } = self;
        // What was not corrected keeps its end to the last bit.
        let correct = |x: f32, d: f32, end: &mut f32, correction: &mut f32| {
            let before = *end - x;
            *correction = d - before;
            *end = if d == before { *end } else { x + d };
        };
        for row in 0..level.rows {
            let columns = first + row * level.columns..first + (row + 1) * level.columns;
            let [even, odd] = [level.place(0, row), level.place(1, row)];
            let fields = [
                (&level.x.x, &level.d.x, &mut ends.x, &mut corrections.x),
                (&level.x.y, &level.d.y, &mut ends.y, &mut corrections.y),
                (&level.x.z, &level.d.z, &mut ends.z, &mut corrections.z),
            ];
            for (x, d, ends, corrections) in fields {
                let (ends, ends_rest) = ends[columns.clone()].as_chunks_mut::<2>();
                let (corrections, corrections_rest) = corrections[columns.clone()].as_chunks_mut::<2>();
                let pairs = ends.len();
                let evens = x[even..even + pairs].iter().zip(&d[even..even + pairs]);
                let odds = x[odd..odd + pairs].iter().zip(&d[odd..odd + pairs]);
                for ((end, correction), (even, odd)) in ends.iter_mut().zip(corrections).zip(evens.zip(odds)) {
                    let ([end_even, end_odd], [correction_even, correction_odd]) = (end, correction);
                    correct(*even.0, *even.1, end_even, correction_even);
                    correct(*odd.0, *odd.1, end_odd, correction_odd);
                }
                if let ([end], [correction]) = (ends_rest, corrections_rest) {
                    correct(x[even + pairs], d[even + pairs], end, correction);
                }
            }
        }
    }
}
