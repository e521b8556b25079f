//! Springs of a regular grid, a row at a time: neighbours stand at fixed distances in memory.
//!
//! Every spring is looked at once. A row's sums are complete when the springs that come up from the row below, those along
//! it and those that leave it upwards have been added. Bands of rows are independent: each begins with the springs that
//! come up into it, so that no band waits for another and no sum depends on the number of threads.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::Impulse;
use super::law::Law;
use crate::geometry::{Pool, Vectors, VectorsChunk};
use crate::model::{Lattice, Model, SpringRun};

/// Rows in a band.
const BAND: usize = 16;

/// Workspace of a lattice: for every band, the sums of two rows and the forces along one.
#[derive(Debug)]
pub(super) struct Sums {
    bands: Vec<[Vectors; 3]>,
}

impl Sums {
    pub fn new(lattice: &Lattice) -> Self {
        let band = || std::array::from_fn(|_| Vectors::zeros(lattice.columns));
        Self { bands: (0..lattice.rows.div_ceil(BAND)).map(|_| band()).collect() }
    }
}

/// Writes `out` for the particles of a lattice.
pub(super) fn apply<L: Law>(law: L, impulse: Impulse<'_>, model: &Model, lattice: &Lattice, sums: &mut Sums, pool: &Pool) {
    let Impulse { field, other, out, keep, add, scale } = impulse;
    let particles = lattice.first..lattice.first + lattice.columns * lattice.rows;
    let weights = &model.particles.inverse_mass;
    out.for_each_band(particles, BAND * lattice.columns, &mut sums.bands, pool, |out, sums| {
        Arch::new().dispatch(Band { law, lattice, field, other, weights, out, factors: [keep, add, scale], sums });
    });
}

/// Some rows of a lattice.
struct Band<'a, L> {
    law: L,
    lattice: &'a Lattice,
    field: &'a Vectors,
    other: &'a Vectors,
    /// Inverse masses [1/kg].
    weights: &'a [f32],
    out: VectorsChunk<'a>,
    /// What is kept of `out`, how much of `other` and of the forces is added.
    factors: [f32; 3],
    sums: &'a mut [Vectors; 3],
}

impl<L: Law> WithSimd for Band<'_, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { law, lattice, field, other, weights, mut out, factors, sums } = self;
        let Lattice { first, columns, rows, .. } = *lattice;
        let begin = (out.first - first) / columns;
        let [here, above, forces] = sums;
        let (mut here, mut above) = (here, above);
        clear(here);
        if begin > 0 {
            let left = first + (begin - 1) * columns;
            clear(above);
            upward(simd, law, lattice, field, left, above, here);
        }
        for row in begin..begin + out.x.len() / columns {
            let left = first + row * columns;
            clear(above);
            along(simd, law, lattice.along_row(row), field, left, here, forces);
            if row + 1 < rows {
                upward(simd, law, lattice, field, left, here, above);
            }
            finish(here, other, weights, left..left + columns, &mut out, factors);
            std::mem::swap(&mut here, &mut above);
        }
    }
}

#[inline(always)]
fn clear(sums: &mut Vectors) {
    sums.x.fill(0.0);
    sums.y.fill(0.0);
    sums.z.fill(0.0);
}

/// The springs along a row whose first particle is `left`.
#[inline(always)]
fn along<S: Simd, L: Law>(
    simd: S,
    law: L,
    run: &SpringRun,
    field: &Vectors,
    left: usize,
    sums: &mut Vectors,
    forces: &mut Vectors,
) {
    let len = run.stiffness.len();
    let [constants, more] = law.constants(run);
    let own = [&field.x, &field.y, &field.z].map(|column| S::as_simd_f32s(&column[left..left + len]));
    let next = [&field.x, &field.y, &field.z].map(|column| S::as_simd_f32s(&column[left + 1..left + 1 + len]));
    let (constants, more) = (S::as_simd_f32s(constants), S::as_simd_f32s(more));
    let [out_x, out_y, out_z] =
        [&mut forces.x, &mut forces.y, &mut forces.z].map(|column| S::as_mut_simd_f32s(&mut column[..len]));
    let heads = constants.0.len();
    for i in 0..heads {
        let ends = [own.map(|own| own.0[i]), next.map(|next| next.0[i])];
        let force = force(simd, law, ends, [constants.0[i], more.0[i]]);
        (out_x.0[i], out_y.0[i], out_z.0[i]) = (force[0], force[1], force[2]);
    }
    let ends = [own.map(|own| simd.partial_load_f32s(own.1)), next.map(|next| simd.partial_load_f32s(next.1))];
    let force = force(simd, law, ends, [simd.partial_load_f32s(constants.1), simd.partial_load_f32s(more.1)]);
    simd.partial_store_f32s(out_x.1, force[0]);
    simd.partial_store_f32s(out_y.1, force[1]);
    simd.partial_store_f32s(out_z.1, force[2]);
    for (sums, forces) in [(&mut sums.x, &forces.x), (&mut sums.y, &forces.y), (&mut sums.z, &forces.z)] {
        sums[..len].iter_mut().zip(&forces[..len]).for_each(|(sum, force)| *sum += force);
        sums[1..].iter_mut().zip(&forces[..len]).for_each(|(sum, force)| *sum -= force);
    }
}

