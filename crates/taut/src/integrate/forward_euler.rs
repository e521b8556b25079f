//! The Euler method of the textbooks (Euler 1768), here to show why not: positions advance with the *old* velocities.
//!
//! `X^(t+h) = X^t + V^t h`, `V^(t+h) = V^t + F h / M`. Order 1 as the paper's, but every undamped vibration of frequency w grows
//! by sqrt(1 + h^2 w^2) in every step, however short it is.

use super::runge_kutta::{Stage, Tableau};

/// One stage.
pub(super) const TABLEAU: Tableau = &[Stage { node: 0.0, weight: 1.0 }];
