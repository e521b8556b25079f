//! Explicit Runge-Kutta methods whose stages each begin where the one before points to.
//!
//! V_(i-1) and A_(i-1) are the velocities and accelerations of the stage before. Stage i sees the state at `X + c_i h V_(i-1)`,
//! `V + c_i h A_(i-1)` and the time `t + c_i h`. The step goes along the weighted means of all V_i and A_i. Every force is
//! looked at anew in every stage, gusts at the stage's own time.

use super::{Method, Step};
use crate::forces::{self, Forces};
use crate::geometry::{Pool, Vectors};
use crate::model::Model;
use crate::state::{Moment, State};

/// The coefficients of a method, stage by stage.
pub(super) type Tableau = &'static [Stage];

/// When a stage looks at the forces, and how much its answer counts.
pub(super) struct Stage {
    /// c [1], as a part of the step.
    pub node: f64,
    /// b [1]; all of them together are 1.
    pub weight: f64,
}

/// A method and its workspace.
pub(super) struct RungeKutta {
    stages: Tableau,
    /// X and V of the stage [m], [m/s].
    positions: Vectors,
    velocities: Vectors,
    /// Weighted sums of the velocities [m/s] and accelerations [m/s^2] so far.
    way: Vectors,
    gain: Vectors,
}

impl RungeKutta {
    pub fn new(model: &Model, stages: Tableau) -> Self {
        let zeros = || Vectors::zeros(model.particle_count());
        Self { stages, positions: zeros(), velocities: zeros(), way: zeros(), gain: zeros() }
    }
}

impl Method for RungeKutta {
    fn propose(&mut self, step: Step<'_>, forces: &mut Forces, pool: &Pool) -> u32 {
        let Step { stride, state, ends } = step;
        let Self { stages, positions, velocities, way, gain } = self;
        let (all, length, start) = (0..stride.model.particle_count(), stride.plan.length, state.time());
        let State { origins, positions: from, velocities: speeds, .. } = state;
        for (number, stage) in stages.iter().enumerate() {
            let (reach, weight) = ((stage.node * length) as f32, stage.weight as f32);
            let moment = if number == 0 {
                Moment { origins, positions: &*from, velocities: &*speeds, time: start }
            } else {
                // The velocities of the stage before are needed for its positions, its accelerations for its velocities.
                positions.set_scaled(all.clone(), from, if number == 1 { speeds } else { velocities }, reach, pool);
                velocities.set_scaled(all.clone(), speeds, forces.acceleration(), reach, pool);
                Moment { origins, positions: &*positions, velocities: &*velocities, time: start + stage.node * length }
            };
            forces::all(stride, moment, forces, pool);
            if number == 0 {
                way.set_scaled(all.clone(), moment.velocities, moment.velocities, weight - 1.0, pool);
                gain.set_scaled(all.clone(), forces.acceleration(), forces.acceleration(), weight - 1.0, pool);
            } else {
                way.add_scaled(all.clone(), moment.velocities, weight, pool);
                gain.add_scaled(all.clone(), forces.acceleration(), weight, pool);
            }
        }
        ends.set_scaled(all.clone(), from, way, length as f32, pool);
        speeds.add_scaled(all, gain, length as f32, pool);
        stages.len() as u32
    }
}
