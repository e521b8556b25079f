//! One level: its particles, stored so that near ones are near in memory, and its springs.

use std::ops::Range;

use glam::Vec3;

use crate::geometry::Vectors;
use crate::model::Adjacency;

/// x, y, z and the inverse mass: 16 bytes that are loaded at once. Most springs are slack and need no more.
pub(super) type Quad = [f32; 4];

/// One level of a cloth.
pub(super) struct Level {
    /// Ends of the step so far [m], and inverse masses.
    pub p: Vec<Quad>,
    /// What is added to displacements: on the finest level the displacements themselves [m].
    pub d: Vectors,
    /// In the order of their first ends.
    pub springs: Vec<Spring>,
    /// Where the finest level keeps each particle.
    pub finest: Vec<u32>,
    /// For each particle those of the next coarser level that it follows, and by which part; none for what is held.
    pub parents: Adjacency<(u32, f32)>,
}

/// A spring of a level.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spring {
    /// Places of its particles, the lower one first.
    pub ends: [u32; 2],
    /// Greatest length [m].
    pub limit: f32,
    /// Greatest length in this step [m].
    pub now: f32,
}

/// When and how far a spring is pulled together, as parts of its greatest length.
#[derive(Clone, Copy)]
pub(super) struct Pull {
    /// Springs longer than this are pulled ..
    pub trigger: f32,
    /// .. to this length ..
    pub aim: f32,
    /// .. by this part of the way.
    pub part: f32,
}

impl Level {
    /// Projects the springs of a run, one after the other.
    pub fn sweep(&mut self, run: Range<usize>, pull: Pull, backwards: bool) {
        let Self { p, d, springs, .. } = self;
        if backwards {
            springs[run].iter().rev().for_each(|spring| project(spring, p, d, pull));
        } else {
            springs[run].iter().for_each(|spring| project(spring, p, d, pull));
        }
    }

    /// Sets the gains to zero.
    pub fn forget(&mut self) {
        let Vectors { x, y, z } = &mut self.d;
        [x, y, z].into_iter().for_each(|column| column.fill(0.0));
    }

    /// Adds what the coarser level gained.
    pub fn follow(&mut self, coarse: &Level) {
        for node in 0..self.p.len() {
            let mut gain = Vec3::ZERO;
            for &(parent, part) in self.parents.of(node) {
                gain += coarse.d.get(parent as usize) * part;
            }
            go(&mut self.p, &mut self.d, node, gain);
        }
    }
}

/// Moves a particle.
#[inline(always)]
fn go(p: &mut [Quad], d: &mut Vectors, node: usize, way: Vec3) {
    let at = &mut p[node];
    *at = [at[0] + way.x, at[1] + way.y, at[2] + way.z, at[3]];
    d.set(node, d.get(node) + way);
}

/// Pulls the two ends together, each by its share.
#[inline(always)]
fn project(spring: &Spring, p: &mut [Quad], d: &mut Vectors, pull: Pull) {
    let [u, v] = spring.ends.map(|end| end as usize);
    let (a, b) = (p[u], p[v]);
    let square = square_distance(a, b);
    let reach = spring.now * pull.trigger;
    if square <= reach * reach {
        return;
    }
    let length = square.sqrt();
    let share = pull.part * (length - spring.now * pull.aim) / (length * (a[3] + b[3]));
    let way = Vec3::new(b[0] - a[0], b[1] - a[1], b[2] - a[2]) * share;
    go(p, d, u, way * a[3]);
    go(p, d, v, way * -b[3]);
}

/// |b - a|^2.
#[inline(always)]
pub(super) fn square_distance(a: Quad, b: Quad) -> f32 {
    let [x, y, z] = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    x * x + y * y + z * z
}
