//! A model, its state and its workspace as one Python object.

use std::collections::BTreeMap;
use std::sync::Mutex;

use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use taut::advance::{NonFinite, Summary, advance};
use taut::geometry::Vectors;
use taut::inputs::Inputs;
use taut::model::{Model, SpringKind};
use taut::prepare::{Prepared, prepare};
use taut::scene::Scene;
use taut::schedule::Schedule;
use taut::state::{Clock, Past, State};
use taut::step::{Work, admit, external};

use crate::{SimulationError, scene_error};
use crate::{arrays, yardstick};

/// See `_taut.pyi` for the documentation of the members.
#[pyclass(frozen, module = "taut._taut")]
pub struct Engine {
    scene: Scene,
    model: Model,
    schedule: Schedule,
    running: Mutex<Running>,
}

/// Seconds of each pass, and the forces.
type Timed<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f32>>);

/// What a step changes, and what acts on it.
struct Running {
    state: State,
    before: State,
    inputs: Inputs,
    work: Work,
}

impl Engine {
    /// The running part; waits for a step that another thread is taking.
    fn with<R: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut Running) -> R + Send) -> R {
        py.detach(|| work(&mut self.running.lock().unwrap_or_else(std::sync::PoisonError::into_inner)))
    }

    fn advance<'py>(&self, py: Python<'py>, count: u64) -> PyResult<Bound<'py, PyDict>> {
        let (result, time) = self.with(py, |running| {
            let Running { state, before, inputs, work } = running;
            let result = advance(&self.model, state, before, inputs, self.schedule.step_length, work, count);
            (result, state.time())
        });
        report(py, &result.map_err(|error| self.explain(error))?, time)
    }

    /// The particle of a vertex.
    fn particle(&self, vertex: usize) -> PyResult<u32> {
        below("vertex", vertex, self.model.particle_count())?;
        Ok(self.model.numbering.particle(vertex as u32))
    }

    /// The vertex of a particle, as NumPy counts.
    fn vertex(&self, particle: u32) -> i32 {
        self.model.numbering.vertex(particle) as i32
    }

    /// The state in the order of the vertices.
    fn state(&self, py: Python<'_>) -> State {
        self.with(py, |running| running.state.to_vertices(&self.model.numbering))
    }

    fn check_group(&self, group: usize) -> PyResult<()> {
        below("group", group, self.model.pins.len())
    }

    /// Names the cloth and its own vertex instead of the particle.
    fn explain(&self, error: NonFinite) -> PyErr {
        let vertex = self.model.numbering.vertex(error.particle) as usize;
        let place = self.model.cloths.iter().find(|cloth| cloth.particles().contains(&vertex));
        let place = place.map_or_else(String::new, |cloth| format!("cloth {:?}, vertex {}: ", cloth.name, vertex - cloth.first));
        SimulationError::new_err(format!("{place}{error}"))
    }
}

#[pymethods]
impl Engine {
    #[new]
    #[pyo3(signature = (scene, meshes, threads=None))]
    fn new(py: Python<'_>, scene: &str, meshes: &Bound<'_, PyDict>, threads: Option<usize>) -> PyResult<Self> {
        let meshes = arrays::meshes(meshes.extract::<BTreeMap<_, _>>()?)?;
        if threads == Some(0) {
            return Err(PyValueError::new_err("threads = 0: must be at least 1, or None for all cores"));
        }
        let threads = threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
        py.detach(|| {
            let scene = Scene::from_json(scene).map_err(scene_error)?;
            let Prepared { model, inputs, schedule } = prepare(&scene, &meshes).map_err(scene_error)?;
            let state = State::new(&model);
            let work = Work::new(&model, &schedule, threads);
            let running = Running { before: state.clone(), state, inputs, work };
            Ok(Self { running: Mutex::new(running), scene, model, schedule })
        })
    }

