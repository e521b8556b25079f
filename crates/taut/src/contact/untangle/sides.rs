//! Two cloths that cross: the outer one goes to the outer side of the inner one.
//!
//! Of two cloths with different layers the one with the higher layer is outside. Which side of the inner one is its outer one is said by
//! the bodies, as it looks away from them; without bodies by its own shape, as it looks away from its middle; if it is flat, by the outer
//! cloth, most of which is there. Of two cloths of one layer each is on the side where most of it is already. A network has no sides: it
//! goes to one side of the cloth that it crosses, whichever of them is outside.

use std::collections::VecDeque;

use glam::DVec3;

use super::super::proximity::Closest;
use super::super::surfaces::{Owner, Surfaces};
use super::super::tree::Tree;
use super::out::{Solid, nearest};
use super::{Asked, Tangle};

/// Cloth is looked for so many mean edges from where it crosses, and so many thicknesses.
const REACH: f64 = 1.5;
const REACH_OF_THICKNESS: f64 = 3.0;
/// Vertices on the right side are kept there if they are nearer than so many thicknesses [1].
const MARGIN: f64 = 1.5;
/// A cloth looks away from something if it does so by this part of its area at least [1].
const CLEAR: f64 = 0.25;
/// Cloths that are nearly at right angles have no common sides: the least cosine between their normals.
const ALIKE: f64 = 0.3;
/// So many vertices of a cloth are asked about bodies.
const SAMPLES: usize = 200;

/// A cloth against another one.
struct Facing<'a> {
    /// Of the other one.
    tree: &'a Tree,
    /// Which way its normals count: 1 or -1; those of the outer cloth are compared with those at each vertex.
    sign: Option<f64>,
    /// The normals of the inner cloth at its vertices, outwards.
    outwards: &'a [DVec3],
    reach: f64,
    thickness: f64,
    most: f64,
}

impl Tangle {
    /// Asks vertices of cloths that cross each other to the right side. Returns which vertices are asked, as they are on the wrong one.
    pub(super) fn take_sides(&mut self, surfaces: &Surfaces, x: &[DVec3], most: f64) -> Vec<bool> {
        let mut settled = vec![false; x.len()];
        let cloths = surfaces.cloths.len() as Owner;
        let mut meetings: Vec<[Owner; 2]> =
            self.crossings.iter().map(|crossing| super::sorted(crossing.owners)).filter(|[a, b]| a != b && *b < cloths).collect();
        meetings.sort_unstable();
        meetings.dedup();
        for [one, other] in meetings {
            let is_layered = self.layers[one as usize] != self.layers[other as usize];
            let (mut inner, mut outer) =
                if self.layers[one as usize] <= self.layers[other as usize] { (one, other) } else { (other, one) };
            let mut looks = 1.0;
            if !surfaces.skins[inner as usize].is_surface {
                (inner, outer, looks) = (outer, inner, -1.0);
            }
            let trees = [inner, outer].map(|cloth| &surfaces.cloths[cloth as usize]);
            let thickness = surfaces.thickness([inner, outer]);
            let reach = (REACH * self.cell).max(REACH_OF_THICKNESS * thickness);
            let sign = Some(())
                .filter(|()| is_layered)
                .and_then(|()| self.away_from_bodies(surfaces, trees[0], x).or_else(|| away_from_middle(trees[0], x)))
                .map(|sign| sign * looks)
                .unwrap_or_else(|| self.majority(trees, x, reach));
            let outwards: Vec<DVec3> = self.normals.iter().map(|normal| *normal * sign).collect();
            let facing = |tree, sign| Facing { tree, sign, outwards: &outwards, reach, thickness, most };
            self.face(surfaces, x, outer, &facing(trees[0], Some(sign)), &mut settled);
            self.face(surfaces, x, inner, &facing(trees[1], None), &mut settled);
        }
        settled
    }

    /// Asks the vertices of a cloth that are on the wrong side of another one, as far as they hang together with what crosses it, and keeps
    /// those around them on the right one.
    fn face(&mut self, surfaces: &Surfaces, x: &[DVec3], own: Owner, facing: &Facing<'_>, settled: &mut [bool]) {
        let other = surfaces.owners[facing.tree.vertices[0] as usize];
        let mut seen = vec![false; x.len()];
        let mut queue = VecDeque::new();
        for crossing in &self.crossings {
            if super::sorted(crossing.owners) == super::sorted([own, other]) {
                let all = crossing.edge.iter().chain(&crossing.triangle);
                for &vertex in all.filter(|&&vertex| surfaces.owners[vertex as usize] == own) {
                    if !std::mem::replace(&mut seen[vertex as usize], true) {
                        queue.push_back((vertex, true));
                    }
                }
            }
        }
        while let Some((vertex, crosses)) = queue.pop_front() {
            let mut is_wrong = false;
            if let Some((triangle, normal, side)) = self.side(x, vertex, facing) {
                let [a, b, c] = facing.tree.triangles[triangle];
                is_wrong = side < 0.0;
                if side < MARGIN * facing.thickness {
                    let place = x[vertex as usize] - normal * side;
                    let corners = [a, b, c].map(|corner| x[corner as usize]);
                    let closest =
                        Closest::new(super::super::proximity::Kind::PointTriangle, &[place, corners[0], corners[1], corners[2]]);
                    // Those on the right side already only stay there.
                    let push = (facing.thickness - side).min(facing.most);
                    self.asked.push(Asked { corners: [vertex, a, b, c], parts: closest.parts, split: 1, normal, push });
                    [vertex, a, b, c].iter().for_each(|&corner| self.zone[corner as usize] = true);
                }
            }
            settled[vertex as usize] |= is_wrong;
            if is_wrong || crosses {
                for &next in surfaces.ring.of(vertex as usize) {
                    if !std::mem::replace(&mut seen[next as usize], true) {
                        queue.push_back((next, false));
                    }
                }
            }
        }
    }

