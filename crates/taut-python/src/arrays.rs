//! NumPy arrays to the engine's arrays and back.

use std::collections::BTreeMap;

use glam::DVec3;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2, PyReadwriteArray2, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use taut::geometry::Vectors;
use taut::inputs::Followed;
use taut::model::MeshData;
use taut::state::hash_of;

/// Vectors as an array of shape (n, 3).
pub fn to_numpy<'py>(py: Python<'py>, vectors: &Vectors) -> Bound<'py, PyArray2<f32>> {
    let rows = vectors.iter().flat_map(|vector| vector.to_array());
    rows_of(PyArray1::from_iter(py, rows), 3)
}

/// A flat array as rows of `width`.
pub fn rows_of<T: numpy::Element>(flat: Bound<'_, PyArray1<T>>, width: usize) -> Bound<'_, PyArray2<T>> {
    let rows = flat.len() / width;
    flat.reshape([rows, width]).expect("a flat array of whole rows can be reshaped")
}

/// Checks that `value` is a float32 array of shape (n, 3).
pub fn readonly<'py>(name: &str, value: &Bound<'py, PyAny>, n: Option<usize>) -> PyResult<PyReadonlyArray2<'py, f32>> {
    let expected = n.map_or_else(|| "(vertices, 3)".to_owned(), |n| format!("({n}, 3)"));
    let describe = |value: &Bound<'py, PyAny>| {
        let of = |attribute: &str| value.getattr(attribute).map(|found| found.to_string()).unwrap_or_default();
        format!("an array of shape {} and dtype {}", of("shape"), of("dtype"))
    };
    let array = value.cast::<PyArray2<f32>>().map_err(|_| {
        let found = if value.hasattr("dtype").unwrap_or(false) { describe(value) } else { value.get_type().to_string() };
        PyTypeError::new_err(format!("{name} must be a float32 array of shape {expected}, not {found}"))
    })?;
    if array.shape()[1] != 3 || n.is_some_and(|n| array.shape()[0] != n) {
        return Err(PyValueError::new_err(format!("{name} must have shape {expected}, not {}", describe(value))));
    }
    array.try_readonly().map_err(|error| PyValueError::new_err(format!("{name} is in use elsewhere: {error}")))
}

/// Vectors from an array of shape (n, 3) of finite numbers.
pub fn from_numpy(name: &str, value: &Bound<'_, PyAny>, n: usize) -> PyResult<Vectors> {
    let array = readonly(name, value, Some(n))?;
    let view = array.as_array();
    if let Some((index, _)) = view.rows().into_iter().enumerate().find(|(_, row)| row.iter().any(|part| !part.is_finite())) {
        return Err(PyValueError::new_err(format!("{name}[{index}] is not finite; all coordinates must be finite numbers")));
    }
    let column = |axis| view.column(axis).to_vec();
    Ok(Vectors { x: column(0), y: column(1), z: column(2) })
}

/// Places [m] from a float64 array of shape (n, 3) of finite numbers.
pub fn places(name: &str, value: &Bound<'_, PyAny>, n: Option<usize>) -> PyResult<Vec<DVec3>> {
    let expected = n.map_or_else(|| "(cloths, 3)".to_owned(), |n| format!("({n}, 3)"));
    let array =
        value.cast::<PyArray2<f64>>().ok().filter(|array| array.shape()[1] == 3 && n.is_none_or(|n| array.shape()[0] == n));
    let array = array.ok_or_else(|| PyValueError::new_err(format!("{name} must be a float64 array of shape {expected}")))?;
    let array = array.try_readonly().map_err(|error| PyValueError::new_err(format!("{name} is in use elsewhere: {error}")))?;
    let places: Vec<DVec3> = array.as_array().rows().into_iter().map(|row| DVec3::new(row[0], row[1], row[2])).collect();
    match places.iter().position(|place| !place.is_finite()) {
        Some(index) => {
            Err(PyValueError::new_err(format!("{name}[{index}] is not finite; all coordinates must be finite numbers")))
        }
        None => Ok(places),
    }
}

