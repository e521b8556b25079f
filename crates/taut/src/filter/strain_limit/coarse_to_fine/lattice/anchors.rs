//! What ties a coarse level to held particles of the finest level that it does not have.

use super::Grid;
use super::level::LatticeLevel;

/// Keeps a particle of a coarse level near a held one of the finest level. It may be further from that than a straight line, as a sheet that
/// shears and folds may be. Where it is at the start of a step, it only may not go further.
pub(super) struct Anchor {
    /// Where the coarse particle and the held one are kept.
    pub particle: usize,
    pub held: usize,
    /// How far apart they may be [m], and what that is in this step.
    limit: f32,
    reach: f32,
}

impl Anchor {
    /// Takes how far apart they are at the start of a step [m].
    pub fn begin(&mut self, length: f32) {
        self.reach = self.limit.max(length);
    }

    /// The part of its `length` by which it is too long at the end of the step so far [1].
    pub fn excess(&self, length: f32, aim: f32) -> f32 {
        let reach = self.reach - self.limit * (1.0 - aim);
        if length > reach { 1.0 - reach / length } else { 0.0 }
    }
}

/// Ties the corners of a coarse cell to a held particle inside it, unless one of them is held itself. `held` has columns and rows.
pub(super) fn of(
    level: &LatticeLevel,
    finest: &LatticeLevel,
    held: &[(usize, usize)],
    grid: &Grid,
    cells: [usize; 2],
    stretch: f64,
) -> Vec<Anchor> {
    let (columns, rows) = (grid.columns.of_level(cells[0]), grid.rows.of_level(cells[1]));
    let cell = |places: &[f64], at: usize| places.partition_point(|&place| place <= at as f64).clamp(1, places.len() - 1);
    let mut anchors = Vec::new();
    for &(column, row) in held {
        let (i, j) = (cell(&columns, column), cell(&rows, row));
        let corners = [(i - 1, j - 1), (i, j - 1), (i - 1, j), (i, j)];
        if corners.iter().any(|&(i, j)| level.w[level.place(i, j)] == 0.0) {
            continue;
        }
        let held = finest.place(column, row);
        anchors.extend(corners.map(|(i, j)| {
            let limit = (stretch * grid.line([columns[i], column as f64], [rows[j], row as f64])) as f32;
            Anchor { particle: level.place(i, j), held, limit, reach: limit }
        }));
    }
    anchors
}
