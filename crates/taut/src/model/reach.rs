//! How far cloth reaches from some of its particles.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::Adjacency;

/// Of each particle the shortest way over springs from the nearest of some sources.
#[derive(Debug)]
pub(crate) struct Reach {
    /// How long it is [m]; infinite where none leads.
    pub lengths: Vec<f64>,
    /// The source, by its number among them.
    pub from: Vec<u32>,
}

impl Reach {
    /// Over a graph that tells of each of its `particles` where springs lead, and how long these may become [m] (Dijkstra).
    pub fn new(graph: &Adjacency<(u32, f32)>, particles: usize, sources: &[u32]) -> Self {
        let mut reach = Self { lengths: vec![f64::INFINITY; particles], from: vec![0; particles] };
        // Non-negative floats order like their bits, which the heap can compare.
        let mut queue = BinaryHeap::new();
        for (number, &source) in (0..).zip(sources) {
            (reach.lengths[source as usize], reach.from[source as usize]) = (0.0, number);
            queue.push(Reverse((0_u64, source)));
        }
        while let Some(Reverse((bits, particle))) = queue.pop() {
            let here = f64::from_bits(bits);
            if here > reach.lengths[particle as usize] {
                continue;
            }
            for &(next, length) in graph.of(particle as usize) {
                let there = here + f64::from(length);
                if there < reach.lengths[next as usize] {
                    (reach.lengths[next as usize], reach.from[next as usize]) = (there, reach.from[particle as usize]);
                    queue.push(Reverse((there.to_bits(), next)));
                }
            }
        }
        reach
    }
}
