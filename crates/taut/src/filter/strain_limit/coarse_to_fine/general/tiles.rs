//! Where the finest level is over its limit: local correction, the paper's future work.

use std::ops::Range;

use super::level::LANES;
use crate::model::Adjacency;

/// Particles in a tile; near ones have near places, so that a tile is a patch of the cloth.
pub(super) const TILE: u32 = 64;

/// The tiles of a level.
pub(super) struct Tiles {
    /// Bundles of tile t: `bundles[starts[t]..starts[t + 1]]`, those whose springs begin in it.
    starts: Vec<usize>,
    /// Tiles that share a spring.
    neighbours: Adjacency<u32>,
    marked: Vec<bool>,
    /// The marked tiles and their neighbours.
    wide: Vec<bool>,
    /// Those of which sweeps moved a particle since the last beginning.
    moved: Vec<bool>,
}

/// The tile in which a spring begins.
pub(super) fn tile_of(ends: [u32; 2]) -> u32 {
    ends[0] / TILE
}

impl Tiles {
    /// Tiles whose bundles begin at `starts`; `springs` are all springs.
    pub fn new(starts: Vec<usize>, springs: impl Iterator<Item = [u32; 2]>) -> Self {
        let count = starts.len() - 1;
        let mut pairs: Vec<(u32, u32)> = springs.map(|[a, b]| (a / TILE, b / TILE)).filter(|(a, b)| a != b).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let neighbours = Adjacency::new(count, pairs.iter().flat_map(|&(a, b)| [(a, b), (b, a)]));
        Self { starts, neighbours, marked: vec![false; count], wide: vec![false; count], moved: vec![false; count] }
    }

    /// Forgets what was moved.
    pub fn begin(&mut self) {
        self.moved.fill(false);
    }

    /// Sweeps moved these particles.
    #[inline(always)]
    pub fn moves(&mut self, ends: &[[u32; LANES]; 2]) {
        ends.as_flattened().iter().for_each(|end| self.moved[(end / TILE) as usize] = true);
    }

    /// Everything was moved.
    pub fn moves_all(&mut self) {
        self.moved.fill(true);
    }

    /// Whether springs of a tile have changed: their ends are in the tile or in its neighbours.
    pub fn has_changed(&self, tile: usize) -> bool {
        self.moved[tile] || self.neighbours.of(tile).iter().any(|&other| self.moved[other as usize])
    }

    /// How many tiles there are.
    pub fn count(&self) -> usize {
        self.marked.len()
    }

    /// The bundles of a tile.
    pub fn bundles(&self, tile: usize) -> Range<usize> {
        self.starts[tile]..self.starts[tile + 1]
    }

    /// Says whether a tile is over its limit.
    pub fn mark(&mut self, tile: usize, over: bool) {
        self.marked[tile] = over;
    }

    /// Whether a tile is over its limit.
    pub fn is_marked(&self, tile: usize) -> bool {
        self.marked[tile]
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

    /// Whether a tile is marked or beside a marked one.
    pub fn is_wide(&self, tile: usize) -> bool {
        self.wide[tile]
    }
}
