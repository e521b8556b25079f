//! The linear system of an implicit step, solved by conjugate gradients.
//!
//! It is `(M - b dF/dV - b^2 dF/dX) U = R` for the change of velocity U of a cloth. What is held does not change
//! (Baraff & Witkin, *Large steps in cloth simulation*, 1998, section 5). The matrix is symmetric and positive definite, and
//! never written down. The method is that of Hestenes & Stiefel 1952, in double precision. The preconditioner is the inverse of each
//! particle's own 3 x 3 block. Sums are taken chunk by chunk, so that they do not depend on the number of threads.

use glam::{DMat3, DVec3};

use crate::forces::{Forces, Stiffness};
use crate::geometry::{CHUNK, Pool, Vectors, for_each_chunk, sum_over_chunks};
use crate::model::{ClothRange, Model};

/// The residual that is left, in the norm of the preconditioner, as a part of the right side.
const TOLERANCE: f64 = 1e-6;
/// No more passes than this in one step.
const MOST_PASSES: u32 = 1000;

/// The system of one cloth.
pub(super) struct LinearSystem {
    cloth: ClothRange,
    stiffness: Stiffness,
    /// M [kg]; 0 for what is held.
    masses: Vec<f64>,
    /// The inverse of each particle's own block; zero for what is held.
    blocks: Vec<DMat3>,
    iterates: Vec<Iterate>,
    /// The direction of search, and the matrix times it.
    search: Vec<DVec3>,
    product: Vec<DVec3>,
    /// A part of a sum for each chunk.
    parts: Vec<f64>,
    /// b [s]
    reach: f64,
}

/// Solution and residual of a particle.
#[derive(Debug, Clone, Copy, Default)]
struct Iterate {
    change: DVec3,
    residual: DVec3,
}

impl LinearSystem {
    pub fn new(model: &Model, cloth: &ClothRange) -> Self {
        let (count, particles) = (cloth.count, &model.particles);
        let masses: Vec<f64> = cloth
            .particles()
            .map(|particle| if particles.inverse_mass[particle] > 0.0 { f64::from(particles.mass[particle]) } else { 0.0 })
            .collect();
        Self {
            stiffness: Stiffness::new(model, cloth),
            masses,
            blocks: vec![DMat3::ZERO; count],
            iterates: vec![Iterate::default(); count],
            search: vec![DVec3::ZERO; count],
            product: vec![DVec3::ZERO; count],
            parts: vec![0.0; count.div_ceil(CHUNK)],
            reach: 0.0,
            cloth: cloth.clone(),
        }
    }

    /// Sets up the matrix for a b [s], forces being linear around these positions.
    pub fn look(&mut self, positions: &Vectors, reach: f64, pool: &Pool) {
        self.stiffness.look(positions, pool);
        self.reach = reach;
        let Self { stiffness, masses, blocks, .. } = self;
        for_each_chunk(blocks, pool, |first, blocks| {
            for (particle, block) in (first..).zip(blocks) {
                *block = own_block(stiffness, particle, masses[particle], reach);
            }
        });
    }

    /// All forces on a particle [N], as they were last looked at.
    pub fn force(&self, forces: &Forces, particle: usize) -> DVec3 {
        self.momentum(forces.acceleration(), particle)
    }

    /// M times one of some velocities [kg m/s].
    pub fn momentum(&self, velocities: &Vectors, particle: usize) -> DVec3 {
        velocities.get(self.cloth.first + particle).as_dvec3() * self.masses[particle]
    }

    /// What the springs add to forces if everything goes on for the time b with its velocity: `b dF/dX V` [N].
    pub fn pull_of(&self, velocities: &Vectors, particle: usize) -> DVec3 {
        let at = |particle: usize| velocities.get(self.cloth.first + particle).as_dvec3();
        let here = at(particle);
        self.stiffness.around(particle).fold(DVec3::ZERO, |sum, (other, answer)| {
            let way = at(other) - here;
            sum + (way * answer.all_ways + answer.direction * (answer.along * answer.direction.dot(way))) * self.reach
        })
    }

