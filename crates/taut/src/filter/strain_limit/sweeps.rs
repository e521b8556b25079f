//! Repeated symmetric, mass-weighted projections on to one spring after the other.
//!
//! Let P = X + V h. A spring with |P_uv| > R pulls both ends together along P_uv, each in proportion to its inverse
//! mass, until |P_uv| = R. That is the projection of P, in the mass norm, on to the convex set |P_uv| <= R; no such
//! projection leads further away from X if X is admissible, so the filter never adds kinetic energy
//! (docs/equations.md, "Sweeps").

use super::StrainLimit;
use super::coloured::{ColouredSprings, Pass};
use crate::filter::Limited;
use crate::geometry::{Pool, Vectors};
use crate::model::Model;
use crate::state::State;

/// The limited springs by colour.
pub(super) struct Sweeps {
    springs: ColouredSprings,
}

impl Sweeps {
    pub(super) fn new(model: &Model) -> Self {
        Self { springs: ColouredSprings::new(model, 0..model.springs.type1) }
    }
}

impl StrainLimit for Sweeps {
    fn apply(&mut self, model: &Model, state: &mut State, ends: &mut Vectors, pool: &Pool) -> Limited {
        let step = model.timing.step_length as f32;
        let allowed = (1.0 + model.solver.tolerance as f32).powi(2);
        let mut limited = Limited::default();
        while limited.sweeps < model.solver.iterations {
            let pass = Pass { step, aim: 1.0, backwards: limited.sweeps % 2 == 1 };
            let found = self.springs.sweep(ends, &mut state.velocities, pass, pool);
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
