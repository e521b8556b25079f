//! Bending whose moment follows a measured curve (after Breen, House & Wozny 1994).

use std::ops::Range;

use super::{Bend, Row, largest_row_sum, pairs};
use crate::model::{Adjacency, Curve, Particles};

/// A weight in a second derivative, and the particle or the row that it leads to.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Share {
    /// Particle or row.
    pub index: u32,
    /// Weight of the particle in the row [1/m].
    pub weight: f32,
}

/// Second derivatives of all cloths that bend along a curve.
///
/// Rows of one place (three on a triangle, one elsewhere) make one curvature k, `k^2 = sum |y|^2 / A`, with y = sum a_v X_v.
/// They store `A W(k)`, W being the integral of the curve, so that v feels `-M(k) / k sum a_v y`.
#[derive(Debug, Default)]
pub struct Curvatures {
    /// The particles of each row.
    pub particles: Adjacency<Share>,
    /// The rows of each particle.
    pub rows: Adjacency<Share>,
    /// Of each row: 1 / A [1/m^2], A being the area it stands for.
    pub per_area: Vec<f32>,
    /// Of each row: the rows that make one curvature, itself among them.
    pub together: Vec<Range<usize>>,
    /// Of each row: which of `curves`.
    pub curve: Vec<u32>,
    /// The curves.
    pub curves: Vec<Curve>,
    /// No mode of it is faster [1/s^2].
    rate: f64,
}

/// A cloth that bends along a curve.
pub(in crate::model) struct CurvedCloth {
    /// Its rows, those that make one curvature after one another.
    pub rows: Vec<Row>,
    /// How many of them make one curvature.
    pub together: usize,
    /// Its first particle.
    pub first: u32,
    /// Its curve.
    pub curve: Curve,
}

impl Curvatures {
    /// Of several cloths in their order.
    pub(in crate::model) fn new(particles: &Particles, cloths: Vec<CurvedCloth>) -> Self {
        let count = particles.mass.len();
        let (mut bends, mut shares) = (Vec::new(), Vec::new());
        let mut found = Self::default();
        for (number, CurvedCloth { rows, together, first, curve }) in (0..).zip(cloths) {
            let moved = |([a, b], pull): ([u32; 2], f64)| ([a + first, b + first], pull);
            bends.extend(pairs(&rows, curve.steepest()).into_iter().map(moved));
            for (place, row) in rows.iter().enumerate() {
                let index = found.curve.len() as u32;
                let start = found.curve.len() - place % together;
                found.together.push(start..start + together);
                shares.extend(row.weights.iter().map(|&(vertex, weight)| (index, vertex + first, weight as f32)));
                found.per_area.push((1.0 / row.area) as f32);
                found.curve.push(number);
            }
            found.curves.push(curve);
        }
        found.rate = largest_row_sum(&Bend::both_ways(count, &bends), particles);
        found.particles =
            Adjacency::new(found.curve.len(), shares.iter().map(|&(row, index, weight)| (row, Share { index, weight })));
        found.rows = Adjacency::new(count, shares.iter().map(|&(index, particle, weight)| (particle, Share { index, weight })));
        found
    }

    /// The number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.curve.len()
    }

    /// Whether no cloth bends along a curve.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.curve.is_empty()
    }

    /// The other ends of a particle's pairs in the matrix of a plate that is everywhere as stiff as the curve where it is steepest, with
    /// their pulls [N/m].
    pub(super) fn pairs_of(&self, particle: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
        let rows = if self.is_empty() { &[] } else { self.rows.of(particle) };
        rows.iter().flat_map(move |own| {
            let row = own.index as usize;
            let stiffness = self.curves[self.curve[row] as usize].steepest() * f64::from(own.weight);
            let others = self.particles.of(row).iter().filter(move |other| other.index as usize != particle);
            others.map(move |other| (other.index, -stiffness * f64::from(other.weight)))
        })
    }

    /// w^2 at most [1/s^2]: of a plate that is everywhere as stiff as the curve where it is steepest.
    pub(in crate::model) fn largest_rate(&self) -> f64 {
        self.rate
    }
}
