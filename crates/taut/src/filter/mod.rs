//! A proposed step in, an admissible step out: velocities, and the ends to which they lead.
//!
//! What is held goes where its path says; then a strain limit makes the rest fit.

mod pins;
mod strain_limit;

use crate::geometry::{Pool, Vectors};
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
    /// Those of them whose pins went only a part of their way, too: they moved apart further than the cloth could follow.
    pub held_back_pins: u32,
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

/// Gives what is held the velocity that its path asks for in this step.
pub fn hold(model: &Model, state: &mut State) {
    pins::hold(model, state);
}

/// Makes the step admissible: its ends [m], and the velocities that lead there.
pub fn apply(model: &Model, state: &mut State, ends: &mut Vectors, filter: &mut Filter, pool: &Pool) -> Limited {
    pins::place(model, state, ends);
    filter.strain_limit.apply(model, state, ends, pool)
}
