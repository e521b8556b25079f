//! No limit: the bare mass-spring cloth with its super-elasticity.

use super::StrainLimit;
use crate::filter::Limited;
use crate::geometry::{Pool, Vectors};
use crate::schedule::Stride;
use crate::state::State;

/// Leaves velocities as they are.
pub(super) struct None;

impl StrainLimit for None {
    fn apply(&mut self, _: Stride<'_>, _: &mut State, _: &mut Vectors, _: &Pool) -> Limited {
        Limited::default()
    }
}
