//! Displacements from a level to the next coarser one and back.
//!
//! Coarse columns and rows are every second fine one, and the last. Going down, fields are sampled; coming back, what
//! the coarse level added is interpolated linearly between its neighbours.

use super::level::Level;
use crate::geometry::Vectors;

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

/// Copies the sampled values of a field from a fine level to a coarse one.
#[inline(always)]
pub(super) fn sample(fine: &Level, coarse: &Level, from: &Vectors, to: &mut Vectors) {
    for (from, to) in [(&from.x, &mut to.x), (&from.y, &mut to.y), (&from.z, &mut to.z)] {
        for row in 0..coarse.rows {
            let fine_row = sampled(row, fine.rows);
            let there = fine.place(0, fine_row);
            let source = &from[there..there + fine.columns.div_ceil(2)];
            for odd in 0..2 {
                let here = coarse.place(odd, row);
                let count = source[odd..].len().div_ceil(2);
                let target = &mut to[here..here + count];
                for (target, source) in target.iter_mut().zip(source[odd..].iter().step_by(2)) {
                    *target = *source;
                }
            }
            // With an even number of columns the last one is an odd one.
            to[coarse.place(coarse.columns - 1, row)] = from[fine.place(fine.columns - 1, fine_row)];
        }
    }
}

/// Adds to the fine displacements what the coarse ones gained over `before`; what is held stays. `gained` is workspace
/// for one coarse row.
#[inline(always)]
pub(super) fn prolong(fine: &mut Level, coarse: &Level, before: &Vectors, gained: &mut [f32]) {
    let (evens, odds) = (fine.columns.div_ceil(2), fine.columns / 2);
    for axis in 0..3 {
        let (now, before) = (column(&coarse.d, axis), column(before, axis));
        for row in 0..fine.rows {
            gain_of_row(coarse, parents(row, fine.rows), now, before, gained);
            let (even, odd) = (fine.place(0, row), fine.place(1, row));
            let w = &fine.w;
            let target = match axis {
                0 => &mut fine.d.x,
                1 => &mut fine.d.y,
                _ => &mut fine.d.z,
            };
            for ((target, w), gain) in target[even..even + evens].iter_mut().zip(&w[even..even + evens]).zip(&gained[..evens]) {
                *target += if *w > 0.0 { *gain } else { 0.0 };
            }
            // With an even number of columns the last one is sampled itself: it has the gain of the last coarse column.
            let between = if fine.columns.is_multiple_of(2) { odds - 1 } else { odds };
            for (k, (target, w)) in target[odd..odd + between].iter_mut().zip(&w[odd..odd + between]).enumerate() {
                *target += if *w > 0.0 { 0.5 * (gained[k] + gained[k + 1]) } else { 0.0 };
            }
            if between < odds && w[odd + between] > 0.0 {
                target[odd + between] += gained[odds];
            }
        }
    }
}

fn column(vectors: &Vectors, axis: usize) -> &[f32] {
    match axis {
        0 => &vectors.x,
        1 => &vectors.y,
        _ => &vectors.z,
    }
}

/// The mean gain of two coarse rows, columns in order.
#[inline(always)]
fn gain_of_row(coarse: &Level, rows: [usize; 2], now: &[f32], before: &[f32], gained: &mut [f32]) {
    for odd in 0..2 {
        let count = (coarse.columns - odd).div_ceil(2);
        let [a, b] = rows.map(|row| coarse.place(odd, row));
        let (now_a, before_a) = (&now[a..a + count], &before[a..a + count]);
        let (now_b, before_b) = (&now[b..b + count], &before[b..b + count]);
        for k in 0..count {
            gained[2 * k + odd] = 0.5 * ((now_a[k] - before_a[k]) + (now_b[k] - before_b[k]));
        }
    }
}
