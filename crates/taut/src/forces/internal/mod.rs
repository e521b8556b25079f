//! F_INT = F_s + F_D (paper, section 2.1): the springs and dampers around each particle.
//!
//! A regular grid is walked over row by row; what is not in a grid has lists of springs.

mod curve;
mod lattice;
mod law;
mod links;
mod row;
mod spring;

use crate::geometry::{Pool, Vectors};
use crate::model::{ClothRange, Model};

pub use curve::curved_energy;
pub(super) use curve::force as curved_force;
pub(super) use law::Damper;
pub(super) use law::Hooke;
use law::Law;
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

/// Workspace of a law: that of every lattice, and that of every cloth with springs outside of lattices.
#[derive(Debug)]
pub(super) struct Workspace {
    lattices: Vec<lattice::Workspace>,
    links: Vec<links::Workspace>,
}

impl Workspace {
    pub fn new<L: Law>(law: L, model: &Model) -> Self {
        let linked = model.cloths.iter().filter(|cloth| cloth.linked.is_some());
        Self {
            lattices: model.lattices.iter().map(|lattice| lattice::Workspace::new(law, lattice)).collect(),
            links: linked.map(|cloth| links::Workspace::new(law, model, cloth)).collect(),
        }
    }
}

impl Impulse<'_> {
    /// Writes `out` for the particles of a cloth.
    pub fn apply<L: Law>(self, law: L, model: &Model, cloth: &ClothRange, workspace: &mut Workspace, pool: &Pool) {
        let Self { field, other, out, mut keep, mut add, scale } = self;
        if let Some(lattice) = cloth.lattice {
            let impulse = Impulse { field, other, out: &mut *out, keep, add, scale };
            lattice::apply(law, impulse, model, &model.lattices[lattice], &mut workspace.lattices[lattice], pool);
            (keep, add) = (1.0, 0.0); // links come on top of that
        }
        if let Some(linked) = cloth.linked {
            links::apply(law, Impulse { field, other, out, keep, add, scale }, model, cloth, &mut workspace.links[linked], pool);
        }
    }
}
