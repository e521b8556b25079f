//! The moving air.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::validate::check_wind;
use super::{Keyframe, SceneError};

/// The moving air.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Wind {
    /// Mean velocity of the air [m/s].
    pub velocity: [f64; 3],
    /// Keyframes `[time [s], [x, y, z] [m/s]]` of `velocity`, joined by straight lines from `velocity` at time 0 on; gusts grow and fall with the speed. None: it stays.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub keyframes: Vec<Keyframe>,
    /// Fluctuations on top of the mean; none when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gust: Option<Gust>,
    /// Flows on top of the mean: vortices, sources and sinks, further uniform flows; none when left out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub elements: Vec<FlowElement>,
    /// Where the force is evaluated: "particle" (the paper's cheaper form) or "triangle" (the classical form).
    pub model: WindModel,
    /// How the force follows from the relative wind: "pressure" (along the normal, as in the paper) or "drag_lift" (drag along the relative wind and lift across it).
    pub law: WindLaw,
    /// Density of the air, the paper's rho [kg/m^3].
    pub density: f64,
}

impl Default for Wind {
    fn default() -> Self {
        Self {
            velocity: [0.0; 3],
            keyframes: Vec::new(),
            gust: None,
            elements: Vec::new(),
            model: WindModel::Particle,
            law: WindLaw::Pressure,
            density: 1.2,
        }
    }
}

impl<T: Into<f64>> From<[T; 3]> for Wind {
    /// The same velocity everywhere and always [m/s].
    fn from(velocity: [T; 3]) -> Self {
        Self { velocity: velocity.map(Into::into), ..Self::default() }
    }
}

impl Wind {
    /// Refuses the first field that is out of range.
    ///
    /// # Errors
    /// That field, what is allowed and a remedy.
    pub fn check(&self) -> Result<(), SceneError> {
        check_wind(self)
    }

    /// The wind as JSON.
    #[cfg(feature = "json")]
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("plain data with string keys always serialises")
    }
}

/// Where the wind force is evaluated.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum WindModel {
    /// On each particle, with the mean normal of its triangles (paper, section 2.2).
    Particle,
    /// On each triangle, shared by its three corners (paper, section 2.2).
    Triangle,
}

/// How the wind force follows from the relative wind.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WindLaw {
    /// Along the normal, with `drag_coefficient` (paper, section 2.2).
    Pressure,
    /// Drag along the relative wind with `drag_coefficient`, lift across it with `lift_coefficient` (Keckeisen et al. 2004).
    DragLift,
}

/// A simple flow that is added to the wind everywhere (Ling, Damodaran & Gay 1994; Wejchert & Haumann 1991).
///
/// Which of the fields below it has depends on its kind; further ones are refused.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FlowElement {
    /// "uniform" (needs velocity), "vortex" (needs centre, axis, circulation, core) or "source" (needs centre, flow, core).
    pub kind: FlowKind,
    /// Of a uniform flow [m/s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[f64; 3]>,
    /// Place of a source, or of any point on the axis of a vortex [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub centre: Option<[f64; 3]>,
    /// Direction of the straight line round which the air of a vortex turns, counter-clockwise seen against it [1]; any length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<[f64; 3]>,
    /// Of a vortex: 2 pi r times the speed at the distance r from its axis [m^2/s]; negative turns it the other way round.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub circulation: Option<f64>,
    /// Air that comes out of a source each second [m^3/s]; negative for a sink.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flow: Option<f64>,
    /// Radius within which the speed falls to zero in proportion to the distance, as in a body that turns or swells [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub core: Option<f64>,
}

/// Which flow.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FlowKind {
    /// The same velocity everywhere.
    Uniform,
    /// Air that turns round a straight line: Rankine's vortex.
    Vortex,
    /// Air that comes out of a point (or, with a negative flow, goes into it).
    Source,
}

/// A flow with all that it needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Flow {
    /// The same velocity everywhere [m/s].
    Uniform([f64; 3]),
    /// Round a line through a point [m] along an axis, with its circulation [m^2/s] and core [m].
    Vortex {
        /// [m]
        centre: [f64; 3],
        /// [1]
        axis: [f64; 3],
        /// [m^2/s]
        circulation: f64,
        /// [m]
        core: f64,
    },
    /// Out of a point [m], with its flow [m^3/s] and core [m].
    Source {
        /// [m]
        centre: [f64; 3],
        /// [m^3/s]
        flow: f64,
        /// [m]
        core: f64,
    },
}

impl FlowElement {
    /// What the element says, if it has exactly the fields of its kind.
    #[must_use]
    pub fn flow(&self) -> Option<Flow> {
        match (self.kind, self.velocity, self.centre, self.axis, self.circulation, self.flow, self.core) {
            (FlowKind::Uniform, Some(velocity), None, None, None, None, None) => Some(Flow::Uniform(velocity)),
            (FlowKind::Vortex, None, Some(centre), Some(axis), Some(circulation), None, Some(core)) => {
                Some(Flow::Vortex { centre, axis, circulation, core })
            }
            (FlowKind::Source, None, Some(centre), None, None, Some(flow), Some(core)) => {
                Some(Flow::Source { centre, flow, core })
            }
            _ => None,
        }
    }
}

/// Seeded fluctuations of the wind, carried along by the mean wind (Taylor 1938).
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
