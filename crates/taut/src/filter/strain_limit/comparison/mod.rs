//! Strain limits to compare with: the paper's to the letter, plain sweeps, and those of other authors.
//!
//! They are written to show what a method does. The engine's own, `coarse_to_fine/`, uses nothing from here.

mod coloured;
mod fast_projection;
mod multipliers;
mod provot;
mod rods;
mod sequential;
mod sweeps;
mod tethers;
mod xpbd;

use super::StrainLimit;
pub(super) use fast_projection::FastProjection;
pub(super) use provot::Provot;
pub(super) use rods::Rods;
pub(super) use sequential::Sequential;
pub(super) use sweeps::Sweeps;
pub(super) use tethers::Tethers;
pub(super) use xpbd::Xpbd;
