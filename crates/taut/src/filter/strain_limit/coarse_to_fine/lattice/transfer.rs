//! From a level to the next coarser one and back.
//!
//! Coarse columns and rows are every second fine one, and the last. Going down, fields are sampled; coming back, what
//! the coarse level added is interpolated linearly between its neighbours.

use pulp::{Simd, WithSimd};

use super::level::LatticeLevel;
use crate::geometry::{Pool, Vectors, VectorsChunk, arch};

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

/// Where the finest level's ends were one cycle ago, and the part of the way since then that they go on by.
pub(super) struct Ahead<'a> {
    pub previous: &'a mut Vectors,
    pub momentum: f32,
}

/// Takes the places where a step begins from a fine level to a coarse one; `sampled` is workspace.
pub(super) fn sample_start(fine: &LatticeLevel, coarse: &mut LatticeLevel, sampled: &mut Vectors, pool: &Pool) {
    let [columns, row_length] = [coarse.columns, coarse.row_length()];
    sample(fine, [&fine.x, &fine.x], 0.0, [&mut coarse.x, sampled], [columns, row_length], pool);
}

/// Takes the places where it ends so far, or those ahead of them; `sampled` keeps them, columns in order.
pub(super) fn sample_ends(
    fine: &LatticeLevel,
    ahead: Option<Ahead<'_>>,
    coarse: &mut LatticeLevel,
    sampled: &mut Vectors,
    pool: &Pool,
) {
    let [columns, row_length] = [coarse.columns, coarse.row_length()];
    let (previous, momentum) = ahead.map_or((&fine.p, 0.0), |ahead| (&*ahead.previous, ahead.momentum));
    sample(fine, [&fine.p, previous], momentum, [&mut coarse.p, sampled], [columns, row_length], pool);
}

fn sample(
    fine: &LatticeLevel,
    [from, previous]: [&Vectors; 2],
    momentum: f32,
    [to, sampled]: [&mut Vectors; 2],
    [columns, row_length]: [usize; 2],
    pool: &Pool,
) {
    to.for_each_part_of_two(sampled, 0..to.len(), BAND * row_length, pool, |to, sampled| {
        let first = to.first / row_length;
        let axes = [
            (&from.x, &previous.x, to.x, sampled.x),
            (&from.y, &previous.y, to.y, sampled.y),
            (&from.z, &previous.z, to.z, sampled.z),
        ];
        for (from, previous, to, sampled) in axes {
            arch().dispatch(Sample { fine, columns, row_length, first, from, previous, momentum, to, sampled });
        }
    });
}

/// Some rows of a coarse level.
struct Sample<'a> {
    fine: &'a LatticeLevel,
    /// Coarse columns.
    columns: usize,
    /// Length of a coarse row in memory.
    row_length: usize,
    /// The first coarse row.
    first: usize,
    from: &'a [f32],
    previous: &'a [f32],
    momentum: f32,
    to: &'a mut [f32],
    sampled: &'a mut [f32],
}

impl WithSimd for Sample<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { fine, columns, row_length, first, from, previous, momentum, to, sampled: rows } = self;
        for (row, (to, sampled_row)) in to.chunks_mut(row_length).zip(rows.chunks_mut(row_length)).enumerate() {
            let fine_row = sampled(first + row, fine.rows);
            let evens = fine.place(0, fine_row)..fine.place(0, fine_row) + fine.columns.div_ceil(2);
            // With an even number of columns the last one is an odd one.
            let last = fine.place(fine.columns - 1, fine_row);
            let sampled_row = &mut sampled_row[..columns];
            let places = from[evens.clone()].iter().zip(&previous[evens]);
            for (value, (now, previous)) in sampled_row.iter_mut().zip(places) {
                *value = ahead(*now, *previous, momentum);
            }
            sampled_row[columns - 1] = ahead(from[last], previous[last], momentum);
            let (pairs, rest) = sampled_row.as_chunks::<2>();
            let (even, odd) = to.split_at_mut(row_length / 2);
            for ((even, odd), pair) in even.iter_mut().zip(odd.iter_mut()).zip(pairs) {
                (*even, *odd) = (pair[0], pair[1]);
            }
            if let [last] = rest {
                even[pairs.len()] = *last;
            }
        }
    }
}

