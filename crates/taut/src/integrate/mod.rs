//! Forces in, a proposed step out: one file a method.
//!
//! All stages of a method together propose where the step leads and with which velocities; the filter looks at that once, and
//! not in between (docs/methods/integrators.md). What is held moves through the step with the velocity of its path.

mod bdf2;
mod euler;
mod forward_euler;
mod implicit_euler;
mod linear_system;
mod mass_scaling;
mod midpoint;
mod momentum;
mod motion;
mod proposal;
mod rk4;
mod runge_kutta;
mod verlet;

use glam::DVec3;

use crate::forces::Forces;
use crate::geometry::{Pool, Vectors};
use crate::model::Model;
use crate::scene::IntegratorKind;
use crate::schedule::{Plan, Stride};
use crate::state::State;
use bdf2::Bdf2;
use euler::Euler;
use implicit_euler::ImplicitEuler;
use linear_system::LinearSystem;
use mass_scaling::MassScaling;
use momentum::Momentum;
use motion::Motion;
pub use proposal::Proposal;
use runge_kutta::RungeKutta;
use verlet::Verlet;

/// A way from one state to a proposal for the next one.
trait Method: Send + Sync {
    /// Writes the ends of the step [m] and its last velocities; positions stay. Returns how often it looked at all forces.
    fn propose(&mut self, step: Step<'_>, forces: &mut Forces, pool: &Pool) -> u32;
}

/// A step to be proposed; what is held has the velocity of its path.
struct Step<'a> {
    stride: Stride<'a>,
    state: &'a mut State,
    /// X* [m].
    ends: &'a mut Vectors,
}

/// The integrator of a model with its workspace.
pub struct Integrator {
    method: Box<dyn Method>,
    momentum: Momentum,
    motion: Motion,
}

impl Integrator {
    /// The integrator that the model's solver asks for, set up for steps that are planned like this one.
    #[must_use]
    pub fn new(model: &Model, plan: &Plan) -> Self {
        Self {
            momentum: Momentum::new(model),
            motion: Motion::new(model),
            method: match model.solver.integrator {
                IntegratorKind::Euler => Box::new(Euler::new(model, plan)),
                IntegratorKind::ForwardEuler => Box::new(RungeKutta::new(model, forward_euler::TABLEAU)),
                IntegratorKind::Midpoint => Box::new(RungeKutta::new(model, midpoint::TABLEAU)),
                IntegratorKind::Rk4 => Box::new(RungeKutta::new(model, rk4::TABLEAU)),
                IntegratorKind::Verlet => Box::new(Verlet::new(model)),
                IntegratorKind::ImplicitEuler => Box::new(ImplicitEuler::new(model)),
                IntegratorKind::Bdf2 => Box::new(Bdf2::new(model)),
            },
        }
    }
}

/// A step of positions and velocities under all forces: from `state` to `ends` and new velocities. Returns how often all
/// springs were looked at.
pub fn propose(
    stride: Stride<'_>,
    state: &mut State,
    ends: &mut Vectors,
    forces: &mut Forces,
    integrator: &mut Integrator,
    pool: &Pool,
) -> u32 {
    integrator.momentum.note(stride.model, state);
    integrator.motion.note(state, pool);
    integrator.method.propose(Step { stride, state, ends }, forces, pool)
}

/// The step has been admitted: its ends are the new positions, and the old ones are its ends. Returns the momentum that rounding took
/// from free cloths, and that they have back [kg m/s].
pub fn advance(
    stride: Stride<'_>,
    state: &mut State,
    ends: &mut Vectors,
    forces: &Forces,
    integrator: &Integrator,
    pool: &Pool,
) -> DVec3 {
    let Stride { model, plan, .. } = stride;
    let repaired = integrator.momentum.keep(stride, state, forces.acceleration());
    std::mem::swap(&mut state.positions, ends);
    integrator.motion.tell(stride, state, ends, pool);
    state.clock = state.clock.next(plan.length);
    if model.solver.integrator.remembers() {
        state.past.displacements.set_scaled(0..model.particle_count(), &state.positions, ends, -1.0, pool);
        state.past.length = plan.length;
    }
    repaired
}
