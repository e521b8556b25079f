//! Points and links: chains, ropes, nets.

use std::collections::BTreeSet;

use glam::DVec3;

use super::SpringKind::{Flexion, Structural};
use super::part::{Part, SpringSeed};
use crate::scene::Network;

/// Two links that meet at a point go straight on if the angle between them is under 30 degrees.
const STRAIGHT: f64 = 0.866;

/// Links become structural springs whose constant is the stiffness itself (the paper's k_s).
pub(super) fn build(network: &Network, flexion: bool) -> Part {
    let points: Vec<DVec3> = network.points.iter().copied().map(DVec3::from_array).collect();
    let mut part = Part { points, ..Part::default() };
    let mut seen = BTreeSet::new();
    let links: Vec<[u32; 2]> = network.links.iter().copied().filter(|&[a, b]| seen.insert([a.min(b), a.max(b)])).collect();
    if links.len() < network.links.len() {
        part.notes.push(format!("{} links are given more than once; each counts once", network.links.len() - links.len()));
    }
    part.springs.extend(links.iter().map(|&ends| SpringSeed { ends, kind: Structural, weight: 1.0 }));
    let neighbours = neighbours(part.points.len(), &links);
    let loose = neighbours.iter().filter(|list| list.is_empty()).count();
    if loose > 0 && part.points.len() > 1 {
        part.notes.push(format!("{loose} points have no link and move freely"));
    }
    if flexion {
        let seed = |[a, _, b]: [u32; 3]| SpringSeed { ends: [a.min(b), a.max(b)], kind: Flexion, weight: 1.0 };
        part.springs.extend(straight_lines(&part.points, &links).into_iter().map(seed));
    }
    part
}

fn neighbours(points: usize, links: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut neighbours = vec![Vec::new(); points];
    for &[a, b] in links {
        neighbours[a as usize].push(b);
        neighbours[b as usize].push(a);
    }
    neighbours
}

/// Three points that follow one another, where the links go straight on.
pub(super) fn straight_lines(points: &[DVec3], links: &[[u32; 2]]) -> Vec<[u32; 3]> {
    let neighbours = neighbours(points.len(), links);
    let mut lines = Vec::new();
    for (middle, around) in neighbours.iter().enumerate() {
        let direction = |end: u32| (points[end as usize] - points[middle]).normalize_or_zero();
        for (index, &a) in around.iter().enumerate() {
            for &b in &around[index + 1..] {
                if direction(a).dot(direction(b)) < -STRAIGHT {
                    lines.push([a, middle as u32, b]);
                }
            }
        }
    }
    lines
}
