//! Springs of coarse levels that no way along springs of the cloth is as short as: guides, as on meshes.
//!
//! Where cells of a level have another shape than those of the cloth, their diagonals lead over diagonals and sides of these, which are
//! longer than a straight line. So does what ties particles of a level to a held one of the finest level that it does not have. A sheet
//! that shears and folds may be further there. Where it is at the start of a step, it only may not go further.

use glam::Vec3;

use super::Grid;
use super::kernels::{LatticePull, TURNED};
use super::level::LatticeLevel;
use crate::geometry::Vectors;

/// A spring that is pulled by itself.
pub(super) struct Guide {
    /// The particle at its first end: of this level, where it is kept.
    pub a: usize,
    /// At its other end: of this level as well, or the held particle of the finest level.
    pub b: usize,
    /// Its greatest length [m], and what that is in this step.
    limit: f32,
    reach: f32,
}

impl Guide {
    /// Of such a greatest length [m].
    pub fn new(a: usize, b: usize, limit: f64) -> Self {
        Self { a, b, limit: limit as f32, reach: limit as f32 }
    }

    /// Takes its length at the start of a step [m].
    pub fn begin(&mut self, length: f32) {
        self.reach = self.limit.max(length);
    }

    /// The part of its `length` at the end of the step so far by which it is too long [1].
    pub fn excess(&self, length: f32, aim: f32) -> f32 {
        let reach = self.reach - self.limit * (1.0 - aim);
        if length > reach { 1.0 - reach / length } else { 0.0 }
    }
}

/// Pulls together the ends of each guide between two particles of a level: `x` is where they begin, `w` are inverse masses.
pub(super) fn pull(guides: &[Guide], x: &Vectors, p: &mut Vectors, w: &[f32], LatticePull { aim, at_start }: LatticePull) {
    for guide in guides {
        let (a, b) = (guide.a, guide.b);
        let way: Vec3 = p.get(b) - p.get(a);
        let (excess, weight) = (guide.excess(way.length(), aim), w[a] + w[b]);
        if excess <= 0.0 || weight <= 0.0 {
            continue;
        }
        let start = x.get(b) - x.get(a);
        let is_steady = at_start && (way - start).length_squared() < TURNED * way.length_squared();
        let along = if is_steady { start } else { way };
        // The length still shrinks by the same.
        let share = along * (excess * way.length_squared() / (way.dot(along) * weight));
        p.set(a, p.get(a) + share * w[a]);
        p.set(b, p.get(b) - share * w[b]);
    }
}

/// Ties the corners of a coarse cell to a held particle inside it, unless one of them is held itself. `held` has columns and rows.
pub(super) fn anchors(
    level: &LatticeLevel,
    finest: &LatticeLevel,
    held: &[(usize, usize)],
    grid: &Grid,
    cells: [usize; 2],
    stretch: f64,
) -> Vec<Guide> {
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
            let line = grid.line([columns[i], column as f64], [rows[j], row as f64]);
            Guide::new(level.place(i, j), held, stretch * line)
        }));
    }
    anchors
}
