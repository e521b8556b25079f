//! Repeated symmetric, mass-weighted projections on to one spring after the other.
//!
//! Let P = X + V h. A spring with |P_uv| > R pulls both ends together along P_uv, each in proportion to its inverse
//! mass, until |P_uv| = R. That is the projection of P, in the mass norm, on to the convex set |P_uv| <= R; no such
//! projection leads further away from X if X is admissible, so the filter never adds kinetic energy
//! (docs/equations.md, "Sweeps").

use glam::Vec3;

use super::StrainLimit;
use super::coloured::{ColouredSprings, Found, Pass};
use crate::filter::Limited;
use crate::geometry::{Pool, Vectors};
use crate::model::Model;
use crate::schedule::Stride;
use crate::state::State;

/// The limited springs by colour.
pub(in super::super) struct Sweeps {
    springs: ColouredSprings<Spring>,
}

struct Spring {
    /// R [m].
    limit: f32,
    /// w_u / (w_u + w_v); the other end has the rest.
    share: f32,
}

impl Sweeps {
    pub(in super::super) fn new(model: &Model) -> Self {
        let keep = |spring, [u, v]: [f32; 2]| Spring { limit: model.springs.greatest_length(spring), share: u / (u + v) };
        Self { springs: ColouredSprings::new(model, 0..model.springs.type1, keep) }
    }
}

impl StrainLimit for Sweeps {
    fn apply(&mut self, stride: Stride<'_>, state: &mut State, ends: &mut Vectors, pool: &Pool) -> Limited {
        let (model, step) = (stride.model, stride.plan.length as f32);
        let longest = 1.0 + model.solver.tolerance as f32;
        let allowed = longest * longest;
        let mut limited = Limited::default();
        while limited.sweeps < model.solver.iterations() {
            let local = model.solver.local_correction && limited.sweeps > 0;
            let pass = Pass { step, backwards: limited.sweeps % 2 == 1, local };
            let found = self.springs.sweep(ends, &mut state.velocities, pass, pool, project);
            if limited.sweeps == 0 {
                limited.springs = found.over;
            }
            limited.sweeps += 1;
            if found.worst <= allowed {
                break;
            }
        }
        limited
    }
}

/// Pulls a spring that is over its limit back to it; the violation is (|P_uv| / R)^2.
fn project(p_uv: Vec3, spring: &mut Spring, found: &mut Found) -> Option<[Vec3; 2]> {
    let (square, limit) = (p_uv.length_squared(), spring.limit * spring.limit);
    found.worst = found.worst.max(square / limit);
    if square <= limit {
        return None;
    }
    found.over += 1;
    let pull = p_uv * (1.0 - spring.limit / square.sqrt());
    Some([pull * spring.share, pull * (spring.share - 1.0)])
}
