//! What users give in numbers, checked.

use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use taut::scene::Scene;

use crate::scene_error;

/// Refuses an index beyond the end.
pub fn below(name: &str, index: usize, count: usize) -> PyResult<()> {
    if index < count {
        return Ok(());
    }
    Err(PyIndexError::new_err(format!("{name} = {index}: there are {count}, counted from 0")))
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
