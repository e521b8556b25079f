//! Where a level is over its limit: local correction, the paper's future work.

use std::ops::Range;

use super::super::Measure;
use super::kernels::BLOCK;
use super::level::LatticeLevel;
use crate::geometry::{for_each_piece, items};

/// Rows in a band of tiles.
const BAND: usize = 2;
/// Springs to either side of what is over its limit that are swept as well, and a band above and below: what is pulled in is missing
/// there.
const MARGIN: usize = 2;

/// Where a band of rows holds springs over their limit: in each of its runs at the places of one interval; empty if it holds none.
#[derive(Clone, Copy, Default)]
pub(super) struct Tile {
    from: usize,
    to: usize,
}

/// All tiles of a level.
pub(super) struct LatticeTiles {
    bands: Vec<Tile>,
    /// What was measured in each.
    found: Vec<Measure>,
    /// Springs in the longest run, filled up.
    springs: usize,
}

impl Tile {
    /// Marks the springs for which `over` is not zero, of those from the place `first` on.
    #[inline(always)]
    pub fn mark(&mut self, first: usize, over: &[f32]) {
        if self.from <= first && first + over.len() <= self.to {
            return;
        }
        let place = |place: usize| first + place;
        let from = over.iter().position(|&over| over != 0.0).map(place);
        let last = over.iter().rposition(|&over| over != 0.0).map(place);
        if let (Some(from), Some(last)) = (from, last) {
            *self = self.join(Self { from, to: last + 1 });
        }
    }

    /// The places of all blocks that it touches.
    #[inline(always)]
    fn blocks(self) -> Range<usize> {
        self.from / BLOCK * BLOCK..self.to.next_multiple_of(BLOCK)
    }

    #[inline(always)]
    fn is_empty(self) -> bool {
        self.from == self.to
    }

    #[inline(always)]
    fn join(self, other: Self) -> Self {
        if self.is_empty() {
            other
        } else if other.is_empty() {
            self
        } else {
            Self { from: self.from.min(other.from), to: self.to.max(other.to) }
        }
    }
}

impl LatticeTiles {
    pub fn new(level: &LatticeLevel) -> Self {
        let bands = level.rows.div_ceil(BAND);
        let springs = level.columns.div_ceil(2).next_multiple_of(BLOCK);
        Self { bands: vec![Tile::default(); bands], found: vec![Measure::default(); bands], springs }
    }

    /// Calls `work` with the rows of each band, the places in their runs that count, whole blocks, and an empty tile to mark;
    /// returns what was found in all of them. Unless everything counts, it is what a sweep over the tiles has changed: it was given whole
    /// blocks, and moved the ends of the springs around them.
    pub fn measure(
        &mut self,
        everywhere: bool,
        in_parallel: bool,
        work: impl Fn(Range<usize>, Range<usize>, &mut Tile) -> Measure + Sync,
    ) -> Measure {
        if everywhere {
            self.bands.fill(Tile { from: 0, to: self.springs });
        } else {
            for tile in &mut self.bands {
                let Range { start: from, end: to } = tile.blocks();
                *tile = Tile { from, to };
            }
            self.widen(1);
        }
        for_each_piece((items(&mut self.bands), items(&mut self.found)), in_parallel, |band, (tile, found)| {
            let before = std::mem::take(tile);
            let rows = band * BAND..(band + 1) * BAND;
            *found = if before.is_empty() { Measure::default() } else { work(rows, before.blocks(), tile) };
        });
        self.found.iter().fold(Measure::default(), |all, found| all.and(*found))
    }

    /// The places that are to be swept in the runs that begin at a row: whole blocks.
    #[inline(always)]
    pub fn of_row(&self, row: usize) -> Range<usize> {
        self.bands[row / BAND].blocks()
    }

    /// The rows of each marked band, and its places in their runs.
    pub fn marked(&self) -> impl Iterator<Item = (Range<usize>, Range<usize>)> {
        let marked = self.bands.iter().enumerate().filter(|(_, tile)| !tile.is_empty());
        marked.map(|(band, tile)| (band * BAND..(band + 1) * BAND, tile.from..tile.to))
    }

    /// The part of the level that is marked.
    pub fn share(&self) -> f32 {
        let marked: usize = self.bands.iter().map(|tile| tile.blocks().len()).sum();
        marked as f32 / (self.bands.len() * self.springs) as f32
    }

    /// Marks what is to be swept together with what is over its limit.
    pub fn take_neighbours(&mut self) {
        self.widen(MARGIN);
    }

    /// Marks so many springs to either side as well, and the same places of the bands above and below.
    fn widen(&mut self, margin: usize) {
        for tile in self.bands.iter_mut().filter(|tile| !tile.is_empty()) {
            *tile = Tile { from: tile.from.saturating_sub(margin), to: (tile.to + margin).min(self.springs) };
        }
        let mut above = Tile::default();
        for index in 0..self.bands.len() {
            let here = self.bands[index];
            let below = self.bands.get(index + 1).copied().unwrap_or_default();
            self.bands[index] = here.join(above).join(below);
            above = here;
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::filter::strain_limit::coarse_to_fine::lattice::Grid;
    use crate::filter::strain_limit::coarse_to_fine::lattice::kernels::LatticePull;
    use crate::geometry::Pool;

    const ENOUGH: f32 = 1.0;
    const PULL: LatticePull = LatticePull { aim: 0.99, at_start: false };

    /// A level with springs at 0.995 of their limits, but for the particles that are `moved` [m] along a row.
    fn level([columns, rows]: [usize; 2], moved: &[(usize, usize, f32)]) -> LatticeLevel {
        let mut level = LatticeLevel::new(&Grid::of_squares([columns, rows], 0.1), [columns - 1, rows - 1], 1.0 / 0.995);
        for (column, row) in (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))) {
            let place = level.place(column, row);
            level.p.set(place, [0.1 * column as f32, 0.1 * row as f32, 0.0].into());
            level.w[place] = 1.0;
        }
        for (column, row, way) in moved {
            let place = level.place(column % columns, row % rows);
            level.p.x[place] += way;
        }
        level
    }

    proptest! {
        #[test]
        fn what_a_local_sweep_makes_longer_is_measured(
            size in [3_usize..80, 3_usize..40],
            moved in prop::collection::vec((0_usize..80, 0_usize..40, -0.03_f32..0.03), 1..4),
            backwards: bool,
        ) {
            let (mut level, pool) = (level(size, &moved), Pool::new(1));
            let mut tiles = LatticeTiles::new(&level);
            let mut worst = level.measure(ENOUGH, &mut tiles, true, &pool);
            for round in 0..6 {
                if worst.over == 0 {
                    break;
                }
                tiles.take_neighbours();
                level.sweep(PULL, backwards ^ (round % 2 == 1), Some(&tiles), &pool);
                worst = level.measure(ENOUGH, &mut tiles, false, &pool);
                let everywhere = level.measure(ENOUGH, &mut LatticeTiles::new(&level), true, &pool);
                prop_assert_eq!(worst.over, everywhere.over);
                prop_assert!(worst == everywhere || everywhere.over == 0, "{worst:?} where it was swept, {everywhere:?} everywhere");
            }
        }
    }
}
