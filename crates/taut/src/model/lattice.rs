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

    /// Whether the particles that are held, numbered from the first one of the grid, are single ones and whole borders. Levels of stride 2
    /// know these. Of two other neighbours that are held they know one and take the other for free, which cycles do not make up for
    /// (docs/decisions/coarse-to-fine.md).
    pub(super) fn is_held_plainly(&self, is_held: impl Fn(usize) -> bool) -> bool {
        let Self { columns, rows, .. } = *self;
        let at = |column: usize, row: usize| is_held(row * columns + column);
        let row_is_held = [0, rows - 1].map(|row| (0..columns).all(|column| at(column, row)));
        let column_is_held = [0, columns - 1].map(|column| (0..rows).all(|row| at(column, row)));
        let is_in_border = |column: usize, row: usize| {
            (row == 0 && row_is_held[0])
                || (row + 1 == rows && row_is_held[1])
                || (column == 0 && column_is_held[0])
                || (column + 1 == columns && column_is_held[1])
        };
        let is_single = |column: usize, row: usize| {
            let around = (row.saturating_sub(1)..(row + 2).min(rows))
                .flat_map(|row| (column.saturating_sub(1)..(column + 2).min(columns)).map(move |column| (column, row)));
            around.filter(|&(column, row)| at(column, row)).count() == 1
        };
        let mut all = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
        all.all(|(column, row)| !at(column, row) || is_in_border(column, row) || is_single(column, row))
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether this is held plainly, of 9 x 7 particles (column, row).
    fn plainly(is_held: impl Fn(usize, usize) -> bool) -> bool {
        let (along, upward) = Default::default();
        let grid = Lattice { first: 0, columns: 9, rows: 7, along, upward, limits: [0.0; 4] };
        grid.is_held_plainly(|particle| is_held(particle % 9, particle / 9))
    }

    #[test]
    fn single_particles_and_whole_borders_are_held_plainly_and_other_neighbours_are_not() {
        assert!(plainly(|_, _| false));
        assert!(plainly(|column, row| (column, row) == (3, 5)));
        assert!(plainly(|column, row| row == 6 && column % 2 == 0));
        assert!(plainly(|column, _| column == 0));
        assert!(plainly(|column, row| column == 0 || column == 8 || row == 0 || row == 6));
        assert!(plainly(|column, row| row == 0 || (column, row) == (4, 3)));
        assert!(!plainly(|column, _| column <= 1), "two columns");
        assert!(!plainly(|column, row| row == 6 && column <= 1), "a part of a border");
        assert!(!plainly(|column, row| column == 0 && row > 0), "all of a border but one");
        assert!(!plainly(|column, row| [(3, 3), (4, 4)].contains(&(column, row))), "diagonal neighbours");
        assert!(!plainly(|column, row| row == 0 || (column, row) == (4, 1)), "a neighbour of a border");
        assert!(!plainly(|column, row| row == 3 && (0..9).contains(&column)), "a row inside");
        assert!(!plainly(|_, _| true));
    }
}
