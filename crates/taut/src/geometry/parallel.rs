//! Threads that never change a result.
//!
//! Work is cut into chunks whose size does not depend on the number of threads. Each chunk writes its own part of the
//! output or its own partial result. Partial results are combined in chunk order. Hence the same bits for any
//! number of threads.

use std::ops::Range;

use super::Pool;
use super::threads::*;

/// Elements in a chunk. Small enough to balance two threads on a 64 x 64 cloth, large enough to hide the hand-over.
pub const CHUNK: usize = 1024;

/// Calls `work` with the number of each part and the part, on the pool's threads where that pays for all `len` elements of the parts.
pub fn for_each_part<T: Send>(parts: &mut [T], len: usize, pool: &Pool, work: impl Fn(usize, &mut T) + Sync) {
    let each = |(index, part): (usize, &mut T)| work(index, part);
    if pool.pays_for(len) {
        parts.par_iter_mut().enumerate().with_max_len(1).for_each(each);
    } else {
        parts.iter_mut().enumerate().for_each(each);
    }
}

/// Calls `work` with the first index and the elements of every chunk, on the pool's threads where that pays.
pub fn for_each_chunk<T: Send>(items: &mut [T], pool: &Pool, work: impl Fn(usize, &mut [T]) + Sync) {
    let each = |(chunk, items): (usize, &mut [T])| work(chunk * CHUNK, items);
    if pool.pays_for(items.len()) {
        items.par_chunks_mut(CHUNK).enumerate().for_each(each);
    } else {
        items.chunks_mut(CHUNK).enumerate().for_each(each);
    }
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
    let length = CHUNK / each;
    let chunk = |(chunk, (items, others)): (usize, (&mut [T], &mut [U]))| work(chunk * length, items, others);
    if pool.pays_for(others.len()) {
        items.par_chunks_mut(length).zip(others.par_chunks_mut(each * length)).enumerate().for_each(chunk);
    } else {
        items.chunks_mut(length).zip(others.chunks_mut(each * length)).enumerate().for_each(chunk);
    }
}

/// Adds up what `work` returns for every chunk of `len` elements, in the order of the chunks. `parts` has a place for each chunk.
pub fn sum_of_chunks<const N: usize>(
    len: usize,
    parts: &mut [[f64; N]],
    pool: &Pool,
    work: impl Fn(Range<usize>) -> [f64; N] + Sync,
) -> [f64; N] {
    let parts = &mut parts[..len.div_ceil(CHUNK)];
    let each = |(chunk, part): (usize, &mut [f64; N])| *part = work(chunk * CHUNK..len.min((chunk + 1) * CHUNK));
    if pool.pays_for(len) {
        parts.par_iter_mut().enumerate().for_each(each);
    } else {
        parts.iter_mut().enumerate().for_each(each);
    }
    parts.iter().fold([0.0; N], |sums, part| std::array::from_fn(|index| sums[index] + part[index]))
}

/// As [`for_each_chunk`]; adds up what `work` returns in the order of the chunks. `parts` has a place for each chunk.
pub fn sum_over_chunks<T: Send>(
    items: &mut [T],
    parts: &mut [f64],
    pool: &Pool,
    work: impl Fn(usize, &mut [T]) -> f64 + Sync,
) -> f64 {
    let each = |(chunk, (items, part)): (usize, (&mut [T], &mut f64))| *part = work(chunk * CHUNK, items);
    if pool.pays_for(items.len()) {
        items.par_chunks_mut(CHUNK).zip(parts.par_iter_mut()).enumerate().for_each(each);
    } else {
        items.chunks_mut(CHUNK).zip(parts.iter_mut()).enumerate().for_each(each);
    }
    parts.iter().sum()
}
