//! From a level to the next coarser one and back.
//!
//! Coarse columns and rows are every second fine one, and the last. Going down, fields are sampled; coming back, what
//! the coarse level added is interpolated linearly between its neighbours.

use pulp::{Arch, Simd, WithSimd};

use super::level::Level;
use crate::geometry::{Pool, Vectors};

/// How many coarse columns (or rows) `count` fine ones have.
pub(super) fn coarsened(count: usize) -> usize {
    count / 2 + 1
}

/// The fine column (or row) that a coarse one samples, of `count` fine ones.
#[inline(always)]
pub(super) fn sampled(coarse: usize, count: usize) -> usize {
    (2 * coarse).min(count - 1)
}

/// The two coarse neighbours of a fine column (or row), each with weight 1/2; the same twice where it is sampled itself.
pub(super) fn parents(fine: usize, count: usize) -> [usize; 2] {
    if fine.is_multiple_of(2) || fine == count - 1 { [fine.div_ceil(2); 2] } else { [fine / 2, fine / 2 + 1] }
}

/// Takes the places where a step begins from a fine level to a coarse one.
pub(super) fn sample_start(fine: &Level, coarse: &mut Level, pool: &Pool) {
    let [columns, row_length] = [coarse.columns, coarse.row_length()];
    sample(fine, &fine.x, &mut coarse.x, [columns, row_length], pool);
}

/// Takes the places where it ends so far.
pub(super) fn sample_ends(fine: &Level, coarse: &mut Level, pool: &Pool) {
    let [columns, row_length] = [coarse.columns, coarse.row_length()];
    sample(fine, &fine.p, &mut coarse.p, [columns, row_length], pool);
}

fn sample(fine: &Level, from: &Vectors, to: &mut Vectors, [columns, row_length]: [usize; 2], pool: &Pool) {
    to.for_each_part(0..to.len(), BAND * row_length, pool, |to| {
        let first = to.first / row_length;
        for (from, to) in [(&from.x, to.x), (&from.y, to.y), (&from.z, to.z)] {
            Arch::new().dispatch(Sample { fine, columns, row_length, first, from, to });
        }
    });
}

/// Some rows of a coarse level.
struct Sample<'a> {
    fine: &'a Level,
    /// Coarse columns.
    columns: usize,
    /// Length of a coarse row in memory.
    row_length: usize,
    /// The first coarse row.
    first: usize,
    from: &'a [f32],
    to: &'a mut [f32],
}

impl WithSimd for Sample<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { fine, columns, row_length, first, from, to } = self;
        let (evens, odds) = (columns.div_ceil(2), columns / 2);
        for (row, to) in to.chunks_mut(row_length).enumerate() {
            let fine_row = sampled(first + row, fine.rows);
            let there = fine.place(0, fine_row);
            let source = &from[there..there + fine.columns.div_ceil(2)];
            let (pairs, rest) = source.as_chunks::<2>();
            let (even, odd) = to.split_at_mut(row_length / 2);
            for ((even, odd), pair) in even.iter_mut().zip(odd.iter_mut()).zip(pairs) {
                (*even, *odd) = (pair[0], pair[1]);
            }
            if let [last] = rest {
                even[pairs.len()] = *last;
            }
            // With an even number of columns the last one is an odd one.
            let last = from[fine.place(fine.columns - 1, fine_row)];
            if columns.is_multiple_of(2) { odd[odds - 1] = last } else { even[evens - 1] = last }
        }
    }
}

