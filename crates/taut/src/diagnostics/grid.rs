//! The springs of a grid, examined row by row: what lies side by side needs no lists of ends, lengths and stiffnesses, which take
//! more memory than the cloth.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use crate::geometry::{Vectors, arch};
use crate::model::{ClothRange, Lattice, Model};

/// Rows that are examined together.
const BAND: usize = 8;
/// So many springs go on side by side, whatever the length of the vector registers, so that bits do not depend on it.
const LANES: usize = 16;

/// The constants of a grid's springs.
#[derive(Debug, Default)]
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

/// Rows of a grid that are examined together, and what they say.
#[derive(Debug)]
pub(super) struct Band {
    /// Which of the grids.
    pub grid: usize,
    rows: Range<usize>,
    /// Largest (|X_uv| / L)^2.
    pub worst: f32,
    /// [J]
    pub elastic: f64,
}

impl Constants {
    fn of(model: &Model, springs: impl Iterator<Item = u32>) -> Self {
        let mut constants = Self::default();
        for spring in springs.map(|spring| spring as usize) {
            let (stiffness, rest) = (model.springs.stiffness[spring], model.springs.rest[spring]);
            constants.stiffness.push(stiffness);
            constants.rest.push(rest);
            constants.inverse_square.push(1.0 / (rest * rest));
        }
        constants
    }
}

impl GridSprings {
    /// Those of a cloth that is a grid.
    pub fn new(model: &Model, cloth: &ClothRange, index: usize) -> Self {
        let lattice = &model.lattices[index];
        let springs = Self { lattice: index, springs: cloth.springs.clone(), ..Self::default() };
        let of = |row: usize, kind: usize| {
            let count = if kind == 1 { lattice.columns } else { lattice.columns - 1 };
            Constants::of(model, (0..count).map(|place| springs.number(lattice, kind, row, place)))
        };
        let along = [of(0, 0), of(1, 0), of(lattice.rows - 1, 0)];
        let upward = [of(0, 1), of(0, 2), of(0, 3)];
        Self { along, upward, ..springs }
    }

    /// The bands of the grid with the number `grid`.
    pub fn bands(&self, model: &Model, grid: usize) -> impl Iterator<Item = Band> + use<> {
        let rows = model.lattices[self.lattice].rows;
        let band = move |first: usize| Band { grid, rows: first..rows.min(first + BAND), worst: 0.0, elastic: 0.0 };
        (0..rows).step_by(BAND).map(band)
    }

    /// Examines a band.
    pub fn examine(&self, model: &Model, positions: &Vectors, band: &mut Band) {
        let (lattice, rows) = (&model.lattices[self.lattice], band.rows.clone());
        (band.worst, band.elastic) = arch().dispatch(Rows { springs: self, lattice, positions, rows });
    }

    /// The first spring that made a band's worst what it is.
    pub fn find(&self, model: &Model, positions: &Vectors, band: &Band) -> Option<u32> {
        let lattice = &model.lattices[self.lattice];
        band.rows.clone().find_map(|row| {
            let runs = self.runs(lattice, row).into_iter().enumerate();
            runs.filter_map(|(kind, run)| Some((kind, run?))).find_map(|(kind, ([a, b], constants))| {
                let ratio = |i: usize| squares::<1>(positions, [a + i, b + i])[0] * constants.inverse_square[i];
                let place = (0..constants.rest.len()).find(|i| ratio(*i) == band.worst)?;
                Some(self.number(lattice, kind, row, place))
            })
        })
    }

    /// The number of a spring, in the order in which grids are built: all along rows, all straight up, the diagonals in turn.
    fn number(&self, lattice: &Lattice, kind: usize, row: usize, place: usize) -> u32 {
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
