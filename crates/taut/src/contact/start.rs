//! What is where contact cannot keep it apart: crossings that are there already, and cloth inside of bodies.
//!
//! Contact makes no crossing and takes none back, so that a scene should start without any. This looks at one moment, on its own:
//! edges against triangles that share no vertex with them, whole triangles and links against what is round, vertices against planes and
//! against surfaces that are closed. Two links that touch exactly are told, since which of them
//! is on which side is not said.

use std::collections::BTreeMap;

use glam::DVec3;

use super::bounds::Bounds;
use super::fill;
use super::pierce::{above, pierces};
use super::proximity::{Closest, Kind};
use super::surfaces::tree_of;
use super::tree::{Leaf, Tree};
use crate::geometry::{Pool, Vectors};
use crate::model::{Body, BodyShape, ClothRange, Model};

/// So many places of each pair of things are kept, the first ones; all are counted.
const MOST: usize = 100;
/// Boxes are wider by this part of the largest coordinate: places are rounded to single precision.
const ROUNDING: f32 = 2.0 * f32::EPSILON;
/// Cloth may be this part of its thickness inside of a sphere, a capsule or a plane [1]: places are rounded.
const SHALLOW: f64 = 1e-3;

/// What intersects at one moment.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Intersections {
    /// The number of places.
    pub count: usize,
    /// The first hundred of each pair of things.
    pub places: Vec<Intersection>,
    /// The pairs of things that intersect.
    pub pairs: Vec<Meeting>,
}

/// A cloth and what it intersects.
#[derive(Debug, Clone, PartialEq)]
pub struct Meeting {
    /// The number of places.
    pub count: usize,
    /// The first of them.
    pub first: Intersection,
}

/// A place where cloth intersects something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intersection {
    /// Which cloth.
    pub cloth: usize,
    /// What it intersects.
    pub other: Other,
    /// How.
    pub fault: Fault,
    /// The vertex of that cloth which is nearest, from 0 within the cloth.
    pub vertex: usize,
    /// Where, in the world [m].
    pub place: DVec3,
    /// How deep inside [m]; none where that is not known.
    pub depth: Option<f64>,
}

/// What a cloth intersects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Other {
    /// A cloth; it may be the same one.
    Cloth(usize),
    /// A body.
    Body(usize),
}

/// How two things intersect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// An edge of one passes through a triangle of the other, or touches it; or two links of networks touch exactly.
    Crosses,
    /// Cloth is inside of a body, or behind a plane.
    Inside,
}

impl Intersections {
    /// Finds what intersects where the scene puts everything.
    #[must_use]
    pub fn at_start(model: &Model) -> Self {
        let origins: Vec<DVec3> = model.origins.iter().map(|origin| origin.at).collect();
        Self::find(model, &origins, &model.particles.rest, &model.bodies.rest)
    }

    /// Finds what intersects. Particles are from the origins of their cloths, vertices of bodies in the world [m].
    ///
    /// # Panics
    /// If these are not those of the model.
    #[must_use]
    pub fn find(model: &Model, origins: &[DVec3], positions: &Vectors, bodies: &[DVec3]) -> Self {
        if !model.contact.is_on || model.cloths.is_empty() {
            return Self::default();
        }
        let mut x = vec![DVec3::ZERO; model.particle_count() + bodies.len()];
        fill(&mut x, model, origins, positions, bodies, &Pool::new(1));
        let mut search = Search { model, base: origins[0], x: &x, found: Self::default(), counts: BTreeMap::new() };
        search.run();
        let mut found = search.found;
        found.pairs = search.counts.into_values().collect();
        found
    }

