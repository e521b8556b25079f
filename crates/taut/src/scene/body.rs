//! What stands in the way of cloths: balls, rods, boxes, floors, figures that walk.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::turn::{self, Turn};
use super::validate::{Check, FARTHEST, NEAREST, check_moves, check_name, constant, direction, vector, within};
use super::{FrameFiles, Keyframe, Scene, SceneError};

/// Greatest coefficient of friction [1]: what is rougher holds as a pin does.
pub(super) const ROUGHEST: f64 = 10.0;
/// Greatest skin of a body, and greatest thickness of a cloth [m].
pub(super) const THICKEST: f64 = 1.0;

/// What cloths collide with: exactly one of `sphere`, `capsule`, `box`, `plane`, `mesh`. With `move` and `turn`, or with `motion`, it travels.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Body {
    /// Name in reports; "body0", "body1" .. when left out.
    pub name: String,
    /// A ball.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sphere: Option<Sphere>,
    /// A straight rod with round ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub capsule: Option<Capsule>,
    /// A rectangular block.
    #[serde(rename = "box", skip_serializing_if = "Option::is_none")]
    pub cuboid: Option<Cuboid>,
    /// All that lies behind a plane: cloth stays on the side that the normal points to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plane: Option<Plane>,
    /// A mesh file of its surface (obj, ply, stl, ..), its path relative to the scene file. It may be open, and which way its faces look does not matter: cloth stays on the side where it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<String>,
    /// Factor on all coordinates of `mesh`, applied first [1].
    pub scale: f64,
    /// Rotation of `mesh` about the x, then the y, then the z axis, applied second [degrees].
    pub rotate: [f64; 3],
    /// Displacement of `mesh`, applied last [m].
    pub translate: [f64; 3],
    /// Where the vertices of `mesh` are in every frame [m], joined by straight lines; in place of `move` and `turn`: an array file, .npy of shape (frames, vertices of `mesh`, 3) or .pc2, or a list of .obj files, one for each frame, or "walk_*.obj" for those that are numbered so. After its last frame it stays there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<FrameFiles>,
    /// Coulomb's coefficient of the friction of cloth on it [1].
    pub friction: f64,
    /// A skin around it that cloth stays out of, too [m].
    pub thickness: f64,
    /// How it turns about a straight line, before `move` displaces it; not at all when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turn: Option<Turn>,
    /// Keyframes `[time [s], [dx, dy, dz] [m]]` of the displacement from the start, joined by straight lines.
    #[serde(rename = "move", skip_serializing_if = "Vec::is_empty")]
    pub keyframes: Vec<Keyframe>,
}

impl Default for Body {
    fn default() -> Self {
        Self {
            name: String::new(),
            sphere: None,
            capsule: None,
            cuboid: None,
            plane: None,
            mesh: None,
            scale: 1.0,
            rotate: [0.0; 3],
            translate: [0.0; 3],
            motion: None,
            friction: 0.3,
            thickness: 0.001,
            turn: None,
            keyframes: Vec::new(),
        }
    }
}

/// A ball.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sphere {
    /// Its middle [m].
    pub center: [f64; 3],
    /// Its radius [m], which must be given.
    pub radius: f64,
}

/// A straight rod with round ends: all that is within its radius of a line.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Capsule {
    /// One end of the line [m].
    pub from: [f64; 3],
    /// The other end [m]; must be given, or `from`.
    pub to: [f64; 3],
    /// Its radius [m], which must be given.
    pub radius: f64,
}

/// A rectangular block.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Cuboid {
    /// Its middle [m].
    pub center: [f64; 3],
    /// Its width along x, y and z before it is rotated [m], which must be given.
    pub size: [f64; 3],
    /// Rotation about its middle: about the x, then the y, then the z axis [degrees].
    pub rotate: [f64; 3],
}

/// All that lies behind a plane: floors, walls, tables without an edge.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Plane {
    /// Any point of it [m].
    pub point: [f64; 3],
    /// Direction of the side where cloth is [1], which must be given; any length.
    pub normal: [f64; 3],
}

