//! Multipliers of distance constraints, all at once: (J W J^T) m = C.
//!
//! J holds the slopes of the constraints and W the inverse masses. The matrix is sparse, symmetric and positive definite, and its pattern
//! never changes.

use glam::DVec3;

use super::super::cholesky::Cholesky;
use crate::model::Adjacency;

/// Added to the diagonal, as a part of it.
const SOFTNESS: f64 = 1e-6;

/// J W J^T and its Cholesky factor.
pub(super) struct System {
    /// What each entry of the upper triangle is made of, column by column.
    entries: Vec<Entry>,
    values: Vec<f64>,
    cholesky: Cholesky,
}

/// Twice the slopes of two constraints multiplied, times this weight.
struct Entry {
    constraints: [u32; 2],
    weight: f64,
}

impl System {
    /// The system of constraints between pairs of particles with such inverse masses [1/kg]; none if there are none. No pair is held
    /// at both ends.
    pub fn new(pairs: impl ExactSizeIterator<Item = [u32; 2]> + Clone, weights: &[f64]) -> Option<Self> {
        let count = pairs.len();
        let numbered = || (0_u32..).zip(pairs.clone());
        let signed = |(index, [u, v]): (u32, [u32; 2])| [(u, (index, -1.0)), (v, (index, 1.0))];
        let around = Adjacency::new(weights.len(), numbered().flat_map(signed));
        let mut entries = Vec::new();
        let mut columns = vec![0];
        for (index, ends) in numbered() {
            let mut column: Vec<Entry> = Vec::new();
            for (end, sign) in ends.into_iter().zip([-1.0, 1.0]) {
                let others = around.of(end as usize).iter().filter(|(other, _)| *other < index);
                let weight = weights[end as usize];
                column
                    .extend(others.map(|&(other, its)| Entry { constraints: [other, index], weight: 4.0 * weight * sign * its }));
            }
            let [u, v] = ends.map(|end| weights[end as usize]);
            column.push(Entry { constraints: [index, index], weight: 4.0 * (u + v) * (1.0 + SOFTNESS) });
            column.retain(|entry| entry.weight != 0.0);
            column.sort_by_key(|entry| entry.constraints[0]);
            entries.append(&mut column);
            columns.push(entries.len() as u32);
        }
        let rows = entries.iter().map(|entry: &Entry| entry.constraints[0]).collect();
        let values = vec![0.0; entries.len()];
        (count > 0).then_some(Self { cholesky: Cholesky::new(columns, rows)?, entries, values })
    }

    /// Replaces C by the solution m, for constraints with such slopes, half of dC/dP_v each. Returns false if the matrix is not positive
    /// definite.
    pub fn solve(&mut self, slope: &[DVec3], c: &mut [f64]) -> bool {
        for (value, Entry { constraints: [a, b], weight }) in self.values.iter_mut().zip(&self.entries) {
            *value = weight * slope[*a as usize].dot(slope[*b as usize]);
        }
        let is_definite = self.cholesky.factorise(&self.values);
        if is_definite {
            self.cholesky.solve(c);
        }
        is_definite
    }
}