    #[getter]
    fn scene(&self) -> String {
        self.scene.to_json()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.model.warnings.clone()
    }

    #[getter]
    fn threads(&self, py: Python<'_>) -> usize {
        self.with(py, |running| running.work.pool().threads())
    }

    #[getter]
    fn vertex_count(&self) -> usize {
        self.model.particle_count()
    }

    #[getter]
    fn cloths(&self) -> Vec<(String, usize, usize)> {
        self.model.cloths.iter().map(|cloth| (cloth.name.clone(), cloth.first, cloth.count)).collect()
    }

    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<i32>> {
        let flat = self.model.triangles.iter().flatten().map(|&corner| self.vertex(corner));
        arrays::rows_of(PyArray1::from_iter(py, flat), 3)
    }

    #[getter]
    fn springs<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<i32>> {
        let flat = self.model.springs.ends.iter().flatten().map(|&end| self.vertex(end));
        arrays::rows_of(PyArray1::from_iter(py, flat), 2)
    }

    #[getter]
    fn spring_kind<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u8>> {
        let code = |kind: &SpringKind| match kind {
            SpringKind::Structural => 0,
            SpringKind::Shear => 1,
            SpringKind::Flexion => 2,
        };
        PyArray1::from_iter(py, self.model.springs.kind.iter().map(code))
    }

