//! Whether an edge meets a triangle, and whether a triangle is above a point: by the signs of volumes and areas, which are exact
//! [Shewchuk97]. Edges that are as good as in line with the side of a triangle would meet it by rounding.

use glam::{DVec2, DVec3};
use robust::{Coord, Coord3D, orient2d, orient3d};

/// Six times the volume of a tetrahedron, positive if `d` sees `a`, `b`, `c` clockwise. Its sign is exact.
fn volume(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let [a, b, c, d] = [a, b, c, d].map(|DVec3 { x, y, z }| Coord3D { x, y, z });
    orient3d(a, b, c, d)
}

/// Twice the area of a triangle, positive if it runs counter-clockwise. Its sign is exact.
fn area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let [a, b, c] = [a, b, c].map(|DVec2 { x, y }| Coord { x, y });
    orient2d(a, b, c)
}

/// Where an edge passes through a triangle or touches it [m]; none if it does not.
pub(super) fn pierces([p, q]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let (from, to) = (volume(a, b, c, p), volume(a, b, c, q));
    if from * to > 0.0 {
        return None;
    }
    if from == 0.0 && to == 0.0 {
        return touches_flat([p, q], [a, b, c]);
    }
    // On which side of each of its sides the edge passes.
    let signs = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
    let passes = signs.iter().all(|&sign| sign >= 0.0) || signs.iter().all(|&sign| sign <= 0.0);
    passes.then(|| p.lerp(q, from / (from - to)))
}

/// Where an edge in the plane of a triangle touches it.
fn touches_flat([p, q]: [DVec3; 2], triangle: [DVec3; 3]) -> Option<DVec3> {
    let [a, b, c] = triangle;
    let normal = (b - a).cross(c - a).abs();
    let flat = |place: DVec3| {
        if normal.x >= normal.y && normal.x >= normal.z {
            DVec2::new(place.y, place.z)
        } else if normal.y >= normal.z {
            DVec2::new(place.z, place.x)
        } else {
            DVec2::new(place.x, place.y)
        }
    };
    let corners = triangle.map(flat);
    let holds = |place: DVec3| {
        let place = flat(place);
        let signs = [0, 1, 2].map(|side| area(corners[side], corners[(side + 1) % 3], place));
        signs.iter().all(|&sign| sign >= 0.0) || signs.iter().all(|&sign| sign <= 0.0)
    };
    if let Some(place) = [p, q].into_iter().find(|&end| holds(end)) {
        return Some(place);
    }
    let ends = [flat(p), flat(q)];
    (0..3).find_map(|side| {
        let [from, to] = [corners[side], corners[(side + 1) % 3]];
        let (one, other) = (area(from, to, ends[0]), area(from, to, ends[1]));
        let apart = area(ends[0], ends[1], from) * area(ends[0], ends[1], to);
        (one * other < 0.0 && apart <= 0.0).then(|| p.lerp(q, one / (one - other)))
    })
}

/// Whether a point, a little to the right and back of where it is, is to the left of a way from `a` to `b`.
fn is_left(a: DVec2, b: DVec2, point: DVec2) -> bool {
    let area = area(a, b, point);
    if area != 0.0 {
        area > 0.0
    } else if a.y != b.y {
        b.y < a.y
    } else {
        b.x > a.x
    }
}

