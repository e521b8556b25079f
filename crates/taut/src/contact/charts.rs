//! Convex pieces of a surface at rest, laid flat: where one of them stays a graph over a plane it touches nothing of itself.
//!
//! A chart belongs to a run of leaves of the surface's tree, its *core*. Its triangles are those around them, projected onto the plane of
//! the core at rest; its *domain* is a convex polygon of that plane, a rectangle around the core within all borders of the surface that
//! are inside. The triangles of the chart cover the domain exactly once, so that any two points of it are joined by a straight line that
//! stays on the surface.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::ops::Range;

use glam::{DVec2, DVec3};

use super::tree::{Leaf, Tree};

/// Triangles that are steeper over the plane of the core than this are no part of a chart [1], a cosine.
const STEEP: f64 = 0.3;
/// What covers the domain twice has twice its area.
const ONCE: f64 = 1.5;
/// Lengths that count as nothing, as a part of the size of a chart [1].
const ROUNDING: f64 = 1e-6;

/// A triangle of a chart: places of its corners among the vertices of the chart. There are many, so they are short.
pub(super) type Facet = [u16; 3];

/// A chart: runs of the lists of [`Charts`].
#[derive(Debug, Clone)]
pub(super) struct Chart {
    pub vertices: Range<usize>,
    /// What makes the mean derivatives of places by rest coordinates of their sums with these, `sum u x^T` [1/m^2]: a symmetric matrix.
    pub spread: [[f32; 2]; 2],
    pub facets: Range<usize>,
    pub leaves: Range<usize>,
    pub around: Range<usize>,
}

/// The charts of a surface.
#[derive(Debug, Clone, Default)]
pub(super) struct Charts {
    pub list: Vec<Chart>,
    /// Their vertices, with their rest coordinates from the mean of those of the chart [m].
    pub vertices: Vec<(u32, [f32; 2])>,
    pub facets: Vec<Facet>,
    /// The leaves of the tree that are wholly in their domains, in rising order; and all that have any of their triangles.
    pub leaves: Vec<u32>,
    pub around: Vec<u32>,
    /// The chart of which each leaf is part of the core.
    pub of_leaf: Vec<u32>,
    /// Of each triangle of the tree, the largest norm of what makes derivatives of its edges, in any chart [1/m].
    pub largest: Vec<f32>,
}

/// The surface that charts are made of.
struct Surface<'a> {
    tree: &'a Tree,
    /// Edges with the triangles along them, in rising order.
    sides: Vec<([u32; 2], u32)>,
    /// Vertices with the leaves of the triangles around them, in rising order.
    touching: Vec<(u32, u32)>,
    /// The leaf of each triangle.
    leaf_of: Vec<u32>,
    place: &'a dyn Fn(u32) -> DVec3,
}

/// A plane to project onto.
struct Plane {
    origin: DVec3,
    axes: [DVec3; 2],
}

impl Plane {
    fn flat(&self, place: DVec3) -> DVec2 {
        let way = place - self.origin;
        DVec2::new(self.axes[0].dot(way), self.axes[1].dot(way))
    }
}

impl Charts {
    /// The charts of a tree over triangles whose cores have at most so many; `place` is where a vertex is at rest.
    pub fn new(tree: &Tree, place: impl Fn(u32) -> DVec3, most: usize) -> Self {
        let edges = (0..)
            .zip(&tree.triangles)
            .flat_map(|(index, &[a, b, c])| [[a, b], [b, c], [c, a]].map(|[p, q]| ([p.min(q), p.max(q)], index)));
        let mut sides: Vec<([u32; 2], u32)> = edges.collect();
        sides.sort_unstable();
        let mut leaf_of = vec![0; tree.triangles.len()];
        let mut touching = Vec::new();
        for leaf in &tree.leaves {
            leaf_of[leaf.triangles[0] as usize..leaf.triangles[1] as usize].fill(leaf.index);
            touching.extend(tree.vertices_of(leaf.index).map(|vertex| (vertex, leaf.index)));
        }
        touching.sort_unstable();
        touching.dedup();
        let surface = Surface { tree, sides, touching, leaf_of, place: &place };
        let (of_leaf, largest) = (vec![0; tree.leaves.len()], vec![0.0; tree.triangles.len()]);
        let mut charts = Self { of_leaf, largest, ..Self::default() };
        for core in tree.runs(most) {
            charts.of_leaf[core.clone()].fill(charts.list.len() as u32);
            charts.add(&surface, core);
        }
        charts
    }

