//! One level of a lattice: every spring is found by arithmetic, and all loops run over consecutive memory.
//!
//! Each row is stored as its even columns and then its odd columns. Neighbours along a row, across rows and along diagonals
//! are then runs of consecutive particles that never meet twice, so that a whole run is projected at once.
//!
//! A sweep takes every second band of rows, then the others: bands of one kind share no particle, so that they may be swept
//! at the same time with the same result.

use std::iter::{empty, repeat_n};
use std::ops::Range;

use glam::Vec3;
use pulp::{Simd, WithSimd};

use super::super::Measure;
use super::Grid;
use super::guides::{self, Guide};
use super::kernels::{BLOCK, End, LatticePull, Limits, project, worst};
use super::tiles::{LatticeTiles, Tile};
use super::transfer::Beside;
use crate::geometry::{Pool, Vectors, VectorsChunk, arch};

/// Rows in a band of a sweep.
const BAND: usize = 16;

/// A limit that no distance reaches, for the lanes that fill up a run; its square is still a number.
const NO_LIMIT: f32 = 1e18;

/// One level of a lattice.
pub(super) struct LatticeLevel {
    pub columns: usize,
    pub rows: usize,
    /// Where the step begins [m].
    pub x: Vectors,
    /// Where it ends so far, P [m].
    pub p: Vectors,
    /// Inverse masses, zero for what is held.
    pub w: Vec<f32>,
    /// Where what is held is kept, and workspace for where it ends.
    pub held: Vec<(usize, Vec3)>,
    /// Diagonals, where cells have quite another shape than those of the cloth: they are in no runs then.
    guides: Vec<Guide>,
    /// Length of half a row in memory.
    stride: usize,
    /// Greatest lengths [m] along a row: of the springs that begin at even columns, at odd columns.
    across: [Lengths; 2],
    /// Greatest lengths of the springs from a row to the next one [m]: straight across, and diagonals with indices as along a row.
    up: Lengths,
    diagonal: [Lengths; 2],
    /// Where its columns, and its rows, lie beside those of the next coarser level.
    pub beside: [Beside; 2],
}

/// The greatest lengths of the springs of a run.
struct Lengths {
    /// R [m].
    length: Vec<f32>,
    /// 1 / R^2 [1/m^2].
    inverse_square: Vec<f32>,
}

impl Lengths {
    fn new(length: impl Iterator<Item = f32>) -> Self {
        let length: Vec<f32> = length.collect();
        let inverse_square = length.iter().map(|length| 1.0 / (length * length)).collect();
        Self { length, inverse_square }
    }

    /// Those of some of the springs.
    #[inline(always)]
    fn of(&self, springs: Range<usize>) -> Limits<'_> {
        Limits { length: &self.length[springs.clone()], inverse_square: &self.inverse_square[springs] }
    }
}

/// The springs of one run: where their two ends begin, and their greatest lengths.
struct Run<'a> {
    a: usize,
    b: usize,
    lengths: &'a Lengths,
}

impl LatticeLevel {
    /// A level with so many cells along and up a grid; `stretch` is 1 + lambda.
    pub fn new(grid: &Grid, [across, up]: [usize; 2], stretch: f64) -> Self {
        let (columns, rows) = (grid.columns.of_level(across), grid.rows.of_level(up));
        let (evens, odds) = (columns.len().div_ceil(2), columns.len() / 2);
        // A run may begin at the second particle of a row and be a whole number of blocks long.
        let stride = (1 + (evens - 1).next_multiple_of(BLOCK)).max(evens).next_multiple_of(BLOCK);
        let along = |rows: [f64; 2]| {
            [(0, odds), (1, evens - 1)].map(|(first, count)| {
                let limit = |k: usize| (stretch * grid.line([columns[2 * k + first], columns[2 * k + first + 1]], rows)) as f32;
                let padded = count.next_multiple_of(BLOCK);
                Lengths::new((0..padded).map(|k| if k < count { limit(k) } else { NO_LIMIT }))
            })
        };
        let [level_row, upward] = [[0.0; 2], [rows[0], rows[1]]];
        let is_guided = grid.is_guided([columns[1], rows[1]]);
        let size = 2 * rows.len() * stride;
        let mut level = Self {
            columns: columns.len(),
            rows: rows.len(),
            x: Vectors::zeros(size),
            p: Vectors::zeros(size),
            w: vec![0.0; size],
            held: Vec::new(),
            guides: Vec::new(),
            stride,
            across: along(level_row),
            diagonal: if is_guided { [(); 2].map(|()| Lengths::new(empty())) } else { along(upward) },
            up: Lengths::new(repeat_n((stretch * grid.line(level_row, upward)) as f32, evens.next_multiple_of(BLOCK))),
            beside: [Beside::new(across), Beside::new(up)],
        };
        if is_guided {
            let limit = stretch * grid.line([columns[0], columns[1]], upward);
            level.guides = (0..up)
                .flat_map(|row| (0..across).map(move |column| (column, row)))
                .flat_map(|(i, j)| [[(i, j), (i + 1, j + 1)], [(i + 1, j), (i, j + 1)]])
                .map(|[a, b]| Guide::new(level.place(a.0, a.1), level.place(b.0, b.1), limit))
                .collect();
        }
        level
    }

