//! How wide the vector registers are that the engine uses.

use pulp::{Arch, Simd, WithSimd};

struct Lanes;

impl WithSimd for Lanes {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        S::F32_LANES
    }
}

/// Numbers of single precision that one vector register holds on this machine: 16 with AVX-512, 8 with AVX2, 4 with
/// NEON, 1 where there is none. Results do not depend on it.
pub fn lanes() -> usize {
    Arch::new().dispatch(Lanes)
}
