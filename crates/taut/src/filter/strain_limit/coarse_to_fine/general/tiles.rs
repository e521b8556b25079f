//! Where the finest level is over its limit: local correction, the paper's future work.

use std::ops::Range;

use super::level::Spring;
use crate::model::Adjacency;

/// Particles in a tile; near ones have near places, so that a tile is a patch of the cloth.
const TILE: usize = 64;

/// The tiles of a level.
pub(super) struct Tiles {
    /// Springs of tile t: `springs[starts[t]..starts[t + 1]]`, those whose first end is in it.
    starts: Vec<usize>,
    /// Tiles that share a spring.
    neighbours: Adjacency<u32>,
    marked: Vec<bool>,
    /// The marked tiles and their neighbours.
    wide: Vec<bool>,
}

impl Tiles {
    /// Tiles of so many particles; `springs` are in the order of their first ends.
    pub fn new(particles: usize, springs: &[Spring]) -> Self {
        let count = particles.div_ceil(TILE);
        let starts = (0..=count).map(|tile| springs.partition_point(|spring| (spring.ends[0] as usize) < tile * TILE)).collect();
        let mut pairs: Vec<(u32, u32)> = springs.iter().map(|spring| spring.ends.map(tile_of)).map(|[a, b]| (a, b)).collect();
        pairs.retain(|(a, b)| a != b);
        pairs.sort_unstable();
        pairs.dedup();
        let neighbours = Adjacency::new(count, pairs.iter().flat_map(|&(a, b)| [(a, b), (b, a)]));
        Self { starts, neighbours, marked: vec![false; count], wide: vec![false; count] }
    }

    pub fn clear(&mut self) {
        self.marked.fill(false);
    }

    /// Marks the tiles of a spring's ends.
    #[inline]
    pub fn mark(&mut self, spring: &Spring) {
        spring.ends.iter().for_each(|&end| self.marked[tile_of(end) as usize] = true);
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

    /// How many tiles there are.
    pub fn count(&self) -> usize {
        self.wide.len()
    }

    /// The springs of a tile if it is marked or beside a marked one.
    pub fn springs(&self, tile: usize) -> Range<usize> {
        if self.wide[tile] { self.starts[tile]..self.starts[tile + 1] } else { 0..0 }
    }
}

fn tile_of(place: u32) -> u32 {
    place / TILE as u32
}
