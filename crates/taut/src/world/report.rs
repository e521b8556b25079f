//! What happened, as data.

use crate::advance::Summary;

/// What happened in the last call of [`World::step`](super::World::step), and what it led to.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[non_exhaustive]
pub struct Report {
    /// Time since the start [s].
    pub time: f64,
    /// Steps that were taken.
    pub steps: u64,
    /// Largest stretch of any spring after any of them [1]: 0.05 is 5 % longer than at rest.
    pub worst_stretch: f64,
    /// Steps in which a strain limit changed a velocity.
    pub limited_steps: u64,
    /// The largest part of its motion that a cloth lost in a step since its limit or what it touches could not be kept otherwise [1].
    pub lost_motion: f64,
    /// Times that pins had to be held back, as cloth between them is not long enough for their ways.
    pub held_back_pins: u64,
    /// Times that bodies had to be held back, as cloth between them and other things could not go out of their way.
    pub held_back_bodies: u64,
    /// Places where what a body presses had to share too little room, summed over the steps: there skins and thicknesses give way.
    pub pinched: u64,
    /// Places where something touched, or was about to, summed over the steps.
    pub contacts: u64,
    /// The least distance between the middles of what touches [m]; none if nothing was near.
    pub closest: Option<f64>,
    /// Places where something intersected at the start and is still being brought apart.
    pub penetrations: u32,
    /// Whether everything slept in the last step: nothing moves then until something from outside changes. Contacts are not counted meanwhile.
    pub asleep: bool,
    /// Kinetic energy of all that is free [J].
    pub kinetic_energy: f64,
    /// Energy of springs and of bending [J].
    pub elastic_energy: f64,
    /// Energy of gravity, from the origin of the world [J].
    pub potential_energy: f64,
}

impl Report {
    pub(super) fn new(summary: &Summary, time: f64) -> Self {
        let Summary { last, steps, worst_stretch, limited_steps, lost_motion, .. } = *summary;
        let Summary { held_back_pins, held_back_bodies, pinched, contacts, closest, penetrations, asleep, .. } = *summary;
        Self {
            time,
            steps,
            worst_stretch,
            limited_steps,
            lost_motion,
            held_back_pins,
            held_back_bodies,
            pinched,
            contacts,
            closest,
            penetrations,
            asleep,
            kinetic_energy: last.kinetic_energy,
            elastic_energy: last.elastic_energy,
            potential_energy: last.potential_energy,
        }
    }
}
