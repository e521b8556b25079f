//! The classical Runge-Kutta method (Kutta 1901), what the paper proposes where accuracy matters (section 5).
//!
//! Order 4. Stable for vibrations up to h w = 2.83, which it damps a little: at h w = 1 by 0.7 % of the amplitude in a step.

use super::runge_kutta::{Stage, Tableau};

/// Four stages.
pub(super) const TABLEAU: Tableau = &[
    Stage { node: 0.0, weight: 1.0 / 6.0 },
    Stage { node: 0.5, weight: 1.0 / 3.0 },
    Stage { node: 0.5, weight: 1.0 / 3.0 },
    Stage { node: 1.0, weight: 1.0 / 6.0 },
];
