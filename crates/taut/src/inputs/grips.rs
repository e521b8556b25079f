//! What a user holds while a simulation runs: vertices with targets of their own, vertices led by hand, pins and bodies moved off their
//! paths.
//!
//! A held particle has no mass while it is held, as a pin of the scene: it goes where it is told. A led particle keeps its mass: it
//! goes where the hand says unless the strain limit holds it back. A hand that asks for the impossible stays behind its target.

use std::ops::Range;

use glam::DVec3;

use super::{BodyForm, BodyShift};

/// All that is held.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Grips {
    /// In rising order.
    particles: Vec<u32>,
    targets: Vec<Target>,
    leads: Vec<Lead>,
    /// Of the pin groups that were moved.
    shifts: Vec<Shift>,
    /// Of the bodies that were moved.
    body_shifts: Vec<BodyShift>,
    /// Of the bodies whose vertices were told.
    body_forms: Vec<BodyForm>,
}

/// Where a held particle goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// The place in the world [m].
    pub place: DVec3,
    /// When it shall be there [s]; it goes straight, and is there at the end of the next step if that is later.
    pub arrival: f64,
}

/// A particle led by hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lead {
    /// Which.
    pub particle: u32,
    /// Where to, in the world [m].
    pub target: DVec3,
    /// Highest speed [m/s].
    pub speed: f32,
}

/// A pin group that shall be beside its path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shift {
    /// Which, in the order of the model.
    pub group: usize,
    /// How far off its path it shall be [m].
    pub target: DVec3,
    /// Highest speed [m/s]; infinite: at once.
    pub speed: f64,
}

impl Grips {
    /// Holds a particle, or gives it another target. A particle that is pinned leaves its path until it is released.
    pub fn hold(&mut self, particle: u32, target: Target) {
        match self.particles.binary_search(&particle) {
            Ok(place) => self.targets[place] = target,
            Err(place) => {
                self.particles.insert(place, particle);
                self.targets.insert(place, target);
            }
        }
    }

    /// Leads a particle towards `target`, a place in the world [m], at no more than `speed` [m/s]; what is pinned or held goes its own
    /// way.
    pub fn lead(&mut self, particle: u32, target: impl Into<DVec3>, speed: f32) {
        self.leads.retain(|lead| lead.particle != particle);
        self.leads.push(Lead { particle, target: target.into(), speed });
    }

    /// Lets a particle go, whether it is held or led.
    pub fn release(&mut self, particle: u32) {
        self.leads.retain(|lead| lead.particle != particle);
        if let Ok(place) = self.particles.binary_search(&particle) {
            self.particles.remove(place);
            self.targets.remove(place);
        }
    }

    /// Lets everything go.
    pub fn release_all(&mut self) {
        self.leads.clear();
        self.particles.clear();
        self.targets.clear();
    }

    /// Moves a pin group to `target` [m] off its path at no more than `speed` [m/s].
    pub fn shift(&mut self, group: usize, target: DVec3, speed: f64) {
        self.shifts.retain(|shift| shift.group != group);
        self.shifts.push(Shift { group, target, speed });
    }

    /// Moves a body off its path.
    pub fn shift_body(&mut self, shift: BodyShift) {
        self.body_shifts.retain(|other| other.body != shift.body);
        self.body_shifts.push(shift);
    }

    /// Tells the vertices of a body, which is on no path then, nor off it.
    pub fn form_body(&mut self, form: BodyForm) {
        self.body_shifts.retain(|other| other.body != form.body);
        self.body_forms.retain(|other| other.body != form.body);
        self.body_forms.push(form);
    }

    /// Displaces all that is held of a cloth [m]: its particles and the targets of those, and its pin groups.
    pub fn translate(&mut self, particles: &Range<usize>, is_own: impl Fn(usize) -> bool, offset: DVec3) {
        let is_in = |particle: u32| particles.contains(&(particle as usize));
        let targets = self.particles.iter().zip(&mut self.targets).filter(|(particle, _)| is_in(**particle));
        targets.for_each(|(_, target)| target.place += offset);
        self.leads.iter_mut().filter(|lead| is_in(lead.particle)).for_each(|lead| lead.target += offset);
        self.shifts.iter_mut().filter(|shift| is_own(shift.group)).for_each(|shift| shift.target += offset);
    }

    /// The held particles, in rising order.
    #[must_use]
    pub fn particles(&self) -> &[u32] {
        &self.particles
    }

    /// The held particles and where they go.
    pub fn held(&self) -> impl Iterator<Item = (u32, Target)> {
        self.particles.iter().copied().zip(self.targets.iter().copied())
    }

    /// The hands, in the order in which they came.
    #[must_use]
    pub fn leads(&self) -> &[Lead] {
        &self.leads
    }

    /// The pin groups that were moved, in the order in which they were.
    #[must_use]
    pub fn shifts(&self) -> &[Shift] {
        &self.shifts
    }

    /// The bodies that were moved, in the order in which they were.
    #[must_use]
    pub fn body_shifts(&self) -> &[BodyShift] {
        &self.body_shifts
    }

    /// The bodies whose vertices were told, in the order in which they were.
    #[must_use]
    pub fn body_forms(&self) -> &[BodyForm] {
        &self.body_forms
    }
}

impl Target {
    /// The part of the way to it that a step of `length` seconds goes which begins at `time` [s].
    #[must_use]
    pub fn part(&self, length: f64, time: f64) -> f32 {
        let left = self.arrival - time;
        // A remainder of rounding is no further step.
        if left <= length * (1.0 + 1e-6) { 1.0 } else { (length / left) as f32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_in_the_future_is_reached_in_equal_steps() {
        let target = Target { place: DVec3::X, arrival: 0.4 };
        let mut gone = 0.0;
        for step in 0..6 {
            gone += (1.0 - gone) * target.part(0.1, 0.1 * f64::from(step));
            assert!((f64::from(gone) - (0.25 * f64::from(step + 1)).min(1.0)).abs() < 1e-6, "{gone} after step {step}");
        }
        assert_eq!(gone, 1.0);
    }
}