    #[getter]
    fn rest_length<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        PyArray1::from_slice(py, &self.model.springs.rest)
    }

    #[getter]
    fn strain_limit<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        PyArray1::from_slice(py, &self.model.springs.strain_limit)
    }

    #[getter]
    fn mass<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        PyArray1::from_iter(py, self.model.numbering.by_vertex(&self.model.particles.mass))
    }

    #[getter]
    fn pinned<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        let weights = self.model.numbering.by_vertex(&self.model.particles.inverse_mass);
        PyArray1::from_iter(py, weights.map(|weight| weight == 0.0))
    }

    #[getter]
    fn substeps(&self) -> u32 {
        self.schedule.substeps
    }

    #[getter]
    fn step_length(&self) -> f64 {
        self.schedule.step_length
    }

    #[getter]
    fn step_bound(&self) -> f64 {
        self.schedule.bound
    }

    #[getter]
    fn steps(&self, py: Python<'_>) -> u64 {
        self.with(py, |running| running.state.clock.steps)
    }

    #[getter]
    fn time(&self, py: Python<'_>) -> f64 {
        self.with(py, |running| running.state.time())
    }

    fn positions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        let rows = self.with(py, |Running { state, work, .. }| {
            let (mut rows, pool) = (vec![[0.0; 3]; self.model.particle_count()], work.pool());
            pool.install(|| state.write_places(&self.model, &mut rows, &pool));
            rows
        });
        arrays::rows_of(PyArray1::from_vec(py, rows.into_flattened()), 3)
    }

    #[getter]
    fn local_positions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        let positions = self.with(py, |running| self.model.numbering.to_vertices(&running.state.positions));
        arrays::to_numpy(py, &positions)
    }

    #[getter]
    fn origins<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let origins = self.with(py, |running| running.state.origins.clone());
        arrays::rows_of(PyArray1::from_iter(py, origins.iter().flat_map(|origin| origin.to_array())), 3)
    }

    fn velocities<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        let velocities = self.with(py, |running| self.model.numbering.to_vertices(&running.state.velocities));
        arrays::to_numpy(py, &velocities)
    }

    fn read_state(&self, py: Python<'_>, positions: Py<PyAny>, velocities: Py<PyAny>) -> PyResult<()> {
        let (count, numbering) = (self.model.particle_count(), &self.model.numbering);
        self.with(py, |Running { state, work, .. }| {
            // One thread at a time: others may be told of the same arrays.
            Python::attach(|py| {
                let mut positions = arrays::writable("positions", positions.bind(py), count)?;
                let mut velocities = arrays::writable("velocities", velocities.bind(py), count)?;
                let (x, v) = (arrays::rows_mut("positions", &mut positions)?, arrays::rows_mut("velocities", &mut velocities)?);
                let pool = work.pool();
                pool.install(|| {
                    state.write_places(&self.model, x, &pool);
                    numbering.write_rows(&state.velocities, 0, v, &pool, |velocity| velocity.to_array());
                });
                Ok(())
            })
        })
    }

    #[getter]
    fn pin_groups<'py>(&self, py: Python<'py>) -> Vec<Bound<'py, PyArray1<i32>>> {
        let group = |particles: &[u32]| PyArray1::from_iter(py, particles.iter().map(|&particle| self.vertex(particle)));
        self.model.pins.iter().map(|pins| group(&pins.particles)).collect()
    }

    fn lead(&self, py: Python<'_>, vertex: usize, target: [f64; 3], speed: f32) -> PyResult<()> {
        let particle = self.particle(vertex)?;
        if !(target.iter().all(|part| part.is_finite()) && speed > 0.0) {
            return Err(PyValueError::new_err(format!(
                "target = {target:?}, speed = {speed}: must be finite numbers and a speed above 0"
            )));
        }
        self.with(py, |running| running.work.hands().lead(particle, target, speed));
        Ok(())
    }

    fn release(&self, py: Python<'_>, vertex: usize) -> PyResult<()> {
        let particle = self.particle(vertex)?;
        self.with(py, |running| running.work.hands().release(particle));
        Ok(())
    }

    fn shift_pins(&self, py: Python<'_>, group: usize, offset: [f64; 3], speed: f64) -> PyResult<()> {
        self.check_group(group)?;
        if !(offset.iter().all(|part| part.is_finite()) && speed > 0.0) {
            return Err(PyValueError::new_err(format!(
                "offset = {offset:?}, speed = {speed}: must be finite numbers and a speed above 0"
            )));
        }
        self.with(py, |running| running.work.hands().shift(group, offset.into(), speed));
        Ok(())
    }

    fn pin_offset(&self, py: Python<'_>, group: usize) -> PyResult<[f64; 3]> {
        self.check_group(group)?;
        Ok(self.with(py, |running| running.work.hands().offset(group)).to_array())
    }

    fn admit(&self, py: Python<'_>) {
        self.with(py, |running| {
            let Running { state, inputs, work, .. } = running;
            admit(&self.model, state, inputs, work);
        });
    }

    fn past<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray2<f32>>> {
        let past = self.state(py).past;
        let vectors: Vectors = past.displacements.iter().chain(past.gains.iter()).collect();
        (!vectors.is_empty()).then(|| arrays::to_numpy(py, &vectors))
    }

    #[pyo3(signature = (positions, velocities, steps, past=None, origins=None))]
    fn set_state(
        &self,
        py: Python<'_>,
        positions: &Bound<'_, PyAny>,
        velocities: &Bound<'_, PyAny>,
        steps: u64,
        past: Option<&Bound<'_, PyAny>>,
        origins: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let (count, numbering) = (self.model.particle_count(), &self.model.numbering);
        let velocities = arrays::from_numpy("velocities", velocities, count)?;
        let clock = Clock::after(steps, self.schedule.step_length);
        let mut state = if let Some(origins) = origins {
            let positions = arrays::from_numpy("positions", positions, count)?;
            let origins = arrays::places("origins", origins, Some(self.model.cloths.len()))?;
            State { origins, ..State::at(&self.model, positions, velocities, clock) }
        } else {
            let places = arrays::places("positions", positions, Some(count))?;
            let place = |particle: usize| places[numbering.vertex(particle as u32) as usize];
            // In the order of the vertices, like all else here.
            let state = State::in_world(&self.model, place, Vectors::default(), clock).to_vertices(numbering);
            State { velocities, ..state }
        };
        if let Some(past) = past {
            let remembered = state.past.displacements.len();
            let past: Vec<_> = arrays::from_numpy("past", past, 2 * remembered)?.iter().collect();
            let (displacements, gains) = past.split_at(remembered);
            let [displacements, gains] = [displacements, gains].map(|part| part.iter().copied().collect());
            state.past = Past { displacements, gains, length: self.schedule.step_length };
        }
        let state = state.to_particles(&self.model.numbering);
        self.with(py, |running| running.state = state);
        Ok(())
    }

    #[pyo3(signature = (count=1))]
    fn step<'py>(&self, py: Python<'py>, count: u64) -> PyResult<Bound<'py, PyDict>> {
        self.advance(py, count)
    }

    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.advance(py, 0)
    }

    fn snapshot<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let bytes = self.with(py, |running| running.state.to_bytes(&self.model));
        PyBytes::new(py, &bytes)
    }

    fn restore(&self, py: Python<'_>, snapshot: &[u8]) -> PyResult<()> {
        let state = State::from_bytes(snapshot, &self.model).map_err(|error| PyValueError::new_err(error.to_string()))?;
        self.with(py, |running| running.state = state);
        Ok(())
    }

    fn yardstick<'py>(&self, py: Python<'py>, repeats: usize) -> Timed<'py> {
        let positions = self.with(py, |running| running.state.positions.clone());
        let (seconds, forces) = py.detach(|| yardstick::measure(&self.model, &positions, repeats));
        (PyArray1::from_vec(py, seconds), arrays::to_numpy(py, &self.model.numbering.to_vertices(&forces)))
    }

    fn external_forces<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        let mut accelerations =
            self.with(py, |Running { state, inputs, work, .. }| external(&self.model, state, inputs, work).clone());
        let masses = &self.model.particles.mass;
        for column in [&mut accelerations.x, &mut accelerations.y, &mut accelerations.z] {
            column.iter_mut().zip(masses).for_each(|(part, mass)| *part *= mass);
        }
        arrays::to_numpy(py, &self.model.numbering.to_vertices(&accelerations))
    }

    fn state_hash(&self, py: Python<'_>) -> String {
        format!("{:016x}", self.state(py).hash())
    }
}

