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
    pub velocities: &'a mut Vectors,
    /// 1 / h [1/s].
    pub rate: f32,
}

impl WithSimd for Store<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { level, first, ends, velocities, rate } = self;
        // What was not corrected keeps its end and its velocity to the last bit.
        let correct = |x: f32, d: f32, end: &mut f32, velocity: &mut f32| {
            let before = *end - x;
            *velocity += (d - before) * rate;
            *end = if d == before { *end } else { x + d };
        };
        for row in 0..level.rows {
            let columns = first + row * level.columns..first + (row + 1) * level.columns;
            let [even, odd] = [level.place(0, row), level.place(1, row)];
            let fields = [
                (&level.x.x, &level.d.x, &mut ends.x, &mut velocities.x),
                (&level.x.y, &level.d.y, &mut ends.y, &mut velocities.y),
                (&level.x.z, &level.d.z, &mut ends.z, &mut velocities.z),
            ];
            for (x, d, ends, velocities) in fields {
                let (ends, ends_rest) = ends[columns.clone()].as_chunks_mut::<2>();
                let (velocities, velocities_rest) = velocities[columns.clone()].as_chunks_mut::<2>();
                let pairs = ends.len();
                let evens = x[even..even + pairs].iter().zip(&d[even..even + pairs]);
                let odds = x[odd..odd + pairs].iter().zip(&d[odd..odd + pairs]);
                for ((end, velocity), (even, odd)) in ends.iter_mut().zip(velocities).zip(evens.zip(odds)) {
                    let ([end_even, end_odd], [velocity_even, velocity_odd]) = (end, velocity);
                    correct(*even.0, *even.1, end_even, velocity_even);
                    correct(*odd.0, *odd.1, end_odd, velocity_odd);
                }
                if let ([end], [velocity]) = (ends_rest, velocities_rest) {
                    correct(x[even + pairs], d[even + pairs], end, velocity);
                }
            }
        }
    }
}
