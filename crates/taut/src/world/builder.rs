//! A world that is asked for: the typed way to a scene, which takes the same checks as any other.

use std::collections::BTreeMap;

use super::cloth::mesh_of;
use super::motion::{Motion, followers};
use super::{Body, Cloth, Error, Pool, World};
use crate::model::MeshData;
use crate::prepare::prepare;
use crate::scene::{Contact, FrameFiles, Scene, SceneError, Solver, Up, Wind};

/// A world that is asked for; see [`World::builder`].
#[derive(Debug, Clone, Default)]
pub struct WorldBuilder {
    scene: Scene,
    meshes: BTreeMap<String, MeshData>,
    motions: BTreeMap<String, Motion>,
    pool: Pool,
}

impl From<Scene> for WorldBuilder {
    /// Meshes that the scene names are given with [`WorldBuilder::mesh`], arrays that its pins and bodies follow with
    /// [`WorldBuilder::frames`].
    fn from(scene: Scene) -> Self {
        Self { scene, ..Self::default() }
    }
}

impl WorldBuilder {
    /// The world of a scene as JSON, of which `docs/scene.schema.json` has the schema. Meshes that it names are given with [`Self::mesh`],
    /// arrays that its pins and bodies follow with [`Self::frames`].
    ///
    /// # Errors
    /// The first field that is unknown, misspelt, of the wrong type or out of range.
    #[cfg(feature = "json")]
    pub fn from_json(text: &str) -> Result<Self, Error> {
        Ok(Scene::from_json(text)?.into())
    }

    /// Adds a cloth; the first one has the number 0.
    #[must_use]
    pub fn cloth(mut self, Cloth { mut asked, mesh, motions }: Cloth) -> Self {
        let index = self.scene.cloth.len();
        if let Some(mesh) = mesh {
            asked.mesh = Some(self.keep(format!("vertices of cloth {index}"), mesh));
        }
        for (pin, motion) in motions {
            let follow = self.keep_frames(format!("frames of cloth {index}, pin {pin}"), motion);
            asked.pins.get_mut(pin).into_iter().for_each(|pin| pin.follow = Some(follow.clone()));
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
            asked.motion = Some(self.keep_frames(format!("frames of body {index}"), motion));
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

    /// The array of a name that a pin of a [`Scene`] has in `follow`, or a body of it in `motion`: places of vertices, frame by frame [m],
    /// and frames per second [1/s].
    #[must_use]
    pub fn frames<T: Copy + Into<f64>>(mut self, name: &str, frames: &[impl AsRef<[[T; 3]]>], frames_per_second: f64) -> Self {
        self.keep_frames(name.to_owned(), Motion::new(frames, frames_per_second));
        self
    }

    fn keep(&mut self, name: String, mesh: MeshData) -> String {
        self.meshes.insert(name.clone(), mesh);
        name
    }

    fn keep_frames(&mut self, name: String, motion: Motion) -> FrameFiles {
        self.motions.insert(name.clone(), motion);
        FrameFiles::All(name)
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

    /// Whether nothing is computed where everything lies still, until something from outside changes ([`Report::asleep`](super::Report::asleep));
    /// not unless it is given. Goes into what [`Self::solver`] has set.
    #[must_use]
    pub fn sleep(self, on: bool) -> Self {
        self.with(|scene| scene.solver.sleep = on)
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
        let Self { scene, meshes, mut motions, pool } = self;
        let given = followers(&scene).filter_map(|(at, name)| Some((at, motions.remove_entry(&name)?)));
        let followed = given.map(|(at, (name, motion))| Ok((name, motion.array(&at)?))).collect::<Result<_, SceneError>>()?;
        let scene = scene.checked()?;
        let prepared = prepare(&scene, &meshes, &followed)?;
        Ok(World::new(prepared, scene.wind, pool))
    }
}
