//! Distances along the cloth at rest.
//!
//! Along crooked edges distances come out too long. Where triangles are known, a front that has reached two corners of
//! a triangle goes on straight across it. The triangle is unfolded into the plane of the source. That is exact on
//! flat and developable cloth.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::{Adjacency, ClothRange, Springs};
use crate::geometry::Vectors;

/// A cloth at rest: particles are numbered from its first.
pub struct Surface {
    /// The particles joined to each, and how far they are [m].
    links: Adjacency<(u32, f32)>,
    /// The triangles around each particle.
    corners: Adjacency<Corner>,
}

/// A triangle as one of its particles sees it.
#[derive(Debug, Clone, Copy, Default)]
struct Corner {
    others: [u32; 2],
    /// From the particle to each of the others [m].
    to: [f32; 2],
    /// Between the others [m].
    across: f32,
}

/// Workspace of a search.
pub struct Search {
    distance: Vec<f32>,
    queue: BinaryHeap<Reverse<(u32, u32)>>,
    /// The particles reached.
    pub reached: Vec<u32>,
}

impl Surface {
    /// A cloth's springs and triangles; `rest` are all particles at rest.
    #[must_use]
    pub fn new(cloth: &ClothRange, rest: &Vectors, springs: &Springs, triangles: &[[u32; 3]]) -> Self {
        let local = |particle: u32| particle - cloth.first as u32;
        let links = cloth.springs.clone().flat_map(|spring| {
            let [a, b] = springs.ends[spring].map(local);
            [(a, (b, springs.rest[spring])), (b, (a, springs.rest[spring]))]
        });
        let own = cloth.particles();
        let apart = |a: u32, b: u32| rest.get(a as usize).distance(rest.get(b as usize));
        let triangles = triangles.iter().filter(|corners| own.contains(&(corners[0] as usize)));
        let corners = triangles.flat_map(|&[a, b, c]| {
            [(a, b, c), (b, c, a), (c, a, b)].map(|(a, b, c)| {
                let corner = Corner { others: [local(b), local(c)], to: [apart(a, b), apart(a, c)], across: apart(b, c) };
                (local(a), corner)
            })
        });
        Self { links: Adjacency::new(cloth.count, links), corners: Adjacency::new(cloth.count, corners) }
    }

    /// The particles joined to one, and how far they are [m].
    pub fn links(&self, particle: u32) -> &[(u32, f32)] {
        self.links.of(particle as usize)
    }
}

impl Search {
    /// Workspace for a cloth of so many particles.
    pub fn new(particles: usize) -> Self {
        Self { distance: vec![f32::INFINITY; particles], queue: BinaryHeap::new(), reached: Vec::new() }
    }

    /// How far a particle is that the last search reached [m].
    pub fn distance(&self, particle: u32) -> f32 {
        self.distance[particle as usize]
    }

    /// Finds the particles within `radius` of `source`, `most` of them at most: hubs with many links know no bounds.
    pub fn run(&mut self, surface: &Surface, source: u32, radius: f32, most: usize) {
        self.run_while(surface, source, radius, most, |_, _| true);
    }

    /// As [`Self::run`], but does not go on from a particle where its distance is not `wanted`.
    pub fn run_while(&mut self, surface: &Surface, source: u32, radius: f32, most: usize, wanted: impl Fn(u32, f32) -> bool) {
        for particle in self.reached.drain(..) {
            self.distance[particle as usize] = f32::INFINITY;
        }
        self.improve(source, 0.0, radius);
        while let Some(Reverse((bits, here))) = self.queue.pop() {
            let so_far = f32::from_bits(bits);
            if so_far > self.distance(here) || self.reached.len() > most || !wanted(here, so_far) {
                continue;
            }
            for &(other, length) in surface.links(here) {
                self.improve(other, so_far + length, radius);
            }
            for corner in surface.corners.of(here as usize) {
                let [a, b] = corner.others;
                let [to_a, to_b] = corner.to;
                if let Some(straight) = unfolded([so_far, self.distance(a)], to_a, [to_b, corner.across]) {
                    self.improve(b, straight, radius);
                }
                if let Some(straight) = unfolded([so_far, self.distance(b)], to_b, [to_a, corner.across]) {
                    self.improve(a, straight, radius);
                }
            }
        }
    }

    fn improve(&mut self, particle: u32, distance: f32, radius: f32) {
        let best = &mut self.distance[particle as usize];
        // An improvement at the level of rounding is none; the front would run in circles.
        if distance <= radius && distance < *best * (1.0 - 1e-5) {
            if *best == f32::INFINITY {
                self.reached.push(particle);
            }
            *best = distance;
            self.queue.push(Reverse((distance.to_bits(), particle)));
        }
    }
}

/// The distance from a source to the tip of a triangle, straight across its base; none if the straight line misses it.
///
/// `source` are the distances of the source from the two ends of the base, `base` its length, `sides` those from its
/// ends to the tip.
fn unfolded(source: [f32; 2], base: f32, sides: [f32; 2]) -> Option<f32> {
    if source[1] == f32::INFINITY || base <= 0.0 {
        return None;
    }
    let along = |[from, to]: [f32; 2]| (from * from - to * to + base * base) / (2.0 * base);
    let (source_along, tip_along) = (along(source), along(sides));
    let depth = source[0] * source[0] - source_along * source_along;
    let height = sides[0] * sides[0] - tip_along * tip_along;
    if depth <= 0.0 || height <= 0.0 {
        return None;
    }
    let (depth, height) = (depth.sqrt(), height.sqrt());
    let crossing = source_along + (tip_along - source_along) * depth / (depth + height);
    let (across, along) = (depth + height, tip_along - source_along);
    (0.0..=base).contains(&crossing).then(|| (across * across + along * along).sqrt())
}
