//! A model, its state and its workspace as one Python object.

use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use taut::advance::advance_in_turns;
use taut::geometry::Vectors;
use taut::inputs::{Air, Target, Track};
use taut::model::{Model, SpringKind};
use taut::prepare::{Prepared, prepare};
use taut::scene::Scene;
use taut::schedule::Schedule;
use taut::state::{Clock, State};
use taut::step::{Work, admit, external};

use crate::checks::{affordable, below, duration, explain, movable, scene_with, workers};
use crate::host::Caller;
use crate::report::report;
use crate::running::{Guarded, Running};
use crate::turns::{Turns, or_error};
use crate::{arrays, pools, registers, scene_error, yardstick};

/// See `_taut.pyi` for the documentation of the members.
#[pyclass(frozen, module = "taut._taut")]
pub struct Engine {
    scene: Scene,
    pub(crate) model: Model,
    schedule: Schedule,
    pub(crate) running: Guarded,
}

/// Seconds of each pass, and the forces.
type Timed<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f32>>);

impl Engine {
    fn advance<'py>(&self, py: Python<'py>, count: u64, dt: f64, hook: Option<Py<PyAny>>) -> PyResult<Bound<'py, PyDict>> {
        let mut caller = Caller { turns: Turns::new(), hook, guarded: &self.running };
        let (result, time) = or_error(|| {
            self.running.with(py, |Running { state, inputs, work, .. }| {
                (advance_in_turns(&self.model, state, inputs, dt, count, work, &mut caller), state.time())
            })
        })??;
        match result {
            Ok(summary) => report(py, &summary, time),
            Err(failure) => Err(caller.turns.raised.unwrap_or_else(|| explain(&self.model, failure))),
        }
    }

    /// The particle of a vertex.
    fn particle(&self, vertex: usize) -> PyResult<u32> {
        below("vertex", vertex, self.model.particle_count())?;
        Ok(self.model.numbering.particle(vertex as u32))
    }

    /// The particles of some vertices.
    fn particles(&self, vertices: &[usize]) -> PyResult<Vec<u32>> {
        vertices.iter().map(|&vertex| self.particle(vertex)).collect()
    }

    /// The vertex of a particle, as NumPy counts.
    fn vertex(&self, particle: u32) -> i32 {
        self.model.numbering.vertex(particle) as i32
    }

    /// The state in the order of the vertices.
    fn state(&self, py: Python<'_>) -> PyResult<State> {
        self.running.with(py, |running| running.state.to_vertices(&self.model.numbering))
    }
}

#[pymethods]
impl Engine {
    #[new]
    #[pyo3(signature = (scene, meshes, threads=None, paths=None))]
    fn new(
        py: Python<'_>,
        scene: &str,
        meshes: &Bound<'_, PyDict>,
        threads: Option<usize>,
        paths: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let (meshes, followed) = (arrays::meshes(meshes)?, arrays::followed(paths)?);
        registers::chosen()?;
        // With Python's lock held: no fork may come while threads are started.
        let pool = pools::shared(workers(threads)?);
        let build = || {
            let scene = Scene::from_json(scene).map_err(scene_error)?;
            affordable(&scene, &meshes)?;
            let Prepared { model, inputs, schedule } = prepare(&scene, &meshes, &followed).map_err(scene_error)?;
            let work = Work::with_pool(&model, &schedule, pool);
            let running = Running { state: State::new(&model), inputs, wind: scene.wind.clone(), work };
            Ok(Self { running: Guarded::new(running), scene, model, schedule })
        };
        or_error(|| py.detach(build))?
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
    fn threads(&self, py: Python<'_>) -> PyResult<usize> {
        self.running.with(py, |running| running.work.pool().threads())
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
    pub(crate) fn step_length(&self) -> f64 {
        self.schedule.step_length
    }

    #[getter]
    fn step_bound(&self) -> f64 {
        self.schedule.bound
    }

    #[getter]
    fn steps(&self, py: Python<'_>) -> PyResult<u64> {
        self.running.with(py, |running| running.state.clock.steps)
    }

    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        self.running.with(py, |running| running.state.time())
    }

    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let rows = self.running.with(py, |Running { state, work, .. }| {
            let (mut rows, pool) = (vec![[0.0; 3]; self.model.particle_count()], work.pool());
            pool.install(state.positions.len(), || state.write_places(&self.model, &mut rows, &pool));
            rows
        })?;
        Ok(arrays::rows_of(PyArray1::from_vec(py, rows.into_flattened()), 3))
    }

