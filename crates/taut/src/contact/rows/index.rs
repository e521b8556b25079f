//! The rows of single vertices, of which those that are not kept are put right one by one.

use glam::Vec3;

use super::{NONE, Row, Rows};

/// The rows of each place in the workspace: those of place p are `rows[starts[p]..starts[p + 1]]`, if there are any starts.
#[derive(Debug, Default)]
pub(super) struct Index {
    starts: Vec<u32>,
    rows: Vec<u32>,
}

impl Index {
    /// Goes on with rows that it does not know.
    pub fn forget(&mut self) {
        self.starts.clear();
    }
}

impl Rows {
    /// Calls `visit` with the particles of rows that are not kept, if these are at most so many. Returns whether they are.
    pub fn unkept(&self, most: usize, mut visit: impl FnMut(usize)) -> bool {
        self.unkept_rows(most, |row| {
            let vertices = self.list[row].locals().map(|local| self.vertices[local] as usize);
            vertices.filter(|&vertex| vertex < self.particles).for_each(&mut visit);
        })
    }

    /// Finds out which rows each vertex is in, if that is not known.
    pub fn index(&mut self) {
        let Index { starts, rows } = &mut self.index;
        if !starts.is_empty() {
            return;
        }
        starts.resize(self.vertices.len() + 2, 0);
        for local in self.list.iter().flat_map(Row::locals) {
            starts[local + 2] += 1;
        }
        (1..starts.len()).for_each(|place| starts[place] += starts[place - 1]);
        rows.clear();
        rows.resize(starts.last().map_or(0, |all| *all as usize), NONE);
        for (number, row) in (0..).zip(&self.list) {
            for local in row.locals() {
                rows[starts[local + 1] as usize] = number;
                starts[local + 1] += 1;
            }
        }
    }

    /// Projects the rows of a vertex that are not kept. Tells which particles that moves, and how far [m].
    pub fn put_right(&mut self, vertex: usize, mut tell: impl FnMut(usize, Vec3)) {
        let local = self.locals[vertex];
        if local == NONE {
            return;
        }
        let [from, to] = [0, 1].map(|next| self.index.starts[local as usize + next] as usize);
        for index in from..to {
            let row = self.index.rows[index] as usize;
            self.put_row_right(row, &mut tell);
        }
    }

    /// Moves a particle, if it is in rows [m].
    pub fn shift(&mut self, particle: usize, way: Vec3) {
        let local = self.locals[particle];
        if local != NONE {
            self.d[local as usize] += way;
        }
    }
}
