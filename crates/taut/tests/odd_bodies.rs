//! Thickness, surfaces and speeds that are unusual: what is warned of, and what is simply simulated.

use std::collections::BTreeMap;

use crate::common::{self, model};
use serde_json::{Value, json};
use taut::model::{MeshData, Model};

/// A small cloth, and what is said beside it.
fn with(rest: Value) -> Value {
    let mut scene = json!({
        "fps": 10.0,
        "cloth": [{ "grid": { "size": [1.0, 1.0], "cells": [4, 4] }, "fabric": "silk", "pins": [{ "edge": "top" }] }],
    });
    for (name, value) in rest.as_object().expect("fields") {
        scene[name] = value.clone();
    }
    scene
}

fn body(body: Value) -> Value {
    with(json!({ "body": [body] }))
}

#[test]
fn cloth_that_is_thick_beside_its_edges_is_warned_of() {
    let cautions = |contact: bool, thickness: f64, body: bool| {
        let mut asked = with(json!({ "contact": { "self": contact } }));
        asked["cloth"][0]["thickness"] = json!(thickness);
        if body {
            asked["body"] = json!([{ "plane": { "point": [0, 0, -9], "normal": [0, 0, 1] } }]);
        }
        let warnings = model(&asked).model.warnings;
        warnings.into_iter().filter(|text| text.contains("thickness")).collect::<Vec<_>>()
    };
    assert!(cautions(true, 0.124, false).is_empty() && cautions(true, 0.125, false).is_empty());
    let found = cautions(true, 0.126, false);
    let expected = [
        "scene.cloth[0].thickness = 0.126: 40 of 72 edges are shorter than twice that, the shortest, from vertex 0 to 1, is 0.25 m long;",
        "make it at most 0.125 m, or such edges longer",
    ];
    assert!(found.len() == 1 && expected.iter().all(|part| found[0].contains(part)), "{found:?}");
    assert!(cautions(false, 0.2, true).is_empty(), "bodies see it from outside");
    // One short edge, in the numbers of the file.
    let mut mesh = common::crooked(6);
    mesh.vertices[9] = [mesh.vertices[8][0] + 1e-3, mesh.vertices[8][1], 0.0];
    let built = common::mesh_scene(json!({}), json!({ "thickness": 0.004, "pins": [{ "vertices": [0] }] }), mesh);
    let found = built.model.warnings.iter().find(|text| text.contains("thickness")).expect("a warning");
    assert!(found.contains(": 1 of ") && found.contains("vertex 8 to 9") | found.contains("vertex 9 to 8"), "{found}");
}

#[test]
fn surfaces_may_be_open_inside_out_or_flat() {
    // A lid, a tetrahedron, and that turned inside out: nothing is wrong with any of them.
    let vertices = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let figure = MeshData { vertices, corners: vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3], counts: vec![3; 4] };
    let lid = MeshData { counts: vec![3], corners: vec![0, 1, 2], ..figure.clone() };
    let mut turned = figure.clone();
    turned.corners.chunks_mut(3).for_each(|face| face.swap(0, 1));
    let scene = common::scene(&body(json!({ "mesh": "m", "translate": [0, 0, -20] })));
    for mesh in [lid, figure, turned] {
        let built = Model::build(&scene, &BTreeMap::from([("m".to_owned(), mesh)])).expect("a model");
        assert!(built.warnings.is_empty(), "{:?}", built.warnings);
    }
}

#[test]
fn a_body_beyond_all_speed_leaves_everything_finite() {
    let scene = body(json!({
        "sphere": { "center": [0.5, -2, 0.5], "radius": 0.1 },
        "move": [[0.1, [0, 0, 0]], [0.101, [0, 9e4, 0]], [0.102, [0, -9e4, 0]], [0.5, [0, 4, 0]]],
    }));
    let mut run = common::Simulation::new(&scene);
    run.steps(6 * u64::from(run.model.schedule.substeps));
    assert!(run.state.positions.iter().all(glam::Vec3::is_finite));
}
