//! Multipliers of distance constraints, all at once: (J W J^T) m = C.
//!
//! J holds the slopes of the constraints and W the inverse masses. The matrix is sparse, symmetric and positive definite, and its pattern
//! never changes. It is ordered and analysed once, and factorised anew for each solution, on one thread and in double precision (faer,
//! simplicial Cholesky: scalar code without fused operations, the same bits everywhere).

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{CholeskySymbolicParams, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par, Side};
use glam::DVec3;

use crate::model::Adjacency;

/// Added to the diagonal, as a part of it.
const SOFTNESS: f64 = 1e-6;

/// J W J^T, its pattern, and its Cholesky factor.
pub(super) struct System {
    pattern: SymbolicSparseColMat<u32>,
    /// What each entry of the upper triangle is made of, column by column.
    entries: Vec<Entry>,
    values: Vec<f64>,
    analysis: SymbolicCholesky<u32>,
    factor: Vec<f64>,
    workspace: MemBuffer,
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
        let pattern = SymbolicSparseColMat::new_checked(count, count, columns, None, rows);
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SIMPLICIAL,
            ..Default::default()
        };
        let analysis = factorize_symbolic_cholesky(pattern.as_ref(), Side::Upper, SymmetricOrdering::Amd, parameters).ok()?;
        let workspace = MemBuffer::new(StackReq::any_of(&[
            analysis.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()),
            analysis.solve_in_place_scratch::<f64>(1, Par::Seq),
        ]));
        let (values, factor) = (vec![0.0; entries.len()], vec![0.0; analysis.len_val()]);
        (count > 0).then_some(Self { pattern, entries, values, analysis, factor, workspace })
    }

    /// Replaces C by the solution m, for constraints with such slopes, half of dC/dP_v each, or only for those that are `active`: the m
    /// of others is their C. Returns false if the matrix is not positive definite.
    pub fn solve(&mut self, slope: &[DVec3], active: Option<&[bool]>, c: &mut [f64]) -> bool {
        let is_active = |constraint: u32| active.is_none_or(|active| active[constraint as usize]);
        for (value, Entry { constraints: [a, b], weight }) in self.values.iter_mut().zip(&self.entries) {
            *value = match (a == b, is_active(*a) && is_active(*b)) {
                (_, true) => weight * slope[*a as usize].dot(slope[*b as usize]),
                (true, false) => 1.0,
                (false, false) => 0.0,
            };
        }
        let matrix = SparseColMatRef::new(self.pattern.as_ref(), &self.values);
        let factor = self.analysis.factorize_numeric_llt(
            &mut self.factor,
            matrix,
            Side::Upper,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut self.workspace),
            Default::default(),
        );
        let Ok(factor) = factor else { return false };
        let count = c.len();
        let right = MatMut::from_column_major_slice_mut(c, count, 1);
        factor.solve_in_place_with_conj(Conj::No, right, Par::Seq, MemStack::new(&mut self.workspace));
        true
    }
}
