//! From a level to the next coarser one and back.
//!
//! Coarse columns and rows are every second fine one, and the last. Going down, fields are sampled; coming back, what
//! the coarse level added is interpolated linearly between its neighbours.

use pulp::{Arch, Simd, WithSimd};

use super::level::Level;
use crate::geometry::{Pool, Vectors, VectorsChunk};

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

/// Copies the places where a step begins from a fine level to a coarse one.
pub(super) fn sample_start(fine: &Level, coarse: &mut Level, pool: &Pool) {
    let [columns, row_length] = [coarse.columns, coarse.row_length()];
    coarse.x.for_each_part(0..coarse.rows * row_length, BAND * row_length, pool, |x| {
        for (from, to) in [(&fine.x.x, x.x), (&fine.x.y, x.y), (&fine.x.z, x.z)] {
            Arch::new().dispatch(Sample { fine, columns, row_length, first: x.first / row_length, from, to });
        }
    });
}

/// Copies the places where it ends so far, and to `before`, too.
pub(super) fn sample_ends(fine: &Level, coarse: &mut Level, before: &mut Vectors, pool: &Pool) {
    let [columns, row_length] = [coarse.columns, coarse.row_length()];
    let all = 0..coarse.rows * row_length;
    coarse.p.for_each_part_of_two(before, all, BAND * row_length, pool, |p, before| {
        let rows = [(&fine.p.x, p.x, before.x), (&fine.p.y, p.y, before.y), (&fine.p.z, p.z, before.z)];
        for (from, to, before) in rows {
            Arch::new().dispatch(Sample { fine, columns, row_length, first: p.first / row_length, from, to });
            before.copy_from_slice(to);
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

/// Adds to the fine ends what the coarse ones gained over `before`, which becomes that gain; what is held stays. `gained` is
/// workspace: a coarse row of gains for every band of fine rows.
pub(super) fn prolong(fine: &mut Level, coarse: &Level, before: &mut Vectors, gained: &mut [Vec<f32>], pool: &Pool) {
    before.for_each_chunk(pool, |VectorsChunk { first, x, y, z }| {
        let run = first..first + x.len();
        for (before, now) in [(x, &coarse.p.x), (y, &coarse.p.y), (z, &coarse.p.z)] {
            Arch::new().dispatch(Gain { before, now: &now[run.clone()] });
        }
    });
    let gains = &*before;
    let row_length = fine.row_length();
    let Level { p, w, columns, rows, .. } = fine;
    let (columns, rows, w) = (*columns, *rows, &*w);
    p.for_each_band(0..rows * row_length, BAND * row_length, gained, pool, |p, gained| {
        Arch::new().dispatch(ProlongBand { p, w, columns, rows, row_length, coarse, gains, gained });
    });
}

/// How many bands [`prolong`] has for a fine level.
pub(super) fn bands(fine: &Level) -> usize {
    fine.rows.div_ceil(BAND)
}

/// Fine rows in a band.
const BAND: usize = 32;

/// before := now - before.
struct Gain<'a> {
    before: &'a mut [f32],
    now: &'a [f32],
}

impl WithSimd for Gain<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.before.iter_mut().zip(self.now).for_each(|(before, now)| *before = now - *before);
    }
}

struct ProlongBand<'a> {
    p: VectorsChunk<'a>,
    w: &'a [f32],
    columns: usize,
    rows: usize,
    row_length: usize,
    coarse: &'a Level,
    gains: &'a Vectors,
    gained: &'a mut [f32],
}

impl WithSimd for ProlongBand<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { p, w, columns, rows, row_length, coarse, gains, gained } = self;
        let (evens, odds) = (columns.div_ceil(2), columns / 2);
        // With an even number of columns the last one is sampled itself: it has the gain of the last coarse column.
        let between = if columns.is_multiple_of(2) { odds - 1 } else { odds };
        let first_row = p.first / row_length;
        for (target, gains) in [(p.x, &gains.x), (p.y, &gains.y), (p.z, &gains.z)] {
            for (index, target) in target.chunks_mut(row_length).enumerate() {
                let row = first_row + index;
                gain_of_row(coarse, parents(row, rows), gains, gained);
                let (even_w, odd_w) = w[row * row_length..(row + 1) * row_length].split_at(row_length / 2);
                let (even, odd) = target.split_at_mut(row_length / 2);
                for ((target, w), gain) in even[..evens].iter_mut().zip(&even_w[..evens]).zip(&gained[..evens]) {
                    *target += if *w > 0.0 { *gain } else { 0.0 };
                }
                let sides = gained[..between].iter().zip(&gained[1..=between]);
                for ((target, w), (left, right)) in odd[..between].iter_mut().zip(&odd_w[..between]).zip(sides) {
                    *target += if *w > 0.0 { 0.5 * (left + right) } else { 0.0 };
                }
                if between < odds && odd_w[between] > 0.0 {
                    odd[between] += gained[odds];
                }
            }
        }
    }
}

/// The mean gain of two coarse rows, or of one twice, columns in order.
#[inline(always)]
fn gain_of_row(coarse: &Level, [one, other]: [usize; 2], gains: &[f32], gained: &mut [f32]) {
    let run = |row: usize, odd: usize| {
        let first = coarse.place(odd, row);
        gains[first..first + (coarse.columns - odd).div_ceil(2)].iter()
    };
    let (pairs, rest) = gained[..coarse.columns].as_chunks_mut::<2>();
    if one == other {
        for (pair, (even, odd)) in pairs.iter_mut().zip(run(one, 0).zip(run(one, 1))) {
            *pair = [*even, *odd];
        }
    } else {
        let terms = run(one, 0).zip(run(other, 0)).zip(run(one, 1).zip(run(other, 1)));
        for (pair, ((even, even_other), (odd, odd_other))) in pairs.iter_mut().zip(terms) {
            *pair = [0.5 * (even + even_other), 0.5 * (odd + odd_other)];
        }
    }
    if let ([last], Some(a), Some(b)) = (rest, run(one, 0).next_back(), run(other, 0).next_back()) {
        *last = 0.5 * (a + b);
    }
}
