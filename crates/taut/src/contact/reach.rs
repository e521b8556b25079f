//! What is so near on a surface or along a network that it cannot keep its thickness.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;

use crate::model::Adjacency;

/// A network keeps its thickness between points that are at least so many thicknesses apart along its links [1]: a rope that turns back
/// on itself as sharply as its thickness allows takes half of pi.
const HAIRPIN: f64 = 2.0;
/// Points of a network have no more than so many near ones, the nearest: links much shorter than their thickness are a mistake.
const MOST: usize = 64;

/// The vertices of a surface within two edges of one, itself among them.
pub(super) fn within_two(ring: &Adjacency<u32>, vertex: u32) -> Vec<u32> {
    let once = ring.of(vertex as usize);
    let twice = once.iter().flat_map(|&other| ring.of(other as usize));
    once.iter().chain(twice).copied().chain([vertex]).collect()
}

/// The points of a network of a thickness [m] that are near one along its links, itself among them; `place` is where a point is at rest.
pub(super) fn along_links(ring: &Adjacency<u32>, vertex: u32, thickness: f64, place: impl Fn(u32) -> DVec3) -> Vec<u32> {
    let mut found = Vec::new();
    // Lengths above zero are ordered as their bits are.
    let mut queue = BinaryHeap::from([Reverse((0_u64, vertex))]);
    while let Some(Reverse((length, point))) = queue.pop() {
        if found.contains(&point) {
            continue;
        }
        found.push(point);
        if found.len() == MOST {
            break;
        }
        for &other in ring.of(point as usize) {
            let further = f64::from_bits(length) + place(point).distance(place(other));
            if further < HAIRPIN * thickness {
                queue.push(Reverse((further.to_bits(), other)));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rope_is_near_along_two_thicknesses() {
        let joined = (0..20_u32).flat_map(|point| [(point, point + 1), (point + 1, point)]);
        let mut pairs: Vec<(u32, u32)> = joined.collect();
        pairs.sort_unstable();
        let ring = Adjacency::new(21, pairs.into_iter());
        // It lies in a heap: what counts is the way along it.
        let place = |point: u32| DVec3::X * f64::from(point % 2);
        let near = |thickness: f64| {
            let mut near = along_links(&ring, 7, thickness, place);
            near.sort_unstable();
            near
        };
        assert_eq!(near(0.5), [7]);
        assert_eq!(near(0.6), [6, 7, 8]);
        assert_eq!(near(1.6), [4, 5, 6, 7, 8, 9, 10]);
        assert_eq!(near(1e9).len(), 21);
        assert_eq!(within_two(&ring, 7), [6, 8, 5, 7, 7, 9, 7]);
    }
}
