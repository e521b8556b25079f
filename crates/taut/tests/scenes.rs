//! What users type, right and wrong.

use crate::common;
use std::collections::BTreeMap;

use serde_json::{Value, json};
use taut::model::MeshData;
use taut::scene::{Scene, schema};

fn grid(change: impl FnOnce(&mut Value)) -> Value {
    let mut scene = json!({
        "cloth": [{ "grid": { "size": [1.0, 1.0], "cells": [4, 4] }, "fabric": "silk", "pins": [{ "corner": "top-left" }] }],
        "solver": { "substeps": 40, "filter": "sweeps" },
    });
    change(&mut scene);
    scene
}

fn curves(curves: Value) -> Value {
    grid(|s| s["cloth"][0]["curves"] = curves)
}

/// The error of reading or building.
fn error(scene: &Value) -> String {
    let built = Scene::from_json(&scene.to_string()).and_then(|scene| common::build(&scene, &BTreeMap::new()));
    built.expect_err("must be refused").to_string()
}

#[test]
fn errors_name_the_field_the_value_what_is_allowed_and_a_remedy() {
    let cases: Vec<(Value, &[&str])> = vec![
        (
            grid(|s| s["cloth"][0]["strain_limit"] = json!(1.5)),
            &["scene.cloth[0].strain_limit = 1.5: must be in [1e-9, 1]; try 0.05"],
        ),
        (grid(|s| s["cloth"][0]["strain_limt"] = json!(0.1)), &["scene.cloth[0].strain_limt", "did you mean `strain_limit`?"]),
        (grid(|s| s["durration"] = json!(1)), &["scene.durration", "did you mean `duration`?"]),
        (
            grid(|s| s["cloth"][0]["fabric"] = json!("slik")),
            &["scene.cloth[0].fabric = \"slik\"", "did you mean `silk`?", "nylon"],
        ),
        (grid(|s| s["solver"]["filter"] = json!("sweep")), &["scene.solver.filter", "did you mean `sweeps`?"]),
        (grid(|s| s["fps"] = json!("fast")), &["scene.fps = \"fast\"", "invalid type"]),
        (grid(|s| s["fps"] = json!(0)), &["scene.fps = 0: must be in [0.001,"]),
        (grid(|s| s["gravity"] = json!([0, 0])), &["scene.gravity = [0,0]", "3"]),
        (grid(|s| s["cloth"] = json!([])), &["scene.cloth: there is none"]),
        (
            grid(|s| s["cloth"][0]["mesh"] = json!("a.obj")),
            &["scene.cloth[0]: needs exactly one of grid, mesh, network; it has several"],
        ),
        (grid(|s| s["cloth"][0]["grid"]["cells"] = json!([0, 4])), &["scene.cloth[0].grid.cells[0] = 0: must be at least 1"]),
        (grid(|s| s["cloth"][0]["grid"]["cells"] = json!([100_000, 100_000])), &["scene.cloth[0].grid.cells", "at most"]),
        (grid(|s| s["cloth"][0]["grid"]["axes"] = json!(["x", "-x"])), &["scene.cloth[0].grid.axes", "must differ"]),
        (grid(|s| s["cloth"][0]["pins"] = json!([{}])), &["scene.cloth[0].pins[0]", "exactly one of corner", "none"]),
        (grid(|s| s["cloth"][0]["pins"] = json!([{ "vertices": [25] }])), &["pins[0].vertices = 25", "numbered 0 to 24"]),
        (
            grid(|s| s["cloth"][0]["pins"] = json!([{ "box": [[5, 5, 5], [6, 6, 6]] }])),
            &["pins[0].box", "holds no vertex", "spans"],
        ),
        (grid(|s| s["cloth"][0]["pins"][0]["move"] = json!([[1, [0, 0, 0]], [1, [0, 0, 1]]])), &["move[1]", "must increase"]),
        (
            grid(|s| s["cloth"][0]["pins"][0]["turn"] = json!({ "angle": [[1, 90]] })),
            &["scene.cloth[0].pins[0].turn.axis = [0.0, 0.0, 0.0]: must be a direction", "try [0, 0, 1]"],
        ),
        (
            grid(|s| s["cloth"][0]["pins"][0]["turn"] = json!({ "axis": [0, 0, 1], "angle": [[0, 90]] })),
            &["scene.cloth[0].pins[0].turn.angle[0] = 90: at time 0 the angle is 0 degrees; begin with [0, 0]"],
        ),
        (
            grid(|s| s["cloth"][0]["pins"][0]["turn"] = json!({ "axis": [0, 0, 1], "angel": [[1, 90]] })),
            &["scene.cloth[0].pins[0].turn.angel: no such field; did you mean `angle`?"],
        ),
        (
            grid(|s| {
                s["cloth"][0]["pins"][0]["turn"] = json!({ "axis": [0, 0, 1] });
                s["cloth"][0]["pins"][0]["follow"] = json!("path.npy");
            }),
            &["scene.cloth[0].pins[0].follow = \"path.npy\"", "a pin that follows an array has neither `move` nor `turn`; leave"],
        ),
        (
            grid(|s| s["cloth"][0]["weights"] = json!([{ "corner": "top-right" }])),
            &["scene.cloth[0].weights[0].mass = 0: must be in [1e-15, 1000000]; try 0.2"],
        ),
        (
            grid(|s| s["cloth"][0]["weights"] = json!([{ "corner": "top-right", "mass": -0.2 }])),
            &["scene.cloth[0].weights[0].mass = -0.2: must be in [1e-15,"],
        ),
        (
            grid(|s| s["cloth"][0]["weights"] = json!([{ "mass": 0.2 }])),
            &["cloth[0].weights[0]: needs exactly one of corner", "none"],
        ),
        (
            grid(|s| s["cloth"][0]["weights"] = json!([{ "edge": "left", "nearest": [0, 0, 0], "mass": 1 }])),
            &["cloth[0].weights[0]", "several"],
        ),
        (
            grid(|s| s["cloth"][0]["weights"] = json!([{ "vertices": [3, 25], "mass": 1 }])),
            &["weights[0].vertices = 25", "numbered 0 to 24"],
        ),
        (
            grid(|s| s["cloth"][0]["weights"] = json!([{ "vertices": [3], "mas": 1 }])),
            &["weights[0].mas: no such field; did you mean `mass`?"],
        ),
        (grid(|s| s["solver"]["\u{1b}[2Jfilter"] = json!("none")), &["scene.solver.\"\\u001b[2Jfilter\": no such field"]),
        (grid(|s| s["solver"]["f".repeat(100_000)] = json!("none")), &["fff...: no such field; allowed: substeps"]),
        (
            grid(|s| s["solver"]["filter"] = json!("n".repeat(100_000))),
            &["scene.solver.filter = \"nnn", "nnn...: unknown; allowed"],
        ),
        (curves(json!({ "tension": [[0, 0]] })), &["cloth[0].curves.tension: has 1 points; give 2 to 64"]),
        (curves(json!({ "tension": [[0, 0.1], [1, 2]] })), &["curves.tension[0] = [0, 0.1]: a curve begins at [0, 0]"]),
        (
            curves(json!({ "tension": [[0, 0], [5, 20]] })),
            &["curves.tension[1] = [5, 20]: the strain must increase", "at most 1"],
        ),
        (curves(json!({ "tension": [[0, 0], [0.1, 2], [0.1, 3]] })), &["curves.tension[2] = [0.1, 3]", "must increase"]),
        (curves(json!({ "shear": [[0, 0], [0.1, 2], [0.2, 1]] })), &["curves.shear[2] = [0.2, 1]", "must not fall", "smooth"]),
        (curves(json!({ "bending": [[0, 0], [9, 0]] })), &["curves.bending[1] = [9, 0]", "resists nothing"]),
        (curves(json!({ "bendnig": [[0, 0], [9, 1]] })), &["curves.bendnig", "did you mean `bending`?"]),
        (curves(json!({ "tension_weft": [[0, 0], [0.1, 2]] })), &["curves.tension_weft: needs tension"]),
        (
            grid(|s| {
                s["cloth"][0]["curves"] = json!({ "tension": [[0, 0], [0.1, 2]] });
                s["cloth"][0]["stiffness"] = json!(20);
            }),
            &["curves.tension: says what stiffness says; leave one of them out"],
        ),
        (
            grid(|s| {
                s["cloth"][0]["curves"] = json!({ "bending": [[0, 0], [10, 1e-4]] });
                s["cloth"][0]["bending"] = json!(1e-5);
            }),
            &["curves.bending: says what cloth.bending says"],
        ),
        (
            grid(|s| {
                s["cloth"][0]["curves"] = json!({ "shear": [[0, 0], [0.1, 2]] });
                s["solver"]["filter"] = json!("xpbd");
            }),
            &["scene.solver.filter = \"xpbd\"", "cloth[0] has curves", "choose another filter"],
        ),
        (
            grid(|s| s["cloth"][0]["bending"] = json!(-1)),
            &["cloth[0].bending = -1: must be 0 or in [1e-20,", "try 1e-5 or \"fabric\""],
        ),
        (grid(|s| s["cloth"][0]["bending"] = json!("soft")), &["cloth[0].bending = \"soft\"", "expected \"fabric\" or a number"]),
        (grid(|s| s["cloth"][0]["density"] = json!(-1)), &["scene.cloth[0].density = -1: must be in [1e-9,"]),
        (grid(|s| s["solver"]["substeps"] = json!("some")), &["scene.solver.substeps = \"some\"", "\"auto\" or a whole number"]),
        (
            grid(|s| s["solver"]["substeps"] = json!(1)),
            &["scene.solver.substeps = 1", "stability bound", "use at least", "force_step"],
        ),
    ];
    for (scene, expected) in cases {
        let text = error(&scene);
        assert!(expected.iter().all(|part| text.contains(part)), "{text:?} lacks one of {expected:?}");
    }
}

