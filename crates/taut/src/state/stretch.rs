//! How far the springs of a cloth are stretched.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use crate::geometry::{CHUNK, Pool, Vectors, arch, sum_in_any_order};
use crate::model::{ClothRange, Lattice, Model};

/// What the type 1 springs of a cloth say.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Stretch {
    /// Springs over their limit.
    pub over: u32,
    /// Largest |X_uv| / R, R = (1 + lambda) L; not a number if a particle of the cloth has no finite place.
    pub worst: f32,
}

/// Rows of a grid that are measured together.
const BAND: usize = 32;

/// Measures all type 1 springs of a cloth at some positions.
#[must_use]
pub fn measure(model: &Model, cloth: &ClothRange, positions: &Vectors, pool: &Pool) -> Stretch {
    let (over, square) = match cloth.lattice {
        Some(lattice) => {
            let lattice = &model.lattices[lattice];
            worst_of(lattice.rows, BAND, pool.pays_for(cloth.count), |rows| arch().dispatch(OfRows { lattice, rows, positions }))
        }
        None => worst_of(cloth.springs.len(), CHUNK, pool.pays_for(cloth.springs.len()), |run| {
            let springs = cloth.springs.start + run.start..cloth.springs.start + run.end;
            let mut squares = [0.0; CHUNK];
            let squares = &mut squares[..springs.len()];
            measure_squares(model, springs.clone(), positions, squares);
            let (rest, strain_limit) = (&model.springs.rest[springs.clone()], &model.springs.strain_limit[springs]);
            arch().dispatch(OverLimit { squares, rest, strain_limit })
        }),
    };
    Stretch { over, worst: square.sqrt() }
}

/// Calls `part` with every `length` of `count` items; sums what is over and finds the worst, in any order.
fn worst_of(count: usize, length: usize, in_parallel: bool, part: impl Fn(Range<usize>) -> (u32, f32) + Sync) -> (u32, f32) {
    let each = |index: usize| part(index * length..count.min((index + 1) * length));
    sum_in_any_order(0..count.div_ceil(length), in_parallel, (0, 0.0), |_, index| each(index), worse)
}

/// The larger ratio, and that is whatever is not a number; the sum of what is over.
fn worse((over, worst): (u32, f32), (more, ratio): (u32, f32)) -> (u32, f32) {
    (over + more, if ratio > worst || ratio.is_nan() { ratio } else { worst })
}

/// |X_uv|^2 of some springs [m^2].
pub fn measure_squares(model: &Model, springs: Range<usize>, positions: &Vectors, squares: &mut [f32]) {
    // Columns that are seen to be as long as one another are checked once for each end.
    let count = positions.len();
    let (x, y, z) = (&positions.x[..count], &positions.y[..count], &positions.z[..count]);
    for (square, [u, v]) in squares.iter_mut().zip(&model.springs.ends[springs]) {
        let (u, v) = (*u as usize, *v as usize);
        let (x, y, z) = (x[v] - x[u], y[v] - y[u], z[v] - z[u]);
        *square = x * x + y * y + z * z;
    }
}

/// The largest ratio of squares to those of lengths at rest, and its place; none if none is larger than 0.
#[must_use]
pub fn longest_of(squares: &[f32], rest: &[f32]) -> Option<(f32, usize)> {
    let worst = arch().dispatch(LargestRatio { squares, rest });
    let place = |ratio: f32| squares.iter().zip(rest).position(|(square, rest)| square / (rest * rest) == ratio);
    Some(worst).filter(|worst| *worst > 0.0).and_then(|worst| Some((worst, place(worst)?)))
}

struct LargestRatio<'a> {
    squares: &'a [f32],
    rest: &'a [f32],
}

impl WithSimd for LargestRatio<'_> {
    type Output = f32;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f32 {
        const LANES: usize = 16;
        let mut lanes = [0.0_f32; LANES];
        for (squares, rest) in self.squares.chunks(LANES).zip(self.rest.chunks(LANES)) {
            for (lane, (square, rest)) in lanes.iter_mut().zip(squares.iter().zip(rest)) {
                let ratio = square / (rest * rest);
                *lane = if ratio > *lane { ratio } else { *lane };
            }
        }
        lanes.into_iter().fold(0.0, f32::max)
    }
}

struct OverLimit<'a> {
    squares: &'a [f32],
    rest: &'a [f32],
    strain_limit: &'a [f32],
}

