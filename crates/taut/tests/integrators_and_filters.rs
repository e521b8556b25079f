//! What a filter does to a step of many stages: the limit holds, pins arrive, nothing bounces, states can be taken up again.

use crate::common::{self, Built, Simulation, chain_links, mesh_scene, model, network, scene_of, sheet};
use glam::Vec3;
use serde_json::{Value, json};
use taut::model::{MeshData, Model};
use taut::scene::Scene;
use taut::state::State;

const INTEGRATORS: [&str; 7] = ["euler", "forward_euler", "midpoint", "rk4", "verlet", "implicit_euler", "bdf2"];

/// Rounding of the ends of the shortest spring.
const ROUNDING: f64 = 1e-5;

/// Gravity, gusty wind and one integrator, in steps of its own choice.
fn blown(integrator: &str, filter: &str) -> Value {
    json!({
        "wind": { "velocity": [6.0, 2.0, 0.0], "gust": { "strength": 0.3, "period": 0.7, "seed": 2 } },
        "solver": { "integrator": integrator, "filter": filter, "iterations": 200 },
    })
}

fn grid() -> Value {
    json!({
        "grid": { "size": [1.0, 0.7], "cells": [10, 7] }, "fabric": "wool", "bending": 1e-5,
        "pins": [{ "corner": "top-left", "move": [[0.1, [0.2, 0.1, 0.0]], [0.3, [0.0, 0.0, 0.1]]] }],
        "weights": [{ "corner": "bottom-right", "mass": 0.05 }],
    })
}

fn net() -> Value {
    let points: Vec<[f64; 3]> = (0..9).map(|knot| [0.1 * f64::from(knot), 0.0, 0.0]).collect();
    let mut cloth = network(&points, &chain_links(8), 0.01);
    (cloth["stiffness"], cloth["damping"]) = (json!(60.0), json!(0.02));
    cloth["pins"] = json!([{ "vertices": [0] }]);
    cloth
}

/// Triangles of unlike shapes.
fn mesh() -> MeshData {
    let mut mesh = MeshData::default();
    for index in 0..81_i64 {
        let wave = 0.02 * (index as f64 * 12.9898).sin();
        mesh.vertices.push([(index % 9) as f64 / 8.0 + wave, (index / 9) as f64 / 8.0 - wave, 0.0]);
        if index % 9 < 8 && index / 9 < 8 {
            mesh.corners.extend([index, index + 1, index + 10, index, index + 10, index + 9]);
            mesh.counts.extend([3, 3]);
        }
    }
    mesh
}

/// A grid, a network and a mesh.
fn models(integrator: &str, filter: &str) -> [Built; 3] {
    let with = |cloth: Value| {
        let mut scene = blown(integrator, filter);
        scene["cloth"] = json!([cloth]);
        model(&scene)
    };
    let cloth = json!({ "fabric": "cotton", "bending": 2e-5, "bending_model": "choi_ko", "pins": [{ "vertices": [0, 8] }] });
    [with(grid()), with(net()), mesh_scene(blown(integrator, filter), cloth, mesh())]
}

/// Largest |X_uv| / R.
fn worst(model: &Model, state: &State) -> f64 {
    let springs = 0..model.springs.type1;
    let ratio = |spring: usize| {
        let [u, v] = model.springs.ends[spring].map(|end| state.positions.get(end as usize).as_dvec3());
        u.distance(v) / f64::from(model.springs.greatest_length(spring))
    };
    springs.map(ratio).fold(0.0, f64::max)
}

#[test]
fn the_limit_holds_after_every_step_of_every_integrator() {
    for integrator in INTEGRATORS {
        for model in models(integrator, "coarse_to_fine") {
            let steps = (0.2 / model.schedule.step_length) as u64;
            let mut run = Simulation::of(model);
            let mut limited = 0;
            for step in 0..steps {
                limited += run.steps(1).limited_steps;
                let worst = worst(&run.model, &run.state);
                assert!(worst <= 1.0 + ROUNDING, "{integrator}, step {step}: {worst}");
            }
            assert!(limited > 0, "{integrator}: nothing came near the limit");
        }
    }
}

