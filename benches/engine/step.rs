//! What a step of each part costs. `make bench`; figures are medians.
#![allow(missing_docs)]

use std::collections::BTreeMap;
use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use serde_json::{Value, json};
use taut::forces::{Forces, external};
use taut::geometry::Pool;
use taut::integrate::{Integrator, propose};
use taut::prepare::{Prepared, prepare};
use taut::scene::Scene;
use taut::schedule::Stride;
use taut::state::State;
use taut::step::{Work, glance, step};

fn flag(filter: &str, wind: Value) -> (Prepared, State) {
    let scene = json!({
        "wind": wind,
        "cloth": [{
            "grid": { "size": [1.5, 1.0], "cells": [96, 64], "origin": [0.0, 0.0, 1.0] },
            "fabric": "nylon", "density": 0.2, "pins": [{ "edge": "left" }],
        }],
        "solver": { "filter": filter, "iterations": 20 },
    });
    let scene = Scene::from_json(&scene.to_string()).expect("a valid scene");
    let prepared = prepare(&scene, &BTreeMap::new(), &BTreeMap::new()).expect("a model");
    let Prepared { model, inputs, schedule } = &prepared;
    let mut state = State::new(model);
    let mut work = Work::new(model, schedule, 1);
    (0..200).for_each(|_| {
        step(model, &mut state, inputs, schedule.step_length, &mut work);
    });
    (prepared, state)
}

fn benches(criterion: &mut Criterion) {
    let pool = Pool::new(1);
    let gusty = json!({ "velocity": [8.0, 1.5, 0.0], "gust": {} });
    let mut group = criterion.benchmark_group("flag_96x64");
    for (name, wind) in [("forces, no wind", Value::Null), ("forces, gusty wind", gusty.clone())] {
        let (Prepared { model, inputs, schedule }, state) = flag("none", wind);
        let (mut forces, plan) = (Forces::new(&model), schedule.plan(&model, schedule.step_length));
        let stride = Stride { model: &model, inputs: &inputs, plan: &plan, can_be_halved: false };
        group.bench_function(format!("external {name}"), |bench| {
            bench.iter(|| external(stride, black_box(&state), &mut forces, &pool))
        });
    }
    let (Prepared { model, inputs, schedule }, mut state) = flag("none", Value::Null);
    let plan = schedule.plan(&model, schedule.step_length);
    let stride = Stride { model: &model, inputs: &inputs, plan: &plan, can_be_halved: false };
    let (mut forces, mut integrator) = (Forces::new(&model), Integrator::new(&model, &plan));
    let mut ends = state.positions.clone();
    group.bench_function("springs", |bench| {
        bench.iter(|| propose(stride, black_box(&mut state), &mut ends, &mut forces, &mut integrator, &pool));
    });
    let (Prepared { model, schedule, .. }, state) = flag("none", Value::Null);
    let mut work = Work::new(&model, &schedule, 1);
    group.bench_function("diagnostics", |bench| bench.iter(|| glance(&model, black_box(&state), &mut work)));
    group.bench_function("plan", |bench| bench.iter(|| schedule.plan(&model, black_box(schedule.step_length))));
    for filter in ["none", "sequential", "sweeps", "coarse_to_fine"] {
        let (Prepared { model, inputs, schedule }, start) = flag(filter, gusty.clone());
        let (mut state, mut work) = (start.clone(), Work::new(&model, &schedule, 1));
        group.bench_function(format!("step, filter {filter}"), |bench| {
            bench.iter(|| {
                state.clone_from(&start);
                step(&model, &mut state, &inputs, schedule.step_length, &mut work)
            });
        });
    }
    group.finish();
}

criterion_group!(all, benches);
criterion_main!(all);