    /// Solves for the changes of velocity; `right(particle)` is R / b [N] of a particle of the cloth. Returns the passes.
    pub fn solve(&mut self, right: impl Fn(&Self, usize) -> DVec3 + Sync, pool: &Pool) -> u32 {
        let mut iterates = std::mem::take(&mut self.iterates);
        let mut parts = std::mem::take(&mut self.parts);
        let first = sum_over_chunks(&mut iterates, &mut parts, pool, |first, iterates| {
            let each = (first..).zip(iterates).map(|(particle, iterate)| {
                let residual = if self.masses[particle] > 0.0 { right(self, particle) * self.reach } else { DVec3::ZERO };
                *iterate = Iterate { change: DVec3::ZERO, residual };
                residual.dot(self.blocks[particle] * residual)
            });
            each.sum()
        });
        (self.iterates, self.parts) = (iterates, parts);
        let (mut square, mut before) = (first, f64::INFINITY);
        for pass in 0..MOST_PASSES {
            if square <= TOLERANCE * TOLERANCE * first || !square.is_finite() {
                return pass;
            }
            self.turn(square / before, pool);
            let curvature = self.multiply(pool);
            before = square;
            square = self.advance(square / curvature, pool);
        }
        MOST_PASSES
    }

    /// Writes the changes of velocity found [m/s].
    pub fn write_changes(&self, changes: &mut Vectors, pool: &Pool) {
        changes.for_each_chunk_of(self.cloth.particles(), pool, |chunk| {
            chunk.map(|particle, _| self.iterates[particle - self.cloth.first].change.as_vec3());
        });
    }

    /// `p = P r + factor p`; the first factor is 0.
    fn turn(&mut self, factor: f64, pool: &Pool) {
        let Self { blocks, iterates, search, .. } = self;
        for_each_chunk(search, pool, |first, search| {
            for (particle, search) in (first..).zip(search) {
                let kept = if factor > 0.0 { *search * factor } else { DVec3::ZERO };
                *search = blocks[particle] * iterates[particle].residual + kept;
            }
        });
    }

    /// The matrix times p; returns p times that.
    fn multiply(&mut self, pool: &Pool) -> f64 {
        let Self { stiffness, masses, search, product, parts, reach, .. } = self;
        let reach = *reach;
        sum_over_chunks(product, parts, pool, |first, product| {
            let each = (first..).zip(product).map(|(particle, product)| {
                let (here, mass) = (search[particle], masses[particle]);
                if mass == 0.0 {
                    *product = DVec3::ZERO;
                    return 0.0;
                }
                let own = here * mass;
                *product = stiffness.around(particle).fold(own, |sum, (other, answer)| {
                    let way = here - search[other];
                    let along = reach * reach * answer.along * answer.direction.dot(way);
                    sum + way * (reach * (answer.damping + reach * answer.all_ways)) + answer.direction * along
                });
                here.dot(*product)
            });
            each.sum()
        })
    }

    /// `u += a p`, `r -= a A p`; returns r times P r.
    fn advance(&mut self, factor: f64, pool: &Pool) -> f64 {
        let Self { blocks, iterates, search, product, parts, .. } = self;
        sum_over_chunks(iterates, parts, pool, |first, iterates| {
            let each = (first..).zip(iterates).map(|(particle, iterate)| {
                iterate.change += search[particle] * factor;
                iterate.residual -= product[particle] * factor;
                iterate.residual.dot(blocks[particle] * iterate.residual)
            });
            each.sum()
        })
    }
}

/// The inverse of what a particle's own change of velocity meets; zero for what is held.
fn own_block(stiffness: &Stiffness, particle: usize, mass: f64, reach: f64) -> DMat3 {
    if mass == 0.0 {
        return DMat3::ZERO;
    }
    let own = DMat3::from_diagonal(DVec3::splat(mass));
    let block = stiffness.around(particle).fold(own, |sum, (_, answer)| {
        let n = answer.direction;
        let along = DMat3::from_cols(n * n.x, n * n.y, n * n.z) * (reach * reach * answer.along);
        sum + along + DMat3::from_diagonal(DVec3::splat(reach * (answer.damping + reach * answer.all_ways)))
    });
    block.inverse()
}
