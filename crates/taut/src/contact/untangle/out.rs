//! The nearest way out of a body.

use glam::DVec3;

use super::super::pierce::above;
use super::super::proximity::{Closest, Kind};
use super::super::start::{around, range};
use super::super::surfaces::{HalfSpace, Owner, Surfaces, Thick};
use super::super::tree::Tree;

/// A way within the cloth counts as this many times as long as one across it.
const WITHIN: f64 = 4.0;

/// A body that has an inside.
#[derive(Debug, Clone)]
pub(super) enum Solid {
    /// A sphere or a capsule.
    Thick(Thick),
    /// What is behind a plane.
    Plane(HalfSpace),
    /// A closed surface: one of the trees of bodies.
    Closed { owner: Owner, body: usize },
}

/// The nearest way from a place inside of a body to its surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    /// How far it is [m].
    pub depth: f64,
    pub normal: DVec3,
    /// The vertices of the body that move with where it leads, and their parts, which add up to 1.
    pub corners: [u32; 3],
    pub parts: [f64; 3],
}

impl Solid {
    pub fn owner(&self) -> Owner {
        match self {
            Self::Thick(thick) => thick.owner,
            Self::Plane(plane) => plane.owner,
            Self::Closed { owner, .. } => *owner,
        }
    }

    /// The way out from a place of a cloth with a normal, if that is inside; `cell` is how far to look first [m]. Cloth goes along its normal
    /// rather than within itself, where its limit lets it go nowhere: out of a box through the side that it lies along.
    pub fn way_out(&self, surfaces: &Surfaces, x: &[DVec3], place: DVec3, across: DVec3, cell: f64) -> Option<Way> {
        match self {
            Self::Thick(thick) => {
                let [from, to] = [thick.vertices.start, thick.vertices.end - 1];
                let (start, line) = (x[from as usize], x[to as usize] - x[from as usize]);
                let square = line.length_squared();
                let part = if square > 0.0 { (line.dot(place - start) / square).clamp(0.0, 1.0) } else { 0.0 };
                let away = place - (start + line * part);
                let (distance, radius) = (away.length(), surfaces.skins[thick.owner as usize].radius);
                // In the very middle all ways are alike.
                let any = || if square > 0.0 { line.normalize().any_orthonormal_vector() } else { DVec3::Z };
                let is_middle = distance <= 1e-9 * radius;
                (distance < radius).then(|| Way {
                    depth: radius - distance,
                    normal: if is_middle { any() } else { away / distance },
                    corners: [from, to, to],
                    parts: [1.0 - part, part, 0.0],
                })
            }
            Self::Plane(HalfSpace { vertex, normal, .. }) => {
                let depth = normal.dot(x[*vertex as usize] - place);
                (depth > 0.0).then_some(Way { depth, normal: *normal, corners: [*vertex; 3], parts: [1.0, 0.0, 0.0] })
            }
            Self::Closed { body, .. } => {
                let tree = &surfaces.bodies[*body];
                if !is_inside(tree, x, place) {
                    return None;
                }
                let mut radius = cell;
                let (triangle, closest) = (0..64).find_map(|_| {
                    let found = nearest(tree, x, place, radius);
                    radius *= 2.0;
                    found
                })?;
                let (triangle, closest) = nearest_across(tree, x, place, across, (triangle, closest));
                let depth = closest.way.length();
                let [a, b, c] = tree.triangles[triangle];
                let [p, q, r] = [a, b, c].map(|corner| x[corner as usize]);
                let normal = if depth > 1e-9 * cell { closest.way / -depth } else { (q - p).cross(r - p).normalize_or_zero() };
                let parts = [-closest.parts[1], -closest.parts[2], -closest.parts[3]];
                Some(Way { depth, normal, corners: [a, b, c], parts })
            }
        }
    }
}

/// Whether a place is inside of a closed surface: a ray upwards from there leaves it once more than it enters it.
pub(super) fn is_inside(tree: &Tree, x: &[DVec3], place: DVec3) -> bool {
    let mut ray = around(place, 0.0);
    ray.high.iter_mut().for_each(|high| high.z = f32::INFINITY);
    let mut crossings = 0;
    tree.within(&ray, true, |leaf| {
        let triangles = range(leaf.triangles).filter(|&triangle| ray.meets(&tree.triangle_bounds[triangle]));
        let met = triangles.filter(|&triangle| above(place, tree.triangles[triangle].map(|corner| (corner, x[corner as usize]))));
        crossings += met.count();
    });
    crossings % 2 == 1
}

/// The triangle that is nearest to a place among those within a radius [m], and where; the way leads from there to the place.
pub(super) fn nearest(tree: &Tree, x: &[DVec3], place: DVec3, radius: f64) -> Option<(usize, Closest)> {
    let bounds = around(place, radius);
    let mut best: Option<(usize, Closest)> = None;
    let mut least = radius;
    tree.within(&bounds, true, |leaf| {
        for triangle in range(leaf.triangles).filter(|&triangle| bounds.meets(&tree.triangle_bounds[triangle])) {
            let [a, b, c] = tree.triangles[triangle].map(|corner| x[corner as usize]);
            let closest = Closest::new(Kind::PointTriangle, &[place, a, b, c]);
            let distance = closest.way.length();
            if distance < least || best.is_none() && distance <= least {
                (best, least) = (Some((triangle, closest)), distance);
            }
        }
    });
    best
}

/// Of the triangles hardly further than the nearest one, the one with the way that is nearest where ways across a cloth are preferred.
fn nearest_across(tree: &Tree, x: &[DVec3], place: DVec3, across: DVec3, nearest: (usize, Closest)) -> (usize, Closest) {
    let cost = |closest: &Closest| {
        let length = closest.way.length();
        let cosine = if length > 0.0 { closest.way.dot(across).abs() / length } else { 1.0 };
        length / (cosine + (1.0 - cosine) / WITHIN)
    };
    let bounds = around(place, WITHIN * nearest.1.way.length());
    let (mut best, mut least) = (nearest, cost(&nearest.1));
    tree.within(&bounds, true, |leaf| {
        for triangle in range(leaf.triangles).filter(|&triangle| bounds.meets(&tree.triangle_bounds[triangle])) {
            let [a, b, c] = tree.triangles[triangle].map(|corner| x[corner as usize]);
            let closest = Closest::new(Kind::PointTriangle, &[place, a, b, c]);
            let cost = cost(&closest);
            if cost < least {
                (best, least) = ((triangle, closest), cost);
            }
        }
    });
    best
}
