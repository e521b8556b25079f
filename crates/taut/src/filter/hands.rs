//! What a user holds while the simulation runs: particles led by hand, pins moved off their paths.
//!
//! Hands are an input of each step, like the scene, but no part of it; nor are they part of the state. A led particle keeps its
//! mass: it goes where the hand says unless the strain limit holds it back. A hand that asks for the impossible then stays
//! behind its target, and the cloth goes on moving.

use glam::{DVec3, Vec3};

use crate::geometry::Vectors;
use crate::model::Model;
use crate::schedule::Stride;
use crate::state::State;

/// A hand closes a gap to its target in about this time [s], unless that is above its speed.
const RESPONSE: f32 = 1.0 / 60.0;
/// Pins that had to wait ask for this part of their speed in the next step, ..
const PATIENCE: f64 = 0.25;
/// .. and for this much more in every step in which they did not.
const COURAGE: f64 = 1.1;
/// Less of its speed a pin never asks for: it must notice that the cloth lets it go on.
const SLOWEST: f64 = 1e-3;

/// The hands of a model.
#[derive(Debug, Default)]
pub struct Hands {
    leads: Vec<Lead>,
    /// Of the pin groups that were moved.
    shifts: Vec<Shift>,
}

/// A particle on its way to a target.
#[derive(Debug, Clone, Copy)]
struct Lead {
    particle: usize,
    /// In the world [m].
    target: DVec3,
    /// Highest speed [m/s].
    speed: f32,
}

/// A pin group on its way to a place beside its path.
#[derive(Debug, Clone, Copy)]
struct Shift {
    group: usize,
    /// How far it is off its path [m], and how far it shall be.
    now: DVec3,
    target: DVec3,
    /// Highest speed [m/s], and the part of it that the cloth followed lately.
    speed: f64,
    pace: f64,
}

impl Hands {
    /// Leads a particle towards `target` [m], a place in the world, at no more than `speed` [m/s]; pins follow their paths instead.
    pub fn lead(&mut self, particle: u32, target: impl Into<DVec3>, speed: f32) {
        self.release(particle);
        self.leads.push(Lead { particle: particle as usize, target: target.into(), speed });
    }

    /// Lets a particle go.
    pub fn release(&mut self, particle: u32) {
        self.leads.retain(|lead| lead.particle != particle as usize);
    }

    /// Moves a pin group to `offset` [m] off its path at no more than `speed` [m/s]; at infinite speed it is there at once.
    pub fn shift(&mut self, group: usize, offset: DVec3, speed: f64) {
        let before = self.offset(group);
        let now = if speed.is_finite() { before } else { offset };
        self.shifts.retain(|shift| shift.group != group);
        self.shifts.push(Shift { group, now, target: offset, speed, pace: 1.0 });
    }

    /// How far a pin group is off its path [m].
    #[must_use]
    pub fn offset(&self, group: usize) -> DVec3 {
        self.shifts.iter().find(|shift| shift.group == group).map_or(DVec3::ZERO, |shift| shift.now)
    }

    /// Starts a step of `step` seconds: pins go on towards their targets.
    pub(super) fn start(&mut self, step: f64) {
        for shift in &mut self.shifts {
            shift.now += (shift.target - shift.now).clamp_length_max(shift.speed * shift.pace * step);
        }
    }

    /// Gives led particles the velocities that take them where they shall be at the end of the step.
    pub(super) fn hold(&self, stride: Stride<'_>, state: &mut State) {
        let step = stride.plan.length as f32;
        for lead in self.free(stride.model) {
            state.velocities.set(lead.particle, lead.way(stride.model, state, step) / step);
        }
    }

    /// Puts them there, and asks for those velocities again: forces have changed them.
    pub(super) fn place(&self, stride: Stride<'_>, state: &mut State, ends: &mut Vectors) {
        let step = stride.plan.length as f32;
        for lead in self.free(stride.model) {
            let way = lead.way(stride.model, state, step);
            ends.set(lead.particle, state.positions.get(lead.particle) + way);
            state.velocities.set(lead.particle, way / step);
        }
    }

    /// Ends a step: where pins had to wait, they go on from where they are, and more slowly.
    pub(super) fn finish(&mut self, stride: Stride<'_>, origins: &[DVec3], ends: &Vectors, time: f64, held_back: bool) {
        for shift in &mut self.shifts {
            shift.pace = if held_back { (shift.pace * PATIENCE).max(SLOWEST) } else { (shift.pace * COURAGE).min(1.0) };
            let (model, paths) = (stride.model, &stride.inputs.pins);
            if let (true, Some(&particle)) = (held_back, model.pins[shift.group].particles.first()) {
                let cloth = model.pins[shift.group].cloth;
                let gone = origins[cloth] - model.origins[cloth].at;
                shift.now = ends.get(particle as usize).as_dvec3() + gone - paths.position(model, shift.group, 0, time);
            }
        }
    }

    fn free<'a>(&'a self, model: &'a Model) -> impl Iterator<Item = &'a Lead> {
        self.leads.iter().filter(|lead| model.particles.inverse_mass[lead.particle] > 0.0)
    }
}

impl Lead {
    /// The way of this step [m].
    fn way(&self, model: &Model, state: &State, step: f32) -> Vec3 {
        let target = (self.target - state.origins[model.cloth_of(self.particle)]).as_vec3();
        let gap = target - state.positions.get(self.particle);
        (gap * (step / RESPONSE).min(1.0)).clamp_length_max(self.speed * step)
    }
}
