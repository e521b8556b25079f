//! F_INT = F_s + F_D (paper, section 2.1): the springs and dampers around each particle.
//!
//! A regular grid is walked over row by row with vector instructions; what is not in a grid gathers along lists of links.

mod damping;
mod lattice;
mod law;
mod links;
mod spring;

use crate::geometry::{Pool, Vectors};
use crate::model::Model;

use lattice::Sums;
use law::Law;
pub(super) use law::{Damper, Hooke};
pub use spring::elastic_energy;

/// `out = keep out + add other + scale F / M`, F being the forces that a law draws from `field`; for what is held 1/M is zero.
pub(super) struct Impulse<'a> {
    /// Positions [m] for springs, velocities [m/s] for dampers.
    pub field: &'a Vectors,
    pub other: &'a Vectors,
    pub out: &'a mut Vectors,
    pub keep: f32,
    pub add: f32,
    /// [s]
    pub scale: f32,
}

/// Workspace: sums over the springs of a row, for every lattice.
#[derive(Debug)]
pub(super) struct Workspace {
    lattices: Vec<Sums>,
}

impl Workspace {
    pub fn new(model: &Model) -> Self {
        Self { lattices: model.lattices.iter().map(Sums::new).collect() }
    }
}

impl Impulse<'_> {
    /// Writes `out` for all cloths.
    pub fn apply<L: Law>(self, law: L, model: &Model, workspace: &mut Workspace, pool: &Pool) {
        let Self { field, other, out, keep, add, scale } = self;
        for (lattice, sums) in model.lattices.iter().zip(&mut workspace.lattices) {
            let impulse = Impulse { field, other, out: &mut *out, keep, add, scale };
            lattice::apply(law, impulse, model, lattice, sums, pool);
        }
        if model.cloths.iter().any(|cloth| cloth.linked) {
            links::apply(law, Impulse { field, other, out, keep, add, scale }, model, pool);
        }
    }
}