/// Whether a ray upwards, along z, passes a triangle, whose corners come with their numbers.
///
/// Two triangles that share a side ask the same question of it, and get the same answer; a ray through a side or a corner counts as one
/// that is a little to the right, and yet less further back. So a ray through their side passes one of them.
pub(super) fn above(from: DVec3, corners: [(u32, DVec3); 3]) -> bool {
    let point = from.truncate();
    let passes = |(i, a): (u32, DVec3), (j, b): (u32, DVec3)| {
        if i < j { is_left(a.truncate(), b.truncate(), point) } else { !is_left(b.truncate(), a.truncate(), point) }
    };
    let [a, b, c] = corners;
    let sides = [passes(a, b), passes(b, c), passes(c, a)];
    if sides != [true; 3] && sides != [false; 3] {
        return false;
    }
    let side = volume(a.1, b.1, c.1, from);
    let looks_up = area(a.1.truncate(), b.1.truncate(), c.1.truncate());
    // The triangle is above the point if the point is behind its upper side.
    if looks_up > 0.0 { side > 0.0 } else { side < 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    #[test]
    fn an_edge_passes_a_triangle_or_touches_it_or_does_neither() {
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let cases = [
            ([at(0.2, 0.2, -1.0), at(0.2, 0.2, 3.0)], Some(at(0.2, 0.2, 0.0))),
            ([at(0.2, 0.2, 3.0), at(0.2, 0.2, -1.0)], Some(at(0.2, 0.2, 0.0))),
            ([at(0.2, 0.2, 0.0), at(0.2, 0.2, 3.0)], Some(at(0.2, 0.2, 0.0))),
            ([at(0.2, 0.2, 0.1), at(0.2, 0.2, 3.0)], None),
            ([at(0.8, 0.8, -1.0), at(0.8, 0.8, 3.0)], None),
            ([at(0.5, 0.5, -1.0), at(0.5, 0.5, 3.0)], Some(at(0.5, 0.5, 0.0))),
            ([at(-1.0, 0.25, 0.0), at(3.0, 0.25, 0.0)], Some(at(0.0, 0.25, 0.0))),
            ([at(-1.0, 1.25, 0.0), at(3.0, 1.25, 0.0)], None),
            ([at(0.1, 0.1, 0.0), at(0.2, 0.1, 0.0)], Some(at(0.1, 0.1, 0.0))),
        ];
        for (edge, expected) in cases {
            let found = pierces(edge, TRIANGLE);
            assert!(found.is_some() == expected.is_some(), "{edge:?}: {found:?}");
            if let (Some(found), Some(expected)) = (found, expected) {
                assert!(found.distance(expected) < 1e-12 || edge[0].z == 0.0, "{edge:?}: {found}");
            }
        }
    }

    #[test]
    fn what_lies_in_the_plane_of_a_triangle_is_not_met_by_rounding() {
        // Cells of an upright ribbon, which lie above each other in one plane: an edge, and a triangle further up.
        for turn in 0..1000 {
            let (sin, cos) = (f64::from(turn) * 0.01).sin_cos();
            let at = |side: f64, up: u8| {
                let z = (0.0025 * f64::from(up) - 0.013) as f32;
                DVec3::new(0.042 * cos - side * sin, 0.042 * sin + side * cos, f64::from(z))
            };
            for edge in [[at(0.0, 0), at(0.0025, 0)], [at(0.0025, 0), at(0.0, 1)], [at(0.0, 0), at(0.0, 1)]] {
                for triangle in [[at(0.0, 2), at(0.0025, 2), at(0.0, 3)], [at(0.0025, 2), at(0.0025, 3), at(0.0, 3)]] {
                    assert_eq!(pierces(edge, triangle), None, "{turn}");
                }
            }
        }
    }

    #[test]
    fn a_ray_passes_a_fan_of_triangles_once() {
        // Around a middle that the ray goes through, and through sides that they share.
        let corners: Vec<DVec3> = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]]
            .map(|[x, y]: [i32; 2]| DVec3::new(f64::from(x), f64::from(y), 1.0))
            .into();
        for [x, y] in [[0.0, 0.0], [0.5, 0.0], [0.3, 0.3], [0.3, 0.1], [-0.7, 0.7], [0.0, -0.2]] {
            for turned in [false, true] {
                let passed = |z: f64| {
                    let passes = |&index: &u32| {
                        let next = (index + 1) % 8;
                        let [mut one, mut two] = [index, next].map(|corner| (corner + 1, corners[corner as usize]));
                        if turned {
                            std::mem::swap(&mut one, &mut two);
                        }
                        above(DVec3::new(x, y, z), [(0, DVec3::Z), one, two])
                    };
                    (0..8_u32).filter(passes).count()
                };
                assert_eq!((passed(0.0), passed(2.0)), (1, 0), "[{x}, {y}]");
            }
        }
    }
}
