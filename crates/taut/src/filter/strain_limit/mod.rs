//! Ways to keep every type 1 spring within `(1 + lambda) L` (paper, section 3, inequality (1)).
//!
//! `coarse_to_fine/` is the engine's own, and where its time goes; `comparison/` holds what it is compared with. A method is a file, or a
//! folder, and a line in [`new`].

mod cholesky;
mod coarse_to_fine;
mod comparison;
mod none;

use super::Limited;
use crate::contact::{Contact, Touching};
use crate::geometry::{Pool, Vectors, Watch};
use crate::model::Model;
use crate::scene::FilterKind;
use crate::schedule::{Plan, Stride};
use crate::state::State;

/// A way to turn proposed velocities into admissible ones.
pub(super) trait StrainLimit: Send + Sync {
    /// Changes the velocities of a state, and with them the ends of the step, so that no spring is longer than
    /// `(1 + lambda) L` there, as far as the method goes.
    fn apply(&mut self, stride: Stride<'_>, state: &mut State, ends: &mut Vectors, pool: &Pool) -> Limited;

    /// What pushed cloth in the last step.
    fn touching(&self) -> Vec<Touching> {
        Vec::new()
    }

    /// Forgets that.
    fn forget_touching(&mut self) {}

    /// Gives away what it knows of contact, if it knows any: to the filter that takes its place.
    fn take_contact(&mut self) -> Option<Contact> {
        None
    }

    /// The part of its motion that each cloth lost, by its number, where the last step was cut and anything can touch [1].
    fn lost(&self) -> &[f64] {
        &[]
    }

    /// What measures the time of contact, where the method knows any.
    fn watch(&mut self) -> Option<&mut Watch> {
        None
    }
}

/// The method that the model's solver asks for, set up for steps that are planned like this one; with contact that the one before it gave
/// away, if it did.
pub(super) fn new(model: &Model, plan: &Plan, contact: Option<Contact>) -> Box<dyn StrainLimit> {
    match model.solver.filter {
        FilterKind::None => Box::new(none::None),
        FilterKind::Sequential => Box::new(comparison::Sequential::new(model)),
        FilterKind::CoarseToFine => Box::new(coarse_to_fine::CoarseToFine::new(model, plan, contact)),
        FilterKind::Sweeps => Box::new(comparison::Sweeps::new(model)),
        FilterKind::Provot => Box::new(comparison::Provot::new(model)),
        FilterKind::Rods => Box::new(comparison::Rods::new(model)),
        FilterKind::FastProjection => Box::new(comparison::FastProjection::new(model)),
        FilterKind::Tethers => Box::new(comparison::Tethers::new(model)),
        FilterKind::Xpbd => Box::new(comparison::Xpbd::new(model)),
    }
}