    /// Where the particle of a column and a row is kept.
    #[inline]
    pub fn place(&self, column: usize, row: usize) -> usize {
        (2 * row + column % 2) * self.stride + column / 2
    }

    /// Where a particle is kept that is numbered row by row.
    #[inline]
    pub fn place_of(&self, particle: usize) -> usize {
        self.place(particle % self.columns, particle / self.columns)
    }

    /// The particle that is kept at a place.
    fn particle_at(&self, place: usize) -> usize {
        let (half, within) = (place / self.stride, place % self.stride);
        half / 2 * self.columns + 2 * within + half % 2
    }

    /// The length of a row in memory.
    pub fn row_length(&self) -> usize {
        2 * self.stride
    }

    /// How many particles there are.
    pub fn size(&self) -> usize {
        self.columns * self.rows
    }

    /// Takes where a step begins for its guides.
    pub fn begin_guides(&mut self) {
        let Self { guides, x, .. } = self;
        guides.iter_mut().for_each(|guide| guide.begin(x.get(guide.a).distance(x.get(guide.b))));
    }

    /// One pass over all springs, or over those in the tiles.
    pub fn sweep(&mut self, pull: LatticePull, backwards: bool, tiles: Option<&LatticeTiles>, pool: &Pool) {
        let row_length = self.row_length();
        let Self { x, p, w, .. } = self;
        let layout =
            Layout { rows: self.rows, stride: self.stride, across: &self.across, up: &self.up, diagonal: &self.diagonal };
        for phase in if backwards { [1, 0] } else { [0, 1] } {
            let first = (phase * BAND * row_length).min(p.len());
            p.for_each_part(first..p.len(), 2 * BAND * row_length, pool, |p| {
                let begin = p.first / row_length;
                arch().dispatch(SweepBand {
                    layout: &layout,
                    x,
                    p,
                    w,
                    rows: begin..(begin + BAND).min(layout.rows),
                    pull,
                    backwards,
                    tiles,
                });
            });
        }
        guides::pull(&self.guides, x, p, w, pull);
    }

    /// What all springs are, or those that the last sweep over tiles may have changed; marks the tiles that are over `enough` of
    /// their limit.
    pub fn measure(&self, enough: f32, tiles: &mut LatticeTiles, everywhere: bool, pool: &Pool) -> Measure {
        let (layout, p) = (self.layout(), &self.p);
        tiles.measure(everywhere, pool.pays_for(self.size()), |rows, places, tile| {
            let rows = rows.start..rows.end.min(layout.rows);
            arch().dispatch(MeasureBand { layout: &layout, p, rows, places, enough, tile })
        })
    }

    /// Calls `visit` with the particles at the ends of each spring in a marked tile that is longer than `enough` of R.
    pub fn over(&self, enough: f32, tiles: &LatticeTiles, visit: &mut dyn FnMut([usize; 2])) {
        let layout = self.layout();
        for (rows, places) in tiles.marked() {
            for (row, run) in (rows.start..rows.end.min(self.rows)).flat_map(|row| (0..RUNS).map(move |run| (row, run))) {
                let Some(Run { a, b, lengths }) = layout.run(row, run) else { continue };
                for place in places.start..places.end.min(lengths.length.len()) {
                    let reach = enough * lengths.length[place];
                    let ends = [a + place, b + place];
                    if (self.p.get(ends[1]) - self.p.get(ends[0])).length_squared() > reach * reach {
                        visit(ends.map(|end| self.particle_at(end)));
                    }
                }
            }
        }
    }

    fn layout(&self) -> Layout<'_> {
        let Self { rows, stride, across, up, diagonal, .. } = self;
        Layout { rows: *rows, stride: *stride, across, up, diagonal }
    }
}

