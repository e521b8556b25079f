//! Several steps as one: all of them, or none.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use glam::DVec3;

use crate::diagnostics::{Glance, StateReport, StepReport, Times};
use crate::inputs::Inputs;
use crate::model::Model;
use crate::schedule::BadLength;
use crate::state::State;
use crate::step::{Content, Host, Work, glance, inspect, step_for};

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
    /// Times that pins of a cloth had to be held back, as it is not long enough between them, or could not follow.
    pub held_back_pins: u64,
    /// The largest part of its motion that the certificate, or the bound on the kinetic energy, took from a cloth in a step [1].
    pub lost_motion: f64,
    /// The same, mean of the steps [1].
    pub mean_lost_motion: f64,
    /// Rows of contact, summed over the steps.
    pub contacts: u64,
    /// Steps that were shortened where something would have crossed something else.
    pub contact_cuts: u64,
    /// Steps that contact had taken in halves, quarters or eighths.
    pub halved_steps: u64,
    /// Rows of contact that shared too little room, as what they keep apart was pressed from two sides; summed over the steps.
    pub pinched: u64,
    /// Bodies that ended behind their paths, since what is pressed between them and other things could not go out of their way; summed
    /// over the steps.
    pub held_back_bodies: u64,
    /// The least distance that the steps found between what touches [m]; none if nothing was near.
    pub closest: Option<f64>,
    /// Places where something intersected at the start of the last step, while that is brought apart.
    pub penetrations: u32,
    /// The momentum that rounding took from free cloths, and that was given back, summed over the steps [kg m/s].
    pub repaired_momentum: DVec3,
    /// Whether everything slept in the last step, and nothing was done.
    pub asleep: bool,
    /// What the filter spent its time on, summed over the steps; see [`Work::set_clock`].
    pub times: Times,
}

/// Why several steps were not taken. The state, and all that the workspace might remember, are as they were before.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Failure {
    /// A particle's position or velocity is no longer a finite number.
    #[error(
        "particle {particle} is no longer at a finite place after the step to {time:.6} s; the state is kept as it was before; \
         the step is probably too long for the forces: use solver.substeps = \"auto\", or look for huge speeds, winds or stiffnesses"
    )]
    NonFinite {
        /// The first such particle.
        particle: u32,
        /// End of the step in which it happened [s].
        time: f64,
    },
    /// The length of the steps is none, or too much.
    #[error(transparent)]
    BadLength(#[from] BadLength),
    /// The caller did not want to wait any longer.
    #[error("stopped on request; the state is kept as it was before")]
    Stopped,
}

/// Takes `count` steps of `dt` seconds.
///
/// # Errors
/// See [`Failure`]; `state` is then as it was before the call, and also if something panics.
pub fn advance(
    model: &Model,
    state: &mut State,
    inputs: &Inputs,
    dt: f64,
    count: u64,
    work: &mut Work,
) -> Result<Summary, Failure> {
    advance_in_turns(model, state, inputs, dt, count, work, &mut Content)
}

/// As [`advance`], asking `host` again and again how many steps to take without asking; with nothing for an answer it stops. The
/// steps are the same whatever the answers.
///
/// # Errors
/// As [`advance`].
pub fn advance_in_turns(
    model: &Model,
    state: &mut State,
    inputs: &Inputs,
    dt: f64,
    count: u64,
    work: &mut Work,
    host: &mut dyn Host,
) -> Result<Summary, Failure> {
    if count > 0 {
        work.schedule().check(model, dt)?;
        work.keep_trace(work.trace().is_some());
    }
    let pool = work.pool();
    pool.install(state.positions.len(), || work.before.copy_from(state, &pool));
    // What is left half done by a panic is put back below.
    let steps = AssertUnwindSafe(|| take(model, state, inputs, dt, count, work, host));
    let result = catch_unwind(steps);
    if !matches!(result, Ok(Ok(_))) {
        undo(model, state, work);
    }
    result.unwrap_or_else(|panic| resume_unwind(panic))
}

/// Takes the last call of [`advance`] back.
pub fn undo(model: &Model, state: &mut State, work: &mut Work) {
    state.copy_from(&work.before, &work.pool());
    work.renew(model);
    work.forget_step();
}

fn take(
    model: &Model,
    state: &mut State,
    inputs: &Inputs,
    dt: f64,
    count: u64,
    work: &mut Work,
    host: &mut dyn Host,
) -> Result<Summary, Failure> {
    let (pool, mut summary) = (work.pool(), Summary::default());
    let found = |summary: &mut Summary, state: &State, work: &mut Work| {
        summary.last = inspect(model, state, inputs, work);
        let non_finite = |particle| Failure::NonFinite { particle, time: state.time() };
        summary.last.non_finite.map(non_finite).map_or(Ok(()), Err)
    };
    while summary.steps < count {
        let most = host.turn().ok_or(Failure::Stopped)?.max(1).min(count - summary.steps);
        pool.install(model.load(), || {
            for _ in 0..most {
                if summary.steps + 1 == count {
                    work.note(state, dt);
                }
                summary.add(step_for(model, state, inputs, dt, work, host).ok_or(Failure::Stopped)?);
                if summary.steps == count {
                    // The examination tells more.
                    break;
                }
                let Glance { worst_stretch, worst_spring, finite } = glance(model, state, work);
                if !finite {
                    found(&mut summary, state, work)?;
                    return Err(Failure::NonFinite { particle: 0, time: state.time() });
                }
                summary.see(worst_stretch, worst_spring);
            }
            Ok(())
        })?;
    }
    found(&mut summary, state, work)?;
    let StateReport { worst_stretch, worst_spring, .. } = summary.last;
    summary.see(worst_stretch, worst_spring);
    Ok(summary)
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
        self.pinched += u64::from(report.limited.pinched);
        self.held_back_bodies += u64::from(report.limited.held_back_bodies);
        self.repaired_momentum += report.repaired;
        self.times = self.times.and(report.times);
        self.contacts += u64::from(report.limited.contacts);
        self.contact_cuts += u64::from(report.limited.contact_cuts);
        self.halved_steps += u64::from(report.halved);
        self.closest = [self.closest, report.limited.closest].into_iter().flatten().reduce(f64::min);
        self.penetrations = report.limited.penetrations;
        self.asleep = report.asleep;
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
