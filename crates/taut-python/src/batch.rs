//! Many simulations that step side by side.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use taut::advance::{Failure, Summary, advance_in_turns, undo};
use taut::geometry::for_each_part;

use crate::checks::{explain, workers};
use crate::engine::Engine;
use crate::pools;
use crate::report::report;
use crate::running::Running;
use crate::turns::{BETWEEN_LOOKS, or_error};

/// Steps between two looks whether to go on.
const TURN: u64 = 16;

type Taken = Result<(Summary, f64), Untaken>;

/// Why a world has not taken its steps.
enum Untaken {
    /// It was told to end, as another one failed or a signal came.
    Stopped,
    Failed(PyErr),
}

impl From<PyErr> for Untaken {
    fn from(error: PyErr) -> Self {
        Self::Failed(error)
    }
}

/// See `_taut.pyi`.
#[pyfunction]
#[pyo3(signature = (engines, count=1, dt=None, threads=None))]
pub fn step_all<'py>(
    py: Python<'py>,
    engines: Vec<Py<Engine>>,
    count: u64,
    dt: Option<f64>,
    threads: Option<usize>,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let pool = pools::shared(workers(threads)?);
    let worlds: Vec<&Engine> = engines.iter().map(Py::get).collect();
    let stop = AtomicBool::new(false);
    let take = |world: &Engine| -> Taken {
        let dt = dt.unwrap_or_else(|| world.step_length());
        let mut turn = || (!stop.load(Ordering::Relaxed)).then_some(TURN);
        let advance = |Running { state, inputs, work, .. }: &mut Running| {
            let result = advance_in_turns(&world.model, state, inputs, dt, count, work, &mut turn);
            result.map(|summary| (summary, state.time()))
        };
        let result = or_error(|| Python::attach(|py| world.running.with(py, advance)))??;
        result.map_err(|failure| {
            // The others may as well end.
            stop.store(true, Ordering::Relaxed);
            if failure == Failure::Stopped { Untaken::Stopped } else { explain(&world.model, failure).into() }
        })
    };
    let mut taken: Vec<Option<Taken>> = worlds.iter().map(|_| None).collect();
    let raised = py.detach(|| {
        thread::scope(|scope| {
            let (done, wait) = channel();
            let taken = &mut taken;
            scope.spawn(move || {
                pool.enter(|| {
                    for_each_part(taken, usize::MAX, &pool, |index, taken| *taken = Some(take(worlds[index])));
                });
                done.send(())
            });
            let mut raised = None;
            while wait.recv_timeout(BETWEEN_LOOKS) == Err(RecvTimeoutError::Timeout) {
                raised = raised.or_else(|| Python::attach(|py| py.check_signals()).err());
                stop.fetch_or(raised.is_some(), Ordering::Relaxed);
            }
            raised
        })
    });
    let taken: Vec<Taken> = taken.into_iter().flatten().collect();
    finish(py, &engines, taken, raised)
}

/// The reports; or what went wrong first, and then no world has moved.
fn finish<'py>(
    py: Python<'py>,
    engines: &[Py<Engine>],
    taken: Vec<Taken>,
    raised: Option<PyErr>,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let failed = taken.iter().enumerate().find_map(|(world, taken)| match taken {
        Err(Untaken::Failed(error)) => Some((world, error)),
        _ => None,
    });
    let named =
        |(world, error): (usize, &PyErr)| PyErr::from_type(error.get_type(py), format!("world {world}: {}", error.value(py)));
    let Some(error) = raised.or_else(|| failed.map(named)) else {
        // None is told to end unless there is such an error.
        return taken.into_iter().flatten().map(|(summary, time)| report(py, &summary, time)).collect();
    };
    for (engine, _) in engines.iter().map(Py::get).zip(&taken).filter(|(_, taken)| taken.is_ok()) {
        engine.running.with(py, |Running { state, work, .. }| undo(&engine.model, state, work))?;
    }
    Err(error)
}
