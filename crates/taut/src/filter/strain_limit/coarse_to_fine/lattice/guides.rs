//! Springs of coarse levels that no way along springs of the cloth is as short as: guides, as on meshes.
//!
//! Where a level has cells of another shape than those of the cloth (in the middle, or where a grid is longer than wide and its rows are
//! used up), their diagonals lead over diagonals and sides of cells of the cloth, which are longer. So does what ties coarse particles to
//! a held one between them. A sheet that shears and folds may be further there than a straight line. Where it is at the start of a step,
//! it only may not go further.

use glam::Vec3;

use super::kernels::{LatticePull, TURNED};
use crate::geometry::Vectors;

/// A spring that is pulled by itself.
pub(super) struct Guide {
    /// The particle at its first end: of this level, where it is kept.
    pub a: usize,
    /// At its other end: of this level as well, or the held particle of the finest level.
    pub b: usize,
    /// Its greatest length [m], and what that is in this step.
    pub limit: f32,
    pub reach: f32,
}

impl Guide {
    /// Of such a greatest length [m].
    pub fn new(a: usize, b: usize, limit: f64) -> Self {
        Self { a, b, limit: limit as f32, reach: limit as f32 }
    }

    /// Takes its length at the start of a step [m].
    pub fn begin(&mut self, length: f32) {
        self.reach = self.limit.max(length);
    }

    /// By how much of `way`, of which it is the length at the end of the step so far, it is too long [1].
    pub fn excess(&self, way: Vec3, aim: f32) -> f32 {
        let (length, reach) = (way.length(), self.reach - self.limit * (1.0 - aim));
        if length > reach { 1.0 - reach / length } else { 0.0 }
    }
}

/// Pulls together the ends of each guide between two particles of a level: `x` is where they begin, `w` are inverse masses.
pub(super) fn pull(guides: &[Guide], x: &Vectors, p: &mut Vectors, w: &[f32], LatticePull { aim, at_start }: LatticePull) {
    for guide in guides {
        let (a, b) = (guide.a, guide.b);
        let way = p.get(b) - p.get(a);
        let (excess, weight) = (guide.excess(way, aim), w[a] + w[b]);
        if excess <= 0.0 || weight <= 0.0 {
            continue;
        }
        let start = x.get(b) - x.get(a);
        let is_steady = at_start && (way - start).length_squared() < TURNED * way.length_squared();
        let along = if is_steady { start } else { way };
        // The length still shrinks by the same.
        let share = along * (excess * way.length_squared() / (way.dot(along) * weight));
        p.set(a, p.get(a) + share * w[a]);
        p.set(b, p.get(b) - share * w[b]);
    }
}
