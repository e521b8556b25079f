//! How a particle follows the coarse ones around it.

/// Only the nearest coarse particles are looked at.
const NEAREST: usize = 8;
/// Distances that belong to no flat triangle, by more than this part of them, make no weights.
const CURVED: f32 = 0.15;

/// Coarse particles with weights that add up to 1 and, where the cloth is flat, carry linear fields over exactly.
///
/// `near` are coarse particles with their distances, the nearest first; `between` tells how far two of them are apart.
/// The triangle around the particle whose corners are nearest is taken (it belongs to the Delaunay triangulation);
/// where there is none, at borders and along chains, the nearest segment.
pub(super) fn weights(near: &[(u32, f32)], between: impl Fn(u32, u32) -> Option<f32>) -> Vec<(u32, f32)> {
    let near = &near[..near.len().min(NEAREST)];
    let mut apart = [[None; NEAREST]; NEAREST];
    for i in 0..near.len() {
        for j in i + 1..near.len() {
            apart[i][j] = between(near[i].0, near[j].0);
        }
    }
    let named = |parts: &[(usize, f32)]| parts.iter().map(|&(index, weight)| (near[index].0, weight)).collect();
    if let Some(parts) = triangle(near, &apart) {
        named(&parts)
    } else if let Some(parts) = segment(near, &apart) {
        named(&parts)
    } else {
        near.first().map(|&(only, _)| vec![(only, 1.0)]).unwrap_or_default()
    }
}

type Apart = [[Option<f32>; NEAREST]; NEAREST];

fn triangle(near: &[(u32, f32)], apart: &Apart) -> Option<[(usize, f32); 3]> {
    let mut best = None;
    for a in 0..near.len() {
        for b in a + 1..near.len() {
            for c in b + 1..near.len() {
                let (Some(ab), Some(ac), Some(bc)) = (apart[a][b], apart[a][c], apart[b][c]) else { continue };
                let to = [a, b, c].map(|corner| near[corner].1);
                let Some(parts) = barycentric([ab, ac, bc], to) else { continue };
                let score: f32 = parts.iter().zip(to).map(|(part, to)| part * to * to).sum();
                if best.is_none_or(|(least, _)| score < least) {
                    best = Some((score, [(a, parts[0]), (b, parts[1]), (c, parts[2])]));
                }
            }
        }
    }
    best.map(|(_, parts)| parts)
}

/// Barycentric coordinates of a point inside a triangle with the sides ab, ac, bc, by its distances from a, b and c.
fn barycentric([ab, ac, bc]: [f32; 3], [to_a, to_b, to_c]: [f32; 3]) -> Option<[f32; 3]> {
    /// Triangles flatter than this part of their base are no triangles.
    const SLIVER: f32 = 0.15;
    /// What rounding may take from a coordinate.
    const ROUNDING: f32 = 1e-4;
    let along = |from_a: f32, from_b: f32| (from_a * from_a - from_b * from_b + ab * ab) / (2.0 * ab);
    let (corner_x, x) = (along(ac, bc), along(to_a, to_b));
    let corner_y = (ac * ac - corner_x * corner_x).max(0.0).sqrt();
    if corner_y <= SLIVER * ab {
        return None;
    }
    let off = |y: f32| ((x - corner_x) * (x - corner_x) + (y - corner_y) * (y - corner_y)).sqrt() - to_c;
    let y = (to_a * to_a - x * x).max(0.0).sqrt();
    let y = if off(y).abs() <= off(-y).abs() { y } else { -y };
    let c = y / corner_y;
    let b = (x - c * corner_x) / ab;
    let parts = [1.0 - b - c, b, c];
    let flat = off(y).abs() <= CURVED * (to_a + to_b + to_c) / 3.0;
    (flat && parts.iter().all(|&part| part >= -ROUNDING)).then_some(parts)
}

fn segment(near: &[(u32, f32)], apart: &Apart) -> Option<[(usize, f32); 2]> {
    /// Of two segments as near as each other, the shorter one.
    const SHORTER: f32 = 0.01;
    let mut best = None;
    for a in 0..near.len() {
        for b in a + 1..near.len() {
            let Some(ab) = apart[a][b].filter(|ab| *ab > 0.0) else { continue };
            let (to_a, to_b) = (near[a].1 * near[a].1, near[b].1 * near[b].1);
            let twice_along = (to_a - to_b) / ab + ab;
            let part = (0.5 * twice_along / ab).clamp(0.0, 1.0);
            let off = (to_a - part * ab * twice_along + part * part * ab * ab).max(0.0);
            let score = off + SHORTER * ((1.0 - part) * to_a + part * to_b);
            if best.is_none_or(|(least, _)| score < least) {
                best = Some((score, [(a, 1.0 - part), (b, part)]));
            }
        }
    }
    best.map(|(_, parts)| parts)
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;

    #[test]
    fn carries_linear_fields_over() {
        let places = [Vec2::ZERO, Vec2::new(1.0, 0.1), Vec2::new(0.3, 0.9), Vec2::new(1.4, 1.2), Vec2::new(-0.9, 0.6)];
        for point in [Vec2::new(0.4, 0.3), Vec2::new(0.9, 0.7), Vec2::new(-0.1, 0.5)] {
            let mut near: Vec<(u32, f32)> = (0..5).map(|index| (index, places[index as usize].distance(point))).collect();
            near.sort_by(|a, b| a.1.total_cmp(&b.1));
            let parts = weights(&near, |a, b| Some(places[a as usize].distance(places[b as usize])));
            let back: Vec2 = parts.iter().map(|&(index, part)| places[index as usize] * part).sum();
            assert!(back.distance(point) < 1e-4, "{point} became {back} by {parts:?}");
        }
    }

    #[test]
    fn lies_between_its_neighbours_on_a_chain() {
        let parts = weights(&[(7, 1.0), (3, 2.0)], |_, _| Some(3.0));
        assert_eq!(parts.len(), 2);
        assert!((parts[0].1 - 2.0 / 3.0).abs() < 1e-6 && (parts[1].1 - 1.0 / 3.0).abs() < 1e-6, "{parts:?}");
    }
}
