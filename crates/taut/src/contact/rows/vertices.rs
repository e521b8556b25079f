//! Rows of single vertices of cloth with bodies that are round or flat: half-spaces that are exact for a vertex, whatever its neighbours do.
//!
//! Beside a sphere the nearest place of a triangle is in its middle, as soon as its corners are about as far away as each other. Rows of
//! triangles alone would leave corners free to go up and down against one another: each triangle's middle stays where it is, and springs
//! are all that holds the corners. So each vertex has a row of its own, and a triangle or an edge has one only where it cuts deeper into
//! the round than its corners do by more than [`SAG`] allows, or than pairs.rs measures.

use glam::DVec3;

use super::super::detect::Detection;
use super::super::surfaces::{HalfSpace, Surfaces, Thick};
use super::super::untangle::Tangle;
use super::super::{MARGIN, Places};
use super::Rows;
use super::wanted::{Wanted, carried};
use crate::geometry::Pool;

/// What triangles and edges may cut off below their corners, as a part of the thickness [1].
const SAG: f64 = 0.1;

impl Rows {
    /// Makes rows of particles in front of planes, but of those that stay behind.
    pub fn take_planes(&mut self, surfaces: &Surfaces, places: &Places, tangle: &Tangle) {
        for &HalfSpace { owner, vertex, normal } in &surfaces.planes {
            for particle in (0..surfaces.particles as u32).filter(|&particle| !tangle.stays(particle, owner)) {
                let at = |places: &[DVec3]| normal.dot(places[particle as usize] - places[vertex as usize]);
                let single = Single {
                    corners: [particle, vertex, vertex],
                    parts: [1.0, -1.0, 0.0],
                    owner,
                    normal,
                    distances: [at(&places.x), at(&places.ends)],
                };
                if let Some(wanted) = single.wanted(surfaces, places) {
                    self.add(self.row(surfaces, &wanted));
                }
            }
        }
    }

    /// The same of vertices beside spheres and capsules.
    pub fn take_thick(&mut self, surfaces: &Surfaces, places: &Places, detection: &Detection, pool: &Pool) {
        self.take_each(&detection.beside, surfaces, pool, |(particle, number)| {
            let Thick { owner, vertices } = &surfaces.thick[number as usize];
            let corners = [particle, vertices.start, vertices.end - 1];
            let [p, a, b] = corners.map(|corner| places.x[corner as usize]);
            let axis = b - a;
            let square = axis.length_squared();
            let part = if square > 0.0 { ((p - a).dot(axis) / square).clamp(0.0, 1.0) } else { 0.0 };
            let parts = [1.0, part - 1.0, -part];
            let way = (p - a) - axis * part;
            // In the very middle no way leads out.
            let normal = way.try_normalize()?;
            let radius = surfaces.skins[*owner as usize].radius;
            let end: DVec3 = corners.iter().zip(parts).map(|(&corner, part)| places.ends[corner as usize] * part).sum();
            let distances = [normal.dot(way) - radius, normal.dot(end) - radius];
            Single { corners, parts, owner: *owner, normal, distances }.wanted(surfaces, places)
        });
    }
}

/// A vertex, the ends of what it is near, and the parts of all three.
struct Single {
    corners: [u32; 3],
    parts: [f64; 3],
    /// Whose the latter is.
    owner: u32,
    normal: DVec3,
    /// At the start of the step and at its end, along the normal [m].
    distances: [f64; 2],
}

impl Single {
    /// What it asks for, if it is near or comes near.
    fn wanted(self, surfaces: &Surfaces, places: &Places) -> Option<Wanted> {
        let Self { corners: [particle, first, last], parts: [own, one, other], owner, normal, distances: [distance, then] } =
            self;
        let owners = [surfaces.owners[particle as usize], owner];
        let thickness = surfaces.thickness(owners);
        (distance.min(then) <= MARGIN * thickness).then(|| Wanted {
            corners: [particle, first, last, last],
            parts: [own, one, other, 0.0],
            split: 1,
            owners,
            normal,
            distance,
            thickness,
            target: places.target(thickness, distance),
            carried: carried(surfaces, places, owners, normal),
        })
    }
}

/// The square of the longest sides of a triangle or an edge that vertices stand for beside something round, wherever it lies [m^2]: a chord
/// of length e between two places outside of a circle of radius r cuts e^2 / 8 r deep into it at most, a triangle with such sides e^2 / 6 r
/// or as deep as one of its sides.
pub(in super::super) fn square_stood_for(radius: f64, thickness: f64) -> f64 {
    6.0 * SAG * thickness * radius
}
