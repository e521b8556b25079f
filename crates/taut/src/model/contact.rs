//! What touches what, and how thick it is.

use super::{Body, ClothRange, Springs};
use crate::scene::{Cloth, Scene};

/// The contact of a model.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ContactSettings {
    /// Whether anything can touch anything.
    pub is_on: bool,
    /// Whether cloths touch themselves and each other.
    pub among_cloths: bool,
    /// Whether what intersects at the start is brought apart.
    pub untangles: bool,
    /// The sides of each cloth.
    pub cloths: Vec<Side>,
    /// The mean length of the springs of the cloth with the shortest ones [m].
    pub cell: f64,
}

/// In a part of a step a body goes a cell of the cloth at most, against it; what is round goes this part of its radius [1], which turns
/// the normal on it by so much, and no more than so many cells.
const OF_RADIUS: f64 = 0.5;
const CELLS: f64 = 4.0;

/// What a cloth is to what touches it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Side {
    /// Mid-surfaces are kept this far apart [m].
    pub thickness: f64,
    /// Coulomb's coefficient [1].
    pub friction: f64,
    /// Of two cloths that intersect the one with the higher layer belongs outside.
    pub layer: u32,
}

impl ContactSettings {
    /// Those of a scene.
    pub(super) fn of(scene: &Scene, cloths: &[ClothRange], springs: &Springs) -> Self {
        let side = |cloth: &Cloth| Side { thickness: cloth.thickness(), friction: cloth.friction(), layer: cloth.layer };
        let mean = |cloth: &ClothRange| {
            let lengths = &springs.rest[cloth.springs.clone()];
            let sum: f64 = lengths.iter().map(|&length| f64::from(length)).sum();
            if lengths.is_empty() { f64::INFINITY } else { sum / lengths.len() as f64 }
        };
        Self {
            is_on: scene.has_contact(),
            among_cloths: scene.self_contact(),
            untangles: scene.has_contact() && scene.untangles(),
            cloths: scene.cloth.iter().map(side).collect(),
            cell: cloths.iter().map(mean).fold(f64::INFINITY, f64::min),
        }
    }

    /// How far a body goes in a part of a step, at most [m].
    #[must_use]
    pub fn furthest(&self, body: &Body) -> f64 {
        (OF_RADIUS * body.radius).clamp(self.cell, CELLS * self.cell)
    }
}