/// The springs from the row whose first particle is `left` to the next one.
#[inline(always)]
fn upward<S: Simd, L: Law>(
    simd: S,
    law: L,
    lattice: &Lattice,
    field: &Vectors,
    left: usize,
    here: &mut Vectors,
    above: &mut Vectors,
) {
    for (run, [from, to]) in lattice.upward.iter().zip([[0, 0], [0, 1], [1, 0]]) {
        let len = run.stiffness.len();
        let [constants, more] = law.constants(run).map(|constants| S::as_simd_f32s(constants));
        let (a, b) = (left + from, left + lattice.columns + to);
        let own = [&field.x, &field.y, &field.z].map(|column| S::as_simd_f32s(&column[a..a + len]));
        let next = [&field.x, &field.y, &field.z].map(|column| S::as_simd_f32s(&column[b..b + len]));
        let plus = [&mut here.x, &mut here.y, &mut here.z].map(|column| S::as_mut_simd_f32s(&mut column[from..from + len]));
        let minus = [&mut above.x, &mut above.y, &mut above.z].map(|column| S::as_mut_simd_f32s(&mut column[to..to + len]));
        let ([plus_x, plus_y, plus_z], [minus_x, minus_y, minus_z]) = (plus, minus);
        for i in 0..constants.0.len() {
            let ends = [own.map(|own| own.0[i]), next.map(|next| next.0[i])];
            let force = force(simd, law, ends, [constants.0[i], more.0[i]]);
            plus_x.0[i] = simd.add_f32s(plus_x.0[i], force[0]);
            plus_y.0[i] = simd.add_f32s(plus_y.0[i], force[1]);
            plus_z.0[i] = simd.add_f32s(plus_z.0[i], force[2]);
            minus_x.0[i] = simd.sub_f32s(minus_x.0[i], force[0]);
            minus_y.0[i] = simd.sub_f32s(minus_y.0[i], force[1]);
            minus_z.0[i] = simd.sub_f32s(minus_z.0[i], force[2]);
        }
        let ends = [own.map(|own| simd.partial_load_f32s(own.1)), next.map(|next| simd.partial_load_f32s(next.1))];
        let force = force(simd, law, ends, [simd.partial_load_f32s(constants.1), simd.partial_load_f32s(more.1)]);
        for (target, force) in [plus_x.1, plus_y.1, plus_z.1].into_iter().zip(force) {
            let sum = simd.add_f32s(simd.partial_load_f32s(target), force);
            simd.partial_store_f32s(target, sum);
        }
        for (target, force) in [minus_x.1, minus_y.1, minus_z.1].into_iter().zip(force) {
            let sum = simd.sub_f32s(simd.partial_load_f32s(target), force);
            simd.partial_store_f32s(target, sum);
        }
    }
}

#[inline(always)]
fn force<S: Simd, L: Law>(simd: S, law: L, [own, other]: [[S::f32s; 3]; 2], constants: [S::f32s; 2]) -> [S::f32s; 3] {
    let difference = [0, 1, 2].map(|axis| simd.sub_f32s(other[axis], own[axis]));
    let factor = law.factor(simd, difference, constants);
    difference.map(|part| simd.mul_f32s(part, factor))
}

/// The sums of a row are complete: writes its part of `out`.
#[inline(always)]
fn finish(
    sums: &Vectors,
    other: &Vectors,
    weights: &[f32],
    row: Range<usize>,
    out: &mut VectorsChunk<'_>,
    [keep, add, scale]: [f32; 3],
) {
    let place = row.start - out.first..row.end - out.first;
    let weights = &weights[row.clone()];
    let columns = [(&mut *out.x, &sums.x, &other.x), (&mut *out.y, &sums.y, &other.y), (&mut *out.z, &sums.z, &other.z)];
    for (out, sums, other) in columns {
        let terms = other[row.clone()].iter().zip(weights).zip(sums);
        for (out, ((other, weight), sum)) in out[place.clone()].iter_mut().zip(terms) {
            *out = *out * keep + *other * add + *sum * (*weight * scale);
        }
    }
}
