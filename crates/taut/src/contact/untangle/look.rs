//! What intersects: edges that pass through triangles, and cloth inside of bodies; and what brings it out of these.

use glam::DVec3;

use super::super::pierce::pierces;
use super::super::proximity::{Closest, Kind};
use super::super::start::{around, range};
use super::super::surfaces::{Owner, Surfaces, Thick};
use super::super::tree::{Leaf, Tree};
use super::out::{Solid, Way};
use super::{Asked, Crossing, SHALLOW, Tangle, sorted};

impl Tangle {
    /// Finds all edges that pass through a triangle which shares no vertex with them.
    pub(super) fn find_crossings(&mut self, surfaces: &Surfaces, x: &[DVec3]) {
        let found = &mut self.crossings;
        for (index, one) in surfaces.cloths.iter().enumerate() {
            if surfaces.among_cloths {
                one.meet_itself(|a, b| {
                    leaves(surfaces, [one, one], [a, b], x, found);
                    if a.triangles != b.triangles {
                        leaves(surfaces, [one, one], [b, a], x, found);
                    }
                });
            }
            let others = surfaces.cloths[index + 1..].iter().filter(|_| surfaces.among_cloths);
            for other in others.chain(&surfaces.bodies) {
                one.meet(other, |a, b| {
                    leaves(surfaces, [one, other], [a, b], x, found);
                    leaves(surfaces, [other, one], [b, a], x, found);
                });
            }
        }
    }

    /// Finds vertices inside of bodies, and asks those out that are not fastened. Returns how many of these are in closed surfaces or behind
    /// planes.
    pub(super) fn find_sunk(&mut self, surfaces: &Surfaces, x: &[DVec3], most: f64) -> usize {
        let Self { solids, cell, sunk, asked, normals, stays, .. } = self;
        let mut count = 0;
        let mut ways: Vec<(&Solid, Way)> = Vec::new();
        for particle in 0..surfaces.particles {
            let out = |solid: &Solid, place: DVec3| solid.way_out(surfaces, x, place, normals[particle], *cell);
            ways.clear();
            ways.extend(solids.iter().filter_map(|solid| Some((solid, out(solid, x[particle])?))));
            sunk.extend(ways.iter().map(|(solid, _)| (particle as u32, solid.owner())));
            // Where bodies overlap, the nearest way that leads out of all of them.
            let leads_out = |(own, way): &(&Solid, Way)| {
                let place = x[particle] + way.normal * (way.depth + 1e-3 * *cell);
                let others = solids.iter().filter(|other| other.owner() != own.owner());
                ways.len() == 1 || others.into_iter().all(|other| out(other, place).is_none())
            };
            let by_depth = |a: &&(&Solid, Way), b: &&(&Solid, Way)| a.1.depth.total_cmp(&b.1.depth);
            let best = ways.iter().filter(|way| leads_out(way)).min_by(by_depth).or_else(|| ways.iter().max_by(by_depth));
            let Some((solid, way)) = best.filter(|_| !stays[particle]) else { continue };
            let thickness = surfaces.thickness([surfaces.owners[particle], solid.owner()]);
            let is_deep = |(solid, Way { depth, .. }): &(&Solid, Way)| match solid {
                Solid::Thick(_) => false,
                Solid::Plane(_) => *depth > SHALLOW * surfaces.thickness([surfaces.owners[particle], solid.owner()]),
                Solid::Closed { .. } => true,
            };
            count += ways.iter().filter(|way| is_deep(way)).count();
            let [a, b, c] = way.corners;
            let [p, q, r] = way.parts;
            asked.push(Asked {
                corners: [particle as u32, a, b, c],
                parts: [1.0, -p, -q, -r],
                split: 1,
                normal: way.normal,
                push: most.min(way.depth + thickness),
            });
        }
        sunk.sort_unstable();
        sunk.dedup();
        count
    }

