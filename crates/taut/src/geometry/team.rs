//! Threads that share the loops of a step, and wait for nothing but the next one.
//!
//! A step has some hundred short loops. The threads of a pool look out for the next one while a step runs: to wake one takes longer than most
//! loops. Each has its own run of a loop's pieces, the same ones in every loop of a length, so that what it has in its caches is of use. It
//! begins at the first of them, and takes the last one of another thread's once it has none. The thread that asks takes part, and goes on when
//! all pieces are done. Nobody waits for a thread that has not come, and no thread does anything else while it is in the team: a thread that
//! did, as those do that wait in rayon, could begin to wait for what is beneath it on its own stack.

use std::any::Any;
use std::cell::Cell;
use std::hint::spin_loop;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::ptr;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicU32, AtomicU64, AtomicUsize, Ordering};
use std::thread;

/// How often a thread looks for something to do before it offers its processor to others.
const LOOKS_BEFORE_YIELD: u32 = 64;

/// What is done for each piece of a loop, by its number.
type Work<'a> = &'a (dyn Fn(usize) + Sync);

/// The threads of a pool while one of them runs something.
pub(super) struct Team {
    /// Of each thread the pieces that are left of its own.
    runs: Box<[Run]>,
    /// What the loop does, if there is one.
    work: AtomicPtr<Work<'static>>,
    /// Pieces of the loop that are not done yet.
    left: AtomicUsize,
    /// How many loops there have been.
    loops: AtomicU32,
    /// What a piece panicked with, if one did.
    panic: Mutex<Option<Box<dyn Any + Send>>>,
    is_taken: AtomicBool,
    is_over: AtomicBool,
}

/// The pieces of a loop that are left of a run: from a number on and up to another one. On a line of the cache of its own.
#[repr(align(128))]
#[derive(Default)]
struct Run(AtomicU64);

/// What a thread has to do with a team.
#[derive(Clone, Copy)]
enum Role {
    None,
    /// It runs something with this team, as the thread of this number.
    Leads(*const Team, usize),
    /// It does a piece of a loop.
    Works,
}

thread_local! {
    static ROLE: Cell<Role> = const { Cell::new(Role::None) };
}

/// Which of a run's pieces.
#[derive(Clone, Copy)]
enum End {
    First,
    Last,
}

impl Team {
    pub fn new(threads: usize) -> Self {
        Self {
            runs: (0..threads).map(|_| Run::default()).collect(),
            work: AtomicPtr::new(ptr::null_mut()),
            left: AtomicUsize::new(0),
            loops: AtomicU32::new(0),
            panic: Mutex::new(None),
            is_taken: AtomicBool::new(false),
            is_over: AtomicBool::new(false),
        }
    }

    /// Runs `work` on one of the threads of a pool, while the others of this team look out for its loops. Where somebody else has the team,
    /// its loops are handed out by rayon.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        let Some(own) = self.place() else { return work() };
        if self.is_taken.swap(true, Ordering::Acquire) {
            return work();
        }
        let _taken = Sets(&self.is_taken, false);
        self.is_over.store(false, Ordering::Relaxed);
        let all = || {
            let _over = Sets(&self.is_over, true);
            let _role = Plays::new(Role::Leads(self, own));
            work()
        };
        rayon::join(all, || self.follow(self.runs.len() - 1)).0
    }

    /// The number of this thread, if it is one of the pool's.
    fn place(&self) -> Option<usize> {
        rayon::current_thread_index().filter(|own| *own < self.runs.len())
    }

    /// Has so many threads look out for loops until all is over. Whoever comes late finds that it is. Whoever is asked in the middle of
    /// something else, as one that waits for another pool may be, has no time, not even to ask others and wait for them: it would wait for
    /// what it is in the middle of.
    fn follow(&self, threads: usize) {
        let (Some(own), Role::None) = (self.place(), ROLE.get()) else { return };
        if threads > 1 {
            rayon::join(|| self.follow(1), || self.follow(threads - 1));
            return;
        }
        let (mut seen, mut idle) = (u32::MAX, 0_u32);
        while !self.is_over.load(Ordering::Acquire) {
            let now = self.loops.load(Ordering::Acquire);
            if now != seen {
                (seen, idle) = (now, 0);
                self.help(own);
            } else {
                wait(&mut idle);
            }
        }
    }

    /// Does `work` for every number below `count`, with whoever follows.
    fn share(&self, own: usize, count: usize, work: Work<'_>) {
        let threads = self.runs.len();
        let work: *const Work<'_> = &raw const work;
        self.work.store(work.cast_mut().cast(), Ordering::Relaxed);
        self.left.store(count, Ordering::Relaxed);
        for (thread, run) in self.runs.iter().enumerate() {
            let [from, to] = [thread, thread + 1].map(|thread| (thread * count / threads) as u64);
            run.0.store(from << 32 | to, Ordering::Release);
        }
        self.loops.fetch_add(1, Ordering::Release);
        self.help(own);
        let mut idle = 0;
        while self.left.load(Ordering::Acquire) > 0 {
            wait(&mut idle);
        }
        if let Some(panic) = self.panic.lock().ok().and_then(|mut panic| panic.take()) {
            resume_unwind(panic);
        }
    }

    /// Does the pieces of this thread, and what is left of those of others.
    fn help(&self, own: usize) {
        let _role = Plays::new(Role::Works);
        let threads = self.runs.len();
        for thread in own..own + threads {
            let end = if thread == own { End::First } else { End::Last };
            while let Some(piece) = self.runs[thread % threads].take(end) {
                // SAFETY: the piece was left, so that the loop is not over, and its thread waits until this one is done.
                let work = unsafe { *self.work.load(Ordering::Relaxed) };
                if let Err(panic) = catch_unwind(AssertUnwindSafe(|| work(piece)))
                    && let Ok(mut first) = self.panic.lock()
                {
                    first.get_or_insert(panic);
                }
                self.left.fetch_sub(1, Ordering::Release);
            }
        }
    }
}

