//! Where a level is over its limit: local correction, the paper's future work.

use std::ops::Range;

use rayon::prelude::*;

use super::kernels::BLOCK;
use super::level::Level;

/// Rows in a band of tiles.
const BAND: usize = 8;

/// The blocks of a band of rows that hold a spring over its limit, as one interval; empty if there are none.
#[derive(Clone, Copy, Default)]
pub(super) struct Tile {
    from: usize,
    to: usize,
}

/// All tiles of a level.
pub(super) struct Tiles {
    bands: Vec<Tile>,
    /// What was measured in each.
    worst: Vec<f32>,
    /// Blocks in the longest run.
    blocks: usize,
}

impl Tile {
    /// Marks a block.
    #[inline(always)]
    pub fn mark(&mut self, block: usize) {
        *self = self.join(Self { from: block, to: block + 1 });
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

impl Tiles {
    pub fn new(level: &Level) -> Self {
        let bands = level.rows.div_ceil(BAND);
        Self { bands: vec![Tile::default(); bands], worst: vec![0.0; bands], blocks: level.columns.div_ceil(2).div_ceil(BLOCK) }
    }

    /// Calls `work` with the rows of each band, the blocks in them that count, and an empty tile to mark; returns the largest
    /// result. Unless everything counts, what is marked and its neighbours do: a pull reaches one spring beyond them.
    pub fn measure(
        &mut self,
        everywhere: bool,
        in_parallel: bool,
        work: impl Fn(Range<usize>, Range<usize>, &mut Tile) -> f32 + Sync,
    ) -> f32 {
        if everywhere {
            self.bands.fill(Tile { from: 0, to: self.blocks });
        } else {
            self.widen();
        }
        let each = |(band, (tile, worst)): (usize, (&mut Tile, &mut f32))| {
            let Tile { from, to } = std::mem::take(tile);
            *worst = if from == to { 0.0 } else { work(band * BAND..(band + 1) * BAND, from..to, tile) };
        };
        if in_parallel {
            self.bands.par_iter_mut().zip(&mut self.worst).enumerate().for_each(each);
        } else {
            self.bands.iter_mut().zip(&mut self.worst).enumerate().for_each(each);
        }
        self.worst.iter().fold(0.0, |largest, &worst| if worst > largest { worst } else { largest })
    }

    /// The marked blocks of the runs that begin at a row.
    #[inline(always)]
    pub fn of_row(&self, row: usize) -> (usize, usize) {
        let Tile { from, to } = self.bands[row / BAND];
        (from, to)
    }

    /// The part of the level that is marked.
    pub fn share(&self) -> f32 {
        let marked: usize = self.bands.iter().map(|tile| tile.to - tile.from).sum();
        marked as f32 / (self.bands.len() * self.blocks) as f32
    }

    /// Marks the neighbouring bands and blocks too: what is pulled in goes over there.
    pub fn widen(&mut self) {
        for tile in self.bands.iter_mut().filter(|tile| !tile.is_empty()) {
            *tile = Tile { from: tile.from.saturating_sub(1), to: (tile.to + 1).min(self.blocks) };
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
