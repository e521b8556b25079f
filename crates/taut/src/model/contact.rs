//! What touches what, and how thick it is.

use crate::scene::{Cloth, Scene};

/// The contact of a model.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ContactSettings {
    /// Whether anything can touch anything.
    pub is_on: bool,
    /// Whether cloths touch themselves and each other.
    pub among_cloths: bool,
    /// The sides of each cloth.
    pub cloths: Vec<Side>,
}

impl ContactSettings {
    /// Those of a scene.
    pub(super) fn of(scene: &Scene) -> Self {
        let side = |cloth: &Cloth| Side { thickness: cloth.thickness(), friction: cloth.friction() };
        Self { is_on: scene.has_contact(), among_cloths: scene.self_contact(), cloths: scene.cloth.iter().map(side).collect() }
    }
}

/// What a cloth is to what touches it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Side {
    /// Mid-surfaces are kept this far apart [m].
    pub thickness: f64,
    /// Coulomb's coefficient [1].
    pub friction: f64,
}
