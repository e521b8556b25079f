//! A sparse Cholesky factorisation of a matrix whose pattern never changes.
//!
//! It is ordered and analysed once, and factorised anew for other values, on one thread and in double precision (faer, simplicial:
//! scalar code without fused operations, the same bits everywhere). Without the feature `direct` every matrix is too large.

#[cfg(feature = "direct")]
pub(super) use with_faer::Cholesky;
#[cfg(not(feature = "direct"))]
pub(super) use without::Cholesky;

#[cfg(feature = "direct")]
mod with_faer {
    use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
    use faer::sparse::linalg::SupernodalThreshold;
    use faer::sparse::linalg::cholesky::{
        CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
    };
    use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
    use faer::{Conj, MatMut, Par, Side};

    /// The pattern of a symmetric matrix, and its factor.
    pub struct Cholesky {
        pattern: SymbolicSparseColMat<u32>,
        analysis: SymbolicCholesky<u32>,
        factor: Vec<f64>,
        workspace: MemBuffer,
    }

    impl Cholesky {
        /// Of the upper triangle with such first entries of its columns, and such rows of its entries in ascending order; none if it is too
        /// large.
        pub fn new(columns: Vec<u32>, rows: Vec<u32>) -> Option<Self> {
            let count = columns.len() - 1;
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
            let factor = vec![0.0; analysis.len_val()];
            Some(Self { pattern, analysis, factor, workspace })
        }

        /// Takes the values of the entries. Returns false if the matrix is not positive definite.
        pub fn factorise(&mut self, values: &[f64]) -> bool {
            let matrix = SparseColMatRef::new(self.pattern.as_ref(), values);
            let workspace = MemStack::new(&mut self.workspace);
            let (factor, side) = (&mut self.factor, Side::Upper);
            self.analysis
                .factorize_numeric_llt(factor, matrix, side, Default::default(), Par::Seq, workspace, Default::default())
                .is_ok()
        }

        /// Replaces a right side by the solution for the values that were last factorised.
        pub fn solve(&mut self, right: &mut [f64]) {
            let count = right.len();
            let right = MatMut::from_column_major_slice_mut(right, count, 1);
            let factor = LltRef::new(&self.analysis, &self.factor);
            factor.solve_in_place_with_conj(Conj::No, right, Par::Seq, MemStack::new(&mut self.workspace));
        }
    }
}

#[cfg(not(feature = "direct"))]
mod without {
    /// There is none.
    pub enum Cholesky {}

    impl Cholesky {
        pub fn new(_: Vec<u32>, _: Vec<u32>) -> Option<Self> {
            None
        }

        pub fn factorise(&mut self, _: &[f64]) -> bool {
            match *self {}
        }

        pub fn solve(&mut self, _: &mut [f64]) {
            match *self {}
        }
    }
}
