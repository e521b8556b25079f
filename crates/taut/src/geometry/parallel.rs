//! Threads that never change a result.
//!
//! Work is cut into chunks whose size does not depend on the number of threads; each chunk writes its own part of the
//! output or its own partial result, and partial results are combined in chunk order. Hence the same bits for any
//! number of threads.

use std::hint::spin_loop;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Elements in a chunk. Small enough to balance two threads on a 64 x 64 cloth, large enough to hide the hand-over.
pub const CHUNK: usize = 1024;

/// How often a thread that stays awake looks for work before it offers its processor to others.
const LOOKS_BEFORE_YIELD: u32 = 64;

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

    /// Runs `work`, whose loops have about `len` elements, where its parallel parts find the pool's threads: awake, if that pays.
    pub fn install<R: Send>(&self, len: usize, work: impl FnOnce() -> R + Send) -> R {
        match &self.workers {
            Some(workers) if workers.current_thread_index().is_none() => {
                let others = if self.pays_for(len) { self.threads - 1 } else { 0 };
                workers.install(|| awake(others, work))
            }
            _ => work(),
        }
    }

    /// Whether a loop over `len` elements is worth handing to several threads.
    #[must_use]
    pub fn pays_for(&self, len: usize) -> bool {
        self.workers.is_some() && len >= CHUNK
    }
}

/// Runs `work` while so many other threads stay awake. A thread that finds nothing to do for some 20 us falls asleep, and to wake it
/// takes longer than most loops here; between two of them there is always some work for one thread.
fn awake<R: Send>(others: usize, work: impl FnOnce() -> R + Send) -> R {
    if others == 0 {
        return work();
    }
    let done = AtomicBool::new(false);
    let all = || {
        let end = End(&done);
        let result = work();
        drop(end);
        result
    };
    rayon::join(all, || wait_in_turn(others, &done)).0
}

/// Says that the work is done when it goes, even in a panic.
struct End<'a>(&'a AtomicBool);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// Has so many threads look for pieces of work until all is done.
fn wait_in_turn(threads: usize, done: &AtomicBool) {
    if threads > 1 {
        rayon::join(|| wait_in_turn(1, done), || wait_in_turn(threads - 1, done));
        return;
    }
    let mut idle = 0_u32;
    while !done.load(Ordering::Acquire) {
        if rayon::yield_now() == Some(rayon::Yield::Executed) {
            idle = 0;
        } else if idle < LOOKS_BEFORE_YIELD {
            idle += 1;
            spin_loop();
        } else {
            // Others may want the processor.
            idle = 0;
            thread::yield_now();
        }
    }
}

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
    let each = |(chunk, (items, others)): (usize, (&mut [T], &mut [U]))| work(chunk * CHUNK, items, others);
    if pool.pays_for(items.len()) {
        items.par_chunks_mut(CHUNK).zip(others.par_chunks_mut(CHUNK)).enumerate().for_each(each);
    } else {
        items.chunks_mut(CHUNK).zip(others.chunks_mut(CHUNK)).enumerate().for_each(each);
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
