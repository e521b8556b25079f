//! Regular grids: neighbours by arithmetic instead of by list.

use super::{ClothRange, Springs};
use crate::scene::Grid;

/// A regular grid among the cloths; particle `(i, j)` (column, row) has number `first + j * columns + i`.
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice {
    /// Its first particle.
    pub first: usize,
    /// Particles in a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// Springs along the bottom row, along a row inside and along the top row.
    pub along: [SpringRun; 3],
    /// Springs from a row to the next one: straight up, up to the right, up to the left.
    pub upward: [SpringRun; 3],
    /// Greatest lengths of all springs to the right, up, up-right and up-left, the least of each kind [m].
    pub limits: [f32; 4],
}

/// The constants of some springs, such as those that stand side by side in a row.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SpringRun {
    /// k_s [N/m].
    pub stiffness: Vec<f32>,
    /// k_s L [N].
    pub stiffness_rest: Vec<f32>,
    /// k_D [kg/s].
    pub damping: Vec<f32>,
}

impl Lattice {
    /// The lattice of a grid, if it is at least three particles wide and high.
    ///
    /// The constants are read off the springs, so that they cannot differ from them.
    pub(super) fn new(grid: &Grid, cloth: &ClothRange, springs: &Springs) -> Option<Self> {
        let first = cloth.first;
        let [columns, rows] = grid.cells.map(|cells| cells as usize + 1);
        if columns < 3 || rows < 3 {
            return None;
        }
        let mut lattice =
            Self { first, columns, rows, along: Default::default(), upward: Default::default(), limits: [f32::INFINITY; 4] };
        let [bottom, inside, top] = &mut lattice.along;
        let [up, right, left] = &mut lattice.upward;
        for spring in cloth.springs.clone() {
            let [a, b] = springs.ends[spring].map(|end| end as usize - first);
            let row = a / columns;
            let (run, of_run) = match (direction(b - a, columns), row) {
                (0, 0) => (&mut *bottom, true),
                (0, row) if row + 1 == rows => (&mut *top, true),
                (0, row) => (&mut *inside, row == 1),
                (1, row) => (&mut *up, row == 0),
                (2, row) => (&mut *right, row == 0),
                (_, row) => (&mut *left, row == 0),
            };
            if of_run {
                run.push(springs.force_stiffness[spring], springs.rest[spring], springs.damping[spring]);
            }
        }
        lattice.set_limits(cloth, springs);
        Some(lattice)
    }

    /// Reads the limits off the springs, where they have changed.
    pub(super) fn set_limits(&mut self, cloth: &ClothRange, springs: &Springs) {
        self.limits = [f32::INFINITY; 4];
        for spring in cloth.springs.clone() {
            let [a, b] = springs.ends[spring].map(|end| end as usize);
            let limit = &mut self.limits[direction(b - a, self.columns)];
            *limit = limit.min(springs.greatest_length(spring));
        }
    }

    /// The springs along a row.
    #[must_use]
    pub fn along_row(&self, row: usize) -> &SpringRun {
        let [bottom, inside, top] = &self.along;
        match row {
            0 => bottom,
            row if row + 1 == self.rows => top,
            _ => inside,
        }
    }
}

/// Along a row (0), straight up (1), up to the right (2) or to the left (3): where the numbers of the ends differ by `offset`.
fn direction(offset: usize, columns: usize) -> usize {
    match offset {
        1 => 0,
        offset if offset == columns => 1,
        offset if offset == columns + 1 => 2,
        _ => 3,
    }
}

impl SpringRun {
    /// Adds a spring: k_s [N/m], L [m], k_D [kg/s].
    pub fn push(&mut self, stiffness: f32, rest: f32, damping: f32) {
        self.stiffness.push(stiffness);
        self.stiffness_rest.push(stiffness * rest);
        self.damping.push(damping);
    }
}
