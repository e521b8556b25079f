//! What cloth collides with, as Python sees it.

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use taut::inputs::BodyPaths;
use taut::model::{Bodies, BodyShape, Model};

use crate::arrays;
use crate::checks::{below, duration, movable};

/// Name, shape, radius [m], whether it ever moves, first vertex, vertices, first triangle, triangles.
pub type Described = (String, &'static str, f64, bool, usize, usize, usize, usize);

/// Each body of a scene.
pub fn describe(bodies: &Bodies, paths: &BodyPaths) -> Vec<Described> {
    let described = bodies.list.iter().enumerate().map(|(index, body)| {
        let shape = match body.shape {
            BodyShape::Sphere => "sphere",
            BodyShape::Capsule => "capsule",
            BodyShape::Plane => "plane",
            BodyShape::Surface => "surface",
        };
        let (vertices, triangles) = (&body.vertices, &body.triangles);
        let moves = paths.moves(index);
        (body.name.clone(), shape, body.radius, moves, vertices.start, vertices.len(), triangles.start, triangles.len())
    });
    described.collect()
}

/// Triangles of all bodies, shape (n, 3).
pub fn triangles<'py>(py: Python<'py>, bodies: &Bodies) -> Bound<'py, PyArray2<i32>> {
    let flat = bodies.triangles.iter().flatten().map(|&corner| corner as i32);
    arrays::rows_of(PyArray1::from_iter(py, flat), 3)
}

/// Refuses a body that is not there, and where or when it cannot go.
pub fn check_pose(model: &Model, body: usize, offset: [f64; 3], rotation: Option<[f64; 3]>, over: f64) -> PyResult<()> {
    below("body", body, model.bodies.list.len())?;
    movable("offset", offset, 1.0)?;
    movable("rotation", rotation.unwrap_or_default(), 1.0)?;
    duration("over", over)
}
