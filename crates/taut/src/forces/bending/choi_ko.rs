//! Immediate buckling (Choi & Ko 2002): type 2 springs that push under compression only, with the force of a buckled arc.

use glam::Vec3;

use crate::geometry::Vectors;
use crate::model::Buckling;

/// On the particle that is `here` [N].
#[inline]
pub(super) fn force(springs: &[Buckling], positions: &Vectors, here: Vec3) -> Vec3 {
    springs.iter().fold(Vec3::ZERO, |sum, spring| {
        let way = positions.get(spring.other as usize) - here;
        let distance = way.length();
        // Two particles at the same place have no direction to push in.
        if distance > 0.0 { sum + way * (spring.pull(distance) / distance) } else { sum }
    })
}

/// Of all its springs [J].
pub(super) fn energy(springs: &[Buckling], positions: &Vectors, here: Vec3) -> f64 {
    springs.iter().map(|spring| spring.energy((positions.get(spring.other as usize) - here).length())).sum()
}
