//! The springs of a grid, examined row by row: what lies side by side needs no lists of ends, lengths and stiffnesses, which take
//! more memory than the cloth.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::SpringPart;
use crate::geometry::Vectors;
use crate::model::{ClothRange, Lattice, Model};

/// Rows that are examined together.
pub(super) const BAND: usize = 8;
/// So many springs go on side by side, whatever the length of the vector registers, so that bits do not depend on it.
const LANES: usize = 16;

/// The constants of a grid's springs.
#[derive(Debug)]
pub(super) struct GridSprings {
    lattice: usize,
    springs: Range<usize>,
    /// Along the bottom row, along a row inside and along the top row.
    along: [Constants; 3],
    /// From a row to the next one: straight up, up to the right, up to the left.
    upward: [Constants; 3],
}

/// Those of springs that stand side by side in a row.
#[derive(Debug, Default)]
struct Constants {
    /// k_s [N/m].
    stiffness: Vec<f32>,
    /// L [m].
    rest: Vec<f32>,
    /// 1 / L^2 [1/m^2].
    inverse_square: Vec<f32>,
}

impl Constants {
    fn of(model: &Model, springs: Vec<usize>) -> Self {
        let rest: Vec<f32> = springs.iter().map(|spring| model.springs.rest[*spring]).collect();
        let inverse_square = rest.iter().map(|rest| 1.0 / (rest * rest)).collect();
        Self { stiffness: springs.iter().map(|spring| model.springs.stiffness[*spring]).collect(), rest, inverse_square }
    }
}

impl GridSprings {
    /// Those of a cloth that is a grid.
    pub fn new(model: &Model, cloth: &ClothRange, index: usize) -> Self {
        let lattice = &model.lattices[index];
        let ways = [1, lattice.columns, lattice.columns + 1, lattice.columns - 1];
        let of = |row: usize, kind: usize| {
            let belongs = |spring: &usize| {
                let [a, b] = model.springs.ends[*spring].map(|end| end as usize);
                // The springs up to the left begin at the second particle.
                (a - lattice.first) / lattice.columns == row && b - a == ways[kind]
            };
            Constants::of(model, cloth.springs.clone().filter(belongs).collect())
        };
        Self {
            lattice: index,
            springs: cloth.springs.clone(),
            along: [of(0, 0), of(1, 0), of(lattice.rows - 1, 0)],
            upward: [of(0, 1), of(0, 2), of(0, 3)],
        }
    }

    /// How many bands of rows there are.
    pub fn bands(&self, model: &Model) -> usize {
        model.lattices[self.lattice].rows.div_ceil(BAND)
    }

    /// Examines a band. The spring is left to [`Self::find`].
    pub fn examine(&self, model: &Model, positions: &Vectors, band: usize) -> SpringPart {
        let lattice = &model.lattices[self.lattice];
        let (worst, elastic) = Arch::new().dispatch(Rows { springs: self, lattice, positions, rows: rows_of(lattice, band) });
        SpringPart { worst, spring: 0, elastic }
    }

    /// A spring of a band whose (|X_uv| / L)^2 is `worst`.
    pub fn find(&self, model: &Model, positions: &Vectors, band: usize, worst: f32) -> Option<u32> {
        let lattice = &model.lattices[self.lattice];
        rows_of(lattice, band).find_map(|row| {
            let runs = self.runs(lattice, row).into_iter().enumerate();
            runs.filter_map(|(kind, run)| Some((kind, run?))).find_map(|(kind, ([a, b], constants))| {
                let ratio = |i: usize| squares::<1>(positions, [a + i, b + i])[0] * constants.inverse_square[i];
                let place = (0..constants.rest.len()).find(|i| ratio(*i) == worst)?;
                Some(self.spring(lattice, kind, row, place))
            })
        })
    }

