//! The explicit midpoint method (Runge 1895): half a step shows the forces of the whole one.
//!
//! Order 2. An undamped vibration of frequency w grows by sqrt(1 + h^4 w^4 / 4) in every step: slowly, but it does.

use super::runge_kutta::{Stage, Tableau};

/// Two stages.
pub(super) const TABLEAU: Tableau = &[Stage { node: 0.0, weight: 0.0 }, Stage { node: 0.5, weight: 1.0 }];
