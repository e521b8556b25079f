//! The whole story of a time step.

use std::sync::Arc;

use crate::filter::{self, Filter, Hands};
use crate::forces::Forces;
use crate::geometry::{Pool, Vectors};
use crate::health::{self, Glance, Health, StateReport, StepReport};
use crate::integrate::{self, Integrator};
use crate::model::Model;
use crate::state::State;

/// The workspace of a simulation: allocated once, never part of a result.
pub struct Work {
    forces: Forces,
    integrator: Integrator,
    filter: Filter,
    health: Health,
    pool: Arc<Pool>,
    /// Where the step leads [m].
    ends: Vectors,
}

impl Work {
    /// Workspace for a model, on `threads` threads.
    #[must_use]
    pub fn new(model: &Model, threads: usize) -> Self {
        let pool = Arc::new(Pool::new(threads));
        Self {
            forces: Forces::new(model),
            integrator: Integrator::new(model, pool.threads()),
            filter: Filter::new(model),
            health: Health::new(model),
            ends: Vectors::zeros(model.particle_count()),
            pool,
        }
    }

    /// The threads.
    #[must_use]
    pub fn pool(&self) -> Arc<Pool> {
        Arc::clone(&self.pool)
    }

    /// What a user holds while the simulation runs.
    pub fn hands(&mut self) -> &mut Hands {
        self.filter.hands()
    }
}

/// Advances by one step.
pub fn step(model: &Model, state: &mut State, work: &mut Work) -> StepReport {
    let Work { forces, integrator, filter, pool, ends, .. } = work;
    pool.install(|| {
        filter::hold(model, state, filter); // paths, hands -> v of what is held
        let evaluations = integrate::propose(model, state, ends, forces, integrator, pool); // forces: x, v -> x*, v*
        let limited = filter::apply(model, state, ends, filter, pool); // x*, v* -> admissible ones
        integrate::advance(model, state, ends, forces, integrator, pool); // x = x*
        StepReport { evaluations, limited }
    })
}

/// A glance at a state between two steps.
pub fn glance(model: &Model, state: &State, work: &mut Work) -> Glance {
    let Work { health, pool, .. } = work;
    pool.install(|| health::glance(model, state, health, pool))
}

/// Examines a state without advancing it.
pub fn inspect(model: &Model, state: &State, work: &mut Work) -> StateReport {
    let Work { health, pool, .. } = work;
    pool.install(|| health::inspect(model, state, health, pool))
}

/// Moves the particles of a state from elsewhere until no spring is over its limit; see [`filter::admit`].
pub fn admit(model: &Model, state: &mut State, work: &mut Work) {
    let Work { filter, pool, .. } = work;
    pool.install(|| filter::admit(model, state, filter, pool));
}
