//! What intersects, by other means than those of the engine: every edge against every triangle.

use glam::DVec3;

use super::Simulation;

/// Places in the world.
pub fn places(run: &Simulation) -> Vec<DVec3> {
    let origins = &run.state.origins;
    let of = |particle: usize| run.state.positions.get(particle).as_dvec3() + origins[run.model.cloth_of(particle)];
    (0..run.state.positions.len()).map(of).collect()
}

/// Whether a segment passes through a triangle (Moller & Trumbore 1997).
pub fn pierces([p, q]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> bool {
    let (way, e1, e2) = (q - p, b - a, c - a);
    let h = way.cross(e2);
    let (det, s) = (e1.dot(h), p - a);
    let (u, k) = (s.dot(h) / det, s.cross(e1));
    let (v, t) = (way.dot(k) / det, e2.dot(k) / det);
    det.abs() > 1e-18 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (0.0..=1.0).contains(&t)
}

/// How many pairs of an edge and a triangle that share no vertex intersect.
pub fn crossings(run: &Simulation) -> usize {
    let (x, bodies) = (places(run), &run.model.bodies);
    let count = x.len() as u32;
    let x: Vec<DVec3> = x.into_iter().chain(run.state.bodies.iter().copied()).collect();
    let of_bodies = bodies.triangles.iter().map(|corners| corners.map(|corner| corner + count));
    let triangles: Vec<[u32; 3]> = run.model.triangles.iter().copied().chain(of_bodies).collect();
    let at = |vertex: u32| x[vertex as usize];
    let span = |list: &[u32]| {
        let low = list.iter().map(|&vertex| at(vertex)).fold(DVec3::INFINITY, DVec3::min);
        (low, list.iter().map(|&vertex| at(vertex)).fold(DVec3::NEG_INFINITY, DVec3::max))
    };
    let spans: Vec<_> = triangles.iter().map(|corners| span(corners)).collect();
    let mut found = 0;
    for &[a, b, c] in &triangles {
        for edge in [[a, b], [b, c], [c, a]].into_iter().filter(|edge| edge[0] < edge[1]) {
            let (low, high) = span(&edge);
            for (corners, (from, to)) in triangles.iter().zip(&spans) {
                let apart = low.cmpgt(*to).any() || high.cmplt(*from).any();
                // Bodies may intersect themselves and each other.
                let of_bodies = edge[0] >= count && corners[0] >= count;
                if !apart && !of_bodies && !corners.iter().any(|corner| edge.contains(corner)) {
                    found += usize::from(pierces(edge.map(at), corners.map(at)));
                }
            }
        }
    }
    found
}
