//! Pairs of features whose ways in a step come near.

use glam::Vec3;

use super::Places;
use super::proximity::Kind;
use super::surfaces::Surfaces;
use super::tree::{Bounds, Leaf, Tree};

/// Boxes are wider by this part of the largest coordinate: places are rounded to single precision.
const ROUNDING: f32 = 2.0 * f32::EPSILON;

/// Two features.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Pair {
    pub kind: Kind,
    pub corners: [u32; 4],
}

/// Pairs, with the workspace to find them.
pub(crate) struct Detection {
    pub pairs: Vec<Pair>,
    bounds: Vec<Bounds>,
    stack: Vec<[u32; 2]>,
}

impl Detection {
    pub fn new(vertices: usize) -> Self {
        Self { pairs: Vec::new(), bounds: vec![Bounds::NOTHING; vertices], stack: Vec::new() }
    }

    /// Finds all pairs of features that share no vertex and whose boxes come within `margin` [m] of each other.
    pub fn run(&mut self, surfaces: &mut Surfaces, places: &Places, margin: f64) {
        let Self { pairs, bounds, stack } = self;
        pairs.clear();
        let half = 0.5 * margin as f32;
        for ((bounds, x), end) in bounds.iter_mut().zip(&places.x).zip(&places.ends) {
            let (x, end) = (x.as_vec3(), end.as_vec3());
            let wide = Vec3::splat(half + ROUNDING * x.abs().max(end.abs()).max_element());
            *bounds = Bounds { low: x.min(end) - wide, high: x.max(end) + wide };
        }
        for tree in surfaces.cloths.iter_mut().chain(&mut surfaces.bodies) {
            tree.refit(bounds);
        }
        let Surfaces { cloths, bodies, thick, skins, among_cloths, .. } = &*surfaces;
        for (index, tree) in cloths.iter().enumerate() {
            if *among_cloths {
                tree.meet_itself(stack, |one, two| within(tree, one, two, bounds, pairs));
                for other in &cloths[index + 1..] {
                    tree.meet(other, stack, |one, two| between([tree, other], [one, two], bounds, pairs));
                }
            }
            for body in bodies {
                tree.meet(body, stack, |one, two| between([tree, body], [one, two], bounds, pairs));
            }
            for thick in thick {
                let radius = skins[thick.owner as usize].radius as f32;
                let wide = Vec3::splat(radius * (1.0 + f32::EPSILON));
                let grown = |vertex: u32| {
                    let Bounds { low, high } = bounds[vertex as usize];
                    Bounds { low: low - wide, high: high + wide }
                };
                let all = thick.vertices.clone().fold(Bounds::NOTHING, |all, vertex| all.and(grown(vertex)));
                tree.within(&all, |leaf| {
                    for triangle in range(leaf.triangles) {
                        let [a, b, c] = tree.triangles[triangle];
                        for vertex in thick.vertices.clone() {
                            if grown(vertex).meets(&tree.triangle_bounds[triangle]) {
                                pairs.push(Pair { kind: Kind::PointTriangle, corners: [vertex, a, b, c] });
                            }
                        }
                    }
                    if thick.vertices.len() == 2 {
                        let first = thick.vertices.start;
                        for edge in range(leaf.edges).filter(|&edge| all.meets(&tree.edge_bounds[edge])) {
                            let [a, b] = tree.edges[edge];
                            pairs.push(Pair { kind: Kind::EdgeEdge, corners: [first, first + 1, a, b] });
                        }
                    }
                });
            }
        }
    }
}

fn range([from, to]: [u32; 2]) -> std::ops::Range<usize> {
    from as usize..to as usize
}

/// Two leaves of one tree.
fn within(tree: &Tree, one: &Leaf, two: &Leaf, bounds: &[Bounds], pairs: &mut Vec<Pair>) {
    if one.triangles != two.triangles {
        return between([tree, tree], [one, two], bounds, pairs);
    }
    points_and_triangles([tree, tree], one.vertices, one.triangles, bounds, pairs);
    for a in range(one.edges) {
        for b in a + 1..one.edges[1] as usize {
            edges([tree, tree], [a, b], pairs);
        }
    }
}

/// Two leaves of two trees, or of one.
fn between([a, b]: [&Tree; 2], [one, two]: [&Leaf; 2], bounds: &[Bounds], pairs: &mut Vec<Pair>) {
    points_and_triangles([a, b], one.vertices, two.triangles, bounds, pairs);
    points_and_triangles([b, a], two.vertices, one.triangles, bounds, pairs);
    for edge in range(one.edges) {
        for other in range(two.edges) {
            edges([a, b], [edge, other], pairs);
        }
    }
}

fn points_and_triangles([a, b]: [&Tree; 2], vertices: [u32; 2], triangles: [u32; 2], bounds: &[Bounds], pairs: &mut Vec<Pair>) {
    for &vertex in &a.vertices[range(vertices)] {
        let own = &bounds[vertex as usize];
        for triangle in range(triangles) {
            let corners = b.triangles[triangle];
            if own.meets(&b.triangle_bounds[triangle]) && !corners.contains(&vertex) {
                pairs.push(Pair { kind: Kind::PointTriangle, corners: [vertex, corners[0], corners[1], corners[2]] });
            }
        }
    }
}

fn edges([a, b]: [&Tree; 2], [edge, other]: [usize; 2], pairs: &mut Vec<Pair>) {
    if a.edge_bounds[edge].meets(&b.edge_bounds[other]) {
        let ([p, q], [r, s]) = (a.edges[edge], b.edges[other]);
        if p != r && p != s && q != r && q != s {
            pairs.push(Pair { kind: Kind::EdgeEdge, corners: [p, q, r, s] });
        }
    }
}