    /// The leaves that are wholly in the domain of a chart.
    pub fn leaves_of(&self, chart: u32) -> &[u32] {
        &self.leaves[self.list[chart as usize].leaves.clone()]
    }

    /// Adds the chart around some leaves; one without leaves where the surface is none over a plane.
    fn add(&mut self, surface: &Surface<'_>, core: Range<usize>) {
        let ends = |charts: &Self| [charts.vertices.len(), charts.facets.len(), charts.leaves.len(), charts.around.len()];
        let from = ends(self);
        let spread = self.fill(surface, core).unwrap_or_default();
        let to = ends(self);
        let run = |list: usize| from[list]..to[list];
        self.list.push(Chart { vertices: run(0), spread, facets: run(1), leaves: run(2), around: run(3) });
    }

    /// Returns what is not in the lists.
    fn fill(&mut self, surface: &Surface<'_>, core: Range<usize>) -> Option<[[f32; 2]; 2]> {
        let Surface { tree, place, .. } = surface;
        let leaves = &tree.leaves;
        let own: Vec<u32> = core.clone().flat_map(|leaf| leaves[leaf].triangles[0]..leaves[leaf].triangles[1]).collect();
        let plane = surface.plane(&own)?;
        let flat = |vertex: u32| plane.flat(place(vertex));
        let mut domain = surface.rectangle(&own, &plane);
        let size = (domain[2] - domain[0]).length();
        let triangles = surface.around(&own, &domain, &plane);
        // Borders bound the domain.
        for ([p, q], inner) in triangles.iter().flat_map(|&triangle| surface.borders(triangle)) {
            let [a, b] = [p, q].map(flat);
            let corners = tree.triangles[inner as usize];
            let third = flat(corners.into_iter().find(|corner| ![p, q].contains(corner))?);
            let normal = (b - a).perp().normalize_or_zero();
            let inward = if normal.dot(third - a) < 0.0 { -normal } else { normal };
            if has_inside(&domain, [a, b], ROUNDING * size) {
                domain = clip(&domain, inward, inward.dot(a));
            }
        }
        let mut covered = 0.0;
        let mut facets = Vec::new();
        for &triangle in &triangles {
            let corners = tree.triangles[triangle as usize].map(flat);
            let part = clip_to(&domain, corners);
            if part.len() < 3 || area(&part) == 0.0 {
                continue;
            }
            let [a, b, c] = corners;
            let determinant = (b - a).perp_dot(c - a);
            let [p, q, r] = tree.triangles[triangle as usize].map(place);
            if determinant <= STEEP * (q - p).cross(r - p).length() {
                return None;
            }
            covered += area(&part);
            facets.push((
                triangle,
                [[(c - a).y, -(c - a).x], [-(b - a).y, (b - a).x]].map(|row| row.map(|x| (x / determinant) as f32)),
            ));
        }
        if domain.len() < 3 || covered > ONCE * area(&domain) {
            return None;
        }
        let members: BTreeSet<u32> = facets.iter().map(|facet| facet.0).collect();
        let is_in = |vertex: u32| is_inside(&domain, flat(vertex), ROUNDING * size);
        let within = |leaf: &Leaf| {
            (leaf.triangles[0]..leaf.triangles[1])
                .all(|triangle| members.contains(&triangle) && tree.triangles[triangle as usize].into_iter().all(is_in))
        };
        let candidates: BTreeSet<u32> = members.iter().map(|&triangle| surface.leaf_of[triangle as usize]).collect();
        let own_leaves: Vec<u32> = candidates.iter().copied().filter(|&leaf| within(&leaves[leaf as usize])).collect();
        let vertices: BTreeSet<u32> = members.iter().flat_map(|&triangle| tree.triangles[triangle as usize]).collect();
        // One that has more vertices than can be counted is none.
        let last = u16::try_from(vertices.len()).ok()?;
        let local: BTreeMap<u32, u16> = vertices.iter().copied().zip(0..last).collect();
        let (mean, spread) = spread(&vertices, flat)?;
        for (triangle, inverse) in facets {
            self.facets.push(tree.triangles[triangle as usize].map(|corner| local[&corner]));
            let largest = &mut self.largest[triangle as usize];
            *largest = largest.max(norm(inverse));
        }
        self.leaves.extend(own_leaves);
        self.around.extend(candidates);
        self.vertices.extend(vertices.iter().map(|&vertex| (vertex, (flat(vertex) - mean).as_vec2().to_array())));
        Some(spread)
    }
}

