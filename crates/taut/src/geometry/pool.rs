//! The threads of a simulation: its own, those of whoever calls, or none but the caller's.

use super::CHUNK;
#[cfg(feature = "threads")]
use super::team::Team;

/// What keeps several threads busy for so many elements in all is worth waking them, which takes as long as a step of small cloths.
const WORTH_WAKING: usize = 4 * CHUNK;

/// The threads that one simulation uses.
pub struct Pool {
    workers: Workers,
    threads: usize,
}

enum Workers {
    /// The thread that asks does everything.
    Caller,
    #[cfg(feature = "threads")]
    Own(rayon::ThreadPool, Team),
    /// Those of the rayon pool that the caller is in, or of the global one.
    #[cfg(feature = "threads")]
    Host,
}

impl Pool {
    /// A pool of `threads` threads (at least 1); one thread means the caller's own.
    ///
    /// Falls back to the caller's thread if the system refuses to start others, or without the feature `threads`: results do not
    /// depend on it.
    #[must_use]
    pub fn new(threads: usize) -> Self {
        let workers = Workers::of(threads);
        let threads = if matches!(workers, Workers::Caller) { 1 } else { threads };
        Self { workers, threads }
    }

    /// The threads of the rayon pool in which a simulation is asked to step, or of rayon's global one.
    #[cfg(feature = "threads")]
    #[must_use]
    pub fn of_host() -> Self {
        Self { workers: Workers::Host, threads: rayon::current_num_threads() }
    }

    /// The number of threads; of a host's, as it was when this was made.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Runs `work`, whose loops have about `len` elements, where its parallel parts find the pool's threads, which look out for them if they
    /// are its own; by the thread that asks if that is too little for several.
    #[cfg_attr(not(feature = "threads"), expect(unused_variables, reason = "nobody is woken"))]
    pub fn install<R: Send>(&self, len: usize, work: impl FnOnce() -> R + Send) -> R {
        match &self.workers {
            #[cfg(feature = "threads")]
            Workers::Own(workers, team) if len >= WORTH_WAKING && !is_within(workers) => workers.install(|| team.run(work)),
            _ => work(),
        }
    }

    /// Runs `work`, a loop of which each piece takes long and has loops itself, on the pool's threads.
    pub fn enter<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.workers {
            #[cfg(feature = "threads")]
            Workers::Own(workers, _) if !is_within(workers) => workers.install(work),
            _ => work(),
        }
    }

    /// Whether a loop over `len` elements is worth handing to several threads. Outside of them there are none.
    #[must_use]
    pub fn pays_for(&self, len: usize) -> bool {
        let finds_threads = match &self.workers {
            Workers::Caller => false,
            #[cfg(feature = "threads")]
            Workers::Own(workers, _) => is_within(workers),
            #[cfg(feature = "threads")]
            Workers::Host => true,
        };
        len >= CHUNK && finds_threads
    }
}

/// Whether one of these threads asks.
#[cfg(feature = "threads")]
fn is_within(workers: &rayon::ThreadPool) -> bool {
    workers.current_thread_index().is_some()
}

impl Workers {
    #[cfg(feature = "threads")]
    fn of(threads: usize) -> Self {
        let own = (threads > 1).then(|| rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok()).flatten();
        own.map_or(Self::Caller, |own| Self::Own(own, Team::new(threads)))
    }

    #[cfg(not(feature = "threads"))]
    fn of(_: usize) -> Self {
        Self::Caller
    }
}
