//! Where the cycles of a step stand.

use glam::Vec3;

use super::calm::less_room;
use super::{Cycle, NO_ROOM, PROGRESS_INTERVAL, general};
use crate::model::Model;

/// The cycles of a cloth in one step.
pub(super) struct Descent {
    /// The displacement of what is held [m], and the kinetic energy of the proposal seen from there, if there is such a frame.
    pub frame: Option<Vec3>,
    pub energy: Option<f64>,
    /// What rounding adds to the shortest spring, and what is short enough, as parts of R.
    pub rounding: f32,
    pub enough: f32,
    /// What the last step left in [`Calm`].
    pub at_least: u32,
    pub room: f32,
    pub brake: f32,
    /// The largest |P_uv| / R, and the cycles so far.
    pub worst: f32,
    pub sweeps: u32,
    /// Those that were taken back, because they pulled further than the step moves.
    pub earlier: u32,
    pub since_restart: u8,
    /// When progress is looked at next; what the worst spring was too long at the last look, and how many were over.
    pub next_look: u32,
    pub before: f32,
    pub over_before: usize,
    /// Springs that the last cycle left over, if it told.
    pub over: Option<usize>,
    /// All springs are short enough; and nothing is left to do, or nothing helps.
    pub is_done: bool,
    pub is_over: bool,
    /// Springs of the proposal are over their limit.
    pub is_needed: bool,
}

impl Descent {
    /// The part of the last cycle's way that the next one of a cloth that can touch starts with [1].
    pub fn momentum(&self) -> f32 {
        general::momentum(self.since_restart, self.at_least > 0)
    }

    /// The next cycle.
    pub fn cycle(&self, model: &Model) -> Cycle {
        let Self { since_restart, enough, at_least, sweeps, .. } = *self;
        let is_last = sweeps + 1 == model.solver.iterations();
        Cycle { since_restart, enough, is_sure: sweeps + 1 < at_least, is_last, is_calm: at_least > 0 }
    }

    /// Begins anew with less room, after cycles that pulled further than the step moves. Returns whether there is less: otherwise nothing has
    /// changed.
    pub fn take_again(&mut self) -> bool {
        let Self { sweeps, earlier, room, .. } = *self;
        if self.frame.is_none() || room <= NO_ROOM {
            return false;
        }
        self.room = less_room(room);
        (self.sweeps, self.earlier) = (0, earlier + sweeps);
        (self.worst, self.since_restart, self.over) = (f32::INFINITY, 0, None);
        (self.next_look, self.before, self.over_before) = (PROGRESS_INTERVAL, f32::INFINITY, usize::MAX);
        (self.is_done, self.is_over) = (false, false);
        true
    }
}
