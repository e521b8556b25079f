//! Garments are fastened: pins hold cloth inside of a body, as a flag in its pole. What hangs on them too short to come out stays there.
//! Nothing asks it out, and it is free to pass the surface of that body; everything else is kept out of it as ever.

use glam::DVec3;

use super::Tangle;
use crate::contact::surfaces::Surfaces;
use crate::model::{Adjacency, Model, Reach};

/// What could hardly come out stays as well: what is this much further from its pin than the surface of the body [1]. It would have to be
/// stretched as far as it goes, along with all around it.
const HARDLY: f64 = 1.1;

/// What hangs on pins.
pub(super) struct Fastened {
    pinned: Vec<u32>,
    /// Of each pinned particle those to which it is the nearest along springs, and how far they can be from it [m], in rising order.
    hanging: Adjacency<(u32, f32)>,
}

impl Fastened {
    pub fn new(model: &Model) -> Self {
        let (springs, particles) = (&model.springs, model.particle_count());
        let pinned: Vec<u32> = model.particles.held(0..particles).map(|particle| particle as u32).collect();
        let graph = Adjacency::new(particles, springs.ways(0..springs.type1));
        let Reach { lengths, from } = Reach::new(&graph, particles, &pinned);
        let within = (0..particles as u32).filter(|&particle| lengths[particle as usize].is_finite());
        let mut within: Vec<(u32, (u32, f32))> =
            within.map(|particle| (from[particle as usize], (particle, lengths[particle as usize] as f32))).collect();
        within.sort_by(|(_, one), (_, other)| one.1.total_cmp(&other.1));
        Self { hanging: Adjacency::new(pinned.len(), within.into_iter()), pinned }
    }
}

impl Tangle {
    /// Finds what stays in bodies: their surface is further from where it is pinned than it can be, with the thickness.
    pub(super) fn find_fastened(&mut self, surfaces: &Surfaces, x: &[DVec3]) {
        self.stays.fill(false);
        for (number, &pin) in self.fastened.pinned.iter().enumerate() {
            for solid in &self.solids {
                let Some(way) = solid.way_out(surfaces, x, x[pin as usize], DVec3::ZERO, self.cell) else { continue };
                let far = HARDLY * (way.depth + surfaces.thickness([surfaces.owners[pin as usize], solid.owner()]));
                for &(particle, _) in self.fastened.hanging.of(number).iter().take_while(|(_, length)| f64::from(*length) < far) {
                    self.stays[particle as usize] = true;
                    self.sunk.push((particle, solid.owner()));
                }
            }
        }
    }
}
