//! One cloth: where its points come from, what it is made of and how it is held.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Bending, BendingModel, Curves, Fabric, LimitKeyframe, Material, Pin, Weight};

/// One cloth: exactly one of `grid`, `mesh`, `network`.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Cloth {
    /// Name in reports; "cloth0", "cloth1" .. when left out.
    pub name: String,
    /// A rectangle of square or rectangular cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<Grid>,
    /// A mesh file (obj, ply, stl, ..), its path relative to the scene file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<String>,
    /// Points and links: chains, ropes, nets.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub network: Option<Network>,
    /// Factor on all coordinates, applied first [1].
    pub scale: f64,
    /// Rotation about the x, then the y, then the z axis, applied second [degrees].
    pub rotate: [f64; 3],
    /// Displacement, applied last [m].
    pub translate: [f64; 3],
    /// Preset for everything below; "cotton" when left out.
    pub fabric: Fabric,
    /// The paper's lambda: no spring may grow beyond (1 + strain_limit) of its rest length [1]; the knee of the curve of tension where one is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strain_limit: Option<f64>,
    /// Keyframes `[time [s], limit [1]]` of `strain_limit`, joined by straight lines from it at time 0 on and followed frame by frame; none: it stays.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub strain_limit_keyframes: Vec<LimitKeyframe>,
    /// Mass per area [kg/m^2].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Membrane stiffness of the structural springs [N/m], independent of resolution; in a network the k_s of each link.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    /// The same for the shear springs (diagonals) [N/m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shear_stiffness: Option<f64>,
    /// Measured curves in place of `stiffness`, `shear_stiffness` and `bending`; none when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub curves: Option<Curves>,
    /// k_s of each type 2 spring (two cells apart) [N/m]; 0 leaves them out, as the paper does.
    pub flexion_stiffness: f64,
    /// Bending stiffness [N m], independent of resolution, or "fabric" for that of the preset; in a network that of each line of links [N m^2]. 0 leaves bending out, as the paper does.
    pub bending: Bending,
    /// What `bending` means: "quadratic" (a thin plate, for droop and folds) or "choi_ko" (type 2 springs that buckle at once under compression).
    pub bending_model: BendingModel,
    /// The paper's k_D, relative-velocity damping along all springs [kg/s], independent of resolution like `stiffness`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// The paper's k_A, Stokes drag in air at rest [1/s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub air_drag: Option<f64>,
    /// The paper's C_d, resistance to wind across the cloth [1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drag_coefficient: Option<f64>,
    /// Lift across the relative wind, for `wind.law = "drag_lift"` [1]; the drag coefficient when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lift_coefficient: Option<f64>,
    /// Friction of the relative wind along both sides of the cloth together [1]; 0 leaves it out, as the paper does.
    pub friction_coefficient: f64,
    /// Mid-surfaces of cloths, and links of networks, are kept this far apart [m]; where nothing collides it has no effect. At most half of the shortest edge of a cloth that touches itself, at most twice the shortest link of a network. That of the preset when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thickness: Option<f64>,
    /// Coulomb's coefficient of the friction of cloth on cloth [1]; 0.3 when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Of two cloths that intersect at the start, the one with the higher layer is brought to the outside [1]; those of one layer go each to the side where most of it is.
    #[serde(skip_serializing_if = "is_zero")]
    pub layer: u32,
    /// Gravity leans so far from point to point at most, across what is flat and has gravity in its plane, which would never buckle [rad]; 0 leaves it out.
    pub imperfection: f64,
    /// What is held.
    pub pins: Vec<Pin>,
    /// What hangs on it: extra masses, which the air does not see.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub weights: Vec<Weight>,
}

impl Default for Cloth {
    fn default() -> Self {
        Self {
            name: String::new(),
            grid: None,
            mesh: None,
            network: None,
            scale: 1.0,
            rotate: [0.0; 3],
            translate: [0.0; 3],
            fabric: Fabric::Cotton,
            strain_limit: None,
            strain_limit_keyframes: Vec::new(),
            density: None,
            stiffness: None,
            shear_stiffness: None,
            curves: None,
            flexion_stiffness: 0.0,
            bending: Bending::Given(0.0),
            bending_model: BendingModel::Quadratic,
            damping: None,
            air_drag: None,
            drag_coefficient: None,
            lift_coefficient: None,
            friction_coefficient: 0.0,
            thickness: None,
            friction: None,
            layer: 0,
            imperfection: 1e-5,
            pins: Vec::new(),
            weights: Vec::new(),
        }
    }
}

