//! Presets, each figure with its source in `docs/fabrics.md`.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A named preset; its figures and their sources stand in `docs/fabrics.md`.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Fabric {
    /// Light dress silk.
    Silk,
    /// Plain-weave shirt cotton.
    Cotton,
    /// Suiting wool.
    Wool,
    /// 12-ounce denim.
    Denim,
    /// Flag nylon.
    Nylon,
    /// Garment leather.
    Leather,
}

/// What a cloth is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// The paper's lambda [1].
    pub strain_limit: f64,
    /// Mass per area [kg/m^2].
    pub density: f64,
    /// Membrane stiffness of the structural springs [N/m].
    pub stiffness: f64,
    /// Membrane stiffness of the shear springs [N/m].
    pub shear_stiffness: f64,
    /// The paper's k_D [kg/s].
    pub damping: f64,
    /// The paper's k_A [1/s].
    pub air_drag: f64,
    /// The paper's C_d [1].
    pub drag_coefficient: f64,
    /// C_l [1].
    pub lift_coefficient: f64,
    /// How far mid-surfaces are kept apart [m].
    pub thickness: f64,
}

impl Fabric {
    /// The preset's figures.
    #[must_use]
    pub fn material(self) -> Material {
        let row = |strain_limit, density, stiffness, shear_stiffness, damping, air_drag, thickness| Material {
            strain_limit,
            density,
            stiffness,
            shear_stiffness,
            damping,
            air_drag,
            // That of a flat plate.
            drag_coefficient: 1.2,
            lift_coefficient: 1.2,
            thickness,
        };
        match self {
            Self::Silk => row(0.06, 0.07, 10.0, 3.0, 0.002, 0.25, 2.0e-4),
            Self::Cotton => row(0.05, 0.13, 20.0, 10.0, 0.004, 0.15, 3.0e-4),
            Self::Wool => row(0.08, 0.25, 25.0, 10.0, 0.0075, 0.1, 5.0e-4),
            Self::Denim => row(0.03, 0.41, 60.0, 36.0, 0.012, 0.05, 8.0e-4),
            Self::Nylon => row(0.04, 0.10, 20.0, 10.0, 0.004, 0.2, 2.5e-4),
            Self::Leather => row(0.02, 0.60, 100.0, 100.0, 0.03, 0.05, 8.0e-4),
        }
    }

    /// Bending stiffness [N m], which `bending = "fabric"` takes.
    #[must_use]
    pub fn bending(self) -> f64 {
        match self {
            Self::Silk => 2.0e-6,
            Self::Cotton => 1.3e-5,
            Self::Wool => 1.8e-5,
            Self::Denim => 6.4e-5,
            Self::Nylon => 6.2e-6,
            Self::Leather => 3.9e-5,
        }
    }

    /// Area densities at which such a fabric is sold [kg/m^2]; outside them a scene gets a warning.
    #[must_use]
    pub fn usual_density(self) -> (f64, f64) {
        match self {
            Self::Silk => (0.015, 0.2),
            Self::Cotton => (0.05, 0.5),
            Self::Wool => (0.1, 0.7),
            Self::Denim => (0.15, 0.85),
            Self::Nylon => (0.03, 0.3),
            Self::Leather => (0.3, 2.5),
        }
    }
}
