//! What a user asks for: plain data in SI units, with a default for every field.
//!
//! This is the one definition of a scene. Files, Python and the documentation derive from it
//! (`schema`, with the feature of that name); the doc comments below are the field reference that users read.

mod bending;
mod body;
mod cloth;
mod contact;
mod curves;
mod error;
mod fabric;
mod files;
#[cfg(feature = "json")]
mod read;
mod selection;
mod solver;
mod turn;
mod validate;
mod wind;

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use bending::{Bending, BendingModel};
pub use body::{Body, Capsule, Cuboid, Plane, Shape, Sphere};
pub use cloth::{Axis, Cloth, Grid, Network, PointMass, Source};
pub use contact::Contact;
pub use curves::{Curve, Curves};
pub use error::SceneError;
pub(crate) use error::{brief, shorten};
pub use fabric::{Fabric, Material};
pub use files::FrameFiles;
pub use selection::{Corner, Edge, Keyframe, LimitKeyframe, Pin, Selector, Weight};
pub use solver::{FilterKind, IntegratorKind, Solver, Substeps};
pub use turn::{AngleKeyframe, Turn};
pub(crate) use validate::{FARTHEST, MASSES, NEAREST, check_gravity};
pub use wind::{Flow, FlowElement, FlowKind, Gust, Wind, WindLaw, WindModel};

/// A scene: cloths, the air and gravity they live in, the bodies in their way, and how to simulate them.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scene {
    /// Shown above pictures and in reports.
    pub title: String,
    /// Length of the simulation [s].
    pub duration: f64,
    /// Frames per second [1/s].
    pub fps: f64,
    /// Which axis points up: "z" (Blender, engineering) or "y" (glTF, most game engines).
    pub up: Up,
    /// Acceleration of gravity [m/s^2]; 9.81 downwards when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity: Option<[f64; 3]>,
    /// Keyframes `[time [s], [x, y, z] [m/s^2]]` of gravity, joined by straight lines from `gravity` at time 0 on; none: it stays.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gravity_keyframes: Vec<Keyframe>,
    /// The moving air; without it the air is at rest and only `air_drag` acts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wind: Option<Wind>,
    /// The cloths.
    pub cloth: Vec<Cloth>,
    /// What cloths collide with; nothing when left out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub body: Vec<Body>,
    /// What cloths collide with besides bodies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact: Option<Contact>,
    /// How the scene is simulated.
    pub solver: Solver,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            title: String::new(),
            duration: 5.0,
            fps: 60.0,
            up: Up::Z,
            gravity: None,
            gravity_keyframes: Vec::new(),
            wind: None,
            cloth: Vec::new(),
            body: Vec::new(),
            contact: None,
            solver: Solver::default(),
        }
    }
}

/// Which axis points up.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Up {
    /// The third axis.
    Z,
    /// The second axis.
    Y,
}

impl Scene {
    /// Reads a scene from JSON, checks every field and fills in every default.
    ///
    /// # Errors
    /// The first field that is unknown, misspelt, of the wrong type or out of range.
    #[cfg(feature = "json")]
    pub fn from_json(text: &str) -> Result<Self, SceneError> {
        read::parse(text)?.checked()
    }

    /// The scene, every field of it checked, with every default filled in.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn checked(mut self) -> Result<Self, SceneError> {
        validate::check(&self)?;
        self.fill_in();
        Ok(self)
    }

    /// The scene as JSON.
    #[cfg(feature = "json")]
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("plain data with string keys always serialises")
    }

    /// What is allowed but looks like a mistake (a 1 kg/m^2 silk), one sentence each.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        validate::suspicions(self)
    }

    /// Acceleration of gravity [m/s^2].
    #[must_use]
    pub fn gravity(&self) -> [f64; 3] {
        self.gravity.unwrap_or(match self.up {
            Up::Z => [0.0, 0.0, -9.81],
            Up::Y => [0.0, -9.81, 0.0],
        })
    }

    /// Writes out everything that was left to a default, so that the scene reads the same for ever.
    fn fill_in(&mut self) {
        self.gravity = Some(self.gravity());
        self.solver.iterations = Some(self.solver.iterations());
        for (index, cloth) in self.cloth.iter_mut().enumerate() {
            if cloth.name.is_empty() {
                cloth.name = format!("cloth{index}");
            }
            cloth.fill_in_material();
        }
        for (index, body) in self.body.iter_mut().enumerate() {
            body.name = body.name(index);
        }
        self.fill_in_contact();
    }
}

/// The JSON schema of [`Scene`]; descriptions are the doc comments of its fields.
#[cfg(feature = "schema")]
#[must_use]
pub fn schema() -> String {
    let schema = schemars::schema_for!(Scene);
    serde_json::to_string_pretty(&schema).expect("a schema is plain JSON")
}
