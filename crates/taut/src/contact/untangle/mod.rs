//! What intersects at the start is brought apart, little by little, in the first steps.
//!
//! Contact makes no crossing and takes none back. So while anything intersects, each step looks at its start for what does (look.rs),
//! and asks for rows that bring it apart: cloth inside of a body goes the nearest way out (out.rs), of two cloths the outer one goes
//! to the outer side of the inner one (sides.rs), and what crosses itself goes where the line along which it does gets shorter
//! (contour.rs). These are rows like all others, so the limit of the cloth stays hard. Only pairs in such places are spared by the
//! ordinary rows and the certificate; everything else stays free of crossings. Where nothing intersects any more this ends for good.
//! What pins hold inside of a body stays there (fastened.rs).

mod contour;
mod fastened;
mod look;
mod out;
mod sides;

use glam::DVec3;

use super::bounds::Bounds;
use super::detect::{Candidate, Pair};
use super::start::{around, is_closed};
use super::surfaces::{Owner, Surfaces};
use crate::geometry::{Pool, Vectors};
use crate::model::Model;
use fastened::Fastened;
use out::{Solid, Way};

/// So many mean edges a second what intersects is brought apart [1/s].
const PACE: f64 = 8.0;
/// Cloth may be this part of its thickness inside of a sphere, a capsule or a plane [1]: places are rounded.
const SHALLOW: f64 = 1e-3;

/// An edge that passes through a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Crossing {
    edge: [u32; 2],
    triangle: [u32; 3],
    /// Where [m].
    place: DVec3,
    /// Whose the edge is, and whose the triangle.
    owners: [Owner; 2],
}

/// A row that brings two features apart: how far they go along a normal in this step, at least.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Asked {
    pub corners: [u32; 4],
    /// Those of the first `split` corners add up to 1, the others to -1.
    pub parts: [f64; 4],
    pub split: usize,
    pub normal: DVec3,
    /// [m].
    pub push: f64,
}

/// What intersects, and what is asked of it.
pub(crate) struct Tangle {
    solids: Vec<Solid>,
    /// The layer of each cloth.
    layers: Vec<u32>,
    /// The mean length of edges, and how far a step brings things apart [m].
    cell: f64,
    most: f64,
    /// The edges of all triangles in rising order, each with the third corner of one of its triangles.
    sides: Vec<([u32; 2], u32)>,
    /// Whether a vertex is on a border.
    border: Vec<bool>,
    fastened: Fastened,
    /// Whether anything is spared in this step, and whether anything is brought apart; nothing below counts where nothing is spared.
    is_on: bool,
    brings_apart: bool,
    /// Of cloths at their vertices.
    normals: Vec<DVec3>,
    crossings: Vec<Crossing>,
    asked: Vec<Asked>,
    /// Vertices of surfaces without inside near crossings, or on the wrong side.
    zone: Vec<bool>,
    /// Vertices of cloths inside of bodies, or fastened there, and edges and triangles (corners in rising order) that pass through closed ones.
    sunk: Vec<(u32, Owner)>,
    /// Whether a vertex is fastened in a body.
    stays: Vec<bool>,
    edges: Vec<([u32; 2], Owner)>,
    triangles: Vec<([u32; 3], Owner)>,
}