impl WithSimd for OverLimit<'_> {
    /// Springs over their limit and the largest (|X_uv| / R)^2, or what is not a number.
    type Output = (u32, f32);

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> (u32, f32) {
        const LANES: usize = 16;
        let (mut over, mut worst, mut unordered) = ([0_u32; LANES], [0.0_f32; LANES], [false; LANES]);
        let limits = self.rest.chunks(LANES).zip(self.strain_limit.chunks(LANES));
        for (squares, (rest, strain_limit)) in self.squares.chunks(LANES).zip(limits) {
            for (lane, (square, (rest, strain_limit))) in squares.iter().zip(rest.iter().zip(strain_limit)).enumerate() {
                let limit = (1.0 + strain_limit) * rest;
                let ratio = square / (limit * limit);
                over[lane] += u32::from(ratio > 1.0);
                worst[lane] = if ratio > worst[lane] { ratio } else { worst[lane] };
                unordered[lane] |= ratio.is_nan();
            }
        }
        let worst = if unordered.contains(&true) { f32::NAN } else { worst.into_iter().fold(0.0, f32::max) };
        (over.iter().sum(), worst)
    }
}

struct OfRows<'a> {
    lattice: &'a Lattice,
    rows: Range<usize>,
    positions: &'a Vectors,
}

impl WithSimd for OfRows<'_> {
    /// Springs over their limit and the largest (|X_uv| / R)^2.
    type Output = (u32, f32);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> (u32, f32) {
        let Lattice { first, columns, rows: all, limits, .. } = *self.lattice;
        let mut tally = Tally { over: simd.splat_f32s(0.0), worst: simd.splat_f32s(0.0), tail_over: 0, tail_worst: 0.0 };
        for row in self.rows {
            let left = first + row * columns;
            tally.run(simd, self.positions, [left, left + 1], columns - 1, limits[0]);
            if row + 1 < all {
                tally.run(simd, self.positions, [left, left + columns], columns, limits[1]);
                tally.run(simd, self.positions, [left, left + columns + 1], columns - 1, limits[2]);
                tally.run(simd, self.positions, [left + 1, left + columns], columns - 1, limits[3]);
            }
        }
        let worst = simd.reduce_max_f32s(tally.worst);
        (
            simd.reduce_sum_f32s(tally.over) as u32 + tally.tail_over,
            if tally.tail_worst > worst { tally.tail_worst } else { worst },
        )
    }
}

/// Lane by lane, and for what is left over at the end of a run.
struct Tally<S: Simd> {
    over: S::f32s,
    worst: S::f32s,
    tail_over: u32,
    tail_worst: f32,
}

impl<S: Simd> Tally<S> {
    #[inline(always)]
    fn run(&mut self, simd: S, positions: &Vectors, [a, b]: [usize; 2], len: usize, limit: f32) {
        let inverse = 1.0 / (limit * limit);
        let (factor, one, zero) = (simd.splat_f32s(inverse), simd.splat_f32s(1.0), simd.splat_f32s(0.0));
        let columns = [&positions.x, &positions.y, &positions.z];
        let [(ax, tail_ax), (ay, tail_ay), (az, tail_az)] = columns.map(|column| S::as_simd_f32s(&column[a..a + len]));
        let [(bx, tail_bx), (by, tail_by), (bz, tail_bz)] = columns.map(|column| S::as_simd_f32s(&column[b..b + len]));
        for i in 0..ax.len() {
            let [x, y, z] = [simd.sub_f32s(bx[i], ax[i]), simd.sub_f32s(by[i], ay[i]), simd.sub_f32s(bz[i], az[i])];
            let sum = simd.add_f32s(simd.mul_f32s(x, x), simd.mul_f32s(y, y));
            let ratio = simd.mul_f32s(simd.add_f32s(sum, simd.mul_f32s(z, z)), factor);
            self.worst = simd.max_f32s(self.worst, ratio);
            self.over = simd.add_f32s(self.over, simd.select_f32s(simd.greater_than_f32s(ratio, one), one, zero));
        }
        for i in 0..tail_ax.len() {
            let (x, y, z) = (tail_bx[i] - tail_ax[i], tail_by[i] - tail_ay[i], tail_bz[i] - tail_az[i]);
            let ratio = (x * x + y * y + z * z) * inverse;
            self.tail_worst = self.tail_worst.max(ratio);
            self.tail_over += u32::from(ratio > 1.0);
        }
    }
}
