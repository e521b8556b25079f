//! Where a level is over its limit: local correction, the paper's future work.

use super::kernels::BLOCK;
use super::level::Level;

/// Rows in a band.
const BAND: usize = 8;

/// For each band of rows, the blocks of a run that hold a spring over its limit, as one interval.
pub(super) struct Tiles {
    bands: Vec<(usize, usize)>,
    /// Blocks in the longest run.
    blocks: usize,
}

impl Tiles {
    pub fn new(level: &Level) -> Self {
        Self { bands: vec![(0, 0); level.rows.div_ceil(BAND)], blocks: level.columns.div_ceil(2).div_ceil(BLOCK) }
    }

    pub fn clear(&mut self) {
        self.bands.fill((0, 0));
    }

    /// Marks a block of a run that begins at a row.
    #[inline(always)]
    pub fn mark(&mut self, row: usize, block: usize) {
        let (from, to) = &mut self.bands[row / BAND];
        (*from, *to) = if from == to { (block, block + 1) } else { ((*from).min(block), (*to).max(block + 1)) };
    }

    /// The marked blocks of the runs that begin at a row; empty if there are none.
    #[inline(always)]
    pub fn of_row(&self, row: usize) -> (usize, usize) {
        self.bands[row / BAND]
    }

    /// Whether less than half of the level is marked, so that sweeping the marked part alone pays.
    pub fn are_few(&self) -> bool {
        let marked: usize = self.bands.iter().map(|(from, to)| to - from).sum();
        2 * marked < self.bands.len() * self.blocks
    }

    /// Marks the neighbouring bands and blocks too: what is pulled in goes over there.
    pub fn widen(&mut self) {
        for (from, to) in self.bands.iter_mut().filter(|(from, to)| from < to) {
            (*from, *to) = (from.saturating_sub(1), (*to + 1).min(self.blocks));
        }
        let mut above = (0, 0);
        for index in 0..self.bands.len() {
            let here = self.bands[index];
            let below = self.bands.get(index + 1).copied().unwrap_or_default();
            self.bands[index] = join(join(here, above), below);
            above = here;
        }
    }
}

fn join(a: (usize, usize), b: (usize, usize)) -> (usize, usize) {
    if a.0 == a.1 {
        b
    } else if b.0 == b.1 {
        a
    } else {
        (a.0.min(b.0), a.1.max(b.1))
    }
}
