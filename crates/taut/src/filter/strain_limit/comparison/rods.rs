//! Rigid rods in place of the structural springs (after Li & Xiu 2006).
//!
//! A rod keeps its length in both directions, |P_uv| = L. What replaces a spring has no force: its stiffness does not
//! act, and does not bound the step. The paper at hand says no more of [LiXiu06] than that rods take the place of
//! springs; the solver is ours: mass-weighted projections, colour after colour, forwards and backwards in turn (SHAKE:
//! Ryckaert, Ciccotti & Berendsen 1977, with the directions of the end of the step), until no rod is off its length by
//! more than `tolerance`, or for `iterations` passes.
//!
//! Rods know no lambda. It is the limit of what is left: shear springs stay springs and may not exceed (1 + lambda) L.
//! Were they rods as well, a cloth could fold along its grid lines at best; so a cloth of irregular triangles, where
//! every edge would be a rod, is refused when the model is built.

use glam::Vec3;

use super::StrainLimit;
use super::coloured::{ColouredSprings, Found, Pass};
use crate::filter::Limited;
use crate::geometry::{Pool, Vectors};
use crate::model::Model;
use crate::scene::FilterKind;
use crate::schedule::Stride;
use crate::state::State;

/// Rods and limited springs by colour.
pub(in super::super) struct Rods {
    springs: ColouredSprings<Rod>,
}

struct Rod {
    /// L of a rod, R of a spring [m].
    length: f32,
    /// Whether it may not be shorter either.
    rigid: bool,
    /// w_u / (w_u + w_v); the other end has the rest.
    share: f32,
}

impl Rods {
    pub(in super::super) fn new(model: &Model) -> Self {
        let springs = &model.springs;
        let keep = |spring: usize, [u, v]: [f32; 2]| {
            let rigid = springs.kind[spring].is_rod(FilterKind::Rods);
            let length = if rigid { springs.rest[spring] } else { springs.greatest_length(spring) };
            Rod { length, rigid, share: u / (u + v) }
        };
        Self { springs: ColouredSprings::new(model, 0..springs.type1, keep) }
    }
}

impl StrainLimit for Rods {
    fn apply(&mut self, stride: Stride<'_>, state: &mut State, ends: &mut Vectors, pool: &Pool) -> Limited {
        let (model, step) = (stride.model, stride.plan.length as f32);
        let tolerance = model.solver.tolerance as f32;
        let mut limited = Limited::default();
        while limited.sweeps < model.solver.iterations() {
            let pass = Pass { step, backwards: limited.sweeps % 2 == 1, local: false };
            let correct = |p_uv: Vec3, rod: &mut Rod, found: &mut Found| project(p_uv, rod, tolerance, found);
            let found = self.springs.sweep(ends, &mut state.velocities, pass, pool, correct);
            if limited.sweeps == 0 {
                limited.springs = found.over;
            }
            limited.sweeps += 1;
            if found.worst <= tolerance {
                break;
            }
        }
        limited
    }
}

/// Brings a rod back to its length; the violation is | |P_uv| / L - 1 |, and it counts where it is over `tolerance`.
fn project(p_uv: Vec3, rod: &mut Rod, tolerance: f32, found: &mut Found) -> Option<[Vec3; 2]> {
    let length = p_uv.length();
    if length == 0.0 || (length <= rod.length && !rod.rigid) {
        return None;
    }
    let violation = (length / rod.length - 1.0).abs();
    found.worst = found.worst.max(violation);
    found.over += u32::from(violation > tolerance);
    let pull = p_uv * (1.0 - rod.length / length);
    Some([pull * rod.share, pull * (rod.share - 1.0)])
}