/// Adds to the fine ends, or to those ahead of them, what the coarse ones have gained since they were `sampled`; what is held stays.
/// Overwrites `sampled`, and what was previous.
pub(super) fn prolong(
    fine: &mut LatticeLevel,
    ahead: Option<Ahead<'_>>,
    coarse: &LatticeLevel,
    sampled: &mut Vectors,
    pool: &Pool,
) {
    let row_length = coarse.row_length();
    sampled.for_each_part(0..coarse.rows * row_length, BAND * row_length, pool, |sampled| {
        let first = sampled.first / row_length;
        for (now, gains) in [(&coarse.p.x, sampled.x), (&coarse.p.y, sampled.y), (&coarse.p.z, sampled.z)] {
            arch().dispatch(Gain { coarse, first, now, gains });
        }
    });
    let gains = &*sampled;
    let row_length = fine.row_length();
    let LatticeLevel { p, held, columns, rows, .. } = fine;
    let [columns, rows] = [*columns, *rows];
    held.iter_mut().for_each(|(place, end)| *end = p.get(*place));
    let (all, length) = (0..rows * row_length, BAND * row_length);
    let add = |[p, previous]: [VectorsChunk<'_>; 2], momentum: f32| {
        let first = p.first / row_length;
        let axes = [(&gains.x, p.x, previous.x), (&gains.y, p.y, previous.y), (&gains.z, p.z, previous.z)];
        for (gains, p, previous) in axes {
            arch().dispatch(Prolong { columns, rows, row_length, coarse, first, gains, p, previous, momentum });
        }
    };
    match ahead {
        Some(Ahead { previous, momentum }) => {
            p.for_each_part_of_two(previous, all, length, pool, |p, previous| add([p, previous], momentum))
        }
        None => p.for_each_part(all, length, pool, |p| {
            let nothing = VectorsChunk { first: p.first, x: &mut [], y: &mut [], z: &mut [] };
            add([p, nothing], 0.0);
        }),
    }
    held.iter().for_each(|(place, end)| p.set(*place, *end));
}

/// Rows in a band.
const BAND: usize = 32;

/// Some rows of gains: where coarse ends are now less where they were sampled, columns in order.
struct Gain<'a> {
    coarse: &'a LatticeLevel,
    /// The first coarse row.
    first: usize,
    now: &'a [f32],
    gains: &'a mut [f32],
}

impl WithSimd for Gain<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { coarse, first, now, gains } = self;
        for (row, gains) in (first..).zip(gains.chunks_mut(coarse.row_length())) {
            let (pairs, rest) = gains[..coarse.columns].as_chunks_mut::<2>();
            let [even, odd] = [coarse.place(0, row), coarse.place(1, row)];
            let (evens, odds) = (&now[even..][..pairs.len()], &now[odd..][..pairs.len()]);
            for (gain, (even, odd)) in pairs.iter_mut().zip(evens.iter().zip(odds)) {
                *gain = [even - gain[0], odd - gain[1]];
            }
            if let [gain] = rest {
                *gain = now[coarse.place(coarse.columns - 1, row)] - *gain;
            }
        }
    }
}

/// Some rows of a fine level.
struct Prolong<'a> {
    columns: usize,
    rows: usize,
    row_length: usize,
    coarse: &'a LatticeLevel,
    /// The first fine row.
    first: usize,
    gains: &'a [f32],
    p: &'a mut [f32],
    /// Empty for levels that do not go on.
    previous: &'a mut [f32],
    momentum: f32,
}

impl WithSimd for Prolong<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { columns, rows, row_length, coarse, first, gains, p, previous, momentum } = self;
        let (evens, odds) = (columns.div_ceil(2), columns / 2);
        // With an even number of columns the last one is sampled itself: it has the gain of the last coarse column.
        let between = if columns.is_multiple_of(2) { odds - 1 } else { odds };
        let gains_of = |row: usize| &gains[row * coarse.row_length()..][..coarse.columns];
        let mut previous = previous.chunks_mut(row_length);
        for (row, p) in (first..).zip(p.chunks_mut(row_length)) {
            if let Some(previous) = previous.next() {
                for (p, previous) in p.iter_mut().zip(previous) {
                    let now = *p;
                    *p = ahead(now, *previous, momentum);
                    *previous = now;
                }
            }
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

/// Where the way from `previous` to `now` leads. Without momentum that is `now`: what is left there from another step need not be a
/// number.
#[inline(always)]
fn ahead(now: f32, previous: f32, momentum: f32) -> f32 {
    if momentum == 0.0 { now } else { now + momentum * (now - previous) }
}
