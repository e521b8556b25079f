//! A turn about a line, of bodies and of pins.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SceneError;
use super::validate::{Check, FARTHEST, direction, vector, within};

/// A turn about a fixed straight line.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Turn {
    /// Direction of the line [1], which must be given; any length. What turns does so counter-clockwise seen against it.
    pub axis: [f64; 3],
    /// Any point of the line [m].
    pub point: [f64; 3],
    /// Keyframes `[time [s], angle [degrees]]`, joined by straight lines from 0 degrees at time 0 on.
    pub angle: Vec<AngleKeyframe>,
}

impl Turn {
    /// A turn about the line in a direction [1] through a point [m].
    #[must_use]
    pub fn about(axis: [impl Into<f64>; 3], point: [impl Into<f64>; 3]) -> Self {
        Self { axis: axis.map(Into::into), point: point.map(Into::into), angle: Vec::new() }
    }

    /// The angle [degrees] at a time [s], later than those before. Between them, and from 0 degrees at time 0 on, it goes evenly.
    #[must_use]
    pub fn at(mut self, time: f64, angle: f64) -> Self {
        self.angle.push(AngleKeyframe(time, angle));
        self
    }
}

/// Time [s] and angle [degrees].
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AngleKeyframe(pub f64, pub f64);

/// Refuses a turn about nothing, out of range, or with times that do not rise.
pub(super) fn check(at: &str, turn: &Turn) -> Check {
    direction(&format!("{at}.axis"), &turn.axis)?;
    vector(&format!("{at}.point"), &turn.point, FARTHEST, "[0, 0, 1]")?;
    let mut previous = f64::NEG_INFINITY;
    for (index, &AngleKeyframe(time, angle)) in turn.angle.iter().enumerate() {
        let at = format!("{at}.angle[{index}]");
        within(&at, time, 0.0, 1e9, "0.0")?;
        within(&at, angle, -1e6, 1e6, "90.0")?;
        if time <= previous {
            return Err(SceneError::with_value(at, time, "times must increase from keyframe to keyframe"));
        }
        if time == 0.0 && angle != 0.0 {
            return Err(SceneError::with_value(at, angle, "at time 0 the angle is 0 degrees; begin with [0, 0]"));
        }
        previous = time;
    }
    Ok(())
}