    /// One sentence for each pair of things that intersect at the start of a scene.
    pub fn warnings<'a>(&'a self, model: &'a Model) -> impl Iterator<Item = String> + 'a {
        let is_net = |cloth: usize| model.cloths[cloth].is_network;
        self.pairs.iter().map(move |Meeting { count, first }| {
            let cloth = format!("scene.cloth[{}] ({})", first.cloth, model.cloths[first.cloth].name);
            let other = match first.other {
                Other::Cloth(other) if other == first.cloth => "itself".to_owned(),
                Other::Cloth(other) => format!("cloth[{other}] ({})", model.cloths[other].name),
                Other::Body(body) => format!("body[{body}] ({})", model.bodies.list[body].name),
            };
            let body = if let Other::Body(body) = first.other { Some(&model.bodies.list[body]) } else { None };
            let behind = body.is_some_and(|body| body.shape == BodyShape::Plane);
            let how = match first.fault {
                Fault::Crosses => "intersects",
                Fault::Inside if behind => "is behind",
                Fault::Inside => "is inside of",
            };
            let [x, y, z] = first.place.to_array().map(rounded);
            let deep = first.depth.map_or_else(String::new, |depth| format!(", {} m deep", rounded(depth)));
            let remedy = if matches!(first.other, Other::Cloth(other) if other == first.cloth) {
                if is_net(first.cloth) { "move its points apart, or set contact.self = false" } else { "mend its mesh, or set contact.self = false" }
            } else if body.is_some() {
                "move one of them away, or let the body come with `move`"
            } else {
                "move one of them away"
            };
            let is_pinned = model.particles.held(model.cloths[first.cloth].particles()).next().is_some();
            let then = if model.contact.untangles && body.is_some() && is_pinned {
                "contact brings it apart in the first frames, but for what pins hold there; if that does not end"
            } else if model.contact.untangles {
                "contact brings it apart in the first frames; if that does not end"
            } else {
                "contact takes no crossing back"
            };
            let places = if *count == 1 { "1 place".to_owned() } else { format!("{count} places") };
            format!(
                "{cloth} {how} {other} at the start: {places}, the first at [{x}, {y}, {z}] m near vertex {}{deep}; {then}: {remedy}",
                first.vertex
            )
        })
    }
}

/// A number in few digits.
fn rounded(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}

struct Search<'a> {
    model: &'a Model,
    /// Where coordinates begin, in the world [m].
    base: DVec3,
    /// Of all particles, then of all vertices of bodies.
    x: &'a [DVec3],
    found: Intersections,
    /// Of each pair of things, in their order.
    counts: BTreeMap<(usize, Other), Meeting>,
}

