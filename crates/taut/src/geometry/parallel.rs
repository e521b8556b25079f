//! Threads that never change a result.
//!
//! Work is cut into chunks whose size does not depend on the number of threads; each chunk writes its own part of the
//! output or its own partial result, and partial results are combined in chunk order. Hence the same bits for any
//! number of threads.

use std::ops::Range;

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Elements in a chunk. Small enough to balance two threads on a 64 x 64 cloth, large enough to hide the hand-over.
pub const CHUNK: usize = 1024;

/// The threads that one simulation uses.
pub struct Pool {
    workers: Option<ThreadPool>,
    threads: usize,
}

impl Pool {
    /// A pool of `threads` threads (at least 1); one thread means the caller's own.
    ///
    /// Falls back to the caller's thread if the system refuses to start others: results do not depend on it.
    #[must_use]
    pub fn new(threads: usize) -> Self {
        let workers = (threads > 1).then(|| ThreadPoolBuilder::new().num_threads(threads).build().ok()).flatten();
        let threads = if workers.is_some() { threads } else { 1 };
        Self { workers, threads }
    }

    /// The number of threads.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Runs `work` where its parallel parts find the pool's threads.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.workers {
            Some(workers) => workers.install(work),
            None => work(),
        }
    }

    /// Whether a loop over `len` elements is worth handing to several threads.
    #[must_use]
    pub fn pays_for(&self, len: usize) -> bool {
        self.workers.is_some() && len >= 4 * CHUNK
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
