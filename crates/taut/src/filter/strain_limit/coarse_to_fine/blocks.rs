//! A sparse symmetric matrix of 3 x 3 blocks, a row of them for each particle that may move.

use glam::{DMat3, DVec3};

use super::super::cholesky::Cholesky;
use crate::model::Adjacency;

/// The matrix, and its factor.
pub(super) struct Blocks {
    /// First entry of each column, the rows of the entries, and the entries of the upper triangle.
    columns: Vec<u32>,
    rows: Vec<u32>,
    values: Vec<f64>,
    cholesky: Cholesky,
}

impl Blocks {
    /// With blocks on its diagonal, and others for such pairs of its `count` columns; none if it is too large.
    pub fn new(count: usize, pairs: impl Iterator<Item = [u32; 2]> + Clone) -> Option<Self> {
        let around = Adjacency::new(count, pairs.map(|[u, v]| (u.max(v), u.min(v))));
        let (mut columns, mut rows) = (vec![0], Vec::new());
        for column in 0..count {
            let mut above = around.of(column).to_vec();
            above.sort_unstable();
            above.dedup();
            for axis in 0..3 {
                rows.extend(above.iter().flat_map(|row| 3 * row..3 * row + 3));
                rows.extend((0..=axis).map(|other| 3 * column as u32 + other));
                columns.push(rows.len() as u32);
            }
        }
        let cholesky = Cholesky::new(columns.clone(), rows.clone())?;
        Some(Self { values: vec![0.0; rows.len()], columns, rows, cholesky })
    }

    /// Where the block of two different columns is in the later one, if there is one.
    pub fn place(&self, [u, v]: [u32; 2]) -> Option<u32> {
        let (first, above) = (3 * u.max(v) as usize, 3 * u.min(v));
        let column = &self.rows[self.columns[first] as usize..self.columns[first + 1] as usize - 1];
        let at = column.partition_point(|row| *row < above);
        (column.get(at) == Some(&above)).then_some(at as u32 / 3)
    }

    /// Begins anew, with such entries on the diagonal.
    pub fn begin(&mut self, diagonal: impl Iterator<Item = f64>) {
        self.values.fill(0.0);
        for (column, entry) in diagonal.enumerate() {
            for axis in 0..3 {
                // The last entry of a column lies on the diagonal.
                self.values[self.columns[3 * column + axis + 1] as usize - 1] = entry;
            }
        }
    }

    /// Adds a symmetric block on the diagonal.
    pub fn add(&mut self, column: u32, block: &DMat3) {
        for axis in 0..3 {
            let end = self.columns[3 * column as usize + axis + 1] as usize;
            for row in 0..=axis {
                self.values[end - 1 - axis + row] += block.col(axis)[row];
            }
        }
    }

    /// Adds a block at a place in the later of two columns; its rows are of the earlier one.
    pub fn add_between(&mut self, [u, v]: [u32; 2], place: u32, block: &DMat3) {
        for axis in 0..3 {
            let first = self.columns[3 * u.max(v) as usize + axis] as usize + 3 * place as usize;
            for row in 0..3 {
                self.values[first + row] += block.col(axis)[row];
            }
        }
    }

    /// Factorises it. Returns false if it is not positive definite.
    pub fn factorise(&mut self) -> bool {
        self.cholesky.factorise(&self.values)
    }

    /// Replaces a right side by the solution.
    pub fn solve(&mut self, right: &mut [f64]) {
        self.cholesky.solve(right);
    }
}

/// The place of a column in a vector.
pub(super) fn of(vector: &[f64], column: u32) -> DVec3 {
    DVec3::from_slice(&vector[3 * column as usize..])
}

/// Adds to it.
pub(super) fn add_to(vector: &mut [f64], column: u32, what: DVec3) {
    let place = &mut vector[3 * column as usize..][..3];
    (DVec3::from_slice(place) + what).write_to_slice(place);
}

/// a b^T.
pub(super) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}