/// The most by which a matrix makes a vector longer [1/m].
fn norm([a, b]: [[f32; 2]; 2]) -> f32 {
    let squares = a[0] * a[0] + a[1] * a[1] + b[0] * b[0] + b[1] * b[1];
    let determinant = a[0] * b[1] - a[1] * b[0];
    (0.5 * (squares + (squares * squares - 4.0 * determinant * determinant).max(0.0).sqrt())).sqrt()
}

impl Surface<'_> {
    /// The mean plane of some triangles.
    fn plane(&self, triangles: &[u32]) -> Option<Plane> {
        let corners = |triangle: &u32| self.tree.triangles[*triangle as usize].map(self.place);
        let normal: DVec3 = triangles.iter().map(corners).map(|[a, b, c]| (b - a).cross(c - a)).sum();
        let normal = normal.try_normalize()?;
        let least = (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs()))?;
        let first = (DVec3::AXES[least] - normal * normal[least]).try_normalize()?;
        let origin = corners(triangles.first()?)[0];
        Some(Plane { origin, axes: [first, normal.cross(first)] })
    }

    /// A rectangle around the triangles of a core and of the leaves that it touches.
    fn rectangle(&self, own: &[u32], plane: &Plane) -> Vec<DVec2> {
        let corners = |triangle: &u32| self.tree.triangles[*triangle as usize];
        let leaves: BTreeSet<u32> = own.iter().flat_map(corners).flat_map(|vertex| self.leaves_at(vertex)).collect();
        let triangles = leaves.iter().flat_map(|&leaf| {
            let [from, to] = self.tree.leaves[leaf as usize].triangles;
            from..to
        });
        let places = triangles.flat_map(|triangle| corners(&triangle)).map(|corner| plane.flat((self.place)(corner)));
        let (low, high) = places.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        vec![low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)]
    }

    /// The triangles that are joined to a core by others that meet a domain, and meet it themselves.
    fn around(&self, core: &[u32], domain: &[DVec2], plane: &Plane) -> Vec<u32> {
        let mut seen: BTreeSet<u32> = core.iter().copied().collect();
        let mut queue: VecDeque<u32> = core.iter().copied().collect();
        while let Some(triangle) = queue.pop_front() {
            let [a, b, c] = self.tree.triangles[triangle as usize];
            for [p, q] in [[a, b], [b, c], [c, a]] {
                for &(_, other) in self.along([p.min(q), p.max(q)]) {
                    let corners = self.tree.triangles[other as usize].map(|corner| plane.flat((self.place)(corner)));
                    if !seen.contains(&other) && clip_to(domain, corners).len() >= 3 {
                        seen.insert(other);
                        queue.push_back(other);
                    }
                }
            }
        }
        seen.into_iter().collect()
    }

    /// The edges of a triangle that it does not share with exactly one other, each with the triangle.
    fn borders(&self, triangle: u32) -> impl Iterator<Item = ([u32; 2], u32)> {
        let [a, b, c] = self.tree.triangles[triangle as usize];
        let edges = [[a, b], [b, c], [c, a]].map(|[p, q]| [p.min(q), p.max(q)]);
        edges.into_iter().filter(|&edge| self.along(edge).len() != 2).map(move |edge| (edge, triangle))
    }

    /// An edge with each triangle along it.
    fn along(&self, edge: [u32; 2]) -> &[([u32; 2], u32)] {
        let from = self.sides.partition_point(|side| side.0 < edge);
        let count = self.sides[from..].partition_point(|side| side.0 == edge);
        &self.sides[from..from + count]
    }

    /// The leaves of the triangles around a vertex.
    fn leaves_at(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let from = self.touching.partition_point(|at| at.0 < vertex);
        self.touching[from..].iter().take_while(move |at| at.0 == vertex).map(|at| at.1)
    }
}

