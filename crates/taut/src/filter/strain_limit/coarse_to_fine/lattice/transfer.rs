//! From a level to the next coarser one and back.
//!
//! A level has half as many cells along a side as the next finer one, rounded up, and all of them are alike. So where a number of cells is
//! odd, coarse columns (or rows) lie between fine ones. Going down, fields are sampled linearly; coming back, what the coarse level added is
//! interpolated linearly between its neighbours.

use pulp::{Simd, WithSimd};

use super::level::LatticeLevel;
use crate::geometry::{Pool, Vectors, VectorsChunk, arch};

/// How many cells the next coarser level has along a side with so many.
pub(super) fn coarsened(cells: usize) -> usize {
    cells.div_ceil(2)
}

/// Where the columns (or rows) of a level lie beside those of the next coarser one.
pub(super) struct Beside {
    /// Coarse ones lie on every second fine one.
    is_even: bool,
    /// Coarse column c samples fine column 2 c - 1 by this part, and 2 c by the rest [1].
    pub before: Vec<f32>,
    /// Fine column f follows coarse column f / 2 + 1 by this part, and f / 2 by the rest [1]; and that in the order in which a row keeps
    /// columns.
    pub beyond: Vec<f32>,
    of_evens: Vec<f32>,
    of_odds: Vec<f32>,
}

impl Beside {
    /// Of a level with so many cells along this side.
    pub fn new(cells: usize) -> Self {
        let coarse = coarsened(cells);
        let before = (0..=coarse).map(|c| (2 * c * coarse - c * cells) as f32 / coarse as f32).collect();
        let beyond: Vec<f32> = (0..=cells).map(|f| (f * coarse - f / 2 * cells) as f32 / cells as f32).collect();
        let [of_evens, of_odds] = [0, 1].map(|first| beyond.iter().skip(first).step_by(2).copied().collect());
        Self { is_even: cells.is_multiple_of(2), before, beyond, of_evens, of_odds }
    }

    /// The fine columns that a coarse one samples, each with its part.
    pub fn sampled(&self, coarse: usize) -> [(usize, f32); 2] {
        let (part, last) = (self.before[coarse], self.beyond.len() - 1);
        [((2 * coarse).min(last), 1.0 - part), ((2 * coarse).saturating_sub(1), part)]
    }

