//! A sparse Cholesky factorisation of a matrix whose pattern never changes.
//!
//! `P A P^T = L L^T` in double precision, on one thread, by supernodes: columns of L with the same rows lie in one dense panel, and panels
//! take what others have for them by small dense products (Ng and Peyton, SIAM J. Sci. Comput. 14(5), 1993; Davis, Direct Methods for
//! Sparse Linear Systems, 2006). The crate amd orders it. Sums are taken entry by entry in a fixed order, without fused operations: the
//! same bits with all registers. Without the feature `direct` every matrix is too large.

#[cfg(feature = "direct")]
mod factor;
#[cfg(feature = "direct")]
mod supernodes;

#[cfg(feature = "direct")]
pub(super) use factor::Cholesky;
#[cfg(not(feature = "direct"))]
pub(super) use without::Cholesky;

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
