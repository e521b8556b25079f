//! The part of a simulation that changes: one thread uses it at a time, and a child of the process gets threads of its own.

use std::mem;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{LazyLock, Mutex, PoisonError, TryLockError};
use std::thread::{self, ThreadId};
use std::time::Instant;

use pyo3::prelude::*;
use taut::inputs::Inputs;
use taut::scene::Wind;
use taut::state::State;
use taut::step::Work;

use crate::{SimulationError, pools};

/// What a step changes, and what acts on it.
pub struct Running {
    pub state: State,
    pub inputs: Inputs,
    pub wind: Option<Wind>,
    pub work: Work,
}

/// Since the first time that somebody asked [s]; it never goes back.
fn seconds() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed().as_secs_f64()
}

/// A running part, for one thread at a time.
pub struct Guarded {
    running: Mutex<Running>,
    /// The thread that uses it.
    user: Mutex<Option<ThreadId>>,
    /// The process that has its threads: a fork does not inherit them.
    process: AtomicU32,
}

impl Guarded {
    pub fn new(mut running: Running) -> Self {
        running.work.set_clock(Some(seconds));
        Self { running: Mutex::new(running), user: Mutex::default(), process: AtomicU32::new(std::process::id()) }
    }

    /// What `work` returns; waits for a step that another thread is taking.
    pub fn with<R: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut Running) -> R + Send) -> PyResult<R> {
        self.adopt(py)?;
        let user = || self.user.lock().unwrap_or_else(PoisonError::into_inner);
        if *user() == Some(thread::current().id()) {
            // It would wait for itself for ever.
            return Err(SimulationError::new_err("a hook or a signal handler must not use the simulation that it interrupts"));
        }
        Ok(py.detach(|| {
            let mut running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
            *user() = Some(thread::current().id());
            let result = catch_unwind(AssertUnwindSafe(|| work(&mut running)));
            *user() = None;
            result.unwrap_or_else(|panic| resume_unwind(panic))
        }))
    }

    /// What `work` returns, which the thread that uses it now has asked of this one: it must not use it, either.
    pub fn lent<R>(&self, work: impl FnOnce() -> R) -> R {
        let user = || self.user.lock().unwrap_or_else(PoisonError::into_inner);
        let before = user().replace(thread::current().id());
        let result = work();
        *user() = before;
        result
    }

    /// Starts threads in a process that is a child of the one whose threads there were. Python lets no other thread come between.
    fn adopt(&self, _: Python<'_>) -> PyResult<()> {
        let process = std::process::id();
        if self.process.load(Ordering::Relaxed) == process {
            return Ok(());
        }
        let mut running = match self.running.try_lock() {
            Ok(running) => running,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => {
                return Err(SimulationError::new_err(
                    "this process was forked while another thread used the simulation, which is therefore lost here; \
                     make another one of its scene, or fork before the thread starts",
                ));
            }
        };
        let threads = running.work.pool().threads();
        // To end threads that are not there could wait for ever.
        mem::forget(running.work.replace_pool(pools::shared(threads)));
        self.process.store(process, Ordering::Relaxed);
        Ok(())
    }
}

impl Drop for Guarded {
    fn drop(&mut self) {
        if *self.process.get_mut() != std::process::id() {
            mem::forget(self.running.get_mut().unwrap_or_else(PoisonError::into_inner).work.pool());
        }
    }
}