impl Search<'_> {
    fn run(&mut self) {
        let (model, particles) = (self.model, self.model.particle_count());
        let bounds: Vec<Bounds> = self.x.iter().map(|&x| around(x, 0.0)).collect();
        let all = vec![true; bounds.len()];
        let x = self.x;
        let tree = |triangles: &[[u32; 3]]| {
            let mut tree = Tree::new(triangles, |vertex| x[vertex as usize].as_vec3());
            tree.refit(&bounds, &all, &Pool::new(1));
            tree
        };
        let of_cloth = |cloth: &ClothRange| {
            let mut tree = tree_of(model, cloth, |vertex| x[vertex as usize].as_vec3());
            tree.refit(&bounds, &all, &Pool::new(1));
            tree
        };
        let cloths: Vec<Tree> = model.cloths.iter().map(of_cloth).collect();
        if model.contact.among_cloths {
            for (index, one) in cloths.iter().enumerate() {
                self.within(index, one);
                for (other, two) in cloths.iter().enumerate().skip(index + 1) {
                    self.between([one, two], index, Other::Cloth(other));
                }
            }
        }
        for (index, body) in model.bodies.list.iter().enumerate() {
            let other = Other::Body(index);
            match body.shape {
                BodyShape::Plane => self.behind(other, body),
                BodyShape::Sphere | BodyShape::Capsule => {
                    cloths.iter().enumerate().for_each(|(cloth, tree)| self.near(tree, cloth, other, body));
                }
                BodyShape::Surface => {
                    let shifted = |corners: &[u32; 3]| corners.map(|corner| corner + particles as u32);
                    let own: Vec<[u32; 3]> = model.bodies.triangles[body.triangles.clone()].iter().map(shifted).collect();
                    let surface = tree(&own);
                    let closed = is_closed(&own);
                    for (cloth, one) in cloths.iter().enumerate() {
                        self.between([one, &surface], cloth, other);
                        if closed {
                            self.inside(one, &surface, cloth, other);
                        }
                    }
                }
            }
        }
    }

    /// A surface and itself.
    fn within(&mut self, cloth: usize, tree: &Tree) {
        tree.meet_itself(|one, two| {
            self.leaves([tree, tree], [one, two], cloth, Other::Cloth(cloth));
            if one.index != two.index {
                self.leaves([tree, tree], [two, one], cloth, Other::Cloth(cloth));
            }
            self.links([tree, tree], [one, two], cloth, Other::Cloth(cloth));
        });
    }

    /// A cloth, and another surface.
    fn between(&mut self, [a, b]: [&Tree; 2], cloth: usize, other: Other) {
        a.meet(b, |one, two| {
            self.leaves([a, b], [one, two], cloth, other);
            self.leaves([b, a], [two, one], cloth, other);
            self.links([a, b], [one, two], cloth, other);
        });
    }

    /// The edges of a leaf, and the triangles of another.
    fn leaves(&mut self, [a, b]: [&Tree; 2], [one, two]: [&Leaf; 2], cloth: usize, other: Other) {
        for edge in range(one.edges) {
            let ends = a.edges[edge];
            for triangle in range(two.triangles) {
                let corners = b.triangles[triangle];
                if !a.edge_bounds[edge].meets(&b.triangle_bounds[triangle]) || ends.iter().any(|end| corners.contains(end)) {
                    continue;
                }
                let (ends, triangle) = (ends.map(|end| self.x[end as usize]), corners.map(|corner| self.x[corner as usize]));
                if let Some(place) = pierces(ends, triangle) {
                    let all = [a.edges[edge][0], a.edges[edge][1], corners[0], corners[1], corners[2]];
                    self.add((cloth, other), Fault::Crosses, &all, place, None);
                }
            }
        }
    }

    /// Links of two leaves that are at one place and share no vertex.
    fn links(&mut self, [a, b]: [&Tree; 2], [one, two]: [&Leaf; 2], cloth: usize, other: Other) {
        if a.is_surface() || b.is_surface() {
            return;
        }
        let is_one = std::ptr::eq(a, b) && one.index == two.index;
        for edge in range(one.edges) {
            let ends = a.edges[edge];
            for second in range(two.edges).filter(|&second| !is_one || second > edge) {
                let others = b.edges[second];
                if !a.edge_bounds[edge].meets(&b.edge_bounds[second]) || ends.iter().any(|end| others.contains(end)) {
                    continue;
                }
                let corners = [ends[0], ends[1], others[0], others[1]];
                let x = corners.map(|corner| self.x[corner as usize]);
                let Closest { way, parts } = Closest::new(Kind::EdgeEdge, &x);
                if way == DVec3::ZERO {
                    self.add((cloth, other), Fault::Crosses, &corners, x[0].lerp(x[1], parts[1]), None);
                }
            }
        }
    }

    /// Triangles and links that come nearer to a sphere or the line of a capsule than its radius.
    fn near(&mut self, tree: &Tree, cloth: usize, other: Other, body: &Body) {
        let first = self.model.particle_count() + body.vertices.start;
        let [from, to] = [self.x[first], self.x[first + body.vertices.len() - 1]];
        let bounds = around(from, body.radius).and(around(to, body.radius));
        let shallow = self.shallow(cloth, body);
        tree.within(&bounds, true, |leaf| {
            let links = range(leaf.edges).filter(|_| !tree.is_surface());
            for link in links.filter(|&link| bounds.meets(&tree.edge_bounds[link])) {
                let [p, q] = tree.edges[link];
                let closest = Closest::new(Kind::EdgeEdge, &[from, to, self.x[p as usize], self.x[q as usize]]);
                let depth = body.radius - closest.way.length();
                if depth > shallow {
                    let place = from.lerp(to, closest.parts[1]) - closest.way;
                    self.add((cloth, other), Fault::Inside, &[p, q], place, Some(depth));
                }
            }
            for triangle in range(leaf.triangles) {
                if !bounds.meets(&tree.triangle_bounds[triangle]) {
                    continue;
                }
                let corners = tree.triangles[triangle];
                let (distance, place) = nearest([from, to], corners.map(|corner| self.x[corner as usize]));
                let depth = body.radius - distance;
                if depth > shallow {
                    self.add((cloth, other), Fault::Inside, &corners, place, Some(depth));
                }
            }
        });
    }

    /// Vertices behind a plane.
    fn behind(&mut self, other: Other, body: &Body) {
        let first = self.model.particle_count() + body.vertices.start;
        let normal = (self.x[first + 1] - self.x[first]).normalize();
        for (cloth, range) in self.model.cloths.iter().enumerate() {
            let shallow = self.shallow(cloth, body);
            for particle in range.particles() {
                let depth = normal.dot(self.x[first] - self.x[particle]);
                if depth > shallow {
                    self.add((cloth, other), Fault::Inside, &[particle as u32], self.x[particle], Some(depth));
                }
            }
        }
    }

    /// Vertices inside of a closed surface: rays upwards from there leave it once more than they enter it.
    fn inside(&mut self, tree: &Tree, surface: &Tree, cloth: usize, other: Other) {
        for &vertex in &tree.vertices {
            let from = self.x[vertex as usize];
            let mut ray = around(from, 0.0);
            ray.high.iter_mut().for_each(|high| high.z = f32::INFINITY);
            let mut crossings = 0;
            surface.within(&ray, true, |leaf| {
                let triangles = range(leaf.triangles).filter(|&triangle| ray.meets(&surface.triangle_bounds[triangle]));
                let met = triangles.filter(|&triangle| {
                    let corners = surface.triangles[triangle];
                    above(from, corners.map(|corner| (corner, self.x[corner as usize])))
                });
                crossings += met.count();
            });
            if crossings % 2 == 1 {
                self.add((cloth, other), Fault::Inside, &[vertex], from, None);
            }
        }
    }

    /// So deep a cloth may be in a body [m].
    fn shallow(&self, cloth: usize, body: &Body) -> f64 {
        SHALLOW * (0.5 * self.model.contact.cloths[cloth].thickness + body.thickness)
    }

    /// Takes a place; it is told with the nearest of those `vertices` that the cloth has.
    fn add(&mut self, (cloth, other): (usize, Other), fault: Fault, vertices: &[u32], place: DVec3, depth: Option<f64>) {
        let own = self.model.cloths[cloth].particles();
        let away = |vertex: &u32| self.x[*vertex as usize].distance_squared(place);
        let near = vertices.iter().copied().filter(|&vertex| own.contains(&(vertex as usize)));
        let Some(near) = near.min_by(|a, b| away(a).total_cmp(&away(b))) else { return };
        let vertex = self.model.numbering.vertex(near) as usize - own.start;
        let found = Intersection { cloth, other, fault, vertex, place: place + self.base, depth };
        self.found.count += 1;
        let meeting = self.counts.entry((cloth, other)).or_insert(Meeting { count: 0, first: found });
        meeting.count += 1;
        if meeting.count <= MOST {
            self.found.places.push(found);
        }
    }
}

