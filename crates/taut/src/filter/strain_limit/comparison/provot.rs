//! Correction of positions, one spring after the other (Provot 1995, "dynamic inverse procedure").
//!
//! X. Provot, *Deformation constraints in a mass-spring model to describe rigid cloth behavior*, Graphics Interface 95.
//! After a step in which springs were mere springs, each spring is looked at once. One that is stretched beyond the
//! critical rate, here lambda, is brought back to it along its axis: by half at each end where both are free, wholly at
//! the free end where the other is held. The order is ours: structural springs, then shear springs. Two cells in a
//! row cannot be stretched further than each of them, so flexion springs need no correction.
//!
//! Mending one spring stretches its neighbours, and a single pass does not come back to them: the known fault of the
//! method, and it shows. Halves are not mass-weighted either, so momentum is kept only where masses are equal.

use super::StrainLimit;
use crate::filter::Limited;
use crate::geometry::{Pool, Vectors};
use crate::model::Model;
use crate::schedule::Stride;
use crate::state::State;

/// A spring that can be corrected.
struct Spring {
    ends: [u32; 2],
    /// R [m].
    limit: f32,
    /// The part of the correction that each end takes.
    parts: [f32; 2],
}

/// The springs in their order.
pub(in super::super) struct Provot {
    springs: Vec<Spring>,
}

impl Provot {
    pub(in super::super) fn new(model: &Model) -> Self {
        let free = |particle: u32| model.particles.inverse_mass[particle as usize] > 0.0;
        let springs = (0..model.springs.type1).filter_map(|index| {
            let ends = model.springs.ends[index];
            let parts = match ends.map(free) {
                [true, true] => [0.5, 0.5],
                [true, false] => [1.0, 0.0],
                [false, true] => [0.0, 1.0],
                [false, false] => return None,
            };
            Some(Spring { ends, limit: model.springs.greatest_length(index), parts })
        });
        Self { springs: springs.collect() }
    }
}

impl StrainLimit for Provot {
    fn apply(&mut self, stride: Stride<'_>, state: &mut State, ends: &mut Vectors, _: &Pool) -> Limited {
        let (model, step) = (stride.model, stride.plan.length as f32);
        let mut limited = Limited::default();
        while limited.sweeps < model.solver.iterations() {
            let mut over = 0;
            for Spring { ends: [u, v], limit, parts } in &self.springs {
                let (u, v) = (*u as usize, *v as usize);
                let p_uv = ends.get(v) - ends.get(u);
                let square = p_uv.length_squared();
                if square <= limit * limit {
                    continue;
                }
                over += 1;
                let excess = p_uv * (1.0 - limit / square.sqrt());
                for (end, pull) in [(u, excess * parts[0]), (v, excess * -parts[1])] {
                    ends.set(end, ends.get(end) + pull);
                    // Velocities follow: one that led out of the limit would grow step by step under the load.
                    state.velocities.set(end, state.velocities.get(end) + pull / step);
                }
            }
            limited.springs = if limited.sweeps == 0 { over } else { limited.springs };
            limited.sweeps += 1;
            if over == 0 {
                break;
            }
        }
        limited
    }
}
