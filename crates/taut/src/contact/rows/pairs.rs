//! Rows of pairs. Beside a body the rows of single vertices of cloth stand for those of edges and triangles that cut hardly deeper than
//! their corners do.
//!
//! A place on an edge or a triangle is `sum w_i x_i` of its corners. It is d from a body along a normal, and they are d_i from it in rows of
//! their own, along nearly the same normal. The body takes all of them along alike. So rows that keep `d_i >= t` keep the place at
//! `d + sum w_i (t - d_i)` or further: t, but for `sum w_i d_i - d`, by which it cuts deeper. On smooth bodies of many triangles most
//! pairs are such; without their rows each vertex is alone with the body (alone.rs).

use glam::Vec3;

use super::super::detect::{Candidate, Detection};
use super::super::proximity::Kind;
use super::super::surfaces::{Owner, Surfaces};
use super::super::{FLOOR, Places};
use super::wanted::Wanted;
use super::{NONE, Rows};
use crate::geometry::Pool;

/// Edges and triangles may come nearer than their corners keep off by this part of the thickness [1].
const DEEPER: f64 = 0.2;
/// Normals that differ by no more than the angle of this cosine push the same way [1].
const ALIKE: f32 = 0.95;

/// What the nearest row of a vertex with a body says.
#[derive(Debug, Clone, Copy)]
struct Stand {
    body: Owner,
    /// From the body to the vertex.
    normal: Vec3,
    /// At X [m].
    distance: f32,
}

impl Stand {
    const NOWHERE: Self = Self { body: NONE, normal: Vec3::ZERO, distance: f32::INFINITY };
}

/// That of each particle, and the particles that have one.
#[derive(Debug, Default)]
pub(super) struct Stands {
    of: Vec<Stand>,
    some: Vec<u32>,
}

impl Rows {
    /// Makes rows of the pairs that are near, or come near along their normal; `all` says whether none of them is left out. Other rows of
    /// single vertices are there by then.
    pub fn take_pairs(&mut self, surfaces: &Surfaces, places: &Places, detection: &Detection, all: bool, pool: &Pool) {
        let particles = self.particles as u32;
        let is_vertex_beside_body = |Candidate { pair, .. }: &Candidate| {
            pair.kind == Kind::PointTriangle && pair.corners[0] < particles && pair.corners[1] >= particles
        };
        self.take_each(&detection.pairs, surfaces, pool, |candidate| {
            is_vertex_beside_body(&candidate).then(|| Wanted::of(surfaces, places, candidate, all, |_| false))?
        });
        let mut stands = std::mem::take(&mut self.stands);
        stands.clear(self.particles);
        // What brings intersecting things apart needs all rows that there are.
        if all {
            self.tell_stands(surfaces, &mut stands);
        }
        self.take_each(&detection.pairs, surfaces, pool, |candidate| {
            let is_implied = |wanted: &Wanted| stands.imply(surfaces, wanted);
            (!is_vertex_beside_body(&candidate)).then(|| Wanted::of(surfaces, places, candidate, all, is_implied))?
        });
        self.stands = stands;
    }

    /// Tells the nearest rows of vertices that are beside bodies by themselves.
    fn tell_stands(&self, surfaces: &Surfaces, stands: &mut Stands) {
        for row in &self.list {
            let ends = || row.ends.into_iter().zip(row.parts).filter(|(_, part)| *part != 0.0);
            let vertex = |end: u32| self.vertices[end as usize];
            let mut own = ends().filter(|(end, _)| (vertex(*end) as usize) < self.particles);
            let (Some((end, part)), None) = (own.next(), own.next()) else { continue };
            let mut others = ends().map(|(end, _)| vertex(end)).filter(|&other| other as usize >= self.particles);
            // What is held goes its own way.
            if let Some(other) = others.next().filter(|_| self.weights[end as usize] > 0.0) {
                let normal = row.normal * part.signum();
                stands.take(vertex(end), Stand { body: surfaces.owners[other as usize], normal, distance: row.distance });
            }
        }
    }
}

impl Stands {
    fn clear(&mut self, particles: usize) {
        self.of.resize(particles, Stand::NOWHERE);
        self.some.drain(..).for_each(|particle| self.of[particle as usize] = Stand::NOWHERE);
    }

    fn take(&mut self, particle: u32, stand: Stand) {
        let nearest = &mut self.of[particle as usize];
        if nearest.body == NONE {
            self.some.push(particle);
        }
        if stand.distance < nearest.distance {
            *nearest = stand;
        }
    }

    /// Whether the rows of corners keep what is wanted of an edge or a triangle of cloth beside a body.
    fn imply(&self, surfaces: &Surfaces, wanted: &Wanted) -> bool {
        let Wanted { corners, parts, split, owners, normal, distance, thickness, .. } = *wanted;
        let is_cloth = owners.map(|owner| (owner as usize) < surfaces.cloths.len());
        let (own, body, normal) = match is_cloth {
            [true, false] => (0..split, owners[1], normal),
            [false, true] => (split..4, owners[0], -normal),
            _ => return false,
        };
        let normal = normal.as_vec3();
        let mut deeper = -distance;
        for end in own.filter(|&end| parts[end] != 0.0) {
            let stand = &self.of[corners[end] as usize];
            if stand.body != body || stand.normal.dot(normal) < ALIKE {
                return false;
            }
            deeper += parts[end].abs() * f64::from(stand.distance);
        }
        // What is nearer than the certificate allows may lose hardly anything of that.
        deeper <= DEEPER * thickness && distance >= FLOOR * thickness
    }
}
