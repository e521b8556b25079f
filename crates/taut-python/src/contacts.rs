//! Where cloth touches something, as Python sees it.

use glam::DVec3;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use taut::model::Model;
use taut::step::Touch;

use crate::arrays;

/// Vertices, bodies (-1: cloth), places [m], normals, forces [N], friction [N].
pub type Arrays<'py> = (
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray1<i32>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
);

/// One row for each place.
pub fn arrays<'py>(py: Python<'py>, model: &Model, touches: &[Touch]) -> Arrays<'py> {
    let rows = |of: fn(&Touch) -> DVec3| {
        arrays::rows_of(PyArray1::from_iter(py, touches.iter().flat_map(|touch| of(touch).to_array())), 3)
    };
    (
        PyArray1::from_iter(py, touches.iter().map(|touch| model.numbering.vertex(touch.particle) as i32)),
        PyArray1::from_iter(py, touches.iter().map(|touch| touch.body.map_or(-1, |body| body as i32))),
        rows(|touch| touch.place),
        rows(|touch| touch.normal),
        PyArray1::from_iter(py, touches.iter().map(|touch| touch.force)),
        rows(|touch| touch.friction),
    )
}
