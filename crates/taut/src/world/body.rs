//! A body that is asked for.

use super::cloth::mesh_of;
use super::motion::Motion;
use crate::model::MeshData;
use crate::scene::{self, Capsule, Cuboid, Plane, Sphere, Turn};

/// What cloth collides with.
///
/// What is not said is as [`scene::Body`] has it, whose every field [`Self::with`] can set. Nothing is checked before
/// [`WorldBuilder::build`](super::WorldBuilder::build).
///
/// ```
/// use taut::Body;
///
/// let ball = Body::sphere([0.0, 0.0, 0.5], 0.3).friction(0.5);
/// let floor = Body::plane([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    pub(super) asked: scene::Body,
    pub(super) mesh: Option<MeshData>,
    pub(super) motion: Option<Motion>,
}

impl From<scene::Body> for Body {
    /// A body whose mesh, if it names one, is given with [`WorldBuilder::mesh`](super::WorldBuilder::mesh).
    fn from(asked: scene::Body) -> Self {
        Self { asked, mesh: None, motion: None }
    }
}

impl Body {
    /// A ball of a radius about its middle [m].
    #[must_use]
    pub fn sphere(center: [impl Into<f64>; 3], radius: f64) -> Self {
        let sphere = Sphere { center: center.map(Into::into), radius };
        scene::Body { sphere: Some(sphere), ..scene::Body::default() }.into()
    }

    /// A rod with round ends of a radius about a line [m].
    #[must_use]
    pub fn capsule(from: [impl Into<f64>; 3], to: [impl Into<f64>; 3], radius: f64) -> Self {
        let capsule = Capsule { from: from.map(Into::into), to: to.map(Into::into), radius };
        scene::Body { capsule: Some(capsule), ..scene::Body::default() }.into()
    }

    /// A block of a size along x, y and z about its middle [m]; `box` of [`scene::Body`].
    #[must_use]
    pub fn cuboid(center: [impl Into<f64>; 3], size: [impl Into<f64>; 3]) -> Self {
        let cuboid = Cuboid { center: center.map(Into::into), size: size.map(Into::into), ..Cuboid::default() };
        scene::Body { cuboid: Some(cuboid), ..scene::Body::default() }.into()
    }

    /// All that lies behind a plane through a point [m]: cloth stays on the side to which the normal points.
    #[must_use]
    pub fn plane(point: [impl Into<f64>; 3], normal: [impl Into<f64>; 3]) -> Self {
        let plane = Plane { point: point.map(Into::into), normal: normal.map(Into::into) };
        scene::Body { plane: Some(plane), ..scene::Body::default() }.into()
    }

    /// A surface of triangles between vertices [m]. It may be open.
    #[must_use]
    pub fn mesh<T: Copy + Into<f64>>(positions: &[[T; 3]], triangles: &[[u32; 3]]) -> Self {
        Self { mesh: Some(mesh_of(positions, triangles)), ..scene::Body::default().into() }
    }

    /// Where the vertices of its mesh are in every frame in the world [m], joined by straight lines: an animation. The first frame is where
    /// the mesh is; after the last one it stays there.
    #[must_use]
    pub fn motion<T: Copy + Into<f64>>(mut self, frames: &[impl AsRef<[[T; 3]]>], frames_per_second: f64) -> Self {
        self.motion = Some(Motion::new(frames, frames_per_second));
        self
    }

    /// How it turns about a straight line; all shapes but planes can. What displaces it, the field `keyframes`, does so after that.
    ///
    /// ```
    /// use taut::{Body, Turn, World};
    ///
    /// // A mill that goes round once in 2 s.
    /// let mill = Body::cuboid([0.0, 0.0, 1.0], [1.2, 0.1, 0.1]).turn(Turn::about([0, 1, 0], [0, 0, 1]).at(2.0, 360.0));
    /// # let sheet = taut::Cloth::grid([0.2, 0.2], [2, 2]);
    /// let mut world = World::builder().cloth(sheet).body(mill).build()?;
    /// world.step(0.5)?;
    /// let corner = world.body_positions(0)?[0];
    /// assert!((corner[2] - 1.6).abs() < 1e-9, "upright after a quarter");
    /// # Ok::<(), taut::Error>(())
    /// ```
    #[must_use]
    pub fn turn(self, turn: Turn) -> Self {
        self.with(|body| body.turn = Some(turn))
    }

    /// Its name in reports.
    #[must_use]
    pub fn name(self, name: impl Into<String>) -> Self {
        self.with(|body| body.name = name.into())
    }

    /// Coulomb's coefficient of the friction of cloth on it [1]; 0.3 unless it is given.
    #[must_use]
    pub fn friction(self, friction: f64) -> Self {
        self.with(|body| body.friction = friction)
    }

    /// A skin around it that cloth stays out of, too [m]; 0.001 unless it is given.
    #[must_use]
    pub fn thickness(self, thickness: f64) -> Self {
        self.with(|body| body.thickness = thickness)
    }

    /// Sets any field of its description.
    #[must_use]
    pub fn with(mut self, set: impl FnOnce(&mut scene::Body)) -> Self {
        set(&mut self.asked);
        self
    }
}
