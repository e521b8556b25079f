//! Springs outside of lattices: each particle gathers along its list of links.

use glam::Vec3;

use super::Impulse;
use super::law::Law;
use crate::geometry::Pool;
use crate::model::Model;

/// Adds the impulses of the links; where a lattice has written `out` already, on top of that.
pub(super) fn apply<L: Law>(law: L, impulse: Impulse<'_>, model: &Model, pool: &Pool) {
    let Impulse { field, other, out, keep, add, scale } = impulse;
    out.for_each_chunk(pool, |mut chunk| {
        let chunk_run = chunk.first..chunk.first + chunk.x.len();
        for cloth in model.cloths.iter().filter(|cloth| cloth.linked) {
            let run = cloth.particles();
            let (from, to) = (run.start.max(chunk_run.start), run.end.min(chunk_run.end));
            let (keep, add) = if cloth.lattice.is_some() { (1.0, 0.0) } else { (keep, add) };
            for particle in from..to {
                let here = field.get(particle);
                let mut force = Vec3::ZERO;
                for link in model.links.of(particle) {
                    force += law.force(field.get(link.other as usize) - here, link);
                }
                let step = scale * model.particles.inverse_mass[particle];
                chunk.set(particle, chunk.get(particle) * keep + other.get(particle) * add + force * step);
            }
        }
    });
}