#[test]
fn a_step_over_the_bound_can_be_forced_and_the_number_that_is_named_would_do() {
    let text = error(&grid(|s| s["solver"]["substeps"] = json!(1)));
    let number = text.split("use at least ").nth(1).and_then(|rest| rest.split(',').next()).expect("a number");
    let substeps: u32 = number.parse().expect("a whole number");
    common::model(&grid(|s| s["solver"]["substeps"] = json!(substeps)));
    common::model(&grid(|s| s["solver"] = json!({ "substeps": 1, "force_step": true, "filter": "sweeps" })));
    assert_eq!(common::model(&grid(|s| s["solver"]["substeps"] = json!("auto"))).schedule.substeps, substeps);
}

#[test]
fn pins_out_of_the_cloths_reach_are_refused_with_both_distances() {
    let apart = |by: f64| {
        grid(|s| {
            s["cloth"][0]["pins"] =
                json!([{ "edge": "left" }, { "edge": "right", "move": [[1.0, [by, 0, 0]], [2.0, [0, 0, 0]]] }])
        })
    };
    let text = error(&apart(0.2));
    assert!(text.contains("1.200 m apart") && text.contains("reaches 1.060 m"), "{text}");
    common::model(&apart(0.05));
}

#[test]
fn suspicious_values_are_warned_about() {
    let scene = common::scene(&grid(|s| s["cloth"][0]["density"] = json!(1.0)));
    let warnings = scene.warnings();
    assert!(warnings.iter().any(|text| text.contains("silk is usually 0.015 to 0.2 kg/m^2")), "{warnings:?}");
    assert!(common::scene(&grid(|_| ())).warnings().is_empty());
    let weights = grid(|s| s["cloth"][0]["weights"] = json!([{ "edge": "left", "mass": 0.1 }]));
    let warnings = common::model(&weights).model.warnings;
    assert!(warnings.iter().any(|text| text.contains("weights[0]: what lies on held vertices")), "{warnings:?}");
}

