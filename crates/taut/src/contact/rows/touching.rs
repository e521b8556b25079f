//! What pushes cloth in a step, for those who ask.

use glam::{DVec3, Vec3};

use super::Rows;
use crate::contact::Places;
use crate::contact::surfaces::Surfaces;

/// A place where cloth is pushed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touching {
    /// The particle of the cloth that is nearest to the place.
    pub particle: u32,
    /// What pushes: a body, or cloth where there is none.
    pub body: Option<u32>,
    /// The place on the cloth at the end of the step [m], from a place near the first cloth.
    pub place: DVec3,
    /// The way in which the cloth is pushed, of length 1.
    pub normal: Vec3,
    /// How hard it is pushed along the normal in the step [kg m]: the sum of masses times displacements.
    pub push: f32,
    /// What friction adds to that, across the normal [kg m].
    pub hold: Vec3,
    /// The vertices of the row, of all cloths and then of all bodies, and the part of both that each takes [1]: below 0 on what pushes.
    pub ends: [(u32, f32); 4],
}

impl Rows {
    /// The rows that pushed in the last step, in their order. Of two cloths the one that the normal points to is told.
    pub(in crate::contact) fn touching<'a>(
        &'a self,
        surfaces: &'a Surfaces,
        places: &'a Places,
    ) -> impl Iterator<Item = Touching> + 'a {
        self.list.iter().filter(|row| row.pushes()).map(move |row| {
            let vertices = row.ends.map(|end| self.vertices[end as usize]);
            // Parts of the first feature are above zero, those of the second below.
            let owner =
                |sign: f32| (0..4).find(|&end| row.parts[end] * sign > 0.0).map(|end| surfaces.owners[vertices[end] as usize]);
            let body = |sign| owner(sign).and_then(|owner| owner.checked_sub(surfaces.cloths.len() as u32));
            let sign = if body(1.0).is_some() { -1.0 } else { 1.0 };
            let (mut place, mut nearest) = (DVec3::ZERO, (0.0, vertices[0]));
            for (&vertex, part) in vertices.iter().zip(row.parts.map(|part| part * sign)) {
                if part > 0.0 {
                    place += places.ends[vertex as usize] * f64::from(part);
                    nearest = if part > nearest.0 { (part, vertex) } else { nearest };
                }
            }
            Touching {
                particle: nearest.1,
                body: body(-sign),
                place,
                normal: row.normal * sign,
                push: row.push,
                hold: row.hold * sign,
                ends: [0, 1, 2, 3].map(|end| (vertices[end], row.parts[end] * sign)),
            }
        })
    }
}
