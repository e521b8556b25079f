//! Several parts of a step in one walk over a grid.
//!
//! A part looks at every particle of the cloth and does little with it, so that memory would set the pace. But a row needs
//! nothing of a part beyond its two neighbours: as soon as one part has left the row above, the next part may take it.
//! The parts follow one another up the rows, and what they share stays in the cache. With several threads, each leads some
//! of the parts and keeps behind the thread whose parts come before. The arithmetic of a row is the same in any case.

use std::hint::spin_loop;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::yield_now;

use pulp::{Arch, Simd, WithSimd};

use super::Part;
use crate::forces::{Hooke, RowConstants, Sums, Three, springs_of_row};
use crate::geometry::{
    Block, LINE, Pool, Rows, SharedRows, SharedVectors, Vectors, copy_column, fill_column, register, registers, set_registers,
};
use crate::model::{Lattice, Model};

/// Rows that the parts of one group work on together should stay in a cache of this size [bytes].
const CACHE: usize = 256 * 1024;
/// Where columns of a row in memory begin: positions, velocities, accelerations, inverse masses.
const POSITION: usize = 0;
const VELOCITY: usize = 3;
const ACCELERATION: usize = 6;
const WEIGHT: usize = 9;
/// How many columns there are.
const COLUMNS: usize = 10;

/// A grid on its way through the parts of a step.
#[derive(Debug)]
pub(super) struct Wave {
    constants: RowConstants,
    rows: Rows<COLUMNS>,
    /// For every part that a thread leads at the same time, what rises to even and to odd rows.
    rising: Vec<Mutex<Rows<3>>>,
    /// How many rows the last part of each group has finished.
    finished: Vec<AtomicUsize>,
    /// Parts in a group.
    group: usize,
}

/// Where a step begins and where it leads.
pub(super) struct Step<'a> {
    pub lattice: &'a Lattice,
    /// How long positions drift before the first part [s].
    pub before: f32,
    pub parts: &'a [Part],
    /// How far ahead springs look [s].
    pub ahead: f32,
    /// F_EXT / M [m/s^2].
    pub acceleration: &'a Vectors,
    pub positions: &'a Vectors,
    pub ends: &'a mut Vectors,
    pub velocities: &'a mut Vectors,
}

impl Wave {
    /// The lattice of a model, for so many parts.
    pub fn new(model: &Model, lattice: &Lattice, parts: usize, threads: usize) -> Self {
        let mut rows = Rows::zeros(lattice.rows, lattice.columns);
        for row in 0..lattice.rows {
            let weights = &model.particles.inverse_mass[lattice.first + row * lattice.columns..][..lattice.columns];
            fill_column(rows.row_mut(row), WEIGHT, weights);
        }
        // A part has two rows in hand, and what rises from one of them.
        let fitting = (CACHE / (size_of::<f32>() * (2 * COLUMNS + 6) * lattice.columns.next_multiple_of(LINE))).max(1);
        let rounds = parts.div_ceil(fitting * threads);
        let group = parts.div_ceil(rounds * threads);
        Self {
            rising: (0..threads).map(|_| Mutex::new(Rows::zeros(2 * group, lattice.columns))).collect(),
            finished: (0..parts.div_ceil(group)).map(|_| AtomicUsize::new(0)).collect(),
            constants: RowConstants::new(Hooke, lattice),
            rows,
            group,
        }
    }

    /// Takes positions and velocities through all parts.
    pub fn run(&mut self, step: Step<'_>, pool: &Pool) {
        let Self { constants, rows, rising, finished, group } = self;
        finished.iter().for_each(|rows| rows.store(0, Ordering::Relaxed));
        let Step { lattice, before, parts, ahead, acceleration, positions, ends, velocities } = step;
        let (rows, ends, velocities) = (rows.shared(), ends.shared(), velocities.shared());
        let outside = Outside { lattice, before, acceleration, positions, ends, velocities };
        pool.on_each_thread(|thread, threads| {
            let Some(rising) = rising.get(thread) else { return };
            let Ok(mut rising) = rising.lock() else { return };
            for (number, parts) in parts.chunks(*group).enumerate().skip(thread).step_by(threads) {
                let before = number.checked_sub(1).map(|before| &finished[before]);
                let last = number + 1 == finished.len();
                let finished = &finished[number];
                let rising = &mut rising;
                if ahead > 0.0 {
                    let group =
                        Group::<true> { outside: &outside, constants, rows, parts, ahead, before, last, finished, rising };
                    Arch::new().dispatch(group);
                } else {
                    let group =
                        Group::<false> { outside: &outside, constants, rows, parts, ahead, before, last, finished, rising };
                    Arch::new().dispatch(group);
                }
            }
        });
    }
}

