//! Surfaces without an inside that cross go where the line along which they do gets shorter [Volino06].
//!
//! An edge that passes through a triangle at a point P is where that line goes on from one of its own triangles to the next. If the edge
//! moves by D against the triangle, P moves by D - (N.D)/(N.E) E, with the direction E of the edge and the normal N of the triangle;
//! the line in a triangle of the edge, which leaves P in the direction R, gets shorter by R times that. So D = sum of
//! R - (E.R)/(E.N) N shortens it most.

use glam::DVec3;

use super::super::proximity::{Closest, Kind};
use super::super::surfaces::{Owner, Surfaces};
use super::{Asked, Crossing, Tangle};

/// Edges that are nearly in the plane of a triangle count as if the sine of their angle were this one.
const STEEP: f64 = 0.05;
/// A line that is as good as straight asks for nothing.
const STRAIGHT: f64 = 0.02;

impl Tangle {
    /// Asks for rows of all crossings of surfaces without an inside; pairs near them may pass each other. Those of edges with a vertex
    /// that is `settled` are brought apart otherwise.
    pub(super) fn shorten_contours(&mut self, surfaces: &Surfaces, x: &[DVec3], most: f64, settled: &[bool]) {
        let closed: Vec<Owner> = self.solids.iter().map(super::out::Solid::owner).collect();
        let crossings = std::mem::take(&mut self.crossings);
        for crossing in crossings.iter().filter(|at| !at.owners.iter().any(|owner| closed.contains(owner))) {
            for &vertex in crossing.edge.iter().chain(&crossing.triangle) {
                self.zone[vertex as usize] = true;
                surfaces.ring.of(vertex as usize).iter().for_each(|&other| self.zone[other as usize] = true);
            }
            if crossing.edge.iter().any(|&end| settled[end as usize]) {
                continue;
            }
            let way = self.way(crossing, x);
            let length = way.length();
            if length < STRAIGHT || !length.is_finite() {
                continue;
            }
            let corners = crossing.triangle;
            let [a, b, c] = corners.map(|corner| x[corner as usize]);
            let closest = Closest::new(Kind::PointTriangle, &[crossing.place, a, b, c]);
            for end in crossing.edge {
                self.asked.push(Asked {
                    corners: [end, corners[0], corners[1], corners[2]],
                    parts: closest.parts,
                    split: 1,
                    normal: way / length,
                    push: most * length.min(1.0),
                });
            }
        }
        self.crossings = crossings;
    }

    /// The way of the edge against the triangle that shortens the line most.
    fn way(&self, crossing: &Crossing, x: &[DVec3]) -> DVec3 {
        let [p, q] = crossing.edge.map(|end| x[end as usize]);
        let [a, b, c] = crossing.triangle.map(|corner| x[corner as usize]);
        let along = (q - p).normalize_or_zero();
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let steep = along.dot(normal);
        let steep = if steep < 0.0 { steep.min(-STEEP) } else { steep.max(STEEP) };
        let from = self.sides.partition_point(|side| side.0 < crossing.edge);
        let own = self.sides[from..].iter().take_while(|side| side.0 == crossing.edge);
        own.map(|&(_, third)| {
            // From the edge into the triangle.
            let third = x[third as usize] - p;
            let into = third - along * along.dot(third);
            let line = normal.cross(along.cross(third)).normalize_or_zero();
            let line = if line.dot(into) < 0.0 { -line } else { line };
            line - normal * (along.dot(line) / steep)
        })
        .sum()
    }
}
