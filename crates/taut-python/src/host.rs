//! Who asks for steps: Python, which can interrupt them, and may look at every proposal.

use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use taut::geometry::Pool;
use taut::integrate::Proposal;
use taut::step::Host;

use crate::arrays;
use crate::running::Guarded;
use crate::turns::Turns;

/// Python in one call of `step`.
pub struct Caller<'a> {
    pub turns: Turns,
    /// Called with positions, velocities and the length of each step.
    pub hook: Option<Py<PyAny>>,
    pub guarded: &'a Guarded,
}

impl Host for Caller<'_> {
    fn turn(&mut self) -> Option<u64> {
        self.turns.next()
    }

    fn look(&mut self, mut proposal: Proposal<'_>) -> bool {
        let Self { turns, hook, guarded } = self;
        let Some(hook) = hook else { return true };
        let result = guarded.lent(|| Python::attach(|py| call(hook.bind(py), &mut proposal)));
        turns.raised = result.err();
        turns.raised.is_none()
    }

    fn lets_sleep(&self) -> bool {
        self.hook.is_none()
    }
}

fn call(hook: &Bound<'_, PyAny>, proposal: &mut Proposal<'_>) -> PyResult<()> {
    let (py, numbering) = (hook.py(), &proposal.model().numbering);
    let count = proposal.model().particle_count();
    let mut places = vec![[0.0; 3]; count];
    proposal.state().write_places(proposal.model(), &mut places, &Pool::new(1));
    let particles: Vec<usize> = (0..count).map(|vertex| numbering.particle(vertex as u32) as usize).collect();
    let before: Vec<_> = particles.iter().map(|&particle| proposal.velocity(particle)).collect();
    let positions = arrays::rows_of(PyArray1::from_vec(py, places.into_flattened()), 3);
    let velocities = arrays::rows_of(PyArray1::from_iter(py, before.iter().flat_map(|velocity| velocity.to_array())), 3);
    let answer = hook.call1((positions, &velocities, proposal.length()))?;
    if !answer.is_none() {
        let kind = answer.get_type().name()?;
        return Err(PyTypeError::new_err(format!(
            "the hook returned a {kind}: must return None; change the array of velocities in place, velocities[:] = .."
        )));
    }
    let velocities = velocities.readonly();
    for (vertex, (row, before)) in velocities.as_array().rows().into_iter().zip(before).enumerate() {
        let now = glam::Vec3::new(row[0], row[1], row[2]);
        if !now.is_finite() {
            return Err(PyValueError::new_err(format!(
                "velocities[{vertex}] is not finite after the hook: must be numbers [m/s]"
            )));
        }
        if now != before {
            proposal.push(particles[vertex], now - before);
        }
    }
    Ok(())
}
