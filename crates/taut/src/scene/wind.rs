//! The moving air.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The moving air.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Wind {
    /// Mean velocity of the air [m/s].
    pub velocity: [f64; 3],
    /// Fluctuations on top of the mean; none when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gust: Option<Gust>,
    /// Where the force is evaluated: "particle" (the paper's cheaper form) or "triangle" (the classical form).
    pub model: WindModel,
    /// Density of the air, the paper's rho [kg/m^3].
    pub density: f64,
}

impl Default for Wind {
    fn default() -> Self {
        Self { velocity: [0.0; 3], gust: None, model: WindModel::Particle, density: 1.2 }
    }
}

/// Where the wind force is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum WindModel {
    /// On each particle, with the mean normal of its triangles (paper, section 2.2).
    Particle,
    /// On each triangle, shared by its three corners (paper, section 2.2).
    Triangle,
}

/// Seeded fluctuations of the wind, carried along by the mean wind (Taylor 1938).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Gust {
    /// Root mean square of the fluctuation as a fraction of the mean wind speed [1].
    pub strength: f64,
    /// Period of the slowest fluctuation [s]; three octaves above it are added.
    pub period: f64,
    /// Seed: the same seed gives the same gusts [1].
    pub seed: u64,
}

impl Default for Gust {
    fn default() -> Self {
        Self { strength: 0.3, period: 2.0, seed: 1 }
    }
}
