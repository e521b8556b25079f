//! From a level to the next coarser one and back.
//!
//! Coarse columns and rows are every second fine one, from both ends: where their number is even, two neighbours in the middle are
//! both kept, so that corners have diagonals that lead away from them on all levels. Going down, fields are sampled; coming back, what
//! the coarse level added is interpolated linearly between its neighbours.

use pulp::{Simd, WithSimd};

use super::level::LatticeLevel;
use crate::geometry::{Pool, Vectors, VectorsChunk, arch};

/// How many coarse columns (or rows) `count` fine ones have.
pub(super) fn coarsened(count: usize) -> usize {
    count / 2 + 1
}

/// How many coarse columns (or rows), of `count` fine ones, sample even ones; the others sample odd ones.
#[inline(always)]
fn of_even_ones(count: usize) -> usize {
    let coarse = coarsened(count);
    if count.is_multiple_of(2) { coarse / 2 } else { coarse }
}

/// The fine column (or row) that a coarse one samples, of `count` fine ones.
#[inline(always)]
pub(super) fn sampled(coarse: usize, count: usize) -> usize {
    if coarse < of_even_ones(count) { 2 * coarse } else { 2 * coarse - 1 }
}

/// The two coarse neighbours of a fine column (or row); the same twice where it is sampled itself.
#[inline(always)]
pub(super) fn parents(fine: usize, count: usize) -> [usize; 2] {
    let is_kept = fine.is_multiple_of(2) == (fine + 1 < 2 * of_even_ones(count));
    if is_kept { [fine.div_ceil(2); 2] } else { [fine / 2, fine / 2 + 1] }
}

/// The part by which each of some fine columns (or rows), which have these numbers in their grid, follows the second of its coarse
/// neighbours [1]; it follows the first one by the rest. That is 1/2, but for some in the middle.
pub(super) fn parts(numbers: &[usize]) -> Vec<f32> {
    let part = |fine: usize| {
        let [first, second] = parents(fine, numbers.len()).map(|coarse| numbers[sampled(coarse, numbers.len())]);
        (numbers[fine] - first) as f32 / (second - first).max(1) as f32
    };
    (0..numbers.len()).map(part).collect()
}