/// Refuses an index beyond the end.
fn below(name: &str, index: usize, count: usize) -> PyResult<()> {
    if index < count {
        return Ok(());
    }
    Err(PyIndexError::new_err(format!("{name} = {index}: there are {count}, counted from 0")))
}

/// `Report` of `_taut.pyi`.
fn report<'py>(py: Python<'py>, summary: &Summary, time: f64) -> PyResult<Bound<'py, PyDict>> {
    let spring = |index: Option<u32>| index.map_or(-1, i64::from);
    let last = &summary.last;
    let report = PyDict::new(py);
    report.set_item("time", time)?;
    report.set_item("steps", summary.steps)?;
    report.set_item("evaluations", summary.evaluations)?;
    report.set_item("worst_stretch", last.worst_stretch)?;
    report.set_item("worst_spring", spring(last.worst_spring))?;
    report.set_item("worst_stretch_in_steps", summary.worst_stretch)?;
    report.set_item("worst_spring_in_steps", spring(summary.worst_spring))?;
    report.set_item("limited_steps", summary.limited_steps)?;
    report.set_item("limited_springs", summary.limited_springs)?;
    report.set_item("sweeps", summary.sweeps)?;
    report.set_item("cuts", summary.cuts)?;
    report.set_item("held_back_pins", summary.held_back_pins)?;
    report.set_item("lost_motion", summary.lost_motion)?;
    report.set_item("mean_lost_motion", summary.mean_lost_motion)?;
    report.set_item("kinetic_energy", last.kinetic_energy)?;
    report.set_item("elastic_energy", last.elastic_energy)?;
    report.set_item("potential_energy", last.potential_energy)?;
    Ok(report)
}
