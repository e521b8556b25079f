//! One impulse on all particles of a grid, in bands of rows.
//!
//! Bands are independent: each begins with the springs that rise to it from below, so that no band waits for another and
//! no sum depends on the number of threads.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::Impulse;
use super::law::Law;
use super::row::{RowConstants, Sums, Three, springs_of_row};
use crate::geometry::{Block, LINE, Pool, Rows, Vectors, VectorsChunk, arch, fill_column, registers, set_registers};
use crate::model::{Lattice, Model};

/// Rows in a band.
const BAND: usize = 16;

/// Rows that a band works with: two of the field, what rose, what rises, and the sums.
const ROWS: usize = 5;

/// Workspace of a lattice and a law.
#[derive(Debug)]
pub(super) struct Workspace {
    constants: RowConstants,
    bands: Vec<Rows<3>>,
}

impl Workspace {
    pub fn new<L: Law>(law: L, lattice: &Lattice) -> Self {
        let bands = (0..lattice.rows.div_ceil(BAND)).map(|_| Rows::zeros(ROWS, lattice.columns)).collect();
        Self { constants: RowConstants::new(law, lattice), bands }
    }
}

/// Writes `out` for the particles of a lattice.
pub(super) fn apply<L: Law>(law: L, impulse: Impulse<'_>, model: &Model, lattice: &Lattice, work: &mut Workspace, pool: &Pool) {
    let Impulse { field, other, out, keep, add, scale } = impulse;
    let particles = lattice.first..lattice.first + lattice.columns * lattice.rows;
    let weights = &model.particles.inverse_mass;
    let Workspace { constants, bands } = work;
    out.for_each_band(particles, BAND * lattice.columns, bands, pool, |out, rows| {
        let factors = [keep, add, scale];
        arch().dispatch(Band { law, lattice, constants, field, other, weights, out, factors, rows });
    });
}

/// Some rows of a lattice.
struct Band<'a, L> {
    law: L,
    lattice: &'a Lattice,
    constants: &'a RowConstants,
    field: &'a Vectors,
    other: &'a Vectors,
    /// Inverse masses [1/kg].
    weights: &'a [f32],
    out: VectorsChunk<'a>,
    /// What is kept of `out`, how much of `other` and of the forces is added.
    factors: [f32; 3],
    rows: &'a mut Rows<3>,
}

impl<L: Law> WithSimd for Band<'_, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { law, lattice, constants, field, other, weights, mut out, factors, rows } = self;
        let Lattice { first, columns, .. } = *lattice;
        let begin = (out.first - first) / columns;
        let end = begin + out.x.len() / columns;
        let row_of = |row: usize| first + row * columns..first + (row + 1) * columns;
        let [mut here, mut above, mut rose, mut rising, sums] = rows.first_mut::<ROWS>();
        rose.fill([[0.0; LINE]; 3]);
        // The row below the band is gone through for what rises from it.
        let start = begin.saturating_sub(1);
        copy_row(field, row_of(start), here);
        for row in start..end {
            if row + 1 < lattice.rows {
                copy_row(field, row_of(row + 1), above);
            }
            springs_of_row(simd, law, constants, row, (rose, rising), &mut Keep { field: here, above, sums });
            if row >= begin {
                finish(sums, other, weights, row_of(row), &mut out, factors);
            }
            std::mem::swap(&mut here, &mut above);
            std::mem::swap(&mut rose, &mut rising);
        }
    }
}

/// Keeps sums for later.
struct Keep<'a> {
    field: &'a [Block<3>],
    above: &'a [Block<3>],
    sums: &'a mut [Block<3>],
}

impl<S: Simd> Sums<S> for Keep<'_> {
    #[inline(always)]
    fn field(&self, _: S, i: usize) -> Three<S::f32s> {
        registers::<S, 3>(self.field, 0, i)
    }

    #[inline(always)]
    fn above(&self, _: S, i: usize) -> Three<S::f32s> {
        registers::<S, 3>(self.above, 0, i)
    }

    #[inline(always)]
    fn take(&mut self, _: S, i: usize, sum: Three<S::f32s>) {
        set_registers::<S, 3>(self.sums, 0, i, sum);
    }
}

#[inline(always)]
fn copy_row(field: &Vectors, row: Range<usize>, to: &mut [Block<3>]) {
    fill_column(to, 0, &field.x[row.clone()]);
    fill_column(to, 1, &field.y[row.clone()]);
    fill_column(to, 2, &field.z[row]);
}

/// The sums of a row are complete: writes its part of `out`.
#[inline(always)]
fn finish(
    sums: &[Block<3>],
    other: &Vectors,
    weights: &[f32],
    row: Range<usize>,
    out: &mut VectorsChunk<'_>,
    [keep, add, scale]: [f32; 3],
) {
    let place = row.start - out.first..row.end - out.first;
    let weights = &weights[row.clone()];
    for (axis, (out, other)) in
        [(&mut *out.x, &other.x), (&mut *out.y, &other.y), (&mut *out.z, &other.z)].into_iter().enumerate()
    {
        let (out, other) = (&mut out[place.clone()], &other[row.clone()]);
        let lines = out.chunks_mut(LINE).zip(other.chunks(LINE)).zip(weights.chunks(LINE)).zip(sums);
        for (((out, other), weights), sums) in lines {
            let terms = other.iter().zip(weights).zip(&sums[axis]);
            for (out, ((other, weight), sum)) in out.iter_mut().zip(terms) {
                *out = *out * keep + *other * add + *sum * (*weight * scale);
            }
        }
    }
}