/// What the first part takes from and the last part gives to the state.
struct Outside<'a> {
    lattice: &'a Lattice,
    before: f32,
    acceleration: &'a Vectors,
    positions: &'a Vectors,
    ends: SharedVectors<'a>,
    velocities: SharedVectors<'a>,
}

impl Outside<'_> {
    /// Takes a row in.
    ///
    /// # Safety
    /// Nobody writes the row's velocities meanwhile.
    #[inline(always)]
    unsafe fn load(&self, row: usize, to: &mut [Block<COLUMNS>]) {
        let columns = self.lattice.columns;
        let run = self.lattice.first + row * columns..self.lattice.first + (row + 1) * columns;
        // SAFETY: the run is there; the caller keeps writers away.
        let velocities = unsafe { self.velocities.run(run.start, columns) };
        let positions = [&self.positions.x[run.clone()], &self.positions.y[run.clone()], &self.positions.z[run.clone()]];
        let accelerations = [&self.acceleration.x[run.clone()], &self.acceleration.y[run.clone()], &self.acceleration.z[run]];
        for axis in 0..3 {
            let lines = positions[axis].chunks(LINE).zip(velocities[axis].chunks(LINE)).zip(&mut *to);
            for ((positions, velocities), block) in lines {
                for (x, (position, velocity)) in block[POSITION + axis].iter_mut().zip(positions.iter().zip(velocities)) {
                    *x = position + velocity * self.before;
                }
            }
            fill_column(to, VELOCITY + axis, velocities[axis]);
            fill_column(to, ACCELERATION + axis, accelerations[axis]);
        }
    }

    /// Gives a row back.
    ///
    /// # Safety
    /// Nobody else touches the row's ends and velocities meanwhile.
    #[inline(always)]
    unsafe fn store(&self, row: usize, from: &[Block<COLUMNS>]) {
        let columns = self.lattice.columns;
        let first = self.lattice.first + row * columns;
        // SAFETY: the run is there; the caller keeps all others away.
        let (ends, velocities) = unsafe { (self.ends.run_mut(first, columns), self.velocities.run_mut(first, columns)) };
        for (axis, (ends, velocities)) in ends.into_iter().zip(velocities).enumerate() {
            copy_column(from, POSITION + axis, ends);
            copy_column(from, VELOCITY + axis, velocities);
        }
    }
}

/// Parts that follow one another closely; whether springs look ahead.
struct Group<'a, const AHEAD: bool> {
    outside: &'a Outside<'a>,
    constants: &'a RowConstants,
    rows: SharedRows<'a, COLUMNS>,
    parts: &'a [Part],
    ahead: f32,
    /// Rows that the group before has finished; none before the first.
    before: Option<&'a AtomicUsize>,
    last: bool,
    finished: &'a AtomicUsize,
    rising: &'a mut Rows<3>,
}