impl Run {
    /// Takes a piece that is left.
    fn take(&self, end: End) -> Option<usize> {
        let mut left = self.0.load(Ordering::Relaxed);
        loop {
            let (from, to) = (left >> 32, left & u64::from(u32::MAX));
            if from >= to {
                return None;
            }
            let (piece, rest) = match end {
                End::First => (from, left + (1 << 32)),
                End::Last => (to - 1, left - 1),
            };
            match self.0.compare_exchange_weak(left, rest, Ordering::Acquire, Ordering::Relaxed) {
                Ok(_) => return Some(piece as usize),
                Err(now) => left = now,
            }
        }
    }
}

/// Sets something as it goes, in a panic, too.
struct Sets<'a>(&'a AtomicBool, bool);

impl Drop for Sets<'_> {
    fn drop(&mut self) {
        self.0.store(self.1, Ordering::Release);
    }
}

/// A role of this thread until it goes, when that before comes back.
struct Plays(Role);

impl Plays {
    fn new(role: Role) -> Self {
        Self(ROLE.replace(role))
    }
}

impl Drop for Plays {
    fn drop(&mut self) {
        ROLE.set(self.0);
    }
}

/// Does `work` for every number below `count` with the team that this thread leads; alone in a piece of a loop. Returns whether that was done.
pub(super) fn shares(count: usize, work: Work<'_>) -> bool {
    match ROLE.get() {
        Role::Leads(team, own) if u32::try_from(count).is_ok() => {
            // SAFETY: a team is there as long as somebody leads it.
            unsafe { &*team }.share(own, count, work);
            true
        }
        Role::Works | Role::Leads(..) => {
            (0..count).for_each(work);
            true
        }
        Role::None => false,
    }
}

/// Lets a moment pass.
fn wait(idle: &mut u32) {
    if *idle < LOOKS_BEFORE_YIELD {
        *idle += 1;
        spin_loop();
    } else {
        // Others may want the processor.
        *idle = 0;
        thread::yield_now();
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::thread;

    use super::super::{Pool, for_each_piece, sum_in_any_order};

    const MUCH: usize = usize::MAX;

    /// Counts how often each piece of some loops is done.
    fn counted(pool: &Pool, len: usize, loops: usize) -> Vec<usize> {
        let counts: Vec<AtomicUsize> = (0..len).map(|_| AtomicUsize::new(0)).collect();
        pool.install(MUCH, || {
            for _ in 0..loops {
                for_each_piece(0..len, true, |_, piece| {
                    counts[piece].fetch_add(1, Ordering::Relaxed);
                });
            }
        });
        counts.into_iter().map(AtomicUsize::into_inner).collect()
    }

    #[test]
    fn every_piece_is_done_once() {
        for threads in 1..=8 {
            let pool = Pool::new(threads);
            for len in [0, 1, 2, 7, 8, 100] {
                assert!(counted(&pool, len, 30).iter().all(|&count| count == 30), "{len} on {threads} threads");
                let sum = pool.install(MUCH, || sum_in_any_order(0..len, true, 0, |_, piece| piece, |a, b| a + b));
                assert_eq!(sum, (0..len).sum::<usize>(), "{len} on {threads} threads");
            }
        }
    }

    #[test]
    fn a_loop_within_a_loop_is_done_by_its_thread() {
        let (pool, count) = (Pool::new(3), AtomicUsize::new(0));
        pool.install(MUCH, || {
            for_each_piece(0..20, true, |_, _| {
                let before = thread::current().id();
                for_each_piece(0..20, true, |_, _| {
                    assert_eq!(thread::current().id(), before);
                    count.fetch_add(1, Ordering::Relaxed);
                });
            });
        });
        assert_eq!(count.into_inner(), 400);
    }

    #[test]
    fn a_panic_in_a_piece_comes_back_and_leaves_the_team_as_it_was() {
        let pool = Pool::new(4);
        for bad in 0..50 {
            let all = || pool.install(MUCH, || for_each_piece(0..50, true, |_, piece| assert_ne!(piece, bad, "bad")));
            let panic = catch_unwind(AssertUnwindSafe(all)).expect_err("a panic");
            assert!(panic.downcast_ref::<String>().is_some_and(|text| text.contains("bad")));
            assert!(counted(&pool, 50, 2).iter().all(|&count| count == 2));
        }
    }

    #[test]
    fn several_callers_share_a_pool() {
        let pool = Pool::new(3);
        thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..200).for_each(|_| assert!(counted(&pool, 40, 3).iter().all(|&count| count == 3))));
            }
        });
    }

    /// Threads that wait in rayon do whatever there is to do: it must not be to wait for themselves.
    #[test]
    fn who_leads_never_waits_for_itself() {
        let [pool, other] = [3, 2].map(Pool::new);
        for _ in 0..300 {
            pool.install(MUCH, || {
                for _ in 0..20 {
                    rayon::yield_now();
                }
                assert!(counted(&other, 40, 3).iter().all(|&count| count == 3));
                for_each_piece(0..40, true, |_, _| {});
            });
        }
    }
}
