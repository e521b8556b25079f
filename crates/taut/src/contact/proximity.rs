//! Closest points of a point and a triangle, and of two edges, in double precision.

use glam::DVec3;

/// What two features are; their corners come in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// A point, and the three corners of a triangle.
    PointTriangle,
    /// The two ends of one edge, and those of another. Either may have no length: the middle of a sphere beside a link, and a point of a
    /// network that no link is tied to, are edges from a vertex to itself.
    EdgeEdge,
}

impl Kind {
    /// How many of the four corners belong to the first feature.
    pub fn split(self) -> usize {
        match self {
            Self::PointTriangle => 1,
            Self::EdgeEdge => 2,
        }
    }
}

/// The closest points of two features.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Closest {
    /// From the point of the second feature to that of the first [m]: the sum of the corners times their parts.
    pub way: DVec3,
    /// The part of each corner [1]: those of the first feature add up to 1, those of the second to -1.
    pub parts: [f64; 4],
}

impl Closest {
    /// The closest points of features with these corners [m].
    pub fn new(kind: Kind, x: &[DVec3; 4]) -> Self {
        let parts = match kind {
            Kind::PointTriangle => {
                let [a, b, c] = on_triangle(x[0], [x[1], x[2], x[3]]);
                [1.0, -a, -b, -c]
            }
            Kind::EdgeEdge => {
                let [s, t] = on_edges([x[0], x[1]], [x[2], x[3]]);
                [1.0 - s, s, t - 1.0, -t]
            }
        };
        // Differences first: coordinates may be large against the distance.
        let way = match kind {
            Kind::PointTriangle => (x[0] - x[1]) + (x[2] - x[1]) * parts[2] + (x[3] - x[1]) * parts[3],
            Kind::EdgeEdge => (x[0] - x[2]) + (x[1] - x[0]) * parts[1] + (x[3] - x[2]) * parts[3],
        };
        Self { way, parts }
    }
}

/// The place on a triangle that is closest to a point, in parts of its corners (Ericson 2005, section 5.1.5).
fn on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let part = d1 / (d1 - d3);
        return [1.0 - part, part, 0.0];
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let part = d2 / (d2 - d6);
        return [1.0 - part, 0.0, part];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let part = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - part, part];
    }
    let sum = va + vb + vc;
    [va / sum, vb / sum, vc / sum]
}

/// Where two edges are closest, in parts of their lengths (Ericson 2005, section 5.1.9).
fn on_edges([p1, q1]: [DVec3; 2], [p2, q2]: [DVec3; 2]) -> [f64; 2] {
    let (d1, d2, r) = (q1 - p1, q2 - p2, p1 - p2);
    let (a, e, f, c) = (d1.length_squared(), d2.length_squared(), d2.dot(r), d1.dot(r));
    match (a > 0.0, e > 0.0) {
        (false, false) => return [0.0, 0.0],
        (false, true) => return [0.0, (f / e).clamp(0.0, 1.0)],
        (true, false) => return [(-c / a).clamp(0.0, 1.0), 0.0],
        (true, true) => {}
    }
    let b = d1.dot(d2);
    let across = a * e - b * b;
    // Nearly parallel edges: any place will do, and both ends of each are tried below.
    let s = if across > 1e-14 * a * e { ((b * f - c * e) / across).clamp(0.0, 1.0) } else { 0.5 };
    let t = (b * s + f) / e;
    if t < 0.0 {
        [(-c / a).clamp(0.0, 1.0), 0.0]
    } else if t > 1.0 {
        [((b - c) / a).clamp(0.0, 1.0), 1.0]
    } else {
        [((b * t - c) / a).clamp(0.0, 1.0), t]
    }
}
