//! Springs whose force follows a measured curve.

use glam::Vec3;

use crate::geometry::Vectors;
use crate::model::Model;

/// Of all its springs with curves on a particle [N].
#[inline]
pub(in crate::forces) fn force(model: &Model, positions: &Vectors, particle: usize) -> Vec3 {
    let here = positions.get(particle);
    model.curved.links.of(particle).iter().fold(Vec3::ZERO, |sum, link| {
        let way = positions.get(link.other as usize) - here;
        let length = way.length();
        // Two particles at the same place have no direction to push in.
        if length > 0.0 { sum + way * (model.curved.pull(link, length) / length) } else { sum }
    })
}

/// A particle's half of the energy of its springs with curves [J].
#[must_use]
pub fn curved_energy(model: &Model, positions: &Vectors, particle: usize) -> f64 {
    let here = positions.get(particle);
    let energies = model.curved.links.of(particle).iter().map(|link| {
        let length = (positions.get(link.other as usize) - here).length();
        model.curved.energy(link, length)
    });
    0.5 * energies.sum::<f64>()
}
