//! Resistance to bending, one file a method. Each turns positions into changes of velocity for a run of particles.

mod choi_ko;
mod quadratic;

use glam::Vec3;

use crate::geometry::{CHUNK, Pool, Vectors};
use crate::model::{ClothRange, Model};

/// `V += F_B / M h` for a cloth; nothing where it does not resist bending.
pub(super) fn kick(model: &Model, cloth: &ClothRange, positions: &Vectors, velocities: &mut Vectors, step: f32, pool: &Pool) {
    if !cloth.bends {
        return;
    }
    velocities.for_each_part(cloth.particles(), CHUNK, pool, |chunk| {
        chunk.map(|particle, velocity| {
            velocity + force(model, positions, particle) * (step * model.particles.inverse_mass[particle])
        });
    });
}

/// F_B on a particle [N].
#[inline]
fn force(model: &Model, positions: &Vectors, particle: usize) -> Vec3 {
    let here = positions.get(particle);
    quadratic::force(model.bending.quadratic.of(particle), positions, here)
        + choi_ko::force(model.bending.buckling.of(particle), positions, here)
}

/// A particle's half of the energy of all the pairs it is in [J].
#[must_use]
pub fn bending_energy(model: &Model, positions: &Vectors, particle: usize) -> f64 {
    if model.bending.is_empty() {
        return 0.0;
    }
    let here = positions.get(particle);
    0.5 * quadratic::energy(model.bending.quadratic.of(particle), positions, here)
        + 0.5 * choi_ko::energy(model.bending.buckling.of(particle), positions, here)
}
