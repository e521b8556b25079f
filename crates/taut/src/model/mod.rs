//! What is simulated: particles, springs, triangles, pins, bodies. Frozen after it is built.

mod adjacency;
mod bending;
mod body;
mod build;
mod compatibility;
mod contact;
mod curve;
mod extent;
mod footprint;
mod free;
mod grid;
mod hierarchy;
mod lattice;
mod mesh;
mod network;
mod numbering;
mod origin;
mod part;
mod pins;
mod precision;
mod rates;
mod reach;
mod selection;
mod springs;
mod surface;
mod thick;
mod weights;
mod winding;

use std::ops::Range;
use std::sync::Arc;

pub use adjacency::Adjacency;
pub use bending::{Bend, Bending, Buckling, Curvatures, Share};
pub use body::{Bodies, Body, BodyShape};
pub use contact::{ContactSettings, Side};
pub use curve::{Curve, CurvedLink, CurvedSprings, Follows};
pub use footprint::Footprint;
pub use hierarchy::{Borne, Hierarchy, HierarchyLevel, NodeRate, Parents, coarse_grid, shares, shares_of_nodes};
pub use lattice::{Lattice, SpringRun};
pub use mesh::MeshData;
pub use numbering::Numbering;
pub use origin::Origin;
pub use pins::PinGroup;
pub use rates::Rates;
pub(crate) use reach::Reach;
pub use springs::{SpringKind, Springs};
pub use surface::{Search, Surface};

use glam::Vec3;

use crate::geometry::Vectors;
use crate::scene::Solver;

/// Contact makes a step about so many times as long: on the shipped scenes 10 to 60 times.
const TOUCHING: usize = 16;

/// Everything about a scene that does not change while it runs. What does not depend on which particles are held may be shared with
/// other models of the scene: see [`Model::holding`].
#[derive(Debug, Clone)]
pub struct Model {
    /// Where each cloth's particles are, in the scene's order.
    pub cloths: Vec<ClothRange>,
    /// Where the coordinates of each cloth begin.
    pub origins: Vec<Origin>,
    /// Which particle each of the user's vertices is.
    pub numbering: Arc<Numbering>,
    /// The particles of all cloths.
    pub particles: Particles,
    /// The springs of all cloths.
    pub springs: Arc<Springs>,
    /// The springs of each particle that are not in a lattice.
    pub links: Arc<Adjacency<Link>>,
    /// The springs that follow measured curves, of all particles.
    pub curved: Arc<CurvedSprings>,
    /// What resists bending.
    pub bending: Arc<Bending>,
    /// The triangles of all cloths, as they are shown: particles counter-clockwise seen from the front.
    pub triangles: Arc<[[u32; 3]]>,
    /// The same surface as masses and wind see it.
    pub panels: Arc<Panels>,
    /// The regular grids among the cloths, for kernels that need no lists of neighbours.
    pub lattices: Arc<[Lattice]>,
    /// The levels of the other cloths, if the filter works on levels.
    pub hierarchies: Arc<[Hierarchy]>,
    /// Held particles.
    pub pins: Arc<[PinGroup]>,
    /// What cloths collide with.
    pub bodies: Arc<Bodies>,
    /// Whether anything touches anything, and how thick cloths are.
    pub contact: ContactSettings,
    /// Integrator and filter.
    pub solver: Solver,
    /// How fast it can vibrate.
    pub rates: Rates,
    /// What is suspicious in the scene and what was repaired in its meshes.
    pub warnings: Vec<String>,
    /// Tells models apart: equal for equal scenes and meshes.
    pub fingerprint: u64,
}

/// A cloth's share of the particles, which is also its share of the user's vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct ClothRange {
    /// The cloth's name.
    pub name: String,
    /// Its first particle.
    pub first: usize,
    /// Its number of particles.
    pub count: usize,
    /// Its type 1 springs.
    pub springs: Range<usize>,
    /// Which of the cloths with springs outside of lattices it is, if it has such springs.
    pub linked: Option<usize>,
    /// Whether springs of it follow measured curves.
    pub curved: bool,
    /// Whether it resists bending.
    pub bends: bool,
    /// Its rows of second derivatives, if their moment follows a curve.
    pub curvatures: Range<usize>,
    /// Whether it is a network, whose masses are never scaled.
    pub is_network: bool,
    /// Which of the model's lattices it is, if it is a grid.
    pub lattice: Option<usize>,
    /// Which of the model's hierarchies is its, if its levels are not those of a lattice.
    pub hierarchy: Option<usize>,
    /// Which of the cloths it is.
    pub index: usize,
    /// How large it is: the side of a square that is as widely spread [m].
    pub size: f64,
    /// Directions in which it extends at the start, of length one and at right angles, a zero for each that is missing; none if it
    /// is not flat.
    pub extends: Option<[Vec3; 2]>,
    /// Gravity leans so far from particle to particle at most, if it is flat [rad].
    pub imperfection: f32,
    /// Its strain limit [1].
    pub strain_limit: f64,
    /// How fast it can vibrate.
    pub fastest: LevelRate,
    /// How fast each of its levels can vibrate, the finest first; none where masses are never scaled.
    pub rates: Vec<LevelRate>,
    /// What a step must bear of them.
    pub borne: Borne,
    /// The part of its free mass that its heaviest particle has beyond four times the mean [1].
    pub heaviest: f64,
}