    /// Finds triangles and links that come nearer to the middle of a sphere or the line of a capsule than its radius. Those without
    /// vertices inside are asked away. Returns how many there are.
    pub(super) fn find_thick(&mut self, surfaces: &Surfaces, x: &[DVec3], most: f64) -> usize {
        let mut count = 0;
        for thick in &surfaces.thick {
            let radius = surfaces.skins[thick.owner as usize].radius;
            let [from, to] = [thick.vertices.start, thick.vertices.end - 1].map(|end| x[end as usize]);
            let bounds = around(from, radius).and(around(to, radius));
            for (cloth, tree) in surfaces.cloths.iter().enumerate() {
                let thickness = surfaces.thickness([cloth as Owner, thick.owner]);
                let mut take = |corners: &[u32], (distance, nearest): (f64, Option<Nearest>)| {
                    if radius - distance <= SHALLOW * thickness {
                        return;
                    }
                    let is_sunk = |&&corner: &&u32| self.sunk.binary_search(&(corner, thick.owner)).is_ok();
                    let mut sunk = corners.iter().filter(is_sunk).peekable();
                    let any_sunk = sunk.peek().is_some();
                    count += usize::from(!sunk.any(|&corner| self.stays[corner as usize]));
                    if any_sunk {
                        return;
                    }
                    if let Some((split, corners, Closest { way, parts })) = nearest.filter(|_| distance > 0.0) {
                        let push = most.min(radius - distance + thickness);
                        self.asked.push(Asked { corners, parts, split, normal: way / distance, push });
                    }
                };
                tree.within(&bounds, true, |leaf| {
                    for triangle in range(leaf.triangles).filter(|&triangle| bounds.meets(&tree.triangle_bounds[triangle])) {
                        let corners = tree.triangles[triangle];
                        take(&corners, to_thick(thick, corners, x));
                    }
                    let links = range(leaf.edges).filter(|_| !tree.is_surface());
                    for link in links.filter(|&link| bounds.meets(&tree.edge_bounds[link])) {
                        let ends = tree.edges[link];
                        take(&ends, link_to_thick(thick, ends, x));
                    }
                });
            }
        }
        count
    }

    /// The normal of a cloth around some of its vertices.
    fn across(&self, vertices: &[u32]) -> DVec3 {
        vertices.iter().map(|&vertex| self.normals[vertex as usize]).sum::<DVec3>().normalize_or_zero()
    }

    /// Finds the normals of all cloths at their vertices.
    pub(super) fn find_normals(&mut self, surfaces: &Surfaces, x: &[DVec3]) {
        self.normals.clear();
        self.normals.resize(surfaces.particles, DVec3::ZERO);
        for &corners in surfaces.cloths.iter().flat_map(|tree| &tree.triangles) {
            let [a, b, c] = corners.map(|corner| x[corner as usize]);
            let area = (b - a).cross(c - a);
            corners.iter().for_each(|&corner| self.normals[corner as usize] += area);
        }
        self.normals.iter_mut().for_each(|normal| *normal = normal.normalize_or_zero());
    }

