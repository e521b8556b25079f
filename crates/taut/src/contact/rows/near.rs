//! Rows that are not kept, and those beside them: where a whole cloth hangs on a corner they need many more sweeps than all others.

use glam::Vec3;

use super::Rows;

/// Rows, and the places in the workspace of their vertices.
#[derive(Debug, Default)]
pub(super) struct Near {
    rows: Vec<u32>,
    locals: Vec<u32>,
    /// Whether a place is one of a row that is not kept, or among `locals`.
    is_unkept: Vec<bool>,
    is_taken: Vec<bool>,
}

impl Rows {
    /// Finds the rows that are not kept, and all that share a vertex with one of them. Returns whether there are any, but only few.
    pub fn find_unkept(&mut self, most: usize) -> bool {
        let mut near = std::mem::take(&mut self.near);
        let Near { rows, locals, is_unkept, is_taken } = &mut near;
        rows.clear();
        locals.clear();
        for flags in [&mut *is_unkept, &mut *is_taken] {
            flags.clear();
            flags.resize(self.vertices.len(), false);
        }
        let mut count = 0;
        for row in self.list.iter().filter(|row| !self.is_kept(row)) {
            count += 1;
            row.locals().filter(|&local| self.weights[local] > 0.0).for_each(|local| is_unkept[local] = true);
        }
        let is_few = (1..=most).contains(&count);
        if is_few {
            let is_near = |row: u32| self.list[row as usize].locals().any(|local| is_unkept[local]);
            rows.extend((0..self.list.len() as u32).filter(|&row| is_near(row)));
            for local in rows.iter().flat_map(|&row| self.list[row as usize].locals()) {
                if !std::mem::replace(&mut is_taken[local], true) {
                    locals.push(local as u32);
                }
            }
        }
        self.near = near;
        is_few
    }

    /// The particles of these rows.
    pub fn near_particles(&self) -> impl Iterator<Item = usize> {
        let all = self.near.places().map(|local| self.vertices[local] as usize);
        all.filter(|&vertex| vertex < self.particles)
    }

    /// Takes the displacements that these particles have so far [m].
    pub fn gather_near(&mut self, displacement: impl Fn(usize) -> Vec3) {
        let Self { near, vertices, d, before, particles, .. } = self;
        for local in near.places() {
            let vertex = vertices[local] as usize;
            if vertex < *particles {
                d[local] = displacement(vertex);
            }
            before[local] = d[local];
        }
    }

    /// Projects these rows.
    pub fn sweep_near(&mut self) {
        for &row in &self.near.rows {
            self.list[row as usize].project(&mut self.d, &self.weights);
        }
    }

    /// Tells which of these particles have moved since, and how far [m].
    pub fn scatter_near(&self, mut shift: impl FnMut(usize, Vec3)) {
        for local in self.near.places().filter(|&local| self.d[local] != self.before[local]) {
            shift(self.vertices[local] as usize, self.d[local] - self.before[local]);
        }
    }
}

impl Near {
    fn places(&self) -> impl Iterator<Item = usize> {
        self.locals.iter().map(|&local| local as usize)
    }
}
