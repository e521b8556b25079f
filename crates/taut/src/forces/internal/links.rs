//! Springs outside of lattices: each particle gathers along its list of links.

use glam::Vec3;

use super::Impulse;
use super::law::Law;
use crate::geometry::Pool;
use crate::model::{ClothRange, Model};

/// Writes `out` for the particles of a cloth.
pub(super) fn apply<L: Law>(law: L, impulse: Impulse<'_>, model: &Model, cloth: &ClothRange, pool: &Pool) {
    let Impulse { field, other, out, keep, add, scale } = impulse;
    out.for_each_chunk_of(cloth.particles(), pool, |chunk| {
        chunk.map(|particle, value| {
            let here = field.get(particle);
            let mut force = Vec3::ZERO;
            for link in model.links.of(particle) {
                force += law.force(field.get(link.other as usize) - here, link);
            }
            value * keep + other.get(particle) * add + force * (scale * model.particles.inverse_mass[particle])
        });
    });
}
