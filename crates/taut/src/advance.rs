//! Several steps as one: all of them, or none.

use crate::health::{Glance, StateReport, StepReport};
use crate::inputs::Inputs;
use crate::model::Model;
use crate::state::State;
use crate::step::{Work, glance, inspect, step};

/// What happened during several steps.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Summary {
    /// How many steps.
    pub steps: u64,
    /// How often the integrator looked at all springs, summed over the steps; a pass of a linear solver counts as one.
    pub evaluations: u64,
    /// The state reached.
    pub last: StateReport,
    /// Largest stretch after any of the steps [1].
    pub worst_stretch: f64,
    /// The spring that had it.
    pub worst_spring: Option<u32>,
    /// Steps in which the filter changed a velocity.
    pub limited_steps: u64,
    /// Springs that would have gone over their limit, summed over the steps.
    pub limited_springs: u64,
    /// Passes over the springs, or cycles over all levels, summed over the steps.
    pub sweeps: u64,
    /// Times that the certificate had to shorten the step of a cloth.
    pub cuts: u64,
    /// Those of them in which it had to hold pins back as well.
    pub held_back_pins: u64,
    /// The largest part of its motion that the certificate took from a cloth in a step [1].
    pub lost_motion: f64,
    /// The same, mean of the steps [1].
    pub mean_lost_motion: f64,
}

/// A particle's position or velocity is no longer a finite number.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "particle {particle} is no longer at a finite place after the step to {time:.6} s; the state is kept as it was before; \
     the step is probably too long for the forces: use solver.substeps = \"auto\", or look for huge speeds, winds or stiffnesses"
)]
pub struct NonFinite {
    /// The first such particle.
    pub particle: u32,
    /// End of the step in which it happened [s].
    pub time: f64,
}

/// Takes `count` steps of `dt` seconds.
///
/// # Errors
/// If a particle becomes non-finite; `state` is then as it was before the call. `before` is workspace for that copy.
pub fn advance(
    model: &Model,
    state: &mut State,
    before: &mut State,
    inputs: &Inputs,
    dt: f64,
    work: &mut Work,
    count: u64,
) -> Result<Summary, NonFinite> {
    let pool = work.pool();
    let result = pool.install(|| {
        before.copy_from(state, &pool);
        let mut summary = Summary::default();
        for left in (0..count).rev() {
            summary.add(step(model, state, inputs, dt, work));
            if left == 0 {
                // The examination tells more.
                break;
            }
            let Glance { worst_stretch, worst_spring, finite } = glance(model, state, work);
            if !finite {
                let particle = inspect(model, state, inputs, work).non_finite.unwrap_or_default();
                return Err(NonFinite { particle, time: state.time() });
            }
            summary.see(worst_stretch, worst_spring);
        }
        summary.last = inspect(model, state, inputs, work);
        if let Some(particle) = summary.last.non_finite {
            return Err(NonFinite { particle, time: state.time() });
        }
        let StateReport { worst_stretch, worst_spring, .. } = summary.last;
        summary.see(worst_stretch, worst_spring);
        Ok(summary)
    });
    if result.is_err() {
        state.copy_from(before, &pool);
    }
    result
}

impl Summary {
    fn add(&mut self, report: StepReport) {
        self.steps += 1;
        self.evaluations += u64::from(report.evaluations);
        self.limited_steps += u64::from(report.limited.springs > 0);
        self.limited_springs += u64::from(report.limited.springs);
        self.sweeps += u64::from(report.limited.sweeps);
        self.cuts += u64::from(report.limited.cuts);
        self.held_back_pins += u64::from(report.limited.held_back_pins);
        self.lost_motion = self.lost_motion.max(report.limited.lost_motion);
        self.mean_lost_motion += (report.limited.lost_motion - self.mean_lost_motion) / self.steps as f64;
    }

    /// Keeps the stretch after a step and the spring that has it, if none was larger before.
    fn see(&mut self, stretch: f64, spring: Option<u32>) {
        if self.worst_spring.is_none() || stretch > self.worst_stretch {
            (self.worst_stretch, self.worst_spring) = (stretch, spring);
        }
    }
}