/// What shape a body has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape<'a> {
    /// A ball.
    Sphere(&'a Sphere),
    /// A straight rod with round ends.
    Capsule(&'a Capsule),
    /// A rectangular block.
    Cuboid(&'a Cuboid),
    /// All that lies behind a plane.
    Plane(&'a Plane),
    /// The path of a mesh file.
    Mesh(&'a str),
}

impl Body {
    /// The shapes that are given; a valid body has exactly one.
    #[must_use]
    pub fn shapes(&self) -> Vec<Shape<'_>> {
        let mut given = Vec::new();
        given.extend(self.sphere.as_ref().map(Shape::Sphere));
        given.extend(self.capsule.as_ref().map(Shape::Capsule));
        given.extend(self.cuboid.as_ref().map(Shape::Cuboid));
        given.extend(self.plane.as_ref().map(Shape::Plane));
        given.extend(self.mesh.as_deref().map(Shape::Mesh));
        given
    }

    /// Whether `scale`, `rotate` or `translate` do anything.
    #[must_use]
    pub fn is_placed(&self) -> bool {
        self.scale != 1.0 || self.rotate != [0.0; 3] || self.translate != [0.0; 3]
    }

    /// Its name, as number `index` of the bodies.
    #[must_use]
    pub fn name(&self, index: usize) -> String {
        if self.name.is_empty() { format!("body{index}") } else { self.name.clone() }
    }
}

/// Refuses bodies with several shapes or none, with numbers out of range, or with motions that contradict each other.
pub(super) fn check(scene: &Scene) -> Check {
    for (index, body) in scene.body.iter().enumerate() {
        let at = format!("body[{index}]");
        check_name(&at, &body.name)?;
        let name = body.name(index);
        if let Some(first) = (0..index).find(|&other| scene.body[other].name(other) == name) {
            let problem = format!("already the name of body[{first}]; choose another");
            return Err(SceneError::with_value(format!("{at}.name"), format!("{name:?}"), problem));
        }
        check_shape(&at, body)?;
        check_placing(&at, body)?;
        constant(&format!("{at}.friction"), body.friction, ROUGHEST, "0.3")?;
        within(&format!("{at}.thickness"), body.thickness, 0.0, THICKEST, "0.001")?;
        check_motion(&at, body)?;
    }
    Ok(())
}

fn check_shape(at: &str, body: &Body) -> Check {
    let place = |name: &str, place: &[f64; 3]| vector(&format!("{at}.{name}"), place, FARTHEST, "[0, 0, 1]");
    let length = |name: &str, length: f64| within(&format!("{at}.{name}"), length, NEAREST, FARTHEST, "0.5");
    match body.shapes().as_slice() {
        [Shape::Sphere(sphere)] => {
            place("sphere.center", &sphere.center)?;
            length("sphere.radius", sphere.radius)
        }
        [Shape::Capsule(capsule)] => {
            place("capsule.from", &capsule.from)?;
            place("capsule.to", &capsule.to)?;
            if capsule.from == capsule.to {
                let problem = "is where `from` is; the two ends must differ, or take a sphere";
                return Err(SceneError::with_value(format!("{at}.capsule.to"), format!("{:?}", capsule.to), problem));
            }
            length("capsule.radius", capsule.radius)
        }
        [Shape::Cuboid(cuboid)] => {
            place("box.center", &cuboid.center)?;
            cuboid.size.iter().enumerate().try_for_each(|(axis, &size)| length(&format!("box.size[{axis}]"), size))?;
            vector(&format!("{at}.box.rotate"), &cuboid.rotate, 1e6, "[0, 0, 90]")
        }
        [Shape::Plane(plane)] => {
            place("plane.point", &plane.point)?;
            direction(&format!("{at}.plane.normal"), &plane.normal)
        }
        [Shape::Mesh("")] => Err(SceneError::at(format!("{at}.mesh"), "must be the path of a mesh file")),
        [Shape::Mesh(_)] => Ok(()),
        given => {
            let problem = "needs exactly one of sphere, capsule, box, plane, mesh";
            Err(SceneError::at(at, format!("{problem}; it has {}", if given.is_empty() { "none" } else { "several" })))
        }
    }
}

/// Where a mesh is put.
fn check_placing(at: &str, body: &Body) -> Check {
    within(&format!("{at}.scale"), body.scale, NEAREST, 1e6, "1.0")?;
    vector(&format!("{at}.rotate"), &body.rotate, 1e6, "[0, 0, 90]")?;
    vector(&format!("{at}.translate"), &body.translate, FARTHEST, "[0, 0, 1]")?;
    if body.is_placed() && body.mesh.is_none() {
        let problem = "has scale, rotate or translate, which are for mesh; put the numbers into the shape itself";
        return Err(SceneError::at(at, problem));
    }
    Ok(())
}

fn check_motion(at: &str, body: &Body) -> Check {
    if let Some(path) = &body.motion {
        let refuse = |problem: &str| Err(SceneError::with_value(format!("{at}.motion"), path, problem));
        if path.is_empty() {
            return refuse("must be the path of an .npy or .pc2 file, or a list of .obj files, one for each frame");
        }
        if body.mesh.is_none() {
            return refuse("needs mesh, whose vertices it tells the places of; other shapes travel with `move` and `turn`");
        }
        if body.turn.is_some() || !body.keyframes.is_empty() {
            return refuse("a body with a motion has neither `move` nor `turn`; leave them out, or the motion");
        }
    }
    check_moves(&format!("{at}.move"), &body.keyframes, "a body is where its shape is")?;
    let Some(turn) = &body.turn else { return Ok(()) };
    let at = format!("{at}.turn");
    if body.plane.is_some() {
        return Err(SceneError::at(at, "a plane has no end and cannot turn; take a box, or leave it out"));
    }
    turn::check(&at, turn)
}
