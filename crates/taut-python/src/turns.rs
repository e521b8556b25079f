//! Long calls that Python can interrupt.

use std::time::{Duration, Instant};

use pyo3::prelude::*;

/// Signals are looked for about this often.
const PATIENCE: Duration = Duration::from_millis(50);

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
        let took = self.began.elapsed();
        if self.steps > 0 && took >= PATIENCE / 2 {
            self.raised = Python::attach(|py| py.check_signals()).err();
        }
        let fitting = PATIENCE.as_secs_f64() / took.as_secs_f64().max(1e-9) * self.steps as f64;
        self.steps = (fitting as u64).clamp(1, 1 + 8 * self.steps);
        self.began = Instant::now();
        self.raised.is_none().then_some(self.steps)
    }
}
