//! Long calls that Python can interrupt.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use pyo3::prelude::*;

use crate::SimulationError;

/// Signals are looked for about this often.
pub const BETWEEN_LOOKS: Duration = Duration::from_millis(50);

/// How many steps to take before signals are looked for again.
pub struct Turns {
    began: Instant,
    steps: u64,
    /// What a signal handler raised.
    pub raised: Option<PyErr>,
}

impl Turns {
    pub fn new() -> Self {
        Self { began: Instant::now(), steps: 0, raised: None }
    }

    /// The next turn; none if a signal handler raised something. Only the main thread is ever given signals.
    pub fn next(&mut self) -> Option<u64> {
        assert!(!BREAKS.swap(false, Ordering::Relaxed), "broken for a test");
        let took = self.began.elapsed();
        if self.steps > 0 && took >= BETWEEN_LOOKS / 2 {
            self.raised = Python::attach(|py| py.check_signals()).err();
        }
        let fitting = BETWEEN_LOOKS.as_secs_f64() / took.as_secs_f64().max(1e-9) * self.steps as f64;
        self.steps = (fitting as u64).clamp(1, 1 + 8 * self.steps);
        self.began = Instant::now();
        self.raised.is_none().then_some(self.steps)
    }
}

/// Whether the next turn of any simulation panics.
static BREAKS: AtomicBool = AtomicBool::new(false);

/// For tests: the next turn of any simulation panics, as a mistake in the engine would.
#[pyfunction]
pub fn break_next_step() {
    BREAKS.store(true, Ordering::Relaxed);
}

/// What `work` returns, or an error where it panics: `except Exception` must find what goes wrong.
pub fn or_error<R>(work: impl FnOnce() -> R) -> PyResult<R> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| {
        let said = panic.downcast_ref::<String>().cloned();
        let said = said.or_else(|| panic.downcast_ref::<&str>().map(|&text| text.to_owned())).unwrap_or_default();
        SimulationError::new_err(format!(
            "the engine broke down ({said}); the state is kept as it was before and the simulation can go on; please report the scene"
        ))
    })
}