/// Those of columns that are not sampled, as a row keeps them: odd ones, then even ones.
pub(super) fn parts_between(numbers: &[usize]) -> Vec<f32> {
    let (all, kept) = (parts(numbers), of_even_ones(numbers.len()));
    let odd = all.iter().skip(1).step_by(2).take(kept - 1);
    odd.chain(all.iter().step_by(2).skip(kept)).copied().collect()
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
            let sampled_row = &mut sampled_row[..columns];
            let (of_evens, of_odds) = sampled_row.split_at_mut(of_even_ones(fine.columns));
            let odds = fine.place(sampled(of_evens.len(), fine.columns), fine_row);
            for (sampled, first) in [(of_evens, fine.place(0, fine_row)), (of_odds, odds)] {
                let places = first..first + sampled.len();
                for (value, (now, previous)) in sampled.iter_mut().zip(from[places.clone()].iter().zip(&previous[places])) {
                    *value = ahead(*now, *previous, momentum);
                }
            }
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
    let LatticeLevel { p, held, columns, rows, right, upper, .. } = fine;
    let ([columns, rows], parts) = ([*columns, *rows], [&**right, &**upper]);
    held.iter_mut().for_each(|(place, end)| *end = p.get(*place));
    let (all, length) = (0..rows * row_length, BAND * row_length);
    let add = |[p, previous]: [VectorsChunk<'_>; 2], momentum: f32| {
        let first = p.first / row_length;
        let axes = [(&gains.x, p.x, previous.x), (&gains.y, p.y, previous.y), (&gains.z, p.z, previous.z)];
        for (gains, p, previous) in axes {
            arch().dispatch(Prolong { columns, rows, parts, row_length, coarse, first, gains, p, previous, momentum });
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
    /// As the level has them.
    parts: [&'a [f32]; 2],
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
        let Self { columns, rows, parts: [right, upper], row_length, coarse, first, gains, p, previous, momentum } = self;
        let (evens, odds, kept) = (columns.div_ceil(2), columns / 2, of_even_ones(columns));
        let (right_of_odd, right_of_even) = right.split_at(kept - 1);
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
            let [one, other] = parents(row, rows).map(gains_of);
            let upper = upper[row];
            let between = |(one, other): (&f32, &f32)| (1.0 - upper) * one + upper * other;
            let (even, odd) = p.split_at_mut(row_length / 2);
            let (even, even_between) = even[..evens].split_at_mut(kept);
            let (odd_between, odd) = odd[..odds].split_at_mut(kept - 1);
            for (sampled, first) in [(even, 0), (odd, kept)] {
                for (p, gains) in sampled.iter_mut().zip(one[first..].iter().zip(&other[first..])) {
                    *p += between(gains);
                }
            }
            for (apart, parts, first) in [(odd_between, right_of_odd, 0), (even_between, right_of_even, kept)] {
                let left = one[first..].iter().zip(&other[first..]);
                let [one, other] = [one, other].map(|gains| gains.get(first + 1..).unwrap_or_default());
                for (((p, part), left), right) in apart.iter_mut().zip(parts).zip(left).zip(one.iter().zip(other)) {
                    *p += (1.0 - part) * between(left) + part * between(right);
                }
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

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use proptest::prelude::*;

    use super::super::Grid;
    use super::*;

    #[test]
    fn both_ends_are_sampled_and_what_is_between_follows_its_neighbours() {
        for count in 2..70 {
            let coarse: Vec<usize> = (0..coarsened(count)).map(|coarse| sampled(coarse, count)).collect();
            assert_eq!((coarse[0], coarse[coarse.len() - 1]), (0, count - 1));
            assert!(coarse.windows(2).all(|pair| (1..=2).contains(&(pair[1] - pair[0]))), "{coarse:?}");
            let narrow: Vec<usize> = (1..coarse.len()).filter(|&place| coarse[place] == coarse[place - 1] + 1).collect();
            assert_eq!(narrow.len(), usize::from(count % 2 == 0));
            assert!(
                count < 5 || narrow.iter().all(|&place| place > 1 && place + 1 < coarse.len()),
                "{coarse:?}: not in the middle"
            );
            for fine in 0..count {
                let [one, other] = parents(fine, count).map(|place| coarse[place]);
                assert_eq!(one + other, 2 * fine, "{fine} of {count}");
            }
        }
    }

    proptest! {
        #[test]
        fn linear_gains_are_carried_over(size in [2_usize..70, 2_usize..40], twice: bool, slope in [-1.0_f32..1.0, -1.0_f32..1.0]) {
            let mut numbers = size.map(|count| (0..count).collect::<Vec<_>>());
            let grid = Grid::of_squares(size, 1.0);
            let halve = |numbers: &Vec<usize>| (0..coarsened(numbers.len())).map(|c| numbers[sampled(c, numbers.len())]).collect();
            if twice {
                numbers = numbers.each_ref().map(halve);
            }
            let coarse_numbers: [Vec<usize>; 2] = numbers.each_ref().map(halve);
            let mut fine = LatticeLevel::new(&grid, &numbers[0], &numbers[1], 1.0);
            let mut coarse = LatticeLevel::new(&grid, &coarse_numbers[0], &coarse_numbers[1], 1.0);
            let (mut sampled, pool) = (Vectors::zeros(coarse.p.len()), Pool::new(1));
            let gain = |column: usize, row: usize| 1.0 + slope[0] * column as f32 + slope[1] * row as f32;
            sample_ends(&fine, None, &mut coarse, &mut sampled, &pool);
            for (i, column) in coarse_numbers[0].iter().enumerate() {
                for (j, row) in coarse_numbers[1].iter().enumerate() {
                    let place = coarse.place(i, j);
                    coarse.p.set(place, Vec3::splat(gain(*column, *row)));
                }
            }
            prolong(&mut fine, None, &coarse, &mut sampled, &pool);
            for (i, column) in numbers[0].iter().enumerate() {
                for (j, row) in numbers[1].iter().enumerate() {
                    let apart = fine.p.get(fine.place(i, j)) - Vec3::splat(gain(*column, *row));
                    prop_assert!(apart.length() < 1e-3, "{column}, {row} of {size:?}: {apart}");
                }
            }
        }
    }
}
