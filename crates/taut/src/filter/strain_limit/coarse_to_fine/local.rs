//! Springs around a few places, swept by themselves.

use super::Levels;
use crate::model::Adjacency;

/// So many rings of springs around a place are swept.
const RINGS: usize = 3;

/// Workspace of a cloth.
pub(super) struct Local {
    particles: Vec<u32>,
    is_taken: Vec<bool>,
}

impl Local {
    /// Of a cloth with so many particles.
    pub fn new(count: usize) -> Self {
        Self { particles: Vec::with_capacity(count), is_taken: vec![false; count] }
    }

    /// Takes the particles around some, ring by ring; `around` has the neighbours of each.
    pub fn gather(&mut self, seeds: impl Iterator<Item = usize>, around: &Adjacency<(u32, f32)>) {
        self.particles.drain(..).for_each(|particle| self.is_taken[particle as usize] = false);
        for seed in seeds {
            self.take(seed as u32);
        }
        let mut first = 0;
        for _ in 0..RINGS {
            let ring = first..self.particles.len();
            first = ring.end;
            for index in ring {
                around.of(self.particles[index] as usize).iter().for_each(|&(other, _)| self.take(other));
            }
        }
    }

    fn take(&mut self, particle: u32) {
        if !std::mem::replace(&mut self.is_taken[particle as usize], true) {
            self.particles.push(particle);
        }
    }

    /// Pulls together the ends of each spring around that is longer than `aim` of its greatest length; `weights` are W [1/kg].
    pub fn sweep(&self, levels: &mut dyn Levels, around: &Adjacency<(u32, f32)>, weights: &[f32], aim: f32) {
        for &particle in &self.particles {
            let one = particle as usize;
            for &(other, limit) in around.of(one) {
                // Springs between two of them are swept once.
                if self.is_taken[other as usize] && other < particle {
                    continue;
                }
                let two = other as usize;
                let (way, reach, both) = (levels.between(one, two), aim * limit, weights[one] + weights[two]);
                let square = way.length_squared();
                if square > reach * reach && both > 0.0 {
                    let pull = way * ((1.0 - reach / square.sqrt()) / both);
                    levels.shift(one, pull * weights[one]);
                    levels.shift(two, pull * -weights[two]);
                }
            }
        }
    }
}
