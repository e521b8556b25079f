//! The Python surface of taut: arrays in, arrays out, errors mapped. No logic of its own.

mod arrays;
mod batch;
mod bodies;
mod checks;
mod contacts;
mod engine;
mod host;
mod intersections;
mod memory;
mod pools;
mod registers;
mod report;
mod running;
mod surroundings;
mod turns;
mod yardstick;

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use taut::model::Footprint;
use taut::scene::Scene;

pyo3::create_exception!(_taut, SceneError, PyValueError, "A scene cannot be simulated.");
pyo3::create_exception!(_taut, SimulationError, PyRuntimeError, "A running simulation cannot go on.");

/// Maps an engine error about a scene.
fn scene_error(error: impl std::fmt::Display) -> PyErr {
    SceneError::new_err(error.to_string())
}

#[pyfunction]
fn scene_schema() -> String {
    taut::scene::schema()
}

#[pyfunction]
fn resolve_scene(document: &str) -> PyResult<(String, Vec<String>)> {
    let scene = Scene::from_json(document).map_err(scene_error)?;
    Ok((scene.to_json(), scene.warnings()))
}

#[pyfunction]
fn footprint(scene: &str, meshes: &Bound<'_, PyDict>) -> PyResult<(u64, u64, u64, u64)> {
    let Footprint { vertices, springs, memory, frame } =
        Footprint::of(&Scene::from_json(scene).map_err(scene_error)?, &arrays::meshes(meshes)?);
    Ok((vertices, springs, memory, frame))
}

#[pyfunction]
fn simd_lanes() -> PyResult<usize> {
    registers::chosen()?;
    Ok(taut::geometry::lanes())
}

#[global_allocator]
static MEMORY: memory::LineAligned = memory::LineAligned;

#[pymodule]
fn _taut(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("SceneError", py.get_type::<SceneError>())?;
    module.add("SimulationError", py.get_type::<SimulationError>())?;
    module.add_class::<engine::Engine>()?;
    module.add_function(wrap_pyfunction!(scene_schema, module)?)?;
    module.add_function(wrap_pyfunction!(resolve_scene, module)?)?;
    module.add_function(wrap_pyfunction!(simd_lanes, module)?)?;
    module.add_function(wrap_pyfunction!(batch::step_all, module)?)?;
    module.add_function(wrap_pyfunction!(footprint, module)?)?;
    module.add_function(wrap_pyfunction!(turns::break_next_step, module)?)?;
    module.add_function(wrap_pyfunction!(arrays::state_hash, module)?)
}