    #[getter]
    fn local_positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let positions = self.running.with(py, |running| self.model.numbering.to_vertices(&running.state.positions))?;
        Ok(arrays::to_numpy(py, &positions))
    }

    #[getter]
    fn origins<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let origins = self.running.with(py, |running| running.state.origins.clone())?;
        Ok(arrays::rows_of(PyArray1::from_iter(py, origins.iter().flat_map(|origin| origin.to_array())), 3))
    }

    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let velocities = self.running.with(py, |running| self.model.numbering.to_vertices(running.state.of_motion()))?;
        Ok(arrays::to_numpy(py, &velocities))
    }

    fn read_state(&self, py: Python<'_>, positions: Py<PyAny>, velocities: Py<PyAny>) -> PyResult<()> {
        let (count, numbering) = (self.model.particle_count(), &self.model.numbering);
        self.running.with(py, |Running { state, work, .. }| {
            // One thread at a time: others may be told of the same arrays.
            Python::attach(|py| {
                let mut positions = arrays::writable("positions", positions.bind(py), count)?;
                let mut velocities = arrays::writable("velocities", velocities.bind(py), count)?;
                let (x, v) = (arrays::rows_mut("positions", &mut positions)?, arrays::rows_mut("velocities", &mut velocities)?);
                let pool = work.pool();
                pool.install(count, || {
                    state.write_places(&self.model, x, &pool);
                    numbering.write_rows(state.of_motion(), 0, v, &pool, |velocity| velocity.to_array());
                });
                Ok(())
            })
        })?
    }

    #[getter]
    fn pin_groups<'py>(&self, py: Python<'py>) -> Vec<Bound<'py, PyArray1<i32>>> {
        let group = |particles: &[u32]| PyArray1::from_iter(py, particles.iter().map(|&particle| self.vertex(particle)));
        self.model.pins.iter().map(|pins| group(&pins.particles)).collect()
    }

    fn lead(&self, py: Python<'_>, vertex: usize, target: [f64; 3], speed: f32) -> PyResult<()> {
        let particle = self.particle(vertex)?;
        movable("target", target, f64::from(speed))?;
        self.running.with(py, |running| running.inputs.grips.lead(particle, target, speed))
    }

    #[pyo3(signature = (vertices, targets, over=0.0))]
    fn hold(&self, py: Python<'_>, vertices: Vec<usize>, targets: &Bound<'_, PyAny>, over: f64) -> PyResult<()> {
        let targets = arrays::places("targets", targets, Some(vertices.len()))?;
        let particles = self.particles(&vertices)?;
        duration("over", over)?;
        self.running.with(py, |Running { state, inputs, .. }| {
            let arrival = state.time() + over;
            for (particle, place) in particles.into_iter().zip(targets) {
                inputs.grips.hold(particle, Target { place, arrival });
            }
        })
    }

    fn release(&self, py: Python<'_>, vertices: Vec<usize>) -> PyResult<()> {
        let particles = self.particles(&vertices)?;
        self.running.with(py, |running| particles.into_iter().for_each(|particle| running.inputs.grips.release(particle)))
    }

    #[getter]
    fn held<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i32>>> {
        let particles = self.running.with(py, |running| running.inputs.grips.particles().to_vec())?;
        let mut vertices: Vec<i32> = particles.into_iter().map(|particle| self.vertex(particle)).collect();
        vertices.sort_unstable();
        Ok(PyArray1::from_vec(py, vertices))
    }

    #[getter]
    fn gravity(&self, py: Python<'_>) -> PyResult<[f64; 3]> {
        Ok(self.running.with(py, |Running { state, inputs, .. }| inputs.gravity.at(state.time()))?.to_array())
    }

    #[setter]
    fn set_gravity(&self, py: Python<'_>, gravity: [f64; 3]) -> PyResult<()> {
        // JSON has no such numbers.
        if !gravity.iter().all(|part| part.is_finite()) {
            return Err(PyValueError::new_err(format!("gravity = {gravity:?}: must be three finite numbers [m/s^2]")));
        }
        let checked = scene_with(&format!(r#""gravity": {gravity:?}"#))?.gravity();
        self.running.with(py, |running| running.inputs.gravity = Track::constant(checked.into()))
    }

    #[getter]
    fn wind(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let wind = self.running.with(py, |running| running.wind.clone())?;
        Ok(wind.map(|wind| wind.to_json()))
    }

    #[setter]
    fn set_wind(&self, py: Python<'_>, wind: Option<&str>) -> PyResult<()> {
        let wind = scene_with(&format!(r#""wind": {}"#, wind.unwrap_or("null")))?.wind;
        self.running.with(py, |running| {
            running.inputs.air = wind.as_ref().map(Air::new);
            running.wind = wind;
        })
    }

    fn shift_pins(&self, py: Python<'_>, group: usize, offset: [f64; 3], speed: f64) -> PyResult<()> {
        below("group", group, self.model.pins.len())?;
        movable("offset", offset, speed)?;
        self.running.with(py, |Running { state, inputs, .. }| {
            inputs.grips.shift(group, offset.into(), speed);
            if speed.is_infinite() {
                state.offsets[group].now = offset.into();
            }
        })
    }

    fn pin_offset(&self, py: Python<'_>, group: usize) -> PyResult<[f64; 3]> {
        below("group", group, self.model.pins.len())?;
        Ok(self.running.with(py, |running| running.state.offsets[group].now)?.to_array())
    }

    fn admit(&self, py: Python<'_>) -> PyResult<()> {
        self.running.with(py, |running| {
            let Running { state, inputs, work, .. } = running;
            admit(&self.model, state, inputs, work);
        })
    }

    fn past<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f32>>>> {
        let state = self.state(py)?;
        let vectors: Vectors = state.memory().flat_map(Vectors::iter).chain(state.memory_of_steps()).collect();
        Ok((!vectors.is_empty()).then(|| arrays::to_numpy(py, &vectors)))
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
        let velocities = numbering.to_particles(&arrays::from_numpy("velocities", velocities, count)?);
        let clock = Clock::after(steps, self.schedule.step_length);
        let mut state = if let Some(origins) = origins {
            let positions = numbering.to_particles(&arrays::from_numpy("positions", positions, count)?);
            let origins = arrays::places("origins", origins, Some(self.model.cloths.len()))?;
            State { origins, ..State::at(&self.model, positions, velocities, clock) }
        } else {
            let places = arrays::places("positions", positions, Some(count))?;
            let place = |particle: usize| places[numbering.vertex(particle as u32) as usize];
            State::in_world(&self.model, place, velocities, clock)
        };
        if let Some(past) = past {
            let count_of_memory = state.memory().map(Vectors::len).sum::<usize>() + state.memory_of_steps().count();
            let rows = arrays::from_numpy("past", past, count_of_memory)?;
            let mut rows = rows.iter();
            for vectors in state.memory_mut() {
                *vectors = numbering.to_particles(&rows.by_ref().take(count).collect());
            }
            state.recall_steps(rows);
            state.past.length = self.schedule.step_length;
        }
        self.running.with(py, |Running { inputs, work, state: now, .. }| {
            work.forget_step();
            // Bodies are on their paths, and those that were moved as far off as they were to go; pins stay beside their paths.
            inputs.settle_bodies();
            inputs.bodies.places(&self.model.bodies, state.time(), &mut state.bodies);
            *now = State { offsets: now.offsets.clone(), ..state };
        })
    }

    #[pyo3(signature = (count=1, dt=None, hook=None))]
    fn step<'py>(&self, py: Python<'py>, count: u64, dt: Option<f64>, hook: Option<Py<PyAny>>) -> PyResult<Bound<'py, PyDict>> {
        self.advance(py, count, dt.unwrap_or(self.schedule.step_length), hook)
    }

    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.advance(py, 0, self.schedule.step_length, None)
    }

    fn snapshot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = self.running.with(py, |running| running.state.to_bytes(&self.model, &running.inputs.grips))?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn restore(&self, py: Python<'_>, snapshot: &[u8]) -> PyResult<()> {
        let read = State::from_bytes(snapshot, &self.model).map_err(|error| PyValueError::new_err(error.to_string()))?;
        self.running.with(py, |Running { state, inputs, work, .. }| {
            work.forget_step();
            inputs.take(read.1);
            *state = read.0;
        })
    }

    fn yardstick<'py>(&self, py: Python<'py>, repeats: usize) -> PyResult<Timed<'py>> {
        let positions = self.running.with(py, |running| running.state.positions.clone())?;
        let (seconds, forces) = py.detach(|| yardstick::measure(&self.model, &positions, repeats));
        Ok((PyArray1::from_vec(py, seconds), arrays::to_numpy(py, &self.model.numbering.to_vertices(&forces))))
    }

    fn external_forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let mut accelerations =
            self.running.with(py, |Running { state, inputs, work, .. }| external(&self.model, state, inputs, work).clone())?;
        let masses = &self.model.particles.mass;
        for column in [&mut accelerations.x, &mut accelerations.y, &mut accelerations.z] {
            column.iter_mut().zip(masses).for_each(|(part, mass)| *part *= mass);
        }
        Ok(arrays::to_numpy(py, &self.model.numbering.to_vertices(&accelerations)))
    }

    fn state_hash(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("{:016x}", self.state(py)?.hash()))
    }
}