/// Where the points of a cloth come from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Source<'a> {
    /// A rectangle of cells.
    Grid(&'a Grid),
    /// The path of a mesh file.
    Mesh(&'a str),
    /// Points and links.
    Network(&'a Network),
}

impl Cloth {
    /// The sources that are given; a valid cloth has exactly one.
    #[must_use]
    pub fn sources(&self) -> Vec<Source<'_>> {
        let mut given = Vec::new();
        given.extend(self.grid.as_ref().map(Source::Grid));
        given.extend(self.mesh.as_deref().map(Source::Mesh));
        given.extend(self.network.as_ref().map(Source::Network));
        given
    }

    /// What `bending` says [N m]; in a network [N m^2].
    #[must_use]
    pub fn bending(&self) -> f64 {
        match self.bending {
            Bending::Given(stiffness) => stiffness,
            Bending::Fabric => self.fabric.bending(),
        }
    }

    /// The tightest limit that it ever has [1].
    #[must_use]
    pub fn tightest_limit(&self) -> f64 {
        self.strain_limit_keyframes.iter().map(|key| key.1).fold(self.material().strain_limit, f64::min)
    }

    /// The fabric with this cloth's own values over the preset's.
    #[must_use]
    pub fn material(&self) -> Material {
        let preset = self.fabric.material();
        let stiffness = self.stiffness.unwrap_or(preset.stiffness);
        // A stiffness given alone speaks for the shear springs too: the paper has a single k_s.
        let shear_preset = if self.stiffness.is_some() { stiffness } else { preset.shear_stiffness };
        let drag_coefficient = self.drag_coefficient.unwrap_or(preset.drag_coefficient);
        let knee = self.curves.as_ref().and_then(Curves::knee);
        Material {
            strain_limit: self.strain_limit.or(knee).unwrap_or(preset.strain_limit),
            density: self.density.unwrap_or(preset.density),
            stiffness,
            shear_stiffness: self.shear_stiffness.unwrap_or(shear_preset),
            damping: self.damping.unwrap_or(preset.damping),
            air_drag: self.air_drag.unwrap_or(preset.air_drag),
            drag_coefficient,
            lift_coefficient: self.lift_coefficient.unwrap_or(drag_coefficient),
            thickness: self.thickness.unwrap_or(preset.thickness),
        }
    }

    /// Writes the preset's values into the fields that were left out.
    pub(super) fn fill_in_material(&mut self) {
        let material = self.material();
        self.bending = Bending::Given(self.bending());
        self.strain_limit = Some(material.strain_limit);
        self.density = Some(material.density);
        // What a curve says has no single number.
        let curves = self.curves.as_ref();
        self.stiffness = Some(material.stiffness).filter(|_| curves.is_none_or(|curves| curves.tension.is_none()));
        self.shear_stiffness = Some(material.shear_stiffness).filter(|_| curves.is_none_or(|curves| curves.shear.is_none()));
        self.damping = Some(material.damping);
        self.air_drag = Some(material.air_drag);
        self.drag_coefficient = Some(material.drag_coefficient);
        self.lift_coefficient = Some(material.lift_coefficient);
    }
}

/// A rectangle of cells, seen from its front: first axis to the right, second axis up.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Grid {
    /// Width and height [m].
    pub size: [f64; 2],
    /// Number of cells along the width and the height [1]; one vertex more each.
    pub cells: [u32; 2],
    /// Position of the bottom left corner [m].
    pub origin: [f64; 3],
    /// Directions of the width and the height: "x", "y", "z", "-x", "-y" or "-z".
    pub axes: [Axis; 2],
}

impl Default for Grid {
    fn default() -> Self {
        Self { size: [1.0, 1.0], cells: [32, 32], origin: [0.0; 3], axes: [Axis::X, Axis::Z] }
    }
}

/// A signed coordinate axis.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Axis {
    /// +x
    #[serde(rename = "x")]
    X,
    /// +y
    #[serde(rename = "y")]
    Y,
    /// +z
    #[serde(rename = "z")]
    Z,
    /// -x
    #[serde(rename = "-x")]
    MinusX,
    /// -y
    #[serde(rename = "-y")]
    MinusY,
    /// -z
    #[serde(rename = "-z")]
    MinusZ,
}

impl Axis {
    /// The unit vector.
    #[must_use]
    pub fn direction(self) -> [f64; 3] {
        match self {
            Self::X => [1.0, 0.0, 0.0],
            Self::Y => [0.0, 1.0, 0.0],
            Self::Z => [0.0, 0.0, 1.0],
            Self::MinusX => [-1.0, 0.0, 0.0],
            Self::MinusY => [0.0, -1.0, 0.0],
            Self::MinusZ => [0.0, 0.0, -1.0],
        }
    }

    /// The coordinate (0, 1 or 2) along which the axis lies.
    #[must_use]
    pub fn coordinate(self) -> usize {
        match self {
            Self::X | Self::MinusX => 0,
            Self::Y | Self::MinusY => 1,
            Self::Z | Self::MinusZ => 2,
        }
    }
}

/// Points and links: chains, ropes, nets. A link is a structural spring whose rest length is its length at the start; where cloth collides it is a round rod of the cloth's `thickness`, and a point that no link is tied to a grain.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Network {
    /// Positions [m].
    pub points: Vec<[f64; 3]>,
    /// Pairs of point numbers, from 0.
    pub links: Vec<[u32; 2]>,
    /// Mass of each point [kg]: one number for all, or a list.
    pub mass: PointMass,
}

/// Mass of the points of a network [kg].
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a number or a list of numbers")]
pub enum PointMass {
    /// The same for all points.
    One(f64),
    /// One for each point.
    Each(Vec<f64>),
}

impl Default for PointMass {
    fn default() -> Self {
        Self::One(0.001)
    }
}

/// Layers are told where there are any.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
fn is_zero(layer: &u32) -> bool {
    *layer == 0
}
