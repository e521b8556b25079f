//! Springs of a regular grid, a row at a time: neighbours stand at fixed distances in memory.
//!
//! Every spring is looked at once, together with the other springs that leave the same row: those along it and those that
//! rise to the row above. Rows are kept with a length that is a whole number of vector registers, and each register is loaded
//! once: that of the right neighbours is put together from two. The lanes that fill up a row have springs of no strength.
//!
//! The sum at a particle has three terms: its own springs, those of its left neighbour, and what rose from below. They are added in
//! this order, in whatever way the rows are walked over. Hence the bits are always the same.

use pulp::Simd;

use super::law::Law;
use crate::geometry::{Block, Rows, fill_column, register, registers, set_registers};
use crate::model::Lattice;

/// Three coordinates.
pub(crate) type Three<T> = [T; 3];

/// The constants of a law on a lattice, filled up with zeros.
#[derive(Debug)]
pub(crate) struct RowConstants {
    /// Along the bottom row, a row inside and the top row.
    along: Rows<2>,
    /// From every row to the next: straight up, up to the right and up to the left.
    upward: Rows<6>,
    rows: usize,
    columns: usize,
}

impl RowConstants {
    pub fn new<L: Law>(law: L, lattice: &Lattice) -> Self {
        let (mut along, mut upward) = (Rows::zeros(3, lattice.columns), Rows::zeros(1, lattice.columns));
        for (index, run) in lattice.along.iter().enumerate() {
            law.constants(run).into_iter().enumerate().for_each(|(kind, run)| fill_column(along.row_mut(index), kind, run));
        }
        let runs = lattice.upward.iter().flat_map(|run| law.constants(run));
        runs.enumerate().for_each(|(column, run)| fill_column(upward.row_mut(0), column, run));
        Self { along, upward, rows: lattice.rows, columns: lattice.columns }
    }
}

/// Who has the row that springs leave and the row above, and takes the sums.
pub(crate) trait Sums<S: Simd> {
    /// The field at register `i` of the row.
    fn field(&self, simd: S, i: usize) -> Three<S::f32s>;
    /// The field at register `i` of the row above; not asked for at the top row.
    fn above(&self, simd: S, i: usize) -> Three<S::f32s>;
    /// Takes the sums of register `i`; its field is not asked for again.
    fn take(&mut self, simd: S, i: usize, sum: Three<S::f32s>);
}

/// Hands the sums of `row` to `sums`: the springs that leave it, and what `rose` to it from below. What rises to the row
/// above, if there is one, is written to `rising`.
#[inline(always)]
pub(crate) fn springs_of_row<S: Simd, L: Law>(
    simd: S,
    law: L,
    constants: &RowConstants,
    row: usize,
    (rose, rising): (&[Block<3>], &mut [Block<3>]),
    sums: &mut impl Sums<S>,
) {
    let count = constants.columns.div_ceil(S::F32_LANES);
    let along = constants.along.row(if row == 0 { 0 } else { 1 + usize::from(row + 1 == constants.rows) });
    let pair = |i: usize| [register::<S, 2>(along, 0, i), register::<S, 2>(along, 1, i)];
    let zero = [simd.splat_f32s(0.0); 3];
    let mut own = sums.field(simd, 0);
    let mut left = zero;
    if row + 1 == constants.rows {
        for i in 0..count {
            let next = sums.field(simd, (i + 1).min(count - 1));
            let [force] = pulls(simd, law, [sub(simd, shift_left(simd, own, next), own)], [pair(i)]);
            let sum = sub(simd, force, shift_right(simd, left, force));
            sums.take(simd, i, sub(simd, sum, registers::<S, 3>(rose, 0, i)));
            (own, left) = (next, force);
        }
        return;
    }
    let upward = constants.upward.row(0);
    let upward = |run: usize, i: usize| [register::<S, 6>(upward, 2 * run, i), register::<S, 6>(upward, 2 * run + 1, i)];
    let mut up = sums.above(simd, 0);
    let mut up_left = zero;
    for i in 0..count {
        let next = (i + 1).min(count - 1);
        let (next_own, next_up) = (sums.field(simd, next), sums.above(simd, next));
        let right = shift_left(simd, own, next_own);
        let ways =
            [sub(simd, right, own), sub(simd, up, own), sub(simd, shift_left(simd, up, next_up), own), sub(simd, up, right)];
        let [along, straight, slash, back] = pulls(simd, law, ways, [pair(i), upward(0, i), upward(1, i), upward(2, i)]);
        let on_own = add(simd, add(simd, along, straight), slash);
        let on_right = sub(simd, back, along);
        let sum = add(simd, on_own, shift_right(simd, left, on_right));
        sums.take(simd, i, sub(simd, sum, registers::<S, 3>(rose, 0, i)));
        let rises = add(simd, add(simd, straight, back), shift_right(simd, up_left, slash));
        set_registers::<S, 3>(rising, 0, i, rises);
        (own, up, left, up_left) = (next_own, next_up, on_right, slash);
    }
}

/// The forces of springs along these differences.
#[inline(always)]
fn pulls<S: Simd, L: Law, const N: usize>(
    simd: S,
    law: L,
    differences: [Three<S::f32s>; N],
    constants: [[S::f32s; 2]; N],
) -> [Three<S::f32s>; N] {
    let factors = law.factors(simd, &differences, constants);
    let mut forces = differences;
    for (force, factor) in forces.iter_mut().zip(factors) {
        *force = [simd.mul_f32s(force[0], factor), simd.mul_f32s(force[1], factor), simd.mul_f32s(force[2], factor)];
    }
    forces
}

#[inline(always)]
fn add<S: Simd>(simd: S, a: Three<S::f32s>, b: Three<S::f32s>) -> Three<S::f32s> {
    [simd.add_f32s(a[0], b[0]), simd.add_f32s(a[1], b[1]), simd.add_f32s(a[2], b[2])]
}

#[inline(always)]
fn sub<S: Simd>(simd: S, a: Three<S::f32s>, b: Three<S::f32s>) -> Three<S::f32s> {
    [simd.sub_f32s(a[0], b[0]), simd.sub_f32s(a[1], b[1]), simd.sub_f32s(a[2], b[2])]
}

/// The right neighbours of a register, `next` being the one after it.
#[inline(always)]
fn shift_left<S: Simd>(simd: S, own: Three<S::f32s>, next: Three<S::f32s>) -> Three<S::f32s> {
    let first = simd.mask_between_m32s(0, 1).mask();
    let shift = |own, next| simd.rotate_left_f32s(simd.select_f32s(first, next, own), 1);
    [shift(own[0], next[0]), shift(own[1], next[1]), shift(own[2], next[2])]
}

/// What each lane's left neighbour has, `left` being the register before.
#[inline(always)]
fn shift_right<S: Simd>(simd: S, left: Three<S::f32s>, own: Three<S::f32s>) -> Three<S::f32s> {
    let lanes = S::F32_LANES as u32;
    let last = simd.mask_between_m32s(lanes - 1, lanes).mask();
    let shift = |left, own| simd.rotate_right_f32s(simd.select_f32s(last, left, own), 1);
    [shift(left[0], own[0]), shift(left[1], own[1]), shift(left[2], own[2])]
}