#[test]
fn every_integrator_runs_with_sweeps_and_with_no_filter() {
    for integrator in INTEGRATORS {
        for filter in ["sweeps", "none"] {
            for model in models(integrator, filter) {
                let steps = (0.2 / model.schedule.step_length) as u64;
                let mut run = Simulation::of(model);
                let summary = run.steps(steps);
                let fastest = run.state.velocities.iter().map(Vec3::length).fold(0.0, f32::max);
                assert!(fastest > 0.5 && fastest < 15.0, "{integrator}, {filter}: {fastest} m/s");
                assert!(filter == "none" || summary.worst_stretch < 0.12, "{integrator}: {}", summary.worst_stretch);
            }
        }
    }
}

#[test]
fn all_integrators_agree_where_steps_are_short() {
    let middle = |integrator: &str| {
        // Level: upright, it would fold in its plane, any way.
        let mut scene = scene_of(sheet([12, 12], 0.1, json!([{ "corner": "top-left" }])), 240, "coarse_to_fine", 9.81);
        (scene["solver"]["integrator"], scene["solver"]["force_step"]) = (json!(integrator), json!(true));
        let mut run = Simulation::new(&scene);
        run.steps(240 * 20);
        run.state.positions.iter().sum::<Vec3>() / run.model.particle_count() as f32
    };
    let reference = middle("rk4");
    assert!(reference.z < -0.4, "the cloth falls by {} m", -reference.z);
    for integrator in INTEGRATORS {
        let apart = middle(integrator).distance(reference);
        assert!(apart < 0.001, "{integrator}: the centres part by {apart} m in a third of a second");
    }
}

#[test]
fn motion_that_touches_no_limit_is_that_of_the_bare_method() {
    for integrator in INTEGRATORS.into_iter().filter(|integrator| *integrator != "euler") {
        let run = |filter: &str| {
            let mut scene = blown(integrator, filter);
            (scene["cloth"], scene["solver"]["substeps"]) = (json!([net()]), json!(40));
            (scene["cloth"][0]["strain_limit"], scene["solver"]["force_step"]) = (json!(0.9), json!(true));
            let mut run = Simulation::new(&scene);
            assert_eq!(run.steps(400).limited_steps, 0);
            run.state
        };
        let (limited, bare) = (run("coarse_to_fine"), run("none"));
        assert_eq!((limited.positions, limited.velocities), (bare.positions, bare.velocities), "{integrator}");
    }
}

#[test]
fn pins_follow_their_path_to_the_bit() {
    for integrator in INTEGRATORS {
        let [model, ..] = models(integrator, "sweeps");
        let mut run = Simulation::of(model);
        for _ in 0..40 {
            run.steps(1);
            let place = run.model.inputs.pins.position(&run.model, 0, 0, run.state.time()).as_vec3();
            assert_eq!(run.state.positions.get(run.model.pins[0].particles[0] as usize), place, "{integrator}");
        }
    }
}

#[test]
fn a_load_that_a_filter_stops_does_not_bounce() {
    // A bead falls 0.1 m on an inextensible string and is stopped dead.
    for integrator in INTEGRATORS {
        let mut cloth = network(&[[0.0; 3], [0.0, 0.0, -1.0]], &[[0, 1]], 0.1);
        (cloth["strain_limit"], cloth["pins"]) = (json!(0.1), json!([{ "vertices": [0] }]));
        let mut scene = scene_of(cloth, 4, "sweeps", 9.81);
        (scene["solver"]["integrator"], scene["solver"]["force_step"]) = (json!(integrator), json!(true));
        let mut run = Simulation::new(&scene);
        let mut lowest = 0.0_f32;
        for _ in 0..240 {
            run.steps(1);
            let z = run.state.positions.z[1];
            assert!(z < lowest + 2e-6, "{integrator}: from {lowest} m up to {z} m");
            lowest = lowest.min(z);
        }
        assert!((lowest + 1.1).abs() < 1e-5, "{integrator}: {lowest} m");
        // What is left of the velocity is at most what gravity adds in a step.
        let left = run.state.velocities.z[1].abs();
        assert!(left < 1.001 * 9.81 / 240.0, "{integrator}: {left} m/s");
    }
}

