//! Grids, meshes and nets through every part of a step, for Miri and ThreadSanitizer (`make sanitize`): they see what no result
//! shows. Cloths are small for Miri, and elsewhere large enough for every parallel loop.
#![allow(missing_docs)]

mod common;

use std::collections::BTreeMap;

use common::{Simulation, build, chain_links, crooked, scene};
use serde_json::{Value, json};

const SMALL: bool = cfg!(miri);
const CELLS: u32 = if SMALL { 3 } else { 66 };
const STEPS: u64 = if SMALL { 1 } else { 4 };
const THREADS: usize = if SMALL { 1 } else { 3 };

fn cloths() -> Value {
    let points: Vec<[f64; 3]> = (0..CELLS * CELLS).map(|point| [f64::from(point) * 0.01, 2.0, 0.0]).collect();
    json!([
        {
            "name": "grid", "grid": { "cells": [CELLS, CELLS] }, "fabric": "nylon", "strain_limit": 0.02,
            "pins": [{ "corner": "top-left" }, { "corner": "top-right", "move": [[1.0, [-0.2, 0.0, 0.0]]] }],
            "weights": [{ "corner": "bottom-left", "mass": 0.01 }],
        },
        { "name": "mesh", "mesh": "crooked", "fabric": "silk", "bending": 1e-5, "pins": [{ "vertices": [0] }] },
        {
            "name": "net", "network": { "points": points, "links": chain_links(CELLS * CELLS - 1), "mass": 1e-4 },
            "stiffness": 5.0, "strain_limit": 0.05, "pins": [{ "vertices": [0] }],
        },
    ])
}

fn run(solver: Value) {
    let document = json!({
        "wind": { "velocity": [6.0, 3.0, 1.0], "gust": {}, "model": "triangle", "law": "drag_lift" },
        "cloth": cloths(), "solver": solver,
    });
    let meshes = BTreeMap::from([("crooked".to_owned(), crooked(CELLS))]);
    let built = build(&scene(&document), &meshes).expect("a model");
    let mut run = Simulation::with_threads(built, THREADS);
    run.steps(STEPS);
    let bytes = run.state.to_bytes(&run.model, &run.inputs.grips);
    taut::state::State::from_bytes(&bytes, &run.model).expect("its own snapshot");
}

#[test]
fn coarse_to_fine() {
    run(json!({}));
}

#[test]
fn sweeps_in_colours() {
    run(json!({ "filter": "sweeps", "iterations": 2, "substeps": 4, "force_step": true }));
}

#[test]
fn xpbd() {
    run(json!({ "filter": "xpbd", "substeps": 4, "force_step": true }));
}

#[test]
fn an_implicit_method() {
    run(json!({ "integrator": "bdf2", "substeps": 1, "force_step": true }));
}