    /// The coarse columns that a fine one follows, each with its part.
    pub fn parents(&self, fine: usize) -> [(usize, f32); 2] {
        let (part, last) = (self.beyond[fine], self.before.len() - 1);
        [(fine / 2, 1.0 - part), ((fine / 2 + 1).min(last), part)]
    }
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
        let [Beside { is_even, before, .. }, up] = &fine.beside;
        for (row, (to, sampled_row)) in to.chunks_mut(row_length).zip(rows.chunks_mut(row_length)).enumerate() {
            let [(one, rest), (other, part)] = up.sampled(first + row);
            let sampled_row = &mut sampled_row[..columns];
            let run = |row: usize, parity: usize, len: usize| {
                let first = fine.place(parity, row);
                from[first..first + len].iter().zip(&previous[first..first + len])
            };
            let at = |(now, previous): (&f32, &f32)| ahead(*now, *previous, momentum);
            let evens = if *is_even { columns } else { columns - 1 };
            if part == 0.0 {
                sampled_row.iter_mut().zip(run(one, 0, evens)).for_each(|(value, even)| *value = at(even));
            } else {
                for (value, (even, below)) in sampled_row.iter_mut().zip(run(one, 0, evens).zip(run(other, 0, evens))) {
                    *value = rest * at(even) + part * at(below);
                }
            }
            if !is_even {
                // The last one lies on the last fine one, which is odd.
                let odds = run(one, 1, evens).zip(run(other, 1, evens)).map(|(odd, below)| rest * at(odd) + part * at(below));
                sampled_row[columns - 1] = 0.0;
                for ((value, before), odd) in sampled_row[1..].iter_mut().zip(&before[1..]).zip(odds) {
                    *value = (1.0 - before) * *value + before * odd;
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
    let LatticeLevel { p, held, columns, rows, beside, .. } = fine;
    let [columns, rows] = [*columns, *rows];
    held.iter_mut().for_each(|(place, end)| *end = p.get(*place));
    let (all, length) = (0..rows * row_length, BAND * row_length);
    let add = |[p, previous]: [VectorsChunk<'_>; 2], momentum: f32| {
        let first = p.first / row_length;
        let axes = [(&gains.x, p.x, previous.x), (&gains.y, p.y, previous.y), (&gains.z, p.z, previous.z)];
        for (gains, p, previous) in axes {
            arch().dispatch(Prolong { columns, beside, row_length, coarse, first, gains, p, previous, momentum });
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
    /// Its columns and rows.
    beside: &'a [Beside; 2],
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
        let Self { columns, beside: [across, up], row_length, coarse, first, gains, p, previous, momentum } = self;
        let (evens, odds) = (columns.div_ceil(2), columns / 2);
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
            let [(one, below), (other, above)] = up.parents(row);
            let [one, other] = [one, other].map(gains_of);
            let between = |(one, other): (&f32, &f32)| below * one + above * other;
            let follow = |p: &mut [f32], parts: &[f32]| {
                let (left, right) = (one.iter().zip(other), one[1..].iter().zip(&other[1..]));
                for (((p, part), left), right) in p.iter_mut().zip(parts).zip(left).zip(right) {
                    *p += (1.0 - part) * between(left) + part * between(right);
                }
            };
            let (even, odd) = p.split_at_mut(row_length / 2);
            if across.is_even {
                even[..evens].iter_mut().zip(one.iter().zip(other)).for_each(|(p, gain)| *p += between(gain));
            } else {
                follow(&mut even[..evens], &across.of_evens);
            }
            follow(&mut odd[..odds], &across.of_odds);
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
    fn both_ends_are_sampled_and_linear_fields_are_carried_over_both_ways() {
        for cells in 1..70 {
            let (beside, coarse) = (Beside::new(cells), coarsened(cells));
            let pitch = cells as f32 / coarse as f32;
            assert_eq!((beside.sampled(0)[0], beside.sampled(coarse)[usize::from(cells % 2 == 1)]), ((0, 1.0), (cells, 1.0)));
            for c in 0..=coarse {
                let place: f32 = beside.sampled(c).iter().map(|(fine, part)| *fine as f32 * part).sum();
                assert!((place - pitch * c as f32).abs() < 1e-5 * cells as f32, "{c} of {cells}: {place}");
            }
            for f in 0..=cells {
                let place: f32 = beside.parents(f).iter().map(|(coarse, part)| *coarse as f32 * pitch * part).sum();
                assert!((place - f as f32).abs() < 1e-5 * cells as f32, "{f} of {cells}: {place}");
                assert!(beside.parents(f).iter().all(|(_, part)| (0.0..=1.0).contains(part)));
            }
        }
    }

    proptest! {
        #[test]
        fn linear_fields_are_carried_over(size in [1_usize..69, 1_usize..39], slope in [-1.0_f32..1.0, -1.0_f32..1.0]) {
            let grid = Grid::of_squares(size.map(|cells| cells + 1), 1.0);
            let coarse_cells = size.map(coarsened);
            let mut fine = LatticeLevel::new(&grid, size, 1.0);
            let mut coarse = LatticeLevel::new(&grid, coarse_cells, 1.0);
            let (mut sampled, pool) = (Vectors::zeros(coarse.p.len()), Pool::new(1));
            let pitch = [0, 1].map(|axis| size[axis] as f32 / coarse_cells[axis] as f32);
            let field = |column: f32, row: f32| Vec3::splat(1.0 + slope[0] * column + slope[1] * row);
            for (i, j) in (0..=size[0]).flat_map(|i| (0..=size[1]).map(move |j| (i, j))) {
                fine.p.set(fine.place(i, j), field(i as f32, j as f32));
            }
            sample_ends(&fine, None, &mut coarse, &mut sampled, &pool);
            for (i, j) in (0..=coarse_cells[0]).flat_map(|i| (0..=coarse_cells[1]).map(move |j| (i, j))) {
                let (place, there) = (coarse.place(i, j), field(pitch[0] * i as f32, pitch[1] * j as f32));
                prop_assert!((coarse.p.get(place) - there).length() < 1e-3, "{i}, {j} of {size:?} is sampled elsewhere");
                coarse.p.set(place, 3.0 * there);
            }
            prolong(&mut fine, None, &coarse, &mut sampled, &pool);
            for (i, j) in (0..=size[0]).flat_map(|i| (0..=size[1]).map(move |j| (i, j))) {
                let apart = fine.p.get(fine.place(i, j)) - 3.0 * field(i as f32, j as f32);
                prop_assert!(apart.length() < 1e-2, "{i}, {j} of {size:?}: {apart}");
            }
        }
    }
}