impl Tangle {
    pub fn new(model: &Model, surfaces: &Surfaces) -> Self {
        let mut solids: Vec<Solid> = surfaces.thick.iter().cloned().map(Solid::Thick).collect();
        solids.extend(surfaces.planes.iter().cloned().map(Solid::Plane));
        for (body, tree) in surfaces.bodies.iter().enumerate().filter(|(_, tree)| is_closed(&tree.triangles)) {
            solids.push(Solid::Closed { owner: surfaces.owners[tree.vertices[0] as usize], body });
        }
        let mut sides = Vec::new();
        for &[a, b, c] in surfaces.cloths.iter().chain(&surfaces.bodies).flat_map(|tree| &tree.triangles) {
            sides.extend([([a.min(b), a.max(b)], c), ([b.min(c), b.max(c)], a), ([c.min(a), c.max(a)], b)]);
        }
        sides.sort_unstable();
        let mut border = vec![false; surfaces.count()];
        for side in sides.chunk_by(|a, b| a.0 == b.0).filter(|side| side.len() == 1) {
            side[0].0.iter().for_each(|&vertex| border[vertex as usize] = true);
        }
        Self {
            layers: model.contact.cloths.iter().map(|side| side.layer).collect(),
            cell: model.contact.cell,
            most: 0.0,
            sides,
            border,
            fastened: Fastened::new(model),
            is_on: false,
            brings_apart: false,
            solids,
            normals: Vec::new(),
            crossings: Vec::new(),
            asked: Vec::new(),
            zone: vec![false; surfaces.count()],
            sunk: Vec::new(),
            stays: vec![false; surfaces.count()],
            edges: Vec::new(),
            triangles: Vec::new(),
        }
    }

    /// Nothing intersects.
    pub fn rest(&mut self) {
        (self.is_on, self.brings_apart) = (false, false);
    }

    /// Whether anything is spared: the next step has to look again.
    pub fn is_on(&self) -> bool {
        self.is_on
    }

    /// How far a step brings things apart [m]; none where it brings nothing apart.
    pub fn most(&self) -> Option<f64> {
        self.brings_apart.then_some(self.most)
    }

    /// What is asked for in this step.
    pub fn asked(&self) -> &[Asked] {
        if self.brings_apart { &self.asked } else { &[] }
    }

    /// Looks for what intersects at the start of a step of so many seconds, and asks for rows. Returns at how many places, without those
    /// where cloth is fastened.
    pub fn look(&mut self, surfaces: &mut Surfaces, x: &[DVec3], step: f64) -> usize {
        self.crossings.clear();
        self.asked.clear();
        self.sunk.clear();
        self.edges.clear();
        self.triangles.clear();
        let bounds: Vec<Bounds> = x.iter().map(|&x| around(x, 0.0)).collect();
        let all = vec![true; bounds.len()];
        for tree in surfaces.cloths.iter_mut().chain(&mut surfaces.bodies) {
            tree.refit(&bounds, &all, &Pool::new(1));
        }
        let surfaces = &*surfaces;
        let most = PACE * self.cell * step;
        self.most = most;
        self.find_normals(surfaces, x);
        self.find_crossings(surfaces, x);
        self.find_fastened(surfaces, x);
        let inside = self.find_sunk(surfaces, x, most) + self.find_thick(surfaces, x, most);
        let count = inside + self.crossings.iter().filter(|crossing| !self.is_fastened(crossing)).count();
        self.brings_apart = count > 0;
        if !self.brings_apart {
            // What is in a body as rounding has it is none of this.
            let stays = &self.stays;
            self.sunk.retain(|&(vertex, _)| stays[vertex as usize]);
        }
        self.is_on = self.brings_apart || !self.sunk.is_empty();
        if self.brings_apart {
            self.zone.fill(false);
            self.leave_closed(surfaces, x, most);
            let settled = self.take_sides(surfaces, x, most);
            self.shorten_contours(surfaces, x, most, &settled);
            self.edges.sort_unstable();
            self.triangles.sort_unstable();
        }
        count
    }

    /// Leaves pairs out that must be free to pass each other.
    pub fn spare(&self, surfaces: &Surfaces, pairs: &mut Vec<Candidate>) {
        if self.is_on {
            pairs.retain(|candidate| !self.is_spared(surfaces, &candidate.pair));
        }
    }

    /// The same of vertices beside what is thick, each with the number of that.
    pub fn spare_sunk(&self, surfaces: &Surfaces, beside: &mut Vec<(u32, u32)>) {
        if self.is_on {
            beside.retain(|&(vertex, thick)| !self.is_sunk(vertex, surfaces.thick[thick as usize].owner));
        }
    }

