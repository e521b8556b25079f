//! The whole story of a time step.

use std::sync::Arc;

use crate::filter::{self, Filter};
use crate::forces::{self, Forces};
use crate::geometry::Pool;
use crate::health::{self, Health, StateReport, StepReport};
use crate::integrate;
use crate::model::Model;
use crate::state::State;

/// The workspace of a simulation: allocated once, never part of a result.
pub struct Work {
    forces: Forces,
    filter: Filter,
    health: Health,
    pool: Arc<Pool>,
}

impl Work {
    /// Workspace for a model, on `threads` threads.
    #[must_use]
    pub fn new(model: &Model, threads: usize) -> Self {
        Self {
            forces: Forces::new(model),
            filter: Filter::new(model),
            health: Health::new(model),
            pool: Arc::new(Pool::new(threads)),
        }
    }

    /// The threads.
    #[must_use]
    pub fn pool(&self) -> Arc<Pool> {
        Arc::clone(&self.pool)
    }
}

/// Advances by one step.
pub fn step(model: &Model, state: &mut State, work: &mut Work) -> StepReport {
    let Work { forces, filter, pool, .. } = work;
    pool.install(|| {
        forces::accumulate(model, state, forces, pool); // x, v -> f
        integrate::propose(model, state, forces.total(), pool); // f -> v*
        let limited = filter::apply(model, state, filter, pool); // v* -> v
        integrate::advance(model, state, pool); // x += h v
        health::glance(model, state, limited)
    })
}

/// Examines a state without advancing it.
pub fn inspect(model: &Model, state: &State, work: &mut Work) -> StateReport {
    let Work { health, pool, .. } = work;
    pool.install(|| health::inspect(model, state, health, pool))
}