/// Checks that `value` is a float32 array of shape (n, 3) that can be written.
pub fn writable<'py>(name: &str, value: &Bound<'py, PyAny>, n: usize) -> PyResult<PyReadwriteArray2<'py, f32>> {
    readonly(name, value, Some(n))?;
    let array = value.cast::<PyArray2<f32>>()?;
    array.try_readwrite().map_err(|error| PyValueError::new_err(format!("{name} cannot be written: {error}")))
}

/// The rows of an array of shape (n, 3).
pub fn rows_mut<'a>(name: &str, array: &'a mut PyReadwriteArray2<'_, f32>) -> PyResult<&'a mut [[f32; 3]]> {
    let values = array.as_slice_mut();
    let values = values.map_err(|_| PyValueError::new_err(format!("{name} must be contiguous, in C order; use numpy.empty")))?;
    Ok(values.as_chunks_mut().0)
}

/// vertices (n, 3) float64, corners (k,) int64, counts (f,) int64.
type MeshArrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>);

/// The meshes of a scene.
pub fn meshes(given: &Bound<'_, PyDict>) -> PyResult<BTreeMap<String, MeshData>> {
    given
        .extract::<BTreeMap<String, MeshArrays<'_>>>()?
        .into_iter()
        .map(|(name, arrays)| mesh(&name, &arrays).map(|mesh| (name, mesh)))
        .collect()
}

/// places (frames, vertices, 3) float64, frames per second or none.
type FollowedArray<'py> = (Bound<'py, PyArray3<f64>>, Option<f64>);

/// The arrays that pins and bodies of a scene follow.
pub fn followed(given: Option<&Bound<'_, PyDict>>) -> PyResult<BTreeMap<String, Followed>> {
    let given = given.map_or_else(|| Ok(BTreeMap::new()), |given| given.extract::<BTreeMap<String, FollowedArray<'_>>>())?;
    let read = |(name, (array, rate)): (String, FollowedArray<'_>)| {
        if array.shape()[2] != 3 {
            return Err(PyValueError::new_err(format!("paths[{name:?}] must have shape (frames, vertices, 3)")));
        }
        let (vertices, array) = (array.shape()[1], array.try_readonly()?);
        let places = array.as_array().rows().into_iter().map(|row| DVec3::new(row[0], row[1], row[2])).collect();
        Ok((name, Followed { vertices, places, rate }))
    };
    given.into_iter().map(read).collect()
}

fn mesh(name: &str, (vertices, corners, counts): &MeshArrays<'_>) -> PyResult<MeshData> {
    if vertices.shape()[1] != 3 {
        return Err(PyValueError::new_err(format!("vertices of mesh {name:?} must have shape (n, 3)")));
    }
    let vertices = vertices.try_readonly()?;
    let vertices = vertices.as_array().rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect();
    let numbers = |array: &Bound<'_, PyArray1<i64>>| array.try_readonly().map(|array| array.as_array().to_vec());
    Ok(MeshData { vertices, corners: numbers(corners)?, counts: numbers(counts)? })
}

#[pyfunction]
#[pyo3(signature = (positions, velocities, past=None, origins=None))]
pub fn state_hash(
    positions: &Bound<'_, PyAny>,
    velocities: &Bound<'_, PyAny>,
    past: Option<&Bound<'_, PyAny>>,
    origins: Option<&Bound<'_, PyAny>>,
) -> PyResult<String> {
    let positions = readonly("positions", positions, None)?;
    let velocities = readonly("velocities", velocities, Some(positions.shape()[0]))?;
    let past = past.map(|past| readonly("past", past, None)).transpose()?;
    let (x, v) = (positions.as_array(), velocities.as_array());
    let past = past.as_ref().map(|past| past.as_array());
    let rows = x.rows().into_iter().chain(v.rows()).chain(past.iter().flat_map(|past| past.rows()));
    let origins = origins.map(|origins| places("origins", origins, None)).transpose()?.unwrap_or_default();
    Ok(format!("{:016x}", hash_of(rows.map(|row| [row[0], row[1], row[2]].into()), &origins)))
}
