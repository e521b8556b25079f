//! All springs of all cloths, as arrays.

use std::ops::Range;

use crate::scene::FilterKind;

/// What a spring is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpringKind {
    /// Type 1: between neighbours.
    Structural,
    /// Type 1: across a cell.
    Shear,
    /// Type 2 (Choi & Ko 2002): two cells apart, against bending; never limited.
    Flexion,
}

impl SpringKind {
    /// Type 1 springs carry tension and shear and have a strain limit (paper, section 2).
    #[must_use]
    pub fn is_type1(self) -> bool {
        self != Self::Flexion
    }

    /// Whether a filter has rigid rods in place of such springs.
    ///
    /// Of cloth these are warp and weft alone (Goldenthal et al. 2007): with rigid diagonals as well nothing could bend.
    #[must_use]
    pub fn is_rod(self, filter: FilterKind) -> bool {
        self == Self::Structural && matches!(filter, FilterKind::Rods | FilterKind::FastProjection)
    }

    /// Whether a filter does what such springs would do as forces.
    pub(super) fn is_left_to(self, filter: FilterKind) -> bool {
        self.is_rod(filter) || (self.is_type1() && filter == FilterKind::Xpbd)
    }
}

/// Springs, type 1 first.
#[derive(Debug, Clone, Default)]
pub struct Springs {
    /// The two particles.
    pub ends: Vec<[u32; 2]>,
    /// Structural, shear or flexion.
    pub kind: Vec<SpringKind>,
    /// L, the rest length [m].
    pub rest: Vec<f32>,
    /// k_s [N/m]; 0 for a rod, which stores no energy.
    pub stiffness: Vec<f32>,
    /// k_s of the force [N/m]: 0 where the filter does the spring's work.
    pub force_stiffness: Vec<f32>,
    /// Of a spring that follows a curve, which has no k_s: no slope of its force by its length is larger [N/m].
    pub steepest: Vec<f32>,
    /// k_D [kg/s].
    pub damping: Vec<f32>,
    /// lambda [1]; infinite for type 2.
    pub strain_limit: Vec<f32>,
    /// How many are of type 1.
    pub type1: usize,
}

impl Springs {
    /// The number of springs.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// R = (1 + lambda) L, the greatest admissible length [m]; infinite for type 2.
    #[must_use]
    pub fn greatest_length(&self, spring: usize) -> f32 {
        (1.0 + self.strain_limit[spring]) * self.rest[spring]
    }

    /// Both ways along some springs: from one end to the other, and how long the spring may become [m].
    pub(crate) fn ways(&self, run: Range<usize>) -> impl Iterator<Item = (u32, (u32, f32))> + Clone + '_ {
        let steps = run.map(|spring| (self.ends[spring], self.greatest_length(spring)));
        steps.flat_map(|([a, b], length)| [(a, (b, length)), (b, (a, length))])
    }
}
