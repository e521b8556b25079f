//! Threads that stay awake within a step.

use std::hint::spin_loop;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

/// How often a thread that stays awake looks for work before it offers its processor to others.
const LOOKS_BEFORE_YIELD: u32 = 64;

/// Runs `work` while so many other threads stay awake. A thread that finds nothing to do for some 20 us falls asleep. To wake it
/// takes longer than most loops here. Between two of them there is always some work for one thread.
pub(super) fn awake<R: Send>(others: usize, work: impl FnOnce() -> R + Send) -> R {
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
