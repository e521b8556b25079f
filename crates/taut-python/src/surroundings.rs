//! What is around the cloths of a simulation, and how steps went: more members of [`Engine`].

use glam::DVec3;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use taut::step::{Waypoint, tensions, touches};

use crate::checks::{below, duration, movable};
use crate::engine::Engine;
use crate::running::Running;
use crate::turns::or_error;
use crate::{arrays, bodies, contacts, intersections};

#[pymethods]
impl Engine {
    #[getter]
    fn bodies(&self, py: Python<'_>) -> PyResult<Vec<bodies::Described>> {
        self.running.with(py, |running| bodies::describe(&self.model.bodies, &running.inputs.bodies))
    }

    #[getter]
    fn body_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<i32>> {
        bodies::triangles(py, &self.model.bodies)
    }

    fn body_positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let places = self.running.with(py, |running| running.state.bodies.clone())?;
        Ok(arrays::rows_of(PyArray1::from_iter(py, places.iter().flat_map(|place| place.to_array())), 3))
    }

    fn intersections(&self, py: Python<'_>) -> PyResult<intersections::Found> {
        let state = self.running.with(py, |running| running.state.clone())?;
        or_error(|| py.detach(|| intersections::find(&self.model, &state)))
    }

    #[pyo3(signature = (body, offset, rotation, over))]
    fn pose_body(&self, py: Python<'_>, body: usize, offset: [f64; 3], rotation: Option<[f64; 3]>, over: f64) -> PyResult<()> {
        bodies::check_pose(&self.model, body, offset, rotation, over)?;
        self.running.with(py, |Running { state, inputs, .. }| {
            state.pose_body(&self.model, inputs, body, offset.into(), rotation.map(DVec3::from), over)
        })
    }

    fn form_body(&self, py: Python<'_>, body: usize, places: &Bound<'_, PyAny>, over: f64) -> PyResult<()> {
        below("body", body, self.model.bodies.list.len())?;
        duration("over", over)?;
        let places = arrays::places("places", places, Some(self.model.bodies.list[body].vertices.len()))?;
        self.running.with(py, |Running { state, inputs, .. }| state.form_body(&self.model, inputs, body, places.into(), over))
    }

    fn translate(&self, py: Python<'_>, cloth: usize, offset: [f64; 3]) -> PyResult<()> {
        below("cloth", cloth, self.model.cloths.len())?;
        movable("offset", offset, 1.0)?;
        self.running.with(py, |Running { state, inputs, work, .. }| {
            inputs.translate(&self.model, cloth, offset.into());
            state.translate(&self.model, cloth, offset.into());
            work.forget_step();
        })
    }

    fn body_offset(&self, py: Python<'_>, body: usize) -> PyResult<[f64; 3]> {
        below("body", body, self.model.bodies.list.len())?;
        Ok(self.running.with(py, |Running { state, inputs, .. }| state.body_offset(&self.model, inputs, body))?.to_array())
    }

    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<contacts::Arrays<'py>> {
        let found = self.running.with(py, |running| touches(&running.state, &running.work))?;
        Ok(contacts::arrays(py, &self.model, &found))
    }

    fn spring_tensions<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let found = self.running.with(py, |Running { state, inputs, work, .. }| tensions(&self.model, state, inputs, work))?;
        Ok(found.map(|tensions| PyArray1::from_vec(py, tensions)))
    }

    fn keep_trace(&self, py: Python<'_>, keep: bool) -> PyResult<()> {
        self.running.with(py, |running| running.work.keep_trace(keep))
    }

    fn trace<'py>(&self, py: Python<'py>) -> PyResult<Option<Vec<Bound<'py, PyArray2<f64>>>>> {
        let points = self.running.with(py, |running| running.work.trace().map(<[_]>::to_vec))?;
        let numbering = &self.model.numbering;
        let rows = |point: Waypoint| {
            let vertices = (0..point.particles.len()).map(|vertex| point.particles[numbering.particle(vertex as u32) as usize]);
            let all = vertices.chain(point.bodies.iter().copied());
            arrays::rows_of(PyArray1::from_iter(py, all.flat_map(|place| place.to_array())), 3)
        };
        Ok(points.map(|points| points.into_iter().map(rows).collect()))
    }
}