#[test]
fn cloths_do_not_know_of_one_another() {
    for integrator in INTEGRATORS {
        let run = |cloths: &[Value]| {
            let mut scene = blown(integrator, "coarse_to_fine");
            (scene["cloth"], scene["solver"]["substeps"]) = (json!(cloths), json!(8));
            scene["solver"]["force_step"] = json!(true);
            let mut run = Simulation::new(&scene);
            run.steps(60);
            run.state.positions.iter().collect::<Vec<Vec3>>()
        };
        let [mut one, mut other] = [grid(), net()];
        (one["name"], other["name"]) = (json!("one"), json!("other"));
        // Both have the same greatest rates or are followed in as many parts; only explicit methods and linear systems remain.
        if integrator == "euler" {
            continue;
        }
        let (alone, together) = (run(&[one.clone()]), run(&[one, other]));
        assert_eq!(alone[..], together[..alone.len()], "{integrator}");
    }
}

#[test]
fn a_snapshot_goes_on_to_the_same_bits() {
    for integrator in INTEGRATORS {
        let [model, ..] = models(integrator, "coarse_to_fine");
        let mut run = Simulation::of(model);
        run.steps(25);
        let bytes = run.state.to_bytes(&run.model, &run.inputs.grips);
        run.steps(25);
        let hash = run.state.hash();
        run.state = State::from_bytes(&bytes, &run.model).expect("a whole snapshot").0;
        run.steps(25);
        assert_eq!(run.state.hash(), hash, "{integrator}");
    }
}

#[test]
fn what_bdf2_remembers_is_part_of_the_state() {
    let [model, ..] = models("bdf2", "coarse_to_fine");
    let mut run = Simulation::of(model);
    assert!(run.state.past.is_blank());
    run.steps(10);
    let mut forgetful = run.state.clone();
    assert!(!forgetful.past.is_blank());
    forgetful.past = taut::state::Past::none(&run.model);
    assert_ne!(forgetful.hash(), run.state.hash());
    let mut cut = run.state.to_bytes(&run.model, &run.inputs.grips);
    cut.truncate(cut.len() / 2);
    assert!(State::from_bytes(&cut, &run.model).is_err());
}

#[test]
fn the_filter_to_the_letter_refuses_integrators_that_it_cannot_serve() {
    for integrator in INTEGRATORS {
        let mut scene = blown(integrator, "sequential");
        scene["cloth"] = json!([net()]);
        let built = Scene::from_json(&scene.to_string()).and_then(|scene| common::build(&scene, &Default::default()));
        match (integrator, built) {
            ("euler" | "implicit_euler", built) => assert!(built.is_ok()),
            (_, built) => {
                let text = built.expect_err("must be refused").to_string();
                for part in [&format!("scene.solver.integrator = \"{integrator}\""), "X + V h", "coarse_to_fine"] {
                    assert!(text.contains(part), "{text:?} lacks {part:?}");
                }
            }
        }
    }
}

#[test]
fn springs_with_measured_curves_run_and_bending_along_a_curve_refuses_implicit_methods() {
    for integrator in INTEGRATORS {
        let built = |curves: Value| {
            let mut scene = blown(integrator, "coarse_to_fine");
            let mut cloth = json!({ "name": "shirt", "grid": { "size": [0.5, 0.5], "cells": [6, 6] }, "density": 0.2 });
            (cloth["pins"], cloth["curves"]) = (json!([{ "edge": "top" }]), curves);
            scene["cloth"] = json!([cloth]);
            Scene::from_json(&scene.to_string()).and_then(|scene| common::build(&scene, &Default::default()))
        };
        let model = built(json!({ "tension": [[0, 0], [0.02, 0.5], [0.06, 8.0]] })).expect("a model");
        let mut run = Simulation::of(model);
        for _ in 0..30 {
            run.steps(1);
            assert!(worst(&run.model, &run.state) <= 1.0 + ROUNDING, "{integrator}");
        }
        match built(json!({ "bending": [[0, 0], [10, 4e-5]] })) {
            Ok(_) => assert!(!["implicit_euler", "bdf2"].contains(&integrator), "{integrator} must be refused"),
            Err(error) => assert!(error.to_string().contains("shirt bends along a measured curve"), "{integrator}: {error}"),
        }
    }
}