    fn is_spared(&self, surfaces: &Surfaces, pair: &Pair) -> bool {
        let (one, other) = pair.corners.split_at(pair.kind.split());
        let in_zone = |feature: &[u32]| feature.iter().any(|&corner| self.zone[corner as usize]);
        if in_zone(one) && in_zone(other) {
            return true;
        }
        let owner = |feature: &[u32]| surfaces.owners[feature[0] as usize];
        let is_cloth = |feature: &[u32]| (owner(feature) as usize) < surfaces.cloths.len();
        match (is_cloth(one), is_cloth(other)) {
            (true, false) => self.passes(one, owner(other)),
            (false, true) => self.passes(other, owner(one)),
            _ => false,
        }
    }

    /// Whether a vertex, an edge or a triangle of a cloth is in a body, or passes through its surface.
    fn passes(&self, feature: &[u32], body: Owner) -> bool {
        if feature.iter().any(|&vertex| self.is_sunk(vertex, body)) {
            return true;
        }
        let has_edge = |a: u32, b: u32| self.edges.binary_search(&([a.min(b), a.max(b)], body)).is_ok();
        match *feature {
            [a, b] => has_edge(a, b),
            [a, b, c] => {
                let corners = sorted([a, b, c]);
                self.triangles.binary_search(&(corners, body)).is_ok() || has_edge(a, b) || has_edge(b, c) || has_edge(c, a)
            }
            _ => false,
        }
    }

    fn is_sunk(&self, vertex: u32, body: Owner) -> bool {
        self.sunk.binary_search(&(vertex, body)).is_ok()
    }

    /// Whether a vertex is fastened in a body.
    pub fn stays(&self, vertex: u32, body: Owner) -> bool {
        self.is_on && self.stays[vertex as usize] && self.is_sunk(vertex, body)
    }

    /// Whether an edge passes through a triangle because cloth is fastened in a body.
    fn is_fastened(&self, &Crossing { edge, triangle, owners: [one, other], .. }: &Crossing) -> bool {
        let stays = |feature: &[u32], body: Owner| {
            feature.iter().any(|&vertex| self.stays[vertex as usize] && self.is_sunk(vertex, body))
        };
        stays(&edge, other) || stays(&triangle, one)
    }

    /// Takes from velocities what the rows have brought apart: it does not fly on. `d` is how far bodies go in a step of so many
    /// seconds [m].
    pub fn calm(&self, surfaces: &Surfaces, velocities: &mut Vectors, d: impl Fn(usize) -> DVec3, step: f64) {
        for asked in self.asked() {
            let corners = asked.corners.map(|corner| corner as usize);
            let velocity = |corner: usize| {
                if corner < surfaces.particles { velocities.get(corner).as_dvec3() } else { d(corner) / step }
            };
            let apart: f64 = (0..4).map(|end| asked.parts[end] * asked.normal.dot(velocity(corners[end]))).sum();
            let weight = |end: usize| f64::from(surfaces.weights[corners[end]]);
            let all: f64 = (0..4).map(|end| asked.parts[end] * asked.parts[end] * weight(end)).sum();
            if apart <= 0.0 || all <= 0.0 {
                continue;
            }
            for end in (0..4).filter(|&end| asked.parts[end] != 0.0 && weight(end) > 0.0) {
                let back = asked.normal * (-apart * asked.parts[end] * weight(end) / all);
                velocities.set(corners[end], velocities.get(corners[end]) + back.as_vec3());
            }
        }
    }
}

/// In rising order.
fn sorted<const N: usize>(mut corners: [u32; N]) -> [u32; N] {
    corners.sort_unstable();
    corners
}

impl Way {
    /// The corner of the body that is nearest to where it leads.
    fn corner(&self) -> u32 {
        let part = |&(part, _): &(f64, u32)| part;
        let all = self.parts.into_iter().zip(self.corners);
        all.max_by(|a, b| part(a).total_cmp(&part(b))).map_or(self.corners[0], |(_, corner)| corner)
    }
}
