//! Between the state, whose rows have their columns in order, and the finest level, which keeps even and odd ones apart.

use pulp::{Arch, Simd, WithSimd};

use super::level::Level;
use crate::geometry::{Pool, Vectors};

/// Rows that are exchanged together.
const BAND: usize = 32;

/// Takes positions and displacements; `first` is the first particle of the cloth.
pub(super) fn load(level: &mut Level, first: usize, positions: &Vectors, ends: &Vectors, pool: &Pool) {
    let [columns, row_length] = [level.columns, level.row_length()];
    let all = 0..level.rows * row_length;
    level.x.for_each_part_of_two(&mut level.d, all, BAND * row_length, pool, |x, d| {
        let first = first + x.first / row_length * columns;
        let fields = [(&positions.x, &ends.x, x.x, d.x), (&positions.y, &ends.y, x.y, d.y), (&positions.z, &ends.z, x.z, d.z)];
        for (from, to, x, d) in fields {
            Arch::new().dispatch(Load { columns, row_length, from: &from[first..], to: &to[first..], x, d });
        }
    });
}

/// Some rows of a coordinate.
struct Load<'a> {
    columns: usize,
    row_length: usize,
    from: &'a [f32],
    to: &'a [f32],
    x: &'a mut [f32],
    d: &'a mut [f32],
}

impl WithSimd for Load<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { columns, row_length, from, to, x, d } = self;
        let state = from.chunks_exact(columns).zip(to.chunks_exact(columns));
        for ((from, to), (x, d)) in state.zip(x.chunks_mut(row_length).zip(d.chunks_mut(row_length))) {
            let ((from, from_rest), (to, to_rest)) = (from.as_chunks::<2>(), to.as_chunks::<2>());
            let pairs = from.len();
            let (x_even, x_odd) = x.split_at_mut(row_length / 2);
            let (d_even, d_odd) = d.split_at_mut(row_length / 2);
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

/// Gives the corrected ends back, and what was added to them [m].
pub(super) fn store(level: &Level, first: usize, ends: &mut Vectors, corrections: &mut Vectors, pool: &Pool) {
    let [columns, row_length] = [level.columns, level.row_length()];
    ends.for_each_part_of_two(corrections, first..first + level.size(), BAND * columns, pool, |ends, corrections| {
        let begin = (ends.first - first) / columns * row_length;
        let fields = [
            (&level.x.x, &level.d.x, ends.x, corrections.x),
            (&level.x.y, &level.d.y, ends.y, corrections.y),
            (&level.x.z, &level.d.z, ends.z, corrections.z),
        ];
        for (x, d, ends, corrections) in fields {
            Arch::new().dispatch(Store { columns, row_length, x: &x[begin..], d: &d[begin..], ends, corrections });
        }
    });
}

/// Some rows of a coordinate.
struct Store<'a> {
    columns: usize,
    row_length: usize,
    x: &'a [f32],
    d: &'a [f32],
    ends: &'a mut [f32],
    corrections: &'a mut [f32],
}

impl WithSimd for Store<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { columns, row_length, x, d, ends, corrections } = self;
        // What was not corrected keeps its end to the last bit.
        let correct = |x: f32, d: f32, end: &mut f32, correction: &mut f32| {
            let before = *end - x;
            *correction = d - before;
            *end = if d == before { *end } else { x + d };
        };
        let level = x.chunks_exact(row_length).zip(d.chunks_exact(row_length));
        for ((x, d), (ends, corrections)) in level.zip(ends.chunks_mut(columns).zip(corrections.chunks_mut(columns))) {
            let (ends, ends_rest) = ends.as_chunks_mut::<2>();
            let (corrections, corrections_rest) = corrections.as_chunks_mut::<2>();
            let pairs = ends.len();
            let ((x_even, x_odd), (d_even, d_odd)) = (x.split_at(row_length / 2), d.split_at(row_length / 2));
            let evens = x_even[..pairs].iter().zip(&d_even[..pairs]);
            let odds = x_odd[..pairs].iter().zip(&d_odd[..pairs]);
            for ((end, correction), (even, odd)) in ends.iter_mut().zip(corrections).zip(evens.zip(odds)) {
                let ([end_even, end_odd], [correction_even, correction_odd]) = (end, correction);
                correct(*even.0, *even.1, end_even, correction_even);
                correct(*odd.0, *odd.1, end_odd, correction_odd);
            }
            if let ([end], [correction]) = (ends_rest, corrections_rest) {
                correct(x_even[pairs], d_even[pairs], end, correction);
            }
        }
    }
}
