//! What a step of each part costs. `cargo bench -p taut`; figures are medians.
#![allow(missing_docs)]

use std::collections::BTreeMap;
use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use serde_json::{Value, json};
use taut::forces::{Forces, external};
use taut::geometry::Pool;
use taut::integrate::{Integrator, propose};
use taut::model::Model;
use taut::scene::Scene;
use taut::state::State;
use taut::step::{Work, glance, step};

fn flag(filter: &str, wind: Value) -> (Model, State) {
    let scene = json!({
        "wind": wind,
        "cloth": [{
            "grid": { "size": [1.5, 1.0], "cells": [96, 64], "origin": [0.0, 0.0, 1.0] },
            "fabric": "nylon", "density": 0.2, "pins": [{ "edge": "left" }],
        }],
        "solver": { "filter": filter, "iterations": 20 },
    });
    let scene = Scene::from_json(&scene.to_string()).expect("a valid scene");
    let model = Model::build(&scene, &BTreeMap::new()).expect("a model");
    let mut state = State::new(&model);
    let mut work = Work::new(&model, 1);
    (0..200).for_each(|_| {
        step(&model, &mut state, &mut work);
    });
    (model, state)
}

fn benches(criterion: &mut Criterion) {
    let pool = Pool::new(1);
    let gusty = json!({ "velocity": [8.0, 1.5, 0.0], "gust": {} });
    let mut group = criterion.benchmark_group("flag_96x64");
    for (name, wind) in [("forces, no wind", Value::Null), ("forces, gusty wind", gusty.clone())] {
        let (model, state) = flag("none", wind);
        let mut forces = Forces::new(&model);
        group.bench_function(format!("external {name}"), |bench| {
            bench.iter(|| external(&model, black_box(&state), &mut forces, &pool))
        });
    }
    let (model, mut state) = flag("none", Value::Null);
    let (mut forces, mut integrator) = (Forces::new(&model), Integrator::new(&model, 1));
    let mut ends = state.positions.clone();
    group.bench_function("springs", |bench| {
        bench.iter(|| propose(&model, black_box(&mut state), &mut ends, &mut forces, &mut integrator, &pool));
    });
    let (model, state) = flag("none", Value::Null);
    let mut work = Work::new(&model, 1);
    group.bench_function("health", |bench| bench.iter(|| glance(&model, black_box(&state), &mut work)));
    for filter in ["none", "sequential", "sweeps", "coarse_to_fine"] {
        let (model, start) = flag(filter, gusty.clone());
        let (mut state, mut work) = (start.clone(), Work::new(&model, 1));
        group.bench_function(format!("step, filter {filter}"), |bench| {
            bench.iter(|| {
                state.clone_from(&start);
                step(&model, &mut state, &mut work)
            });
        });
    }
    group.finish();
}

criterion_group!(all, benches);
criterion_main!(all);
