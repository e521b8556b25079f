//! The whole story of a time step.

use std::sync::Arc;

use crate::filter::{self, Filter, Hands};
use crate::forces::Forces;
use crate::geometry::{Pool, Vectors};
use crate::health::{self, Glance, Health, StateReport, StepReport};
use crate::inputs::Inputs;
use crate::integrate::{self, Integrator};
use crate::model::Model;
use crate::schedule::{Plan, Schedule, Stride};
use crate::state::State;

/// The workspace of a simulation: allocated once, never part of a result.
pub struct Work {
    forces: Forces,
    integrator: Integrator,
    filter: Filter,
    health: Health,
    pool: Arc<Pool>,
    schedule: Schedule,
    /// The last step, planned.
    plan: Plan,
    /// Where the step leads [m].
    ends: Vectors,
}

impl Work {
    /// Workspace for a model and the steps of its scene, on `threads` threads.
    #[must_use]
    pub fn new(model: &Model, schedule: &Schedule, threads: usize) -> Self {
        Self::with_pool(model, schedule, Arc::new(Pool::new(threads)))
    }

    /// The same on the threads of a pool, which simulations may share.
    #[must_use]
    pub fn with_pool(model: &Model, schedule: &Schedule, pool: Arc<Pool>) -> Self {
        let plan = schedule.plan(model, schedule.step_length);
        Self {
            forces: Forces::new(model),
            integrator: Integrator::new(model, &plan),
            filter: Filter::new(model, &plan),
            health: Health::new(model),
            ends: Vectors::zeros(model.particle_count()),
            schedule: schedule.clone(),
            plan,
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

    /// Plans a step of `dt` seconds, unless it is like the last one.
    fn plan(&mut self, model: &Model, dt: f64) {
        if self.plan.length != dt {
            self.plan = self.schedule.plan(model, dt);
        }
    }
}

/// Advances by one step of `dt` seconds under what acts from outside.
pub fn step(model: &Model, state: &mut State, inputs: &Inputs, dt: f64, work: &mut Work) -> StepReport {
    work.plan(model, dt); // dt -> parts of the step
    let Work { forces, integrator, filter, pool, plan, ends, .. } = work;
    let stride = Stride { model, inputs, plan };
    pool.install(|| {
        state.follow(model, pool); // origins stay near cloths that travel
        filter::hold(stride, state, filter); // paths, hands -> v of what is held
        let evaluations = integrate::propose(stride, state, ends, forces, integrator, pool); // forces: x, v -> x*, v*
        let limited = filter::apply(stride, state, ends, filter, pool); // x*, v* -> admissible ones
        integrate::advance(stride, state, ends, forces, integrator, pool); // x = x*
        StepReport { evaluations, limited }
    })
}

/// A glance at a state between two steps.
pub fn glance(model: &Model, state: &State, work: &mut Work) -> Glance {
    let Work { health, pool, .. } = work;
    pool.install(|| health::glance(model, state, health, pool))
}

/// Examines a state without advancing it.
pub fn inspect(model: &Model, state: &State, inputs: &Inputs, work: &mut Work) -> StateReport {
    let Work { health, pool, .. } = work;
    pool.install(|| health::inspect(model, state, inputs, health, pool))
}

/// Gravity, drag and wind on a state: the accelerations of all particles [m/s^2].
pub fn external<'a>(model: &Model, state: &State, inputs: &Inputs, work: &'a mut Work) -> &'a Vectors {
    let Work { forces, pool, plan, .. } = work;
    pool.install(|| crate::forces::external(Stride { model, inputs, plan }, state, forces, pool));
    forces.acceleration()
}

/// Moves the particles of a state from elsewhere until no spring is over its limit; see [`filter::admit`].
pub fn admit(model: &Model, state: &mut State, inputs: &Inputs, work: &mut Work) {
    let Work { filter, pool, plan, .. } = work;
    pool.install(|| filter::admit(Stride { model, inputs, plan }, state, filter, pool));
}
