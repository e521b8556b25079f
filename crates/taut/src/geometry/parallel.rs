//! Threads that never change a result.
//!
//! Work is cut into pieces whose size does not depend on the number of threads. Each piece writes its own part of the
//! output or its own partial result. Partial results are combined in the order of the pieces, or by what gives the same in any order.
//! Hence the same bits for any number of threads.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use super::Pool;
use super::pieces::{Pieces, chunks, items};
#[cfg(feature = "threads")]
use super::team;

/// Elements in a chunk. Small enough to balance two threads on a 64 x 64 cloth, large enough to hide the hand-over.
pub const CHUNK: usize = 1024;

/// How a loop is handed to threads.
#[derive(Clone, Copy)]
enum Spread {
    /// One piece after the other, by the thread that asks.
    Not,
    /// Runs of pieces, cut again where a thread has nothing to do.
    Runs,
    /// Every piece by itself: they take different times.
    Single,
}

/// Calls `work` with every index below `count`. It is compiled once, and what is done for a piece once for all ways to hand it out.
fn for_each_index(count: usize, spread: Spread, work: &(dyn Fn(usize) + Sync)) {
    #[cfg(feature = "threads")]
    {
        use rayon::prelude::*;
        match spread {
            Spread::Not => {}
            _ if team::shares(count, work) => return,
            Spread::Runs => return (0..count).into_par_iter().for_each(work),
            Spread::Single => return (0..count).into_par_iter().with_max_len(1).for_each(work),
        }
    }
    #[cfg(not(feature = "threads"))]
    let _ = spread;
    (0..count).for_each(work);
}

fn spread_over<P: Pieces>(pieces: P, spread: Spread, work: impl Fn(usize, P::Piece) + Sync) {
    // SAFETY: every index below the count comes once, and nobody else has the pieces.
    for_each_index(pieces.count(), spread, &|index| work(index, unsafe { pieces.piece(index) }));
}

/// Calls `work` with the number of each piece and the piece, on the threads of the pool that is installed if `in_parallel`.
pub fn for_each_piece<P: Pieces>(pieces: P, in_parallel: bool, work: impl Fn(usize, P::Piece) + Sync) {
    spread_over(pieces, if in_parallel { Spread::Runs } else { Spread::Not }, work);
}

/// Adds up what `each` returns for the number of each piece and the piece, in any order, on the threads of the pool that is installed
/// if `in_parallel`. `add` must give the same bits in any order, and leave what `zero` is added to as it is.
pub fn sum_in_any_order<P: Pieces, R: Copy + Send>(
    pieces: P,
    in_parallel: bool,
    zero: R,
    each: impl Fn(usize, P::Piece) -> R + Sync,
    add: impl Fn(R, R) -> R + Sync,
) -> R {
    let sum = Mutex::new(zero);
    for_each_piece(pieces, in_parallel, |index, piece| {
        let part = each(index, piece);
        let mut sum = sum.lock().unwrap_or_else(PoisonError::into_inner);
        *sum = add(*sum, part);
    });
    sum.into_inner().unwrap_or_else(PoisonError::into_inner)
}

/// As [`sum_in_any_order`], of what `each` returns for runs of some values.
pub fn sum_of_runs<R: Copy + Send>(
    values: &[f32],
    pool: &Pool,
    zero: R,
    each: impl Fn(&[f32]) -> R + Sync,
    add: impl Fn(R, R) -> R + Sync,
) -> R {
    const RUN: usize = 4 * CHUNK;
    let run = |index| &values[index * RUN..values.len().min((index + 1) * RUN)];
    let runs = 0..values.len().div_ceil(RUN);
    sum_in_any_order(runs, pool.pays_for(values.len()), zero, |_, index| each(run(index)), add)
}

/// Calls `work` with the number of each part and the part, on the pool's threads where that pays for all `len` elements of the parts.
pub fn for_each_part<T: Send>(parts: &mut [T], len: usize, pool: &Pool, work: impl Fn(usize, &mut T) + Sync) {
    spread_over(items(parts), if pool.pays_for(len) { Spread::Single } else { Spread::Not }, work);
}

/// Calls `work` with the first index and the elements of every chunk, on the pool's threads where that pays.
pub fn for_each_chunk<T: Send>(items: &mut [T], pool: &Pool, work: impl Fn(usize, &mut [T]) + Sync) {
    let in_parallel = pool.pays_for(items.len());
    for_each_piece(chunks(items, CHUNK), in_parallel, |chunk, items| work(chunk * CHUNK, items));
}

/// As [`for_each_chunk`], for two slices of the same length.
pub fn for_each_two_chunks<T: Send, U: Send>(
    items: &mut [T],
    others: &mut [U],
    pool: &Pool,
    work: impl Fn(usize, &mut [T], &mut [U]) + Sync,
) {
    for_each_of_both(items, others, 1, pool, work);
}

/// As [`for_each_two_chunks`], where each item has `each` of the others; the last one may have fewer.
pub fn for_each_of_both<T: Send, U: Send>(
    items: &mut [T],
    others: &mut [U],
    each: usize,
    pool: &Pool,
    work: impl Fn(usize, &mut [T], &mut [U]) + Sync,
) {
    let (length, in_parallel) = (CHUNK / each, pool.pays_for(others.len()));
    let both = (chunks(items, length), chunks(others, each * length));
    for_each_piece(both, in_parallel, |chunk, (items, others)| work(chunk * length, items, others));
}

/// Adds up what `work` returns for every chunk of `len` elements, in the order of the chunks. `parts` has a place for each chunk.
pub fn sum_of_chunks<const N: usize>(
    len: usize,
    parts: &mut [[f64; N]],
    pool: &Pool,
    work: impl Fn(Range<usize>) -> [f64; N] + Sync,
) -> [f64; N] {
    let parts = &mut parts[..len.div_ceil(CHUNK)];
    for_each_piece(items(parts), pool.pays_for(len), |chunk, part| {
        *part = work(chunk * CHUNK..len.min((chunk + 1) * CHUNK));
    });
    parts.iter().fold([0.0; N], |sums, part| std::array::from_fn(|index| sums[index] + part[index]))
}

/// As [`for_each_chunk`]; adds up what `work` returns in the order of the chunks. `parts` has a place for each chunk.
pub fn sum_over_chunks<T: Send>(
    run: &mut [T],
    parts: &mut [f64],
    pool: &Pool,
    work: impl Fn(usize, &mut [T]) -> f64 + Sync,
) -> f64 {
    let in_parallel = pool.pays_for(run.len());
    let both = (chunks(run, CHUNK), items(parts));
    for_each_piece(both, in_parallel, |chunk, (run, part)| *part = work(chunk * CHUNK, run));
    parts.iter().sum()
}