impl<const AHEAD: bool> WithSimd for Group<'_, AHEAD> {
    type Output = ();

    /// The first part is at row `time`, each further part one row behind.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { outside, constants, rows, parts, ahead, before, last, finished, rising } = self;
        let ahead = simd.splat_f32s(ahead);
        let height = outside.lattice.rows;
        let rising = rising.shared();
        for time in 0..height + parts.len() - 1 {
            // The first part needs this row and the one above.
            let needed = (time + 2).min(height);
            match before {
                Some(before) => wait(before, needed),
                None => {
                    for row in if time == 0 { 0 } else { (time + 1).min(height) }..needed {
                        // SAFETY: no part has reached this row yet.
                        unsafe { outside.load(row, rows.row_mut(row)) };
                    }
                }
            }
            for (index, part) in parts.iter().enumerate() {
                let Some(row) = time.checked_sub(index).filter(|row| *row < height) else { continue };
                // SAFETY: this part is at this row and has finished those below; the parts before it have finished this
                // row and the one above, and will not come back; those behind have not reached them. What rises is the
                // part's own.
                let (here, above, rose, rises) = unsafe {
                    let above: &[Block<COLUMNS>] = if row + 1 < height { rows.row(row + 1) } else { &[] };
                    (rows.row_mut(row), above, rising.row_mut(2 * index + row % 2), rising.row_mut(2 * index + (row + 1) % 2))
                };
                if row == 0 {
                    rose.fill([[0.0; LINE]; 3]);
                }
                let (kick, after) = (simd.splat_f32s(part.kick), simd.splat_f32s(part.after));
                let mut leap = Leap::<S, AHEAD> { row: here, above, ahead, kick, after };
                springs_of_row(simd, Hooke, constants, row, (rose, rises), &mut leap);
            }
            if let Some(done) = (time + 1).checked_sub(parts.len()) {
                if last {
                    // SAFETY: all parts have finished this row.
                    unsafe { outside.store(done, rows.row(done)) };
                }
                finished.store(done + 1, Ordering::Release);
            }
        }
    }
}

/// Waits until another thread has finished `rows` rows.
#[inline(always)]
fn wait(finished: &AtomicUsize, rows: usize) {
    const PATIENCE: usize = 2000;
    let mut turns = 0;
    while finished.load(Ordering::Acquire) < rows {
        turns += 1;
        if turns < PATIENCE { spin_loop() } else { yield_now() }
    }
}

/// A row on its way through one part: `V += (F_s / M + F_EXT / M) h`, then `X += V h'`.
struct Leap<'a, S: Simd, const AHEAD: bool> {
    row: &'a mut [Block<COLUMNS>],
    above: &'a [Block<COLUMNS>],
    ahead: S::f32s,
    kick: S::f32s,
    after: S::f32s,
}

/// Where springs see the particles of a register.
#[inline(always)]
fn seen<S: Simd, const AHEAD: bool>(simd: S, row: &[Block<COLUMNS>], i: usize, ahead: S::f32s) -> Three<S::f32s> {
    let [x, y, z] = registers::<S, COLUMNS>(row, POSITION, i);
    if !AHEAD {
        return [x, y, z];
    }
    let [u, v, w] = registers::<S, COLUMNS>(row, VELOCITY, i);
    [
        simd.add_f32s(x, simd.mul_f32s(u, ahead)),
        simd.add_f32s(y, simd.mul_f32s(v, ahead)),
        simd.add_f32s(z, simd.mul_f32s(w, ahead)),
    ]
}

impl<S: Simd, const AHEAD: bool> Sums<S> for Leap<'_, S, AHEAD> {
    #[inline(always)]
    fn field(&self, simd: S, i: usize) -> Three<S::f32s> {
        seen::<S, AHEAD>(simd, self.row, i, self.ahead)
    }

    #[inline(always)]
    fn above(&self, simd: S, i: usize) -> Three<S::f32s> {
        seen::<S, AHEAD>(simd, self.above, i, self.ahead)
    }

    #[inline(always)]
    fn take(&mut self, simd: S, i: usize, force: Three<S::f32s>) {
        let mut position = registers::<S, COLUMNS>(self.row, POSITION, i);
        let mut velocity = registers::<S, COLUMNS>(self.row, VELOCITY, i);
        let acceleration = registers::<S, COLUMNS>(self.row, ACCELERATION, i);
        let weight = simd.mul_f32s(register::<S, COLUMNS>(self.row, WEIGHT, i), self.kick);
        for axis in 0..3 {
            let pushed = simd.add_f32s(velocity[axis], simd.mul_f32s(acceleration[axis], self.kick));
            velocity[axis] = simd.add_f32s(pushed, simd.mul_f32s(force[axis], weight));
            position[axis] = simd.add_f32s(position[axis], simd.mul_f32s(velocity[axis], self.after));
        }
        set_registers::<S, COLUMNS>(self.row, POSITION, i, position);
        set_registers::<S, COLUMNS>(self.row, VELOCITY, i, velocity);
    }
}