#[test]
fn a_resolved_scene_reads_back_as_itself() {
    let scene = common::scene(&grid(|s| s["wind"] = json!({ "velocity": [1, 0, 0], "gust": {} })));
    assert_eq!(Scene::from_json(&scene.to_json()).expect("reads back"), scene);
    assert_eq!(scene.cloth[0].strain_limit, Some(0.06));
    let turn = json!({ "axis": [0, 0, 2], "point": [0.0, 0.5, 0.0], "angle": [[0, 0], [2, 360]] });
    let scene = common::scene(&grid(|s| s["cloth"][0]["pins"][0]["turn"] = turn.clone()));
    assert_eq!(Scene::from_json(&scene.to_json()).expect("reads back"), scene);
    assert!(scene.to_json().contains("\"turn\"") && !common::scene(&grid(|_| ())).to_json().contains("\"turn\""));
}

#[test]
fn every_field_is_described_in_the_schema() {
    fn walk(path: &str, value: &Value, undescribed: &mut Vec<String>) {
        let Some(object) = value.as_object() else { return };
        for (name, property) in object.get("properties").and_then(Value::as_object).into_iter().flatten() {
            if property.get("description").is_none() {
                undescribed.push(format!("{path}.{name}"));
            }
        }
        object.iter().for_each(|(key, child)| walk(&format!("{path}/{key}"), child, undescribed));
    }
    let schema: Value = serde_json::from_str(&schema()).expect("JSON");
    let mut undescribed = Vec::new();
    walk("", &schema, &mut undescribed);
    assert!(undescribed.is_empty(), "{undescribed:?}");
    assert!(schema["properties"]["duration"]["description"].as_str().expect("text").contains("[s]"));
}

