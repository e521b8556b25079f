//! What cloth collides with, as Python sees it.

use std::sync::Arc;

use glam::DVec3;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use taut::geometry::{turn_about, turn_between};
use taut::inputs::{BodyForm, BodyPaths, BodyShift};
use taut::model::{Bodies, BodyShape, Model};

use crate::arrays;
use crate::checks::{below, duration, movable};
use crate::running::Running;

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

/// Sends a body off its path and turns it, by an axis times an angle [rad] or as it is turned now, in a time [s]; at once if that is
/// zero.
pub fn pose(model: &Model, running: &mut Running, body: usize, to: DVec3, rotation: Option<DVec3>, over: f64) {
    let from = offset(model, running, body);
    let Running { state, inputs, .. } = running;
    let start = state.time();
    let turned = inputs.bodies.rotation_of(body, start);
    let asked = |rotation: DVec3| turn_about(rotation.normalize_or_zero(), rotation.length().to_degrees());
    let goal = rotation.map_or(turned, asked);
    if over > 0.0 {
        let turn = turn_between(turned, goal);
        return inputs.shift_body(BodyShift { body, from, to, turned, turn, start, arrival: start + over });
    }
    inputs.shift_body(BodyShift { turned: goal, ..BodyShift::constant(body, to) });
    put(model, running, body);
}

/// Sends the vertices of a body to places [m] in a time [s]; at once if that is zero.
pub fn form(model: &Model, running: &mut Running, body: usize, to: Arc<[DVec3]>, over: f64) {
    let Running { state, inputs, .. } = running;
    let start = state.time();
    if over > 0.0 {
        let from = state.bodies[model.bodies.list[body].vertices.clone()].into();
        return inputs.form_body(BodyForm { body, from, to, start, arrival: start + over });
    }
    inputs.form_body(BodyForm::constant(body, to));
    put(model, running, body);
}

/// Has a body where it shall be now, whatever lies between.
fn put(model: &Model, Running { state, inputs, .. }: &mut Running, body: usize) {
    let mut places = state.bodies.clone();
    inputs.bodies.places(&model.bodies, state.time(), &mut places);
    let own = model.bodies.list[body].vertices.clone();
    state.bodies[own.clone()].copy_from_slice(&places[own]);
}

/// How far a body is off its path [m]: the mean of its vertices.
pub fn offset(model: &Model, running: &Running, body: usize) -> DVec3 {
    let Running { state, inputs, .. } = running;
    let mut places = state.bodies.clone();
    inputs.bodies.places(&model.bodies, state.time(), &mut places);
    let own = model.bodies.list[body].vertices.clone();
    let count = own.len().max(1) as f64;
    let lag: DVec3 = own.map(|vertex| state.bodies[vertex] - places[vertex]).sum();
    inputs.bodies.shift_of(body, state.time()) + lag / count
}
