//! Between the state, whose rows have their columns in order, and the finest level, which keeps even and odd ones apart.

use pulp::{Simd, WithSimd};

use super::level::LatticeLevel;
use crate::geometry::{Pool, Vectors, arch};

/// Rows that are exchanged together.
const BAND: usize = 32;

/// Takes where a step begins and ends, relative to where the particle `middle` begins, and the displacements; `first` is the
/// first particle of the cloth.
pub(super) fn load(
    level: &mut LatticeLevel,
    d: &mut Vectors,
    first: usize,
    middle: usize,
    [starts, ends]: [&Vectors; 2],
    pool: &Pool,
) {
    let [columns, row_length] = [level.columns, level.row_length()];
    let all = 0..level.rows * row_length;
    let origin = starts.get(middle);
    level.x.for_each_part_of_two(d, all, BAND * row_length, pool, |x, d| {
        let first = first + x.first / row_length * columns;
        let fields = [
            (&starts.x, &ends.x, origin.x, x.x, d.x),
            (&starts.y, &ends.y, origin.y, x.y, d.y),
            (&starts.z, &ends.z, origin.z, x.z, d.z),
        ];
        for (from, to, origin, x, d) in fields {
            arch().dispatch(Load { columns, row_length, from: &from[first..], to: &to[first..], origin, x, d });
        }
    });
    let (x, d) = (&level.x, &*d);
    level.p.for_each_chunk(pool, |p| {
        let run = p.first..p.first + p.x.len();
        for (p, x, d) in [(p.x, &x.x, &d.x), (p.y, &x.y, &d.y), (p.z, &x.z, &d.z)] {
            arch().dispatch(Sum { p, x: &x[run.clone()], d: &d[run.clone()] });
        }
    });
}

/// Some rows of a coordinate.
struct Load<'a> {
    columns: usize,
    row_length: usize,
    from: &'a [f32],
    to: &'a [f32],
    origin: f32,
    x: &'a mut [f32],
    d: &'a mut [f32],
}

impl WithSimd for Load<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { columns, row_length, from, to, origin, x, d } = self;
        let state = from.chunks_exact(columns).zip(to.chunks_exact(columns));
        for ((from, to), (x, d)) in state.zip(x.chunks_mut(row_length).zip(d.chunks_mut(row_length))) {
            let ((from, from_rest), (to, to_rest)) = (from.as_chunks::<2>(), to.as_chunks::<2>());
            let pairs = from.len();
            let (x_even, x_odd) = x.split_at_mut(row_length / 2);
            let (d_even, d_odd) = d.split_at_mut(row_length / 2);
            for ((from, to), (x, d)) in from.iter().zip(to).zip(x_even.iter_mut().zip(d_even.iter_mut())) {
                (*x, *d) = (from[0] - origin, to[0] - from[0]);
            }
            for ((from, to), (x, d)) in from.iter().zip(to).zip(x_odd.iter_mut().zip(d_odd.iter_mut())) {
                (*x, *d) = (from[1] - origin, to[1] - from[1]);
            }
            if let ([from], [to]) = (from_rest, to_rest) {
                (x_even[pairs], d_even[pairs]) = (from - origin, to - from);
            }
        }
    }
}

/// p := x + d.
struct Sum<'a> {
    p: &'a mut [f32],
    x: &'a [f32],
    d: &'a [f32],
}

impl WithSimd for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.p.iter_mut().zip(self.x.iter().zip(self.d)).for_each(|(p, (x, d))| *p = x + d);
    }
}

/// Gives the corrected ends back, and what was added to them [m].
pub(super) fn store(
    level: &LatticeLevel,
    d: &Vectors,
    first: usize,
    starts: &Vectors,
    [ends, corrections]: [&mut Vectors; 2],
    pool: &Pool,
) {
    let [columns, row_length] = [level.columns, level.row_length()];
    ends.for_each_part_of_two(corrections, first..first + level.size(), BAND * columns, pool, |ends, corrections| {
        let (here, begin) = (ends.first..ends.first + ends.x.len(), (ends.first - first) / columns * row_length);
        let fields = [
            (&starts.x, &d.x, ends.x, corrections.x),
            (&starts.y, &d.y, ends.y, corrections.y),
            (&starts.z, &d.z, ends.z, corrections.z),
        ];
        for (starts, d, ends, corrections) in fields {
            let starts = &starts[here.clone()];
            arch().dispatch(Store { columns, row_length, starts, d: &d[begin..], ends, corrections });
        }
    });
}

/// Some rows of a coordinate.
struct Store<'a> {
    columns: usize,
    row_length: usize,
    starts: &'a [f32],
    d: &'a [f32],
    ends: &'a mut [f32],
    corrections: &'a mut [f32],
}

impl WithSimd for Store<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { columns, row_length, starts, d, ends, corrections } = self;
        // What was not corrected keeps its end to the last bit.
        let correct = |start: f32, d: f32, end: &mut f32, correction: &mut f32| {
            let before = *end - start;
            *correction = d - before;
            *end = if d == before { *end } else { start + d };
        };
        let rows = starts.chunks(columns).zip(d.chunks_exact(row_length));
        for ((starts, d), (ends, corrections)) in rows.zip(ends.chunks_mut(columns).zip(corrections.chunks_mut(columns))) {
            let (starts, starts_rest) = starts.as_chunks::<2>();
            let (ends, ends_rest) = ends.as_chunks_mut::<2>();
            let (corrections, corrections_rest) = corrections.as_chunks_mut::<2>();
            let pairs = ends.len();
            let (even, odd) = d.split_at(row_length / 2);
            let d = even[..pairs].iter().zip(&odd[..pairs]);
            for ((start, (even, odd)), (end, correction)) in starts.iter().zip(d).zip(ends.iter_mut().zip(corrections)) {
                let ([end_even, end_odd], [correction_even, correction_odd]) = (end, correction);
                correct(start[0], *even, end_even, correction_even);
                correct(start[1], *odd, end_odd, correction_odd);
            }
            if let ([start], [end], [correction]) = (starts_rest, ends_rest, corrections_rest) {
                correct(*start, even[pairs], end, correction);
            }
        }
    }
}
