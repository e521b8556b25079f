//! Scenes beyond what single precision can do are refused by name, and what is allowed runs.

use std::collections::BTreeMap;

use crate::common::{Simulation, build, crooked, worst};
use serde_json::{Value, json};
use taut::scene::Scene;

fn sheet(changes: &[(&str, Value)]) -> Value {
    let mut scene = json!({
        "fps": 60.0,
        "cloth": [{ "grid": { "size": [1.0, 1.0], "cells": [8, 8] }, "density": 0.2, "pins": [{ "corner": "top-left" }] }],
    });
    for (path, value) in changes {
        *scene.pointer_mut(path).unwrap_or_else(|| panic!("no {path}")) = value.clone();
    }
    scene
}

/// What is said of a scene, if it is refused.
fn refusal(document: &Value) -> Option<String> {
    let scene = match Scene::from_json(&document.to_string()) {
        Ok(scene) => scene,
        Err(error) => return Some(error.to_string()),
    };
    build(&scene, &BTreeMap::from([("mesh".to_owned(), crooked(8))])).err().map(|error| error.to_string())
}

#[test]
fn sizes_that_single_precision_does_not_resolve_are_refused_by_name() {
    let mut weighted = sheet(&[("/cloth/0/grid/size", json!([1.0, 1e-6]))]);
    weighted["cloth"][0]["weights"] = json!([{ "corner": "bottom-right", "mass": 0.1 }]);
    let mesh = |scale: f64| json!({ "cloth": [{ "mesh": "mesh", "scale": scale, "density": 0.2 }] });
    let network =
        |points: Value, mass: f64| json!({ "cloth": [{ "network": { "points": points, "links": [[0, 1]], "mass": mass } }] });
    let near = json!([[0, 0, 0], [0.1, 0, 0]]);
    for (scene, words) in [
        (sheet(&[("/cloth/0/density", json!(1e-45))]), "scene.cloth[0].density = 1e-45: must be in [1e-9, 10000]"),
        (
            sheet(&[("/cloth/0/grid/size", json!([1e-30, 1e-30]))]),
            "scene.cloth[0].grid.size[0] = 1e-30: must be in [1e-9, 100000]",
        ),
        (sheet(&[("/cloth/0/grid/size", json!([1.4e-45, 1.0]))]), "scene.cloth[0].grid.size[0] = 1.4e-45: must be"),
        (sheet(&[("/cloth/0/grid/size", json!([1.0, 1e-38]))]), "scene.cloth[0].grid.size[1] = 1e-38: must be"),
        (weighted, "scene.cloth[0].grid.size = [1, 1e-6] (cloth[0].grid.cells = [8, 8])"),
        (sheet(&[("/cloth/0/grid/size", json!([1e-7, 1e-7]))]), "scene.cloth[0].density = 0.2: with "),
        (sheet(&[("/fps", json!(1e-20))]), "scene.fps = 1e-20: must be in [0.001, 100000]"),
        (mesh(1e-8), "cloth[0].scale = 1e-8"),
        (mesh(1e-12), "scene.cloth[0].scale = 1e-12: must be"),
        (mesh(1e6), "cloth[0].scale"),
        (network(near.clone(), 1e-50), "scene.cloth[0].network.mass = 1e-50: must be in [1e-15, 1000000]"),
        (
            network(json!([[0, 0, 0], [1e-12, 0, 0], [1, 0, 0]]), 1e-3),
            "scene.cloth[0].network.points: the spring from vertex 0 to 1",
        ),
    ] {
        let said = refusal(&scene).unwrap_or_else(|| panic!("allowed: {scene}"));
        assert!(said.contains(words), "{words}: {said}");
    }
    assert_eq!(refusal(&network(near, 1e-3)), None);
}

#[test]
fn what_makes_steps_too_many_is_named() {
    let mut windy = sheet(&[("/cloth/0/density", json!(1e-8))]);
    windy["wind"] = json!({ "velocity": [5e3, 5e3, 5e3] });
    let mut stiff = sheet(&[("/cloth/0/density", json!(1e-8))]);
    stiff["cloth"][0]["stiffness"] = json!(1e9);
    let tiny = sheet(&[("/cloth/0/grid/size", json!([1e-3, 1e-3])), ("/fps", json!(1e-3))]);
    for (scene, words) in [
        (windy, &["meets air", "scene.wind.velocity = [5000.0,5000.0,5000.0]", "scene.cloth[0].density = 1e-8"][..]),
        (stiff, &["springs", "scene.cloth[0].stiffness = 1000000000.0", "scene.cloth[0].density"]),
        (tiny, &["moves by its own size", "scene.cloth[0].grid.size = [0.001,0.001]", "scene.fps = 0.001"]),
    ] {
        let said = refusal(&scene).unwrap_or_else(|| panic!("allowed: {scene}"));
        assert!(words.iter().all(|word| said.contains(word)) && said.starts_with("scene.solver.substeps: "), "{words:?}: {said}");
    }
}

