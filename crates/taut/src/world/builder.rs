//! A world that is asked for: the typed way to a scene, which takes the same checks as any other.

use std::collections::BTreeMap;

use glam::DVec3;

use super::body::Motion;
use super::cloth::mesh_of;
use super::{Body, Cloth, Error, Pool, World};
use crate::inputs::Followed;
use crate::model::MeshData;
use crate::prepare::prepare;
use crate::scene::{Contact, FrameFiles, Scene, SceneError, Solver, Up, Wind};

/// A world that is asked for; see [`World::builder`].
#[derive(Debug, Clone, Default)]
pub struct WorldBuilder {
    scene: Scene,
    meshes: BTreeMap<String, MeshData>,
    motions: Vec<(usize, Motion)>,
    pool: Pool,
}

impl From<Scene> for WorldBuilder {
    /// Meshes that the scene names are given with [`WorldBuilder::mesh`].
    fn from(scene: Scene) -> Self {
        Self { scene, ..Self::default() }
    }
}

impl WorldBuilder {
    /// The world of a scene as JSON, of which `docs/scene.schema.json` has the schema. Meshes that it names are given with [`Self::mesh`].
    ///
    /// # Errors
    /// The first field that is unknown, misspelt, of the wrong type or out of range.
    #[cfg(feature = "json")]
    pub fn from_json(text: &str) -> Result<Self, Error> {
        Ok(Scene::from_json(text)?.into())
    }

    /// Adds a cloth; the first one has the number 0.
    #[must_use]
    pub fn cloth(mut self, Cloth { mut asked, mesh }: Cloth) -> Self {
        if let Some(mesh) = mesh {
            asked.mesh = Some(self.keep(format!("vertices of cloth {}", self.scene.cloth.len()), mesh));
        }
        self.scene.cloth.push(asked);
        self
    }

    /// Adds a body that cloth collides with; the first one has the number 0.
    #[must_use]
    pub fn body(mut self, Body { mut asked, mesh, motion }: Body) -> Self {
        let index = self.scene.body.len();
        if let Some(mesh) = mesh {
            asked.mesh = Some(self.keep(format!("vertices of body {index}"), mesh));
        }
        if let Some(motion) = motion {
            asked.motion = Some(FrameFiles::All(frames_of(index)));
            self.motions.push((index, motion));
        }
        self.scene.body.push(asked);
        self
    }

    /// The mesh of a name that a [`Scene`] gives.
    #[must_use]
    pub fn mesh<T: Copy + Into<f64>>(mut self, name: &str, positions: &[[T; 3]], triangles: &[[u32; 3]]) -> Self {
        self.keep(name.to_owned(), mesh_of(positions, triangles));
        self
    }

    fn keep(&mut self, name: String, mesh: MeshData) -> String {
        self.meshes.insert(name.clone(), mesh);
        name
    }

    /// Which axis points up; z unless it is given. Gravity points down unless it is given, too.
    #[must_use]
    pub fn up(self, up: Up) -> Self {
        self.with(|scene| scene.up = up)
    }

    /// Acceleration of gravity [m/s^2]; 9.81 downwards unless it is given.
    #[must_use]
    pub fn gravity(self, gravity: [impl Into<f64>; 3]) -> Self {
        self.with(|scene| scene.gravity = Some(gravity.map(Into::into)))
    }

    /// The moving air; without it only the `air_drag` of a cloth slows it.
    #[must_use]
    pub fn wind(self, wind: impl Into<Wind>) -> Self {
        self.with(|scene| scene.wind = Some(wind.into()))
    }

    /// Whether cloths touch themselves and each other; unless it is given, they do if one of them is given a thickness.
    #[must_use]
    pub fn self_contact(self, on: bool) -> Self {
        self.with(|scene| scene.contact.get_or_insert_with(Contact::default).self_contact = Some(on))
    }

    /// How often [`World::step`] will be called, about [1/s]; 60 unless it is given. Steps divide that time.
    #[must_use]
    pub fn frames_per_second(self, rate: f64) -> Self {
        self.with(|scene| scene.fps = rate)
    }

    /// How it is simulated.
    #[must_use]
    pub fn solver(self, solver: Solver) -> Self {
        self.with(|scene| scene.solver = solver)
    }

    /// Steps on the threads of a pool, which worlds may share; on the caller's thread unless it is given.
    #[must_use]
    pub fn pool(mut self, pool: &Pool) -> Self {
        self.pool = pool.clone();
        self
    }

    /// Sets any field of the scene.
    #[must_use]
    pub fn with(mut self, set: impl FnOnce(&mut Scene)) -> Self {
        set(&mut self.scene);
        self
    }

    /// Checks everything and builds the world, at time 0.
    ///
    /// # Errors
    /// The first field that is out of range, a mesh that cannot be a cloth, a pin that matches nothing: [`Error::Scene`].
    pub fn build(self) -> Result<World, Error> {
        let Self { scene, meshes, motions, pool } = self;
        let followed = motions.into_iter().map(|(index, motion)| Ok((frames_of(index), followed(index, motion)?)));
        let followed = followed.collect::<Result<_, SceneError>>()?;
        let scene = scene.checked()?;
        let prepared = prepare(&scene, &meshes, &followed)?;
        Ok(World::new(prepared, scene.wind, pool))
    }
}

fn frames_of(body: usize) -> String {
    format!("frames of body {body}")
}

/// The motion of a body as an array.
fn followed(body: usize, Motion { frames, rate }: Motion) -> Result<Followed, SceneError> {
    let vertices = frames.first().map_or(0, Vec::len);
    if let Some(frame) = frames.iter().position(|frame| frame.len() != vertices) {
        let problem = format!("must have {vertices} places as the first frame has, one for each vertex");
        return Err(SceneError::with_value(
            format!("body[{body}].motion[{frame}]"),
            format!("a list of {}", frames[frame].len()),
            problem,
        ));
    }
    Ok(Followed { vertices, places: frames.into_iter().flatten().map(DVec3::from_array).collect(), rate: Some(rate) })
}