fn mesh(vertices: &[[f64; 3]], faces: &[&[i64]]) -> Result<common::Built, String> {
    let mesh = MeshData {
        vertices: vertices.to_vec(),
        corners: faces.concat(),
        counts: faces.iter().map(|face| face.len() as i64).collect(),
    };
    let scene = common::scene(&json!({ "cloth": [{ "mesh": "m" }] }));
    common::build(&scene, &[("m".to_owned(), mesh)].into()).map_err(|error| error.to_string())
}

const SQUARE: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

#[test]
fn faulty_meshes_are_refused_or_repaired_and_the_repair_is_reported() {
    let refused: Vec<(Result<common::Built, String>, &str)> = vec![
        (mesh(&SQUARE, &[&[0, 1, 9]]), "names vertex 9; there are 4"),
        (mesh(&SQUARE, &[&[0, 1, -1]]), "names vertex -1"),
        (mesh(&SQUARE, &[]), "no face with an area"),
        (mesh(&SQUARE, &[&[0, 1, 1]]), "no face with an area"),
        (mesh(&[[0., 0., f64::NAN]], &[&[0, 0, 0]]), "not a finite number"),
    ];
    for (result, expected) in refused {
        let text = result.expect_err("must be refused");
        assert!(text.contains("scene.cloth[0].mesh") && text.contains(expected), "{text:?} lacks {expected:?}");
    }
    let five = [SQUARE.as_slice(), &[[5., 5., 5.]]].concat();
    let repaired: Vec<(Result<common::Built, String>, &str)> = vec![
        (mesh(&SQUARE, &[&[0, 1, 2], &[0, 1, 2], &[0, 2, 3]]), "1 faces that stand there twice"),
        (mesh(&SQUARE, &[&[0, 1, 2], &[0, 0, 2], &[0, 2, 3]]), "1 faces without area"),
        (mesh(&SQUARE, &[&[0, 1, 2], &[0, 3, 2]]), "1 faces were turned round"),
        (mesh(&five, &[&[0, 1, 2, 3]]), "1 vertices belong to no face"),
        (mesh(&[SQUARE.as_slice(), &[[0.5, 0.5, 1.0]]].concat(), &[&[0, 1, 2], &[0, 2, 3], &[0, 2, 4]]), "non-manifold"),
        (mesh(&[SQUARE.as_slice(), &SQUARE].concat(), &[&[0, 1, 2, 3], &[4, 5, 6, 7]]), "4 vertices lie exactly on others"),
    ];
    for (result, expected) in repaired {
        let model = result.expect("is repaired");
        assert!(model.warnings.iter().any(|text| text.contains(expected)), "{:?} lacks {expected:?}", model.warnings);
    }
}
