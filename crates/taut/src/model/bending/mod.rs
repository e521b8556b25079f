//! What resists bending: a constant matrix (quadratic bending), or type 2 springs that buckle at once.
//!
//! The energy of a thin plate whose middle surface is not stretched is quadratic in its positions X, because the second
//! derivatives of X are as long as the curvatures (Bergou et al. 2006). It is `E = B/2 (|X_ss|^2 + 2 |X_st|^2 + |X_tt|^2)` per
//! area, with Poisson's ratio 0. Each source of cloth says what the second derivatives are, as weighted sums of positions
//! ([`Row`]); here they become one matrix. Where the moment follows a measured curve there is none, and the rows are kept.

mod buckling;
mod curved;
mod lines;
mod triangles;

pub use buckling::Buckling;
pub(super) use curved::CurvedCloth;
pub use curved::{Curvatures, Share};
pub(super) use lines::{grid, network};
pub(super) use triangles::mesh;

use std::ops::Range;

use super::{Adjacency, Particles};

/// One second derivative times the root of the area it stands for, as a sum over vertices: `E = B/2 |sum a_v X_v|^2`.
#[derive(Debug, Clone, Default)]
pub(super) struct Row {
    /// Vertices and their a_v [1/m].
    pub weights: Vec<(u32, f64)>,
    /// The area [m^2]; in a network the length [m].
    pub area: f64,
}

/// A pair in the matrix of quadratic bending as one of its ends sees it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Bend {
    /// The other particle.
    pub other: u32,
    /// Pull of the pair per distance [N/m], negative where it pushes: minus the entry of the matrix.
    pub weight: f32,
}

impl Bend {
    /// Pairs with their pulls [N/m], for both ends.
    pub(super) fn both_ways(count: usize, pairs: &[([u32; 2], f64)]) -> Adjacency<Self> {
        let both = pairs.iter().flat_map(|&([a, b], pull)| {
            let weight = pull as f32;
            [(a, Self { other: b, weight }), (b, Self { other: a, weight })]
        });
        Adjacency::new(count, both)
    }
}

/// What resists bending, of all cloths.
#[derive(Debug, Default)]
pub struct Bending {
    /// The matrix of quadratic bending, without its diagonal.
    pub quadratic: Adjacency<Bend>,
    /// Type 2 springs that buckle at once (Choi & Ko 2002).
    pub buckling: Adjacency<Buckling>,
    /// Second derivatives whose moment follows a curve.
    pub curved: Curvatures,
}

impl Bending {
    /// Whether nothing resists bending.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.quadratic.is_empty() && self.buckling.is_empty() && self.curved.is_empty()
    }

    /// A particle's pairs with those after it, where they are stiffest, with their pulls [N/m].
    pub(super) fn pairs_of(&self, particle: usize) -> impl Iterator<Item = ([u32; 2], f64)> + '_ {
        let own = particle as u32;
        let quadratic = self.quadratic.of(particle).iter().map(|bend| (bend.other, f64::from(bend.weight)));
        let buckling = self.buckling.of(particle).iter().map(|spring| (spring.other, spring.steepest()));
        let pairs = quadratic.chain(buckling).chain(self.curved.pairs_of(particle));
        pairs.filter(move |(other, _)| *other > own).map(move |(other, pull)| ([own, other], pull))
    }

    /// An upper bound of w^2 of some particles without curves [1/s^2]: absolute row sums of the matrix divided by masses
    /// (Gershgorin). The largest eigenvalue of a sum is at most the sum of the largest ones.
    pub(super) fn largest_rate(&self, particles: &Particles, run: Range<usize>) -> f64 {
        let rate = |particle: usize| {
            let quadratic = row_sum(&self.quadratic, particle);
            let buckling: f64 = self.buckling.of(particle).iter().map(|spring| 2.0 * spring.steepest()).sum();
            (quadratic + buckling) * f64::from(particles.inverse_mass[particle])
        };
        run.map(rate).fold(0.0, f64::max)
    }
}

/// Absolute sum of a particle's row of a matrix [N/m]; rows add up to zero with their diagonals.
fn row_sum(bends: &Adjacency<Bend>, particle: usize) -> f64 {
    let pulls = bends.of(particle).iter().map(|bend| f64::from(bend.weight));
    pulls.clone().map(f64::abs).sum::<f64>() + pulls.sum::<f64>().abs()
}

/// Largest absolute row sum of a matrix divided by the masses [1/s^2].
fn largest_row_sum(bends: &Adjacency<Bend>, particles: &Particles) -> f64 {
    let rate = |particle: usize| row_sum(bends, particle) * f64::from(particles.inverse_mass[particle]);
    (0..particles.mass.len()).map(rate).fold(0.0, f64::max)
}

/// The pairs of `A^T A` times the bending stiffness, each with its pull [N/m], in the order of their vertices.
pub(super) fn pairs(rows: &[Row], bending: f64) -> Vec<([u32; 2], f64)> {
    let products = rows.iter().flat_map(|row| {
        let before = |index: usize| row.weights[..index].iter();
        row.weights.iter().enumerate().flat_map(move |(index, &(b, of_b))| {
            before(index).map(move |&(a, of_a)| ([a.min(b), a.max(b)], -bending * of_a * of_b))
        })
    });
    let mut products: Vec<_> = products.collect();
    products.sort_by_key(|&(ends, _)| ends);
    let sum = |pair: &[([u32; 2], f64)]| (pair[0].0, pair.iter().map(|&(_, pull)| pull).sum());
    products.chunk_by(|one, other| one.0 == other.0).map(sum).collect()
}