/// A box around all that is `radius` from a place [m], with room for rounding.
pub(super) fn around(place: DVec3, radius: f64) -> Bounds {
    let place = place.as_vec3a();
    Bounds::around([place; 2], [radius as f32 * (1.0 + f32::EPSILON) + ROUNDING * place.abs().max_element(); 2])
}

pub(super) fn range([from, to]: [u32; 2]) -> std::ops::Range<usize> {
    from as usize..to as usize
}

/// The distance of a triangle from a line between two places, which may be one, and its nearest place [m].
fn nearest([from, to]: [DVec3; 2], triangle: [DVec3; 3]) -> (f64, DVec3) {
    let [a, b, c] = triangle;
    let of_end = |end: DVec3| {
        let closest = Closest::new(Kind::PointTriangle, &[end, a, b, c]);
        (closest.way.length(), end - closest.way)
    };
    let mut best = of_end(from);
    if from != to {
        let of_side = |[p, q]: [DVec3; 2]| {
            let closest = Closest::new(Kind::EdgeEdge, &[from, to, p, q]);
            (closest.way.length(), from.lerp(to, closest.parts[1]) - closest.way)
        };
        let through = pierces([from, to], triangle).map(|place| (0.0, place));
        let all = [Some(of_end(to)), Some(of_side([a, b])), Some(of_side([b, c])), Some(of_side([c, a])), through];
        best = all.into_iter().flatten().fold(best, |best, one| if one.0 < best.0 { one } else { best });
    }
    best
}

/// Whether a surface has no border: each edge belongs to an even number of triangles.
pub(super) fn is_closed(triangles: &[[u32; 3]]) -> bool {
    let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut sides: Vec<[u32; 2]> = sides.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    sides.sort_unstable();
    sides.chunk_by(|a, b| a == b).all(|side| side.len() % 2 == 0)
}