    /// The number of a spring, in the order in which grids are built: all along rows, all straight up, the diagonals in turn.
    fn spring(&self, lattice: &Lattice, kind: usize, row: usize, place: usize) -> u32 {
        let Lattice { columns, rows, .. } = *lattice;
        let along = rows * (columns - 1);
        let up = (rows - 1) * columns;
        let number = match kind {
            0 => row * (columns - 1) + place,
            1 => along + row * columns + place,
            _ => along + up + 2 * (row * (columns - 1) + place) + (kind - 2),
        };
        (self.springs.start + number) as u32
    }

    /// Where the springs that begin at a row have their first ends, and their constants.
    #[inline(always)]
    fn runs(&self, lattice: &Lattice, row: usize) -> [Option<([usize; 2], &Constants)>; 4] {
        let left = lattice.first + row * lattice.columns;
        let above = left + lattice.columns;
        let [bottom, inside, top] = &self.along;
        let last = row + 1 == lattice.rows;
        let along = if row == 0 {
            bottom
        } else if last {
            top
        } else {
            inside
        };
        let [up, right, across] = &self.upward;
        let upward = |run| Some(run).filter(|_| !last);
        [
            Some(([left, left + 1], along)),
            upward(([left, above], up)),
            upward(([left, above + 1], right)),
            upward(([left + 1, above], across)),
        ]
    }
}

fn rows_of(lattice: &Lattice, band: usize) -> Range<usize> {
    band * BAND..lattice.rows.min((band + 1) * BAND)
}

/// |X_uv|^2 of springs side by side, the first of which joins `a` and `b` [m^2].
#[inline(always)]
fn squares<const N: usize>(positions: &Vectors, [a, b]: [usize; 2]) -> [f32; N] {
    let mut squares = [0.0; N];
    for column in [&positions.x, &positions.y, &positions.z] {
        let [from, to] = [&column[a..a + N], &column[b..b + N]];
        for (square, (from, to)) in squares.iter_mut().zip(from.iter().zip(to)) {
            *square += (to - from) * (to - from);
        }
    }
    squares
}

/// Some rows of a grid.
struct Rows<'a> {
    springs: &'a GridSprings,
    lattice: &'a Lattice,
    positions: &'a Vectors,
    rows: Range<usize>,
}

impl WithSimd for Rows<'_> {
    /// The largest (|X_uv| / L)^2 and the elastic energy [J].
    type Output = (f32, f64);

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> (f32, f64) {
        let Self { springs, lattice, positions, rows } = self;
        let mut worst = [0.0_f32; LANES];
        let mut elastic = 0.0;
        for row in rows {
            // Few enough for single precision.
            let mut sums = [0.0_f32; LANES];
            for ([a, b], Constants { stiffness, rest, inverse_square }) in springs.runs(lattice, row).into_iter().flatten() {
                let whole = rest.len() / LANES * LANES;
                for i in (0..whole).step_by(LANES) {
                    let squares = squares::<LANES>(positions, [a + i, b + i]);
                    let constants = [stiffness, rest, inverse_square].map(|values| &values[i..i + LANES]);
                    take(squares, constants, &mut worst, &mut sums);
                }
                for i in whole..rest.len() {
                    let constants = [stiffness, rest, inverse_square].map(|values| &values[i..=i]);
                    take(squares::<1>(positions, [a + i, b + i]), constants, &mut worst, &mut sums);
                }
            }
            elastic += 0.5 * sums.iter().map(|sum| f64::from(*sum)).sum::<f64>();
        }
        (worst.into_iter().fold(0.0, f32::max), elastic)
    }
}

/// Takes springs into account, each in its lane: k_s (|X_uv| - L)^2 is summed.
#[inline(always)]
fn take<const N: usize>(squares: [f32; N], [stiffness, rest, inverse_square]: [&[f32]; 3], worst: &mut [f32], sums: &mut [f32]) {
    for i in 0..N {
        let ratio = squares[i] * inverse_square[i];
        worst[i] = if ratio > worst[i] { ratio } else { worst[i] };
        let extension = squares[i].sqrt() - rest[i];
        sums[i] += stiffness[i] * (extension * extension);
    }
}