/// Some rows of a level, with the springs to the next row.
struct SweepBand<'a> {
    layout: &'a Layout<'a>,
    x: &'a Vectors,
    p: VectorsChunk<'a>,
    w: &'a [f32],
    rows: Range<usize>,
    pull: LatticePull,
    backwards: bool,
    tiles: Option<&'a LatticeTiles>,
}

impl WithSimd for SweepBand<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { layout, x, p, w, rows, pull, backwards, tiles } = self;
        for step in 0..rows.len() {
            let row = if backwards { rows.end - 1 - step } else { rows.start + step };
            let places = tiles.map_or(0..usize::MAX, |tiles| tiles.of_row(row));
            for run in 0..RUNS {
                let run = if backwards { RUNS - 1 - run } else { run };
                let Some(Run { a, b, lengths }) = layout.run(row, run) else { continue };
                let all = lengths.length.len();
                let places = places.start.min(all)..places.end.min(all);
                if places.is_empty() {
                    continue;
                }
                let [a, b] = [a, b].map(|end| end + places.start);
                let len = places.len();
                // One check a run: slices of each column would be checked fourteen times.
                assert!(a.abs_diff(b) >= len && a.min(b) >= p.first, "the two ends of a run do not overlap");
                assert!(a.max(b) + len <= (p.first + p.x.len()).min(w.len()), "a run lies in its band");
                let columns = [&x.x, &x.y, &x.z];
                let moving = [&mut *p.x, &mut *p.y, &mut *p.z].map(<[f32]>::as_mut_ptr);
                // SAFETY: columns of a level are as long as its weights, those of a band as long as its first one. The runs lie
                // in both and are apart.
                let end = |at: usize| unsafe {
                    End {
                        x: columns.map(|column| column.get_unchecked(at..at + len)),
                        p: moving.map(|column| std::slice::from_raw_parts_mut(column.add(at - p.first), len)),
                        w: w.get_unchecked(at..at + len),
                    }
                };
                project(simd, end(a), end(b), lengths.of(places), pull);
            }
        }
    }
}

/// Some rows of a level that are measured.
struct MeasureBand<'a> {
    layout: &'a Layout<'a>,
    p: &'a Vectors,
    rows: Range<usize>,
    places: Range<usize>,
    enough: f32,
    tile: &'a mut Tile,
}

impl WithSimd for MeasureBand<'_> {
    type Output = Measure;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Measure {
        let Self { layout, p, rows, places, enough, tile } = self;
        let (mut largest, mut count) = (simd.splat_f32s(0.0), 0);
        for row in rows {
            for run in 0..RUNS {
                if let Some(Run { a, b, lengths }) = layout.run(row, run) {
                    let inverse = &*lengths.inverse_square;
                    let there = places.start.min(inverse.len())..places.end.min(inverse.len());
                    let ends = [a + there.start, b + there.start];
                    let mark = |first, over: &[f32]| {
                        tile.mark(places.start + first, over);
                        count += over.iter().filter(|&&over| over != 0.0).count();
                    };
                    largest = worst(simd, p, ends, &inverse[there], largest, enough * enough, mark);
                }
            }
        }
        Measure { worst: simd.reduce_max_f32s(largest).sqrt(), over: count }
    }
}

/// Runs that begin at a row: two along it, six to the next row.
const RUNS: usize = 8;

/// What is needed to find a run.
struct Layout<'a> {
    rows: usize,
    stride: usize,
    across: &'a [Lengths; 2],
    up: &'a Lengths,
    diagonal: &'a [Lengths; 2],
}

impl<'a> Layout<'a> {
    /// The run of a number at a row; none where there is no next row.
    #[inline(always)]
    fn run(&self, row: usize, run: usize) -> Option<Run<'a>> {
        let even = 2 * row * self.stride;
        let odd = even + self.stride;
        if let Some(lengths) = self.across.get(run) {
            let [a, b] = [[even, odd], [odd, even + 1]][run];
            return Some(Run { a, b, lengths });
        }
        if row + 1 >= self.rows {
            return None;
        }
        let Self { up, diagonal, .. } = *self;
        let (next_even, next_odd) = (even + 2 * self.stride, odd + 2 * self.stride);
        let (a, b, lengths) = match run {
            2 => (even, next_even, up),
            3 => (odd, next_odd, up),
            4 => (even, next_odd, &diagonal[0]),
            5 => (odd, next_even + 1, &diagonal[1]),
            6 => (odd, next_even, &diagonal[0]),
            _ => (even + 1, next_odd, &diagonal[1]),
        };
        Some(Run { a, b, lengths })
    }
}
