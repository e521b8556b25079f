//! Second derivatives on triangle meshes, from how far neighbours are folded against one another.
//!
//! The positions are linear on every triangle, so that their slope jumps across an edge. With a slope in the middle of the edge the
//! second derivatives of a triangle are `1/A sum |e| (slope across e there - own slope across e) N N^T` over its edges e with
//! outward normals N (Morley 1968). As in rotation-free elements (Onate & Zarate 2000) that slope is taken between those on both
//! sides, and is nearer to that of the flatter triangle. Any constant second derivative then holds itself in balance on every mesh.
//! Sums of folds over single hinges do not measure it: on a grid cut along one diagonal they bend three times too hard along the
//! grid.
//!
//! Across a border the slope may be anything: it is what makes the energy least.
//!
//! Only lengths enter: at rest the cloth is taken for flat pieces, whatever its shape.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::Row;

/// A sum over vertices.
type Weights = Vec<(u32, f64)>;

/// The triangles on each edge, and their vertices opposite to it.
type Sides = BTreeMap<[u32; 2], Vec<u32>>;

/// The second derivatives of every triangle of a mesh.
pub(in crate::model) fn mesh(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<Row> {
    let mut sides = Sides::new();
    for [a, b, c] in triangles.iter().copied() {
        for ([p, q], opposite) in [([a, b], c), ([b, c], a), ([c, a], b)] {
            sides.entry([p.min(q), p.max(q)]).or_default().push(opposite);
        }
    }
    triangles.iter().flat_map(|&corners| second_derivatives(corners, points, &sides)).collect()
}

/// X_ss, root of 2 times X_st and X_tt of a triangle, times the root of its area.
fn second_derivatives([a, b, c]: [u32; 3], points: &[DVec3], sides: &Sides) -> [Row; 3] {
    let at = |vertex: u32| points[vertex as usize];
    let (side, other) = (at(b) - at(a), at(c) - at(a));
    let normal = side.cross(other).normalize();
    let (s, t) = (side.normalize(), normal.cross(side.normalize()));
    let area = 0.5 * side.cross(other).length();
    let mut folds: Vec<(Weights, DVec3)> = Vec::new();
    let mut free: Vec<DVec3> = Vec::new();
    for [p, q, own] in [[a, b, c], [b, c, a], [c, a, b]] {
        let edge = at(q) - at(p);
        let across = DVec2::new(edge.dot(t), -edge.dot(s)) / edge.length();
        let direction = DVec3::new(across.x * across.x, 2.0_f64.sqrt() * across.x * across.y, across.y * across.y);
        // Across an edge of more than two triangles the cloth is free to fold.
        match sides[&[p.min(q), p.max(q)]][..] {
            [one, two] => folds
                .push((fold([p, q], own, if one == own { two } else { one }, points), direction * (edge.length() / area.sqrt()))),
            _ => free.push(direction),
        }
    }
    let folds = folds.into_iter().map(|(fold, direction)| (fold, without(direction, &free)));
    let mut rows = [(); 3].map(|()| Row { weights: Weights::new(), area });
    for (fold, direction) in folds {
        for (row, part) in rows.iter_mut().zip(direction.to_array()) {
            fold.iter().for_each(|&(vertex, weight)| add(&mut row.weights, vertex, weight * part));
        }
    }
    rows
}

/// The slope across an edge in its middle less that on the side of `own`, as a sum over four vertices [1/m].
fn fold([p, q]: [u32; 2], own: u32, other: u32, points: &[DVec3]) -> Weights {
    let at = |vertex: u32| points[vertex as usize];
    let edge = at(q) - at(p);
    let measure = |vertex: u32| {
        let way = at(vertex) - at(p);
        (way.dot(edge) / edge.length_squared(), way.cross(edge).length() / edge.length())
    };
    let ((foot, height), (other_foot, other_height)) = (measure(own), measure(other));
    let share = height / (height + other_height);
    let (near, far) = (share / height, share / other_height);
    let to_q = -(foot * near + other_foot * far);
    vec![(own, near), (other, far), (p, -near - far - to_q), (q, to_q)]
}

/// A vector less its parts along others.
fn without(vector: DVec3, others: &[DVec3]) -> DVec3 {
    let mut axes: Vec<DVec3> = Vec::new();
    for other in others {
        let rest = axes.iter().fold(*other, |rest, axis| rest - *axis * rest.dot(*axis));
        axes.extend(rest.try_normalize());
    }
    axes.iter().fold(vector, |rest, axis| rest - *axis * rest.dot(*axis))
}

fn add(row: &mut Weights, vertex: u32, weight: f64) {
    match row.iter_mut().find(|(other, _)| *other == vertex) {
        Some((_, sum)) => *sum += weight,
        None => row.push((vertex, weight)),
    }
}
