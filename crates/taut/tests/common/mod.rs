//! Scenes in a few words, for all tests.
#![allow(dead_code, missing_docs)]

pub mod goldens;
pub mod lines;
pub mod nets;
pub mod oracle;

use std::collections::BTreeMap;
use std::ops::Deref;

use glam::DVec3;
use serde_json::{Value, json};
use taut::advance::{Failure, Summary, advance};
use taut::forces::{Forces, external};
use taut::geometry::{self, Pool, Vectors};
use taut::inputs::Inputs;
use taut::model::{MeshData, Model};
use taut::prepare::{Prepared, prepare};
use taut::scene::{Scene, SceneError};
use taut::schedule::{Plan, Schedule, Stride};
use taut::state::State;
use taut::step::Work;

/// A model, and what its scene says beside it.
#[derive(Debug)]
pub struct Built {
    pub model: Model,
    pub inputs: Inputs,
    pub schedule: Schedule,
}

impl Deref for Built {
    type Target = Model;

    fn deref(&self) -> &Model {
        &self.model
    }
}

impl Built {
    /// The scene's own step.
    pub fn plan(&self) -> Plan {
        self.schedule.plan(&self.model, self.schedule.step_length)
    }

    /// That step, to be taken.
    pub fn stride<'a>(&'a self, plan: &'a Plan) -> Stride<'a> {
        Stride { model: &self.model, inputs: &self.inputs, plan, can_be_halved: false }
    }

    /// What acts from outside [m/s^2].
    pub fn external(&self, state: &State) -> Vectors {
        let mut forces = Forces::new(self);
        external(self.stride(&self.plan()), state, &mut forces, &Pool::new(1));
        forces.acceleration().clone()
    }
}

pub fn build(scene: &Scene, meshes: &BTreeMap<String, MeshData>) -> Result<Built, SceneError> {
    if let Ok(registers) = std::env::var("TAUT_SIMD") {
        geometry::choose(&registers).expect("registers of this processor");
    }
    let Prepared { model, inputs, schedule } = prepare(scene, meshes, &BTreeMap::new())?;
    Ok(Built { model, inputs, schedule })
}

pub struct Simulation {
    pub model: Built,
    pub inputs: Inputs,
    pub state: State,
    pub work: Work,
}

impl Simulation {
    pub fn new(scene: &Value) -> Self {
        Self::on_threads(scene, 1)
    }

    pub fn on_threads(scene: &Value, threads: usize) -> Self {
        Self::with_threads(model(scene), threads)
    }

    pub fn of(model: Built) -> Self {
        Self::with_threads(model, 1)
    }

    pub fn with_threads(model: Built, threads: usize) -> Self {
        let state = State::new(&model);
        let work = Work::new(&model, &model.schedule, threads);
        Self { inputs: model.inputs.clone(), model, state, work }
    }

    pub fn steps(&mut self, count: u64) -> Summary {
        self.try_steps(count, self.step_length()).expect("stays finite")
    }

    /// Steps of another length [s].
    pub fn try_steps(&mut self, count: u64, dt: f64) -> Result<Summary, Failure> {
        let Self { model, inputs, state, work } = self;
        advance(model, state, inputs, dt, count, work)
    }

    pub fn step_length(&self) -> f64 {
        self.model.schedule.step_length
    }
}

pub fn scene(value: &Value) -> Scene {
    Scene::from_json(&value.to_string()).expect("a valid scene")
}

pub fn model(value: &Value) -> Built {
    build(&scene(value), &BTreeMap::new()).expect("a model")
}

pub fn mesh_model(cloth: Value, mesh: MeshData) -> Built {
    mesh_scene(json!({}), cloth, mesh)
}

/// One cloth made of a mesh; `rest` holds the other fields of the scene.
pub fn mesh_scene(mut rest: Value, mut cloth: Value, mesh: MeshData) -> Built {
    cloth["mesh"] = json!("mesh");
    rest["cloth"] = json!([cloth]);
    let meshes = BTreeMap::from([("mesh".to_owned(), mesh)]);
    build(&scene(&rest), &meshes).expect("a model")
}

/// A sheet 1 m wide in the plane of x and y, its vertices off their places by up to a quarter of a cell, its cells cut either way.
pub fn crooked(cells: u32) -> MeshData {
    let random = |seed: u32| (f64::from(seed) * 0.618_034).fract() - 0.5;
    let place = |at: u32, seed: u32| {
        let off = if at == 0 || at == cells { 0.0 } else { 0.5 * random(seed) };
        (f64::from(at) + off) / f64::from(cells)
    };
    let mut mesh = MeshData::default();
    for vertex in 0..(cells + 1).pow(2) {
        let (i, j) = (vertex % (cells + 1), vertex / (cells + 1));
        mesh.vertices.push([place(i, 7 * vertex), place(j, 13 * vertex + 3), 0.0]);
    }
    for cell in 0..cells * cells {
        let a = i64::from(cell / cells * (cells + 1) + cell % cells);
        let [b, c, d] = [a + 1, a + i64::from(cells) + 2, a + i64::from(cells) + 1];
        mesh.corners.extend(if random(5 * cell) < 0.0 { [a, b, c, a, c, d] } else { [a, b, d, b, c, d] });
        mesh.counts.extend([3, 3]);
    }
    mesh
}

/// Of all particles [m].
pub fn centre_of_mass(run: &Simulation) -> DVec3 {
    let masses = &run.model.particles.mass;
    let sum: DVec3 = run.state.positions.iter().zip(masses).map(|(x, m)| x.as_dvec3() * f64::from(*m)).sum();
    sum / masses.iter().map(|m| f64::from(*m)).sum::<f64>()
}

/// A cloth of points and links with neither stiffness, damping nor drag.
pub fn network(points: &[[f64; 3]], links: &[[u32; 2]], mass: f64) -> Value {
    json!({
        "network": { "points": points, "links": links, "mass": mass },
        "stiffness": 0.0, "damping": 0.0, "air_drag": 0.0, "strain_limit": 0.1,
    })
}

/// Point numbers of a chain of `links` links, each joined to the next.
pub fn chain_links(links: u32) -> Vec<[u32; 2]> {
    (0..links).map(|link| [link, link + 1]).collect()
}

/// One cloth, frames of 1/60 s, a fixed number of steps a frame.
pub fn scene_of(cloth: Value, substeps: u32, filter: &str, gravity: f64) -> Value {
    json!({
        "fps": 60.0, "gravity": [0.0, 0.0, -gravity], "cloth": [cloth],
        "solver": { "substeps": substeps, "filter": filter },
    })
}

/// Largest |X_uv| / ((1 + lambda) L) by another route than the engine's: double precision, spring by spring.
pub fn worst(model: &Model, state: &State) -> f64 {
    let springs = &model.springs;
    let ratio = |index: usize| {
        let [u, v] = springs.ends[index].map(|end| state.positions.get(end as usize).as_dvec3());
        u.distance(v) / (f64::from(springs.rest[index]) * (1.0 + f64::from(springs.strain_limit[index])))
    };
    (0..springs.type1).map(ratio).fold(0.0, f64::max)
}

/// A sheet 1 m wide in the plane of x and y.
pub fn sheet(cells: [u32; 2], strain_limit: f64, pins: Value) -> Value {
    json!({
        "grid": { "size": [1.0, f64::from(cells[1]) / f64::from(cells[0])], "cells": cells, "axes": ["x", "y"] },
        "fabric": "nylon", "density": 0.2, "strain_limit": strain_limit, "pins": pins,
    })
}
