//! Rows of what would cross.

use glam::DVec3;

use super::Rows;
use super::wanted::{Wanted, carried, is_near};
use crate::contact::certificate::Cuts;
use crate::contact::proximity::Closest;
use crate::contact::surfaces::Surfaces;
use crate::contact::{NEAR, Places};

impl Rows {
    /// Makes rows of pairs that would cross, with what is closest at the time of impact.
    pub fn take_cuts(&mut self, surfaces: &Surfaces, places: &Places, cuts: &Cuts) {
        for cut in &cuts.list {
            let corners = cut.pair.corners;
            let split = cut.pair.kind.split();
            let (normal, parts) = match cut.plane {
                Some(normal) => (normal, [1.0, -1.0, 0.0, 0.0]),
                None => {
                    let then = corners.map(|corner| {
                        let corner = corner as usize;
                        places.x[corner].lerp(places.ends[corner], cut.allowed)
                    });
                    let closest = Closest::new(cut.pair.kind, &then);
                    (closest.way.normalize_or_zero(), closest.parts)
                }
            };
            let owners = surfaces.owners_of(cut.pair);
            let start: DVec3 = (0..4).map(|end| places.x[corners[end] as usize] * parts[end]).sum();
            let distance = normal.dot(start) - surfaces.radius(owners);
            let are_near = owners[0] == owners[1] && is_near(surfaces, corners, split);
            let thickness = surfaces.thickness(owners) * if are_near { NEAR } else { 1.0 };
            let target = places.target(thickness, cut.distance);
            let carried = carried(surfaces, places, owners, normal);
            let wanted = Wanted { corners, parts, split, owners, normal, distance, thickness, target, carried };
            self.add(self.row(surfaces, &wanted));
        }
    }
}
