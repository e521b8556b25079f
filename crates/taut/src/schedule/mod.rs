//! How long a step is, and in how many parts springs and dampers take it: every policy about steps, with its constants.

mod blame;
mod bodies;
mod choice;
mod halving;
mod pace;
mod parts;
mod sleep;
mod stability;

pub(crate) use bodies::{BodyWays, Moving};
pub use choice::{BadLength, Schedule};
pub use halving::{Halving, Parts};
pub use parts::{ClothPlan, Plan, ScaledTiming};
pub use sleep::{Sleep, Stillness};

use crate::inputs::Inputs;
use crate::model::Model;

/// A step to be taken: of what, under what, and how.
#[derive(Debug, Clone, Copy)]
pub struct Stride<'a> {
    /// What moves.
    pub model: &'a Model,
    /// What acts on it from outside.
    pub inputs: &'a Inputs,
    /// How long the step is, and its parts.
    pub plan: &'a Plan,
    /// Whether it is taken back, and taken in halves, where it would have to be cut: nobody needs it cut then.
    pub can_be_halved: bool,
}
