//! The best places so far. A light particle of cloth that just holds may go to and fro between two places while all else is found. Left to
//! cycles instead, whose pushes are too small, the cloth slips.

use glam::DVec3;

use super::{Foot, Task};

/// Places that keep limits and rows, with what rows push and hold there.
#[derive(Default)]
pub(super) struct Best {
    /// What is missing, as a part of what may be.
    pub missing: f64,
    found: Vec<DVec3>,
    pushes: Vec<(f64, DVec3)>,
}

impl Best {
    /// Keeps the present places, if less is missing there.
    pub fn keep(&mut self, task: &Task<'_>, feet: &[Foot], found: &[DVec3], missing: f64) {
        if missing < self.missing {
            self.missing = missing;
            self.found.clear();
            self.found.extend(task.movable.iter().map(|&particle| found[particle as usize]));
            self.pushes.clear();
            self.pushes.extend(feet.iter().map(|foot| (foot.pair.multiplier, foot.hold * -foot.bound)));
        }
    }

    /// Takes these places. Has rows know what they push and hold.
    pub fn tell(&self, task: &mut Task<'_>, found: &mut [DVec3]) {
        for (&particle, &way) in task.movable.iter().zip(&self.found) {
            found[particle as usize] = way;
        }
        for (&(push, hold), support) in self.pushes.iter().zip(&mut *task.supports) {
            (support.push, support.hold) = (push, hold);
        }
    }
}