/// How fast a level of a cloth can vibrate at most.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LevelRate {
    /// w^2 of springs and bending [1/s^2].
    pub frequency_squared: f64,
    /// g of dampers [1/s].
    pub damping: f64,
    /// The part of the mass of what is not held that its particles carry, if they are not tied to what is held [1].
    pub moving: f64,
}

impl ClothRange {
    /// Its particles.
    #[must_use]
    pub fn particles(&self) -> Range<usize> {
        self.first..self.first + self.count
    }

    /// Which of the model's lattices has its levels, if it is a grid that holds nothing that those could not know.
    #[must_use]
    pub fn lattice_of_levels(&self) -> Option<usize> {
        self.lattice.filter(|_| self.hierarchy.is_none())
    }
}

/// The particles of all cloths.
#[derive(Debug, Clone, Default)]
pub struct Particles {
    /// Positions at the start, from the origin of their cloth, where all springs are at rest [m].
    pub rest: Vectors,
    /// Mass [kg].
    pub mass: Vec<f32>,
    /// 1/mass [1/kg]; zero for what is held.
    pub inverse_mass: Vec<f32>,
    /// k_A [1/s].
    pub air_drag: Vec<f32>,
    /// C_d, C_l and C_f [1].
    pub wind: Vec<Resistance>,
}

/// How strongly the wind acts on a cloth.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Resistance {
    /// C_d [1].
    pub drag: f32,
    /// C_l [1].
    pub lift: f32,
    /// C_f [1].
    pub friction: f32,
}

/// What has mass and catches the wind: the triangles of a mesh, the whole cells of a grid. Cutting cells along one
/// diagonal would give their corners different shares.
#[derive(Debug, Default)]
pub struct Panels {
    /// Their particles, counter-clockwise seen from the front; a triangle has its last one twice.
    pub corners: Vec<[u32; 4]>,
    /// The share of each corner: 1/3 or 1/4 [1].
    pub share: Vec<f32>,
    /// The panels around each particle.
    pub around: Adjacency<u32>,
}

impl Particles {
    /// Those of a run that are held.
    pub(crate) fn held(&self, run: Range<usize>) -> impl Iterator<Item = usize> {
        run.filter(|&particle| self.inverse_mass[particle] == 0.0 && self.mass[particle] > 0.0)
    }

    /// Masses of the particles of a cloth [kg]; nothing for what is held.
    #[must_use]
    pub fn free_masses(&self, cloth: &ClothRange) -> Vec<f64> {
        let weights = &self.inverse_mass[cloth.particles()];
        weights.iter().map(|&weight| if weight > 0.0 { 1.0 / f64::from(weight) } else { 0.0 }).collect()
    }

    /// The part of a cloth's free mass that its heaviest particle has beyond four times the mean [1].
    fn heaviest(&self, cloth: &ClothRange) -> f64 {
        let masses = self.free_masses(cloth);
        let (sum, most) = masses.iter().fold((0.0, 0.0), |(sum, most), mass| (sum + mass, mass.max(most)));
        (most / sum.max(f64::MIN_POSITIVE) - 4.0 / masses.len() as f64).max(0.0)
    }
}

/// A spring as one of its ends sees it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Link {
    /// The particle at the other end.
    pub other: u32,
    /// L [m].
    pub rest: f32,
    /// k_s [N/m].
    pub stiffness: f32,
    /// k_D [kg/s].
    pub damping: f32,
}

impl Model {
    /// The cloth that a particle belongs to.
    ///
    /// # Panics
    /// If there is no such particle.
    #[must_use]
    pub fn cloth_of(&self, particle: usize) -> usize {
        self.cloths.partition_point(|cloth| cloth.particles().end <= particle)
    }

    /// How much a step has to do: as much as one of so many particles that touch nothing.
    #[must_use]
    pub fn load(&self) -> usize {
        self.particle_count() * if self.contact.is_on { TOUCHING } else { 1 }
    }

    /// The number of particles.
    #[must_use]
    pub fn particle_count(&self) -> usize {
        self.particles.mass.len()
    }
}