    /// The nearest triangle of another cloth, the direction in which a vertex should be seen from there, and how far it is in it [m]; none
    /// where nothing is near, or that is a border, beyond which there are no sides.
    fn side(&self, x: &[DVec3], vertex: u32, facing: &Facing<'_>) -> Option<(usize, DVec3, f64)> {
        let place = x[vertex as usize];
        let (triangle, closest) = nearest(facing.tree, x, place, facing.reach)?;
        let corners = facing.tree.triangles[triangle];
        let parts = [closest.parts[1], closest.parts[2], closest.parts[3]];
        let is_inner = parts.iter().all(|&part| part != 0.0);
        let on_border = |(&corner, &part): (&u32, &f64)| part == 0.0 || self.border[corner as usize];
        if !is_inner && corners.iter().zip(&parts).all(on_border) {
            return None;
        }
        let [a, b, c] = corners.map(|corner| x[corner as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let toward = match facing.sign {
            Some(sign) => normal * sign,
            None => {
                let cosine = normal.dot(facing.outwards[vertex as usize]);
                if cosine.abs() < ALIKE {
                    return None;
                }
                if cosine > 0.0 { -normal } else { normal }
            }
        };
        let length = closest.way.length();
        let side = if toward.dot(closest.way) < 0.0 { -length } else { length };
        // Across an edge the way is no normal of the triangle.
        let direction = if is_inner || length <= 1e-9 * facing.reach { toward } else { closest.way / side };
        Some((triangle, direction, side))
    }

    /// Which way a cloth looks away from bodies, if it does.
    fn away_from_bodies(&self, surfaces: &Surfaces, tree: &Tree, x: &[DVec3]) -> Option<f64> {
        let every = tree.vertices.len().div_ceil(SAMPLES);
        let (mut sum, mut all) = (0.0, 0.0);
        for &vertex in tree.vertices.iter().step_by(every.max(1)) {
            let normal = self.normals[vertex as usize];
            if let Some(away) = self.away(surfaces, x, x[vertex as usize]) {
                sum += normal.dot(away);
                all += normal.length();
            }
        }
        (sum.abs() > CLEAR * all).then(|| sum.signum())
    }

    /// The direction away from the nearest body, if there is one that is no plane: far away, or inside, as well.
    fn away(&self, surfaces: &Surfaces, x: &[DVec3], place: DVec3) -> Option<DVec3> {
        let mut best: Option<(f64, DVec3)> = None;
        for solid in &self.solids {
            let (distance, away) = match solid {
                Solid::Plane(_) => continue,
                Solid::Thick(thick) => {
                    let [start, end] = [thick.vertices.start, thick.vertices.end - 1].map(|end| x[end as usize]);
                    let line = end - start;
                    let square = line.length_squared();
                    let part = if square > 0.0 { (line.dot(place - start) / square).clamp(0.0, 1.0) } else { 0.0 };
                    let away = place - (start + line * part);
                    (away.length() - surfaces.skins[thick.owner as usize].radius, away)
                }
                Solid::Closed { body, .. } => {
                    if let Some(way) = solid.way_out(surfaces, x, place, DVec3::ZERO, self.cell) {
                        (-way.depth, way.normal)
                    } else {
                        let mut radius = self.cell;
                        let found = (0..24).find_map(|_| {
                            let found = nearest(&surfaces.bodies[*body], x, place, radius);
                            radius *= 2.0;
                            found
                        });
                        let Some((_, closest)) = found else { continue };
                        (closest.way.length(), closest.way)
                    }
                }
            };
            if best.is_none_or(|best| distance < best.0) {
                best = Some((distance, away.normalize_or_zero()));
            }
        }
        best.map(|(_, away)| away)
    }

    /// On which side of the first cloth most of the second is, of what is near.
    fn majority(&self, [inner, outer]: [&Tree; 2], x: &[DVec3], reach: f64) -> f64 {
        let facing = Facing { tree: inner, sign: Some(1.0), outwards: &[], reach, thickness: 0.0, most: 0.0 };
        let sides = outer.vertices.iter().filter_map(|&vertex| self.side(x, vertex, &facing));
        let sum: f64 = sides.map(|(_, _, side)| if side < 0.0 { -1.0 } else { 1.0 }).sum();
        if sum < 0.0 { -1.0 } else { 1.0 }
    }
}

/// Which way a cloth looks away from its own middle, if it does.
fn away_from_middle(tree: &Tree, x: &[DVec3]) -> Option<f64> {
    let middle = tree.vertices.iter().map(|&vertex| x[vertex as usize]).sum::<DVec3>() / tree.vertices.len() as f64;
    let (mut sum, mut all) = (0.0, 0.0);
    for &[a, b, c] in &tree.triangles {
        let [a, b, c] = [a, b, c].map(|corner| x[corner as usize]);
        let (area, away) = ((b - a).cross(c - a), (a + b + c) / 3.0 - middle);
        sum += area.dot(away);
        all += area.length() * away.length();
    }
    (sum.abs() > CLEAR * all).then(|| sum.signum())
}
