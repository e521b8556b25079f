//! Where the pins of a scene go.

use glam::DVec3;

use super::Track;
use crate::model::Model;
use crate::scene::Scene;

/// The path of each pin group of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct Paths {
    /// Displacements from the start [m].
    tracks: Vec<Track>,
}

impl Paths {
    /// What the pins of a scene say.
    pub(super) fn new(scene: &Scene) -> Self {
        let pins = scene.cloth.iter().flat_map(|cloth| &cloth.pins);
        Self { tracks: pins.map(|pin| Track::new(DVec3::ZERO, &pin.keyframes)).collect() }
    }

    /// The displacement of a group from the start [m].
    pub(super) fn track(&self, group: usize) -> &Track {
        &self.tracks[group]
    }

    /// Where particle number `index` of a pin group is at `time`, from the origin that its cloth has at the start [m].
    #[must_use]
    pub fn position(&self, model: &Model, group: usize, index: usize, time: f64) -> DVec3 {
        model.pins[group].start[index] + self.tracks[group].at(time)
    }
}