/// Adds to the fine ends what the coarse ones have gained since they were sampled; what is held stays. `gains` is workspace: as many
/// as the coarse level has places, columns in order.
pub(super) fn prolong(fine: &mut Level, coarse: &Level, gains: &mut Vectors, pool: &Pool) {
    let row_length = coarse.row_length();
    gains.for_each_part(0..coarse.rows * row_length, BAND * row_length, pool, |gains| {
        let first = gains.first / row_length;
        let columns = [(&fine.p.x, &coarse.p.x, gains.x), (&fine.p.y, &coarse.p.y, gains.y), (&fine.p.z, &coarse.p.z, gains.z)];
        for (before, now, gains) in columns {
            Arch::new().dispatch(Gain { fine, coarse, first, before, now, gains });
        }
    });
    let gains = &*gains;
    let row_length = fine.row_length();
    let Level { p, held, columns, rows, .. } = fine;
    let [columns, rows] = [*columns, *rows];
    held.iter_mut().for_each(|(place, end)| *end = p.get(*place));
    p.for_each_part(0..rows * row_length, BAND * row_length, pool, |p| {
        let first = p.first / row_length;
        for (gains, p) in [(&gains.x, p.x), (&gains.y, p.y), (&gains.z, p.z)] {
            Arch::new().dispatch(Prolong { columns, rows, row_length, coarse, first, gains, p });
        }
    });
    held.iter().for_each(|(place, end)| p.set(*place, *end));
}

/// Rows in a band.
const BAND: usize = 32;

/// Some rows of gains: coarse ends less fine ones.
struct Gain<'a> {
    fine: &'a Level,
    coarse: &'a Level,
    /// The first coarse row.
    first: usize,
    before: &'a [f32],
    now: &'a [f32],
    gains: &'a mut [f32],
}

impl WithSimd for Gain<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { fine, coarse, first, before, now, gains } = self;
        for (index, gains) in gains.chunks_mut(coarse.row_length()).enumerate() {
            let (row, fine_row) = (first + index, sampled(first + index, fine.rows));
            let [even, odd] = [coarse.place(0, row), coarse.place(1, row)];
            let fine_even = fine.place(0, fine_row);
            let before_row = &before[fine_even..fine_even + fine.columns.div_ceil(2)];
            let ((gains_of_pairs, _), (pairs, rest)) = (gains.as_chunks_mut::<2>(), before_row.as_chunks::<2>());
            let (evens, odds) = (&now[even..even + pairs.len()], &now[odd..odd + pairs.len()]);
            for ((gain, pair), (even, odd)) in gains_of_pairs.iter_mut().zip(pairs).zip(evens.iter().zip(odds)) {
                *gain = [even - pair[0], odd - pair[1]];
            }
            let column = 2 * pairs.len();
            if let [before] = rest {
                gains[column] = now[coarse.place(column, row)] - before;
            }
            // With an even number of columns the last one is an odd one.
            let last = coarse.columns - 1;
            gains[last] = now[coarse.place(last, row)] - before[fine.place(fine.columns - 1, fine_row)];
        }
    }
}

/// Some rows of a fine level.
struct Prolong<'a> {
    columns: usize,
    rows: usize,
    row_length: usize,
    coarse: &'a Level,
    /// The first fine row.
    first: usize,
    gains: &'a [f32],
    p: &'a mut [f32],
}

impl WithSimd for Prolong<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { columns, rows, row_length, coarse, first, gains, p } = self;
        let (evens, odds) = (columns.div_ceil(2), columns / 2);
        // With an even number of columns the last one is sampled itself: it has the gain of the last coarse column.
        let between = if columns.is_multiple_of(2) { odds - 1 } else { odds };
        let gains_of = |row: usize| &gains[row * coarse.row_length()..][..coarse.columns];
        for (row, p) in (first..).zip(p.chunks_mut(row_length)) {
            let [one, other] = parents(row, rows);
            let (one, other) = (gains_of(one), gains_of(other));
            let (even, odd) = p.split_at_mut(row_length / 2);
            // The mean of a row and itself is that row to the last bit.
            let means = one.iter().zip(other);
            for (p, (one, other)) in even[..evens].iter_mut().zip(means.clone()) {
                *p += 0.5 * (one + other);
            }
            let sides = means.clone().zip(means.skip(1));
            for (p, ((one, other), (one_right, other_right))) in odd[..between].iter_mut().zip(sides) {
                *p += 0.5 * (0.5 * (one + other) + 0.5 * (one_right + other_right));
            }
            if between < odds {
                odd[between] += 0.5 * (one[odds] + other[odds]);
            }
        }
    }
}
