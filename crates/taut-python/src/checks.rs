//! What users give in numbers, checked.

use std::collections::BTreeMap;

use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use taut::advance::Failure;
use taut::model::{Footprint, MeshData, Model};
use taut::scene::{Scene, SceneError, Source};

use crate::{SimulationError, memory, scene_error};

/// So much more than the estimate is asked for: it may be wrong, and lists that grow take more for a while [1].
const MARGIN: f64 = 1.6;

/// Refuses an index beyond the end.
pub fn below(name: &str, index: usize, count: usize) -> PyResult<()> {
    if index < count {
        return Ok(());
    }
    Err(PyIndexError::new_err(format!("{name} = {index}: there are {count}, counted from 0")))
}

/// Names the cloth and its own vertex instead of the particle.
pub fn explain(model: &Model, failure: Failure) -> PyErr {
    let Failure::NonFinite { particle, .. } = failure else { return PyValueError::new_err(failure.to_string()) };
    let vertex = model.numbering.vertex(particle) as usize;
    let place = model.cloths.iter().find(|cloth| cloth.particles().contains(&vertex));
    let place = place.map_or_else(String::new, |cloth| format!("cloth {:?}, vertex {}: ", cloth.name, vertex - cloth.first));
    SimulationError::new_err(format!("{place}{failure}"))
}

/// Refuses a place that is not finite, and a speed that is none.
pub fn movable(name: &str, place: [f64; 3], speed: f64) -> PyResult<()> {
    if place.iter().all(|part| part.is_finite()) && speed > 0.0 {
        return Ok(());
    }
    let problem = format!("{name} = {place:?}, speed = {speed}: must be finite numbers and a speed above 0");
    Err(PyValueError::new_err(problem))
}

/// Refuses what is no time to spend.
pub fn duration(name: &str, time: f64) -> PyResult<()> {
    if time.is_finite() && time >= 0.0 {
        return Ok(());
    }
    Err(PyValueError::new_err(format!("{name} = {time} s: must be a finite time, 0 or longer")))
}

/// A scene with nothing in it but these fields, checked as any scene.
pub fn scene_with(fields: &str) -> PyResult<Scene> {
    Scene::from_json(&format!(r#"{{ {fields}, "cloth": [{{ "grid": {{}} }}] }}"#)).map_err(scene_error)
}

/// Refuses a scene for which there is no memory: asking for it piece by piece would end the process.
pub fn affordable(scene: &Scene, meshes: &BTreeMap<String, MeshData>) -> PyResult<()> {
    let needs = Footprint::of(scene, meshes);
    let asked = (MARGIN * needs.memory as f64) as u64;
    if memory::is_there(asked) {
        return Ok(());
    }
    let of_body = |index: &usize| Footprint::of_body(&scene.body[*index], meshes).memory;
    let own = |index: &usize| Footprint::of_cloth(&scene.cloth[*index], &scene.solver, meshes);
    let largest = (0..scene.cloth.len()).max_by_key(|index| own(index).memory).unwrap_or_default();
    if let Some(body) = (0..scene.body.len()).max_by_key(of_body).filter(|body| of_body(body) > own(&largest).memory) {
        let problem = format!(
            "the scene needs about {:.2} GB of memory, most of it here, and this process cannot have it; use a coarser mesh, close other \
             programs or take a larger machine",
            needs.memory as f64 / 1e9
        );
        let path = format!("{:?}", scene.body[body].mesh.as_deref().unwrap_or_default());
        return Err(scene_error(SceneError::with_value(format!("body[{body}].mesh"), path, problem)));
    }
    let cloth = &scene.cloth[largest];
    let (field, value) = match cloth.sources().first() {
        Some(Source::Grid(grid)) => ("grid.cells", format!("{:?}", grid.cells)),
        Some(Source::Mesh(path)) => ("mesh", format!("{path:?}")),
        _ => ("network.points", String::new()),
    };
    let problem = format!(
        "the scene needs about {:.2} GB of memory for {} vertices and {} springs, {} vertices of them here, and this process cannot have it; use \
         fewer, close other programs or take a larger machine",
        needs.memory as f64 / 1e9,
        needs.vertices,
        needs.springs,
        own(&largest).vertices
    );
    Err(scene_error(SceneError::with_value(format!("cloth[{largest}].{field}"), value, problem)))
}

/// The number of threads that is asked for.
pub fn workers(threads: Option<usize>) -> PyResult<usize> {
    match threads {
        Some(0) => Err(PyValueError::new_err("threads = 0: must be at least 1, or None for all cores")),
        Some(threads) => Ok(threads),
        None => Ok(std::thread::available_parallelism().map_or(1, usize::from)),
    }
}