#[test]
fn narrow_cloth_keeps_its_limit_under_every_integrator() {
    for integrator in ["euler", "implicit_euler", "bdf2"] {
        // Springs of a hundred thousandth of the cloth.
        let mut scene = sheet(&[("/cloth/0/grid/size", json!([1.0, 1e-4]))]);
        (scene["solver"], scene["cloth"][0]["stiffness"]) = (json!({ "integrator": integrator }), json!(1e-4));
        (scene["cloth"][0]["shear_stiffness"], scene["cloth"][0]["damping"]) = (json!(1e-4), json!(1e-7));
        let mut run = Simulation::new(&scene);
        for _ in 0..30 {
            run.steps(1);
            assert!(worst(&run.model, &run.state) <= 1.0 + 1e-5, "{integrator}: {}", worst(&run.model, &run.state));
        }
    }
}

#[test]
fn a_limit_that_single_precision_does_not_resolve_is_told() {
    let warnings = |length: f64, limit: f64| {
        let points = json!([[0.0, 0.0, 0.0], [length, 0.0, 0.0], [100.0, 0.0, 0.0]]);
        let cloth = json!({ "network": { "points": points, "links": [[0, 1], [1, 2]], "mass": 0.1 }, "strain_limit": limit });
        Simulation::new(&json!({ "cloth": [cloth] })).model.warnings.join("\n")
    };
    assert_eq!(warnings(0.01, 0.05), "");
    let said = warnings(0.001, 0.01);
    assert!(said.contains("scene.cloth[0].strain_limit = 0.01: the spring from vertex 0 to 1 is 0.001 m long"), "{said}");
}

#[test]
fn gusts_of_hardly_any_wind_are_none() {
    for velocity in [[1e-15, 0.0, 0.0], [1e-40, 0.0, 0.0], [1e-6, 0.0, 0.0], [1e4, 0.0, 0.0]] {
        for period in [1e-3, 2.0, 1e6] {
            let mut scene = sheet(&[]);
            scene["wind"] = json!({ "velocity": velocity, "gust": { "period": period } });
            let mut run = Simulation::new(&scene);
            run.steps(3);
            assert!(run.state.positions.iter().all(|place| place.is_finite()), "{velocity:?}, {period} s");
        }
    }
    let mut scene = sheet(&[]);
    scene["wind"] = json!({ "velocity": [1, 0, 0], "gust": { "period": 1e-14 } });
    let said = refusal(&scene).expect("refused");
    assert!(said.contains("scene.wind.gust.period = 1e-14: must be in [0.001, 1000000]"), "{said}");
}

#[test]
fn what_is_long_or_odd_is_quoted_shortly_and_by_its_name() {
    let long = "x".repeat(100_000);
    let mut scenes = vec![
        (sheet(&[("/fps", json!(long))]), "scene.fps = \"xxx"),
        (sheet(&[("/cloth/0/pins/0/corner", json!(long))]), "scene.cloth[0].pins[0].corner = \"xxx"),
        (sheet(&[("/cloth/0/grid/cells/0", json!(long))]), "scene.cloth[0].grid.cells[0] = \"xxx"),
    ];
    for (name, words) in [
        (long.as_str(), "scene.cloth[0].xxx"),
        ("", "scene.cloth[0].\"\": no such field; allowed: "),
        ("`, `", "scene.cloth[0].\"`, `\": no such field; allowed: "),
        ("a`b", "scene.cloth[0].\"a`b\": no such field; allowed: "),
        ("line\nline", "scene.cloth[0].\"line\\nline\": no such field"),
        ("denisty", "scene.cloth[0].denisty: no such field; did you mean `density`? allowed: "),
    ] {
        let mut scene = sheet(&[]);
        scene["cloth"][0][name] = json!(1);
        scenes.push((scene, words));
    }
    for (scene, words) in scenes {
        let said = refusal(&scene).expect("refused");
        assert!(said.contains(words) && said.len() < 1000 && !said.contains('\n'), "{words}: {}", &said[..said.len().min(300)]);
        assert!(!said.contains("mean `,") && !said.contains("mean ``"), "{said}");
    }
}
