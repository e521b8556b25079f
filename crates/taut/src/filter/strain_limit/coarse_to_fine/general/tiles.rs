//! Where the finest level is over its limit: local correction, the paper's future work.

use super::super::Measure;
use super::level::GeneralLevel;
use crate::geometry::{Pool, items, sum_in_any_order};
use crate::model::Adjacency;

/// Particles in a tile; near ones have near places, so that a tile is a patch of the cloth.
pub(super) const TILE: u32 = 64;

/// The tiles of a level.
pub(super) struct GeneralTiles {
    /// Tiles that share a spring with each, and those that share one with these.
    neighbours: Adjacency<u32>,
    around: Adjacency<u32>,
    marked: Vec<bool>,
    /// The marked tiles and their neighbours.
    wide: Vec<bool>,
}

/// The tile in which a spring begins.
pub(super) fn tile_of(ends: [u32; 2]) -> u32 {
    ends[0] / TILE
}

impl GeneralTiles {
    /// The tiles of a level with these springs.
    pub fn new(level: &GeneralLevel, springs: impl Iterator<Item = [u32; 2]>) -> Self {
        let count = level.moved.len();
        let mut pairs: Vec<(u32, u32)> = springs.map(|[a, b]| (a / TILE, b / TILE)).filter(|(a, b)| a != b).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let neighbours = Adjacency::new(count, pairs.iter().flat_map(|&(a, b)| [(a, b), (b, a)]));
        let ring = |tile: usize| {
            let mut ring: Vec<u32> =
                neighbours.of(tile).iter().flat_map(|&other| neighbours.of(other as usize)).copied().collect();
            ring.extend(neighbours.of(tile));
            ring.sort_unstable();
            ring.dedup();
            ring.retain(|&other| other as usize != tile);
            ring
        };
        let around =
            Adjacency::new(count, (0..count).flat_map(|tile| ring(tile).into_iter().map(move |other| (tile as u32, other))));
        Self { neighbours, around, marked: vec![false; count], wide: vec![false; count] }
    }

    /// What springs are where sweeps pulled something; elsewhere they are as short as sweeps make them. Marks the tiles that are over
    /// `enough`.
    pub fn measure(&mut self, level: &GeneralLevel, enough: f32, pool: &Pool) -> Measure {
        let Self { around, marked, .. } = self;
        let each = |tile, marked: &mut bool| {
            // The ends of its springs are in the tile or in its neighbours, and springs that begin in theirs pull at them.
            let changed = level.moved[tile] || around.of(tile).iter().any(|&other| level.moved[other as usize]);
            let here = if changed { level.measure(tile, enough) } else { Measure::default() };
            *marked = here.over > 0;
            here
        };
        sum_in_any_order(items(marked), pool.pays_for(level.d.len()), Measure::default(), each, Measure::and)
    }

    /// The tiles that are over their limit.
    pub fn marked(&self) -> impl Iterator<Item = usize> {
        self.marked.iter().enumerate().filter(|(_, marked)| **marked).map(|(tile, _)| tile)
    }

    /// The part of the level that is marked.
    pub fn share(&self) -> f32 {
        self.marked.iter().filter(|marked| **marked).count() as f32 / self.marked.len() as f32
    }

    /// Takes the neighbours in: what is pulled in goes over there. Returns whether less than half of the level is
    /// marked then, so that sweeping the marked part alone pays.
    pub fn widen(&mut self) -> bool {
        self.wide.copy_from_slice(&self.marked);
        for tile in (0..self.marked.len()).filter(|&tile| self.marked[tile]) {
            self.neighbours.of(tile).iter().for_each(|&other| self.wide[other as usize] = true);
        }
        2 * self.wide.iter().filter(|wide| **wide).count() < self.wide.len()
    }

    /// Which tiles are marked or beside a marked one.
    pub fn wide(&self) -> &[bool] {
        &self.wide
    }
}
