//! A scene becomes all that a simulation needs.

use std::collections::BTreeMap;

use crate::contact::Intersections;
use crate::inputs::{Followed, Inputs};
use crate::model::{MeshData, Model};
use crate::scene::{Scene, SceneError};
use crate::schedule::Schedule;

/// A scene, ready to be simulated.
#[derive(Debug)]
pub struct Prepared {
    /// What is simulated.
    pub model: Model,
    /// What acts on it as long as nobody asks for anything else.
    pub inputs: Inputs,
    /// The steps that the scene asks for.
    pub schedule: Schedule,
}

/// Builds the model of a scene. `meshes` holds the geometry of every mesh that the scene names. `followed` holds the arrays that its
/// pins and bodies follow.
///
/// # Errors
/// A mesh is missing or unusable, a pin matches nothing, pins are out of the cloth's reach, a motion does not fit its body, the step is
/// over its bound.
pub fn prepare(
    scene: &Scene,
    meshes: &BTreeMap<String, MeshData>,
    followed: &BTreeMap<String, Followed>,
) -> Result<Prepared, SceneError> {
    let mut model = Model::build(scene, meshes)?;
    let inputs = Inputs::new(scene, &model, followed)?;
    let schedule = Schedule::new(scene, &model, &inputs)?;
    model.warnings.extend(schedule.cautions(&model).collect::<Vec<_>>());
    let found = Intersections::at_start(&model);
    model.warnings.extend(found.warnings(&model).collect::<Vec<_>>());
    Ok(Prepared { model, inputs, schedule })
}