/// The mean of the rest coordinates of some vertices, and the inverse of `sum u u^T` of them from there; none if they lie on a line.
fn spread(vertices: &BTreeSet<u32>, flat: impl Fn(u32) -> DVec2) -> Option<(DVec2, [[f32; 2]; 2])> {
    let mean = vertices.iter().map(|&vertex| flat(vertex)).sum::<DVec2>() / vertices.len() as f64;
    let [mut xx, mut xy, mut yy] = [0.0; 3];
    for &vertex in vertices {
        let DVec2 { x, y } = flat(vertex) - mean;
        xx += x * x;
        xy += x * y;
        yy += y * y;
    }
    let determinant = xx * yy - xy * xy;
    (determinant > 0.0).then(|| (mean, [[yy, -xy], [-xy, xx]].map(|row| row.map(|entry| (entry / determinant) as f32))))
}

/// What of a convex polygon is where `normal . x >= at`.
fn clip(polygon: &[DVec2], normal: DVec2, at: f64) -> Vec<DVec2> {
    let mut clipped = Vec::with_capacity(polygon.len() + 1);
    for (index, &from) in polygon.iter().enumerate() {
        let to = polygon[(index + 1) % polygon.len()];
        let [before, after] = [from, to].map(|place| normal.dot(place) - at);
        if before >= 0.0 {
            clipped.push(from);
        }
        if before * after < 0.0 {
            clipped.push(from.lerp(to, before / (before - after)));
        }
    }
    clipped
}

/// The part of a triangle in a convex polygon, whose corners go round counterclockwise.
fn clip_to(domain: &[DVec2], triangle: [DVec2; 3]) -> Vec<DVec2> {
    let mut part = triangle.to_vec();
    for (index, &from) in domain.iter().enumerate() {
        let normal = (domain[(index + 1) % domain.len()] - from).perp();
        part = clip(&part, normal, normal.dot(from));
        if part.is_empty() {
            break;
        }
    }
    part
}

/// The area of a polygon whose corners go round counterclockwise.
fn area(polygon: &[DVec2]) -> f64 {
    let origin = polygon[0];
    polygon.windows(2).map(|pair| 0.5 * (pair[0] - origin).perp_dot(pair[1] - origin)).sum()
}

/// Whether a point is in a convex polygon, or hardly outside.
fn is_inside(domain: &[DVec2], place: DVec2, rounding: f64) -> bool {
    (0..domain.len()).all(|index| {
        let (from, to) = (domain[index], domain[(index + 1) % domain.len()]);
        (to - from).perp_dot(place - from) >= -rounding * (to - from).length()
    })
}

/// Whether an edge passes through the inside of a convex polygon.
fn has_inside(domain: &[DVec2], edge: [DVec2; 2], rounding: f64) -> bool {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for (index, &corner) in domain.iter().enumerate() {
        let inward = (domain[(index + 1) % domain.len()] - corner).normalize_or_zero().perp();
        let [a, b] = edge.map(|end| inward.dot(end - corner) - rounding);
        if a < 0.0 && b < 0.0 {
            return false;
        }
        if a < 0.0 {
            from = from.max(a / (a - b));
        } else if b < 0.0 {
            to = to.min(a / (a - b));
        }
    }
    from < to
}
