//! Proposed velocities in, admissible velocities out.
//!
//! First the pins take the velocity that their path asks for, then a strain limit makes the others fit.

mod pins;
mod strain_limit;

use crate::geometry::Pool;
use crate::model::Model;
use crate::state::State;
use strain_limit::StrainLimit;

/// What a filter did in one step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Limited {
    /// Springs that would have gone over their limit.
    pub springs: u32,
    /// Passes over the springs; cycles over all levels in the coarse-to-fine filter.
    pub sweeps: u32,
    /// Cloths whose step the certificate had to shorten.
    pub cuts: u32,
}

/// The filter of a model with its workspace.
pub struct Filter {
    strain_limit: Box<dyn StrainLimit>,
}

impl Filter {
    /// The filter that the model's solver asks for.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        Self { strain_limit: strain_limit::new(model) }
    }
}

/// Makes the velocities admissible.
pub fn apply(model: &Model, state: &mut State, filter: &mut Filter, pool: &Pool) -> Limited {
    pins::apply(model, state);
    filter.strain_limit.apply(model, state, pool)
}