    /// Brings edges and triangles without vertices inside out of closed surfaces that they pass through.
    pub(super) fn leave_closed(&mut self, surfaces: &Surfaces, x: &[DVec3], most: f64) {
        let cloths = surfaces.cloths.len() as Owner;
        for index in 0..self.solids.len() {
            let solid = self.solids[index].clone();
            let Solid::Closed { owner, .. } = solid else { continue };
            let through = |one: Owner, other: Owner| one < cloths && other == owner;
            let mut edges: Vec<Crossing> =
                self.crossings.iter().copied().filter(|at| through(at.owners[0], at.owners[1])).collect();
            edges.sort_by_key(|at| at.edge);
            for of_edge in edges.chunk_by(|a, b| a.edge == b.edge) {
                let edge = of_edge[0].edge;
                self.edges.push((edge, owner));
                if edge.iter().any(|&end| self.is_sunk(end, owner)) {
                    continue;
                }
                let [p, q] = edge.map(|end| x[end as usize]);
                let along = |at: &Crossing| ((at.place - p).dot(q - p) / (q - p).length_squared()).clamp(0.0, 1.0);
                let mut parts: Vec<f64> = of_edge.iter().map(along).collect();
                parts.sort_by(f64::total_cmp);
                for inside in parts.chunks_exact(2) {
                    let part = 0.5 * (inside[0] + inside[1]);
                    let across = self.across(&edge);
                    let Some(way) = solid.way_out(surfaces, x, p.lerp(q, part), across, self.cell) else { continue };
                    let thickness = surfaces.thickness([of_edge[0].owners[0], owner]);
                    self.asked.push(Asked {
                        corners: [edge[0], edge[1], way.corner(), way.corner()],
                        parts: [1.0 - part, part, -1.0, 0.0],
                        split: 2,
                        normal: way.normal,
                        push: most.min(way.depth + thickness),
                    });
                }
            }
            let mut triangles: Vec<Crossing> =
                self.crossings.iter().copied().filter(|at| through(at.owners[1], at.owners[0])).collect();
            triangles.sort_by_key(|at| at.triangle);
            for of_triangle in triangles.chunk_by(|a, b| a.triangle == b.triangle) {
                let corners = of_triangle[0].triangle;
                self.triangles.push((sorted(corners), owner));
                if corners.iter().any(|&corner| self.is_sunk(corner, owner)) {
                    continue;
                }
                let middle = of_triangle.iter().map(|at| at.place).sum::<DVec3>() / of_triangle.len() as f64;
                let Some(way) = solid.way_out(surfaces, x, middle, self.across(&corners), self.cell) else { continue };
                let [a, b, c] = corners;
                let closest = Closest::new(Kind::PointTriangle, &[middle, x[a as usize], x[b as usize], x[c as usize]]);
                let thickness = surfaces.thickness([of_triangle[0].owners[1], owner]);
                self.asked.push(Asked {
                    corners: [way.corner(), a, b, c],
                    parts: closest.parts,
                    split: 1,
                    normal: -way.normal,
                    push: most.min(way.depth + thickness),
                });
            }
        }
    }
}

/// The edges of a leaf, and the triangles of another.
fn leaves(surfaces: &Surfaces, [a, b]: [&Tree; 2], [one, two]: [&Leaf; 2], x: &[DVec3], found: &mut Vec<Crossing>) {
    for index in range(one.edges) {
        let edge = a.edges[index];
        for other in range(two.triangles) {
            let triangle = b.triangles[other];
            if !a.edge_bounds[index].meets(&b.triangle_bounds[other]) || edge.iter().any(|end| triangle.contains(end)) {
                continue;
            }
            let place = pierces(edge.map(|end| x[end as usize]), triangle.map(|corner| x[corner as usize]));
            if let Some(place) = place {
                let owners = [edge[0], triangle[0]].map(|vertex| surfaces.owners[vertex as usize]);
                found.push(Crossing { edge, triangle, place, owners });
            }
        }
    }
}

/// A pair: where its first feature ends, its corners, and where it is closest.
type Nearest = (usize, [u32; 4], Closest);

/// A pair with its distance [m].
fn pair_of(kind: Kind, corners: [u32; 4], x: &[DVec3]) -> (f64, Option<Nearest>) {
    let closest = Closest::new(kind, &corners.map(|corner| x[corner as usize]));
    (closest.way.length(), Some((kind.split(), corners, closest)))
}

/// How near a triangle comes to the middle of a sphere or the line of a capsule [m], and the pair that does; none if the line passes
/// through it.
fn to_thick(thick: &Thick, [a, b, c]: [u32; 3], x: &[DVec3]) -> (f64, Option<Nearest>) {
    let pair = |kind: Kind, corners: [u32; 4]| pair_of(kind, corners, x);
    let [from, to] = [thick.vertices.start, thick.vertices.end - 1];
    let first = pair(Kind::PointTriangle, [from, a, b, c]);
    if from == to {
        return first;
    }
    if pierces([from, to].map(|end| x[end as usize]), [a, b, c].map(|corner| x[corner as usize])).is_some() {
        return (0.0, None);
    }
    let sides = [[a, b], [b, c], [c, a]].map(|[p, q]| pair(Kind::EdgeEdge, [from, to, p, q]));
    let others = [pair(Kind::PointTriangle, [to, a, b, c])].into_iter().chain(sides);
    others.fold(first, |best, other| if other.0 < best.0 { other } else { best })
}

/// How near a link comes to them [m], and the pair that does.
fn link_to_thick(thick: &Thick, [a, b]: [u32; 2], x: &[DVec3]) -> (f64, Option<Nearest>) {
    pair_of(Kind::EdgeEdge, [thick.vertices.start, thick.vertices.end - 1, a, b], x)
}
