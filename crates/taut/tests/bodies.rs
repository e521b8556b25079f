//! What cloths collide with: what a scene says of it, what a model makes of that, and where it goes.

use crate::common;
use std::collections::BTreeMap;

use glam::DVec3;
use serde_json::{Value, json};
use taut::inputs::Followed;
use taut::model::{Bodies, BodyShape, MeshData, Model};
use taut::prepare::{Prepared, prepare};
use taut::scene::{Fabric, Scene, SceneError};

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

/// A tetrahedron with its faces outwards, and a vertex that belongs to no face.
fn figure() -> MeshData {
    MeshData {
        vertices: vec![[0.0, 0.0, 0.0], [9.0, 9.0, 9.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        corners: vec![0, 3, 2, 0, 2, 4, 0, 4, 3, 2, 3, 4],
        counts: vec![3; 4],
    }
}

fn build(scene: &Value, followed: &BTreeMap<String, Followed>) -> Result<Prepared, SceneError> {
    let meshes = BTreeMap::from([("figure.obj".to_owned(), figure())]);
    Scene::from_json(&scene.to_string()).and_then(|scene| prepare(&scene, &meshes, followed))
}

fn prepared(scene: &Value) -> Prepared {
    build(scene, &BTreeMap::new()).expect("a model")
}

fn model(scene: &Value) -> Model {
    prepared(scene).model
}

fn places(prepared: &Prepared, time: f64) -> Vec<DVec3> {
    let bodies = &prepared.model.bodies;
    let mut places = vec![DVec3::ZERO; bodies.rest.len()];
    prepared.inputs.bodies.places(bodies, time, &mut places);
    places
}

fn near(found: &[DVec3], expected: &[DVec3]) -> bool {
    found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| a.distance(*b) < 1e-12)
}

/// Six times the volume inside a surface that is closed and whose triangles face outwards.
fn volume(bodies: &Bodies) -> f64 {
    let corners = bodies.triangles.iter().map(|corners| corners.map(|corner| bodies.rest[corner as usize]));
    corners.map(|[a, b, c]| a.dot(b.cross(c))).sum()
}

/// Places of the figure in so many frames, each 1 m further along z.
fn walk(frames: usize, rate: Option<f64>) -> BTreeMap<String, Followed> {
    let vertices: Vec<DVec3> = figure().vertices.into_iter().map(DVec3::from_array).collect();
    let way = |frame: usize| DVec3::Z * frame as f64;
    let places = (0..frames).flat_map(|frame| vertices.iter().map(move |&vertex| vertex + way(frame)).collect::<Vec<_>>());
    let places = places.collect();
    BTreeMap::from([("walk.npy".to_owned(), Followed { vertices: vertices.len(), places, rate })])
}

#[test]
fn what_is_left_out_has_its_default() {
    let scene = common::scene(&body(json!({ "sphere": { "radius": 0.5 } })));
    let body = &scene.body[0];
    assert_eq!((body.name.as_str(), body.friction, body.thickness), ("body0", 0.3, 0.001));
    assert_eq!(body.sphere.as_ref().map(|sphere| (sphere.center, sphere.radius)), Some(([0.0; 3], 0.5)));
    assert!(scene.has_contact() && !scene.self_contact());
    let cloth = &scene.cloth[0];
    assert_eq!((cloth.thickness, cloth.friction), (Some(Fabric::Silk.material().thickness), Some(0.3)));
}

#[test]
fn a_scene_without_bodies_says_nothing_of_contact() {
    let scene = common::scene(&with(json!({})));
    let text = scene.to_json();
    assert!(!scene.has_contact() && !scene.self_contact());
    for word in ["body", "contact", "thickness", "\"friction\""] {
        assert!(!text.contains(word), "{word} in {text}");
    }
    let bodies = model(&with(json!({}))).bodies;
    assert!(bodies.list.is_empty() && bodies.rest.is_empty() && bodies.triangles.is_empty());
}

#[test]
fn cloths_collide_with_themselves_where_it_is_said_or_one_has_a_thickness() {
    let cases = [
        (with(json!({ "contact": { "self": true } })), true, true),
        (with(json!({ "contact": { "self": false } })), false, false),
        (with(json!({ "contact": {} })), false, false),
        (body(json!({ "sphere": { "radius": 1.0 } })), true, false),
    ];
    for (asked, contact, alone) in cases {
        let scene = common::scene(&asked);
        assert_eq!((scene.has_contact(), scene.self_contact()), (contact, alone), "{asked}");
        assert_eq!(scene.cloth[0].thickness.is_some(), contact, "{asked}");
    }
    for (said, expected) in [(json!({}), true), (json!({ "self": false }), false)] {
        let mut asked = with(json!({ "contact": said }));
        asked["cloth"][0]["thickness"] = json!(0.002);
        let scene = common::scene(&asked);
        assert_eq!((scene.has_contact(), scene.self_contact()), (expected, expected));
        assert_eq!((scene.cloth[0].thickness(), scene.cloth[0].friction()), (0.002, 0.3));
    }
}

#[test]
fn a_resolved_scene_reads_back_as_itself() {
    let scenes = [
        with(json!({ "contact": {} })),
        with(json!({ "contact": { "self": true } })),
        body(json!({ "box": { "size": [1, 2, 3], "rotate": [0, 0, 30] }, "move": [[0, [0, 0, 0]], [1, [0, 0, 1]]] })),
        body(json!({ "mesh": "figure.obj", "scale": 0.5, "motion": "walk.npy", "friction": 0.0 })),
        with(json!({ "body": [
            { "capsule": { "to": [0, 0, 1], "radius": 0.2 }, "turn": { "axis": [0, 0, 2], "angle": [[1, 90]] } },
            { "name": "floor", "plane": { "normal": [0, 0, 1] } },
        ] })),
    ];
    for asked in scenes {
        let scene = common::scene(&asked);
        assert_eq!(common::scene(&serde_json::from_str(&scene.to_json()).expect("JSON")), scene, "{asked}");
    }
}

#[test]
fn errors_name_the_field_the_value_what_is_allowed_and_a_remedy() {
    let ball = |change: fn(&mut Value)| {
        let mut ball = json!({ "sphere": { "radius": 0.5 } });
        change(&mut ball);
        body(ball)
    };
    let mut sweeps = body(json!({ "sphere": { "radius": 0.5 } }));
    sweeps["solver"] = json!({ "filter": "sweeps" });
    let mut thick = with(json!({ "solver": { "filter": "none" } }));
    thick["cloth"][0]["thickness"] = json!(0.001);
    let cloth = |name: &str, value: f64| {
        let mut scene = with(json!({}));
        scene["cloth"][0][name] = json!(value);
        scene
    };
    let figure = |rest: Value| {
        let mut figure = json!({ "mesh": "figure.obj" });
        rest.as_object().expect("fields").iter().for_each(|(name, value)| figure[name] = value.clone());
        body(figure)
    };
    let cases: Vec<(Value, &[&str])> = vec![
        (body(json!({})), &["scene.body[0]: needs exactly one of sphere, capsule, box, plane, mesh; it has none"]),
        (ball(|b| b["plane"] = json!({ "normal": [0, 0, 1] })), &["scene.body[0]: needs exactly one of", "it has several"]),
        (ball(|b| b["spere"] = json!({})), &["scene.body[0].spere: no such field; did you mean `sphere`?"]),
        (ball(|b| b["sphere"]["centre"] = json!([0, 0, 0])), &["sphere.centre: no such field; did you mean `center`?"]),
        (ball(|b| b["sphere"] = json!({})), &["scene.body[0].sphere.radius = 0: must be in [1e-9, 100000]; try 0.5"]),
        (ball(|b| b["sphere"]["radius"] = json!(-1)), &["body[0].sphere.radius = -1: must be in"]),
        (
            ball(|b| b["sphere"]["center"] = json!([0, 0, 1e9])),
            &["body[0].sphere.center = [0, 0, 1000000000]: must be numbers in"],
        ),
        (body(json!({ "capsule": { "radius": 1 } })), &["body[0].capsule.to = [0.0, 0.0, 0.0]: is where `from` is", "sphere"]),
        (body(json!({ "capsule": { "to": [0, 0, 1] } })), &["body[0].capsule.radius = 0: must be in"]),
        (body(json!({ "capsule": { "to": [0, 0, 1e6], "radius": 1 } })), &["body[0].capsule.to = [0, 0, 1000000]"]),
        (body(json!({ "box": { "size": [1, 0, 1] } })), &["body[0].box.size[1] = 0: must be in"]),
        (body(json!({ "box": { "size": [1, 1, 1], "rotate": [1e7, 0, 0] } })), &["body[0].box.rotate = [10000000, 0, 0]"]),
        (body(json!({ "box": { "size": [1, 1, 1], "center": [0, -1e6, 0] } })), &["body[0].box.center = [0, -1000000, 0]"]),
        (body(json!({ "plane": {} })), &["body[0].plane.normal = [0.0, 0.0, 0.0]: must be a direction", "try [0, 0, 1]"]),
        (body(json!({ "plane": { "normal": [0, 0, 1], "point": [1e6, 0, 0] } })), &["body[0].plane.point = [1000000, 0, 0]"]),
        (body(json!({ "mesh": "" })), &["scene.body[0].mesh: must be the path of a mesh file"]),
        (body(json!({ "mesh": "gone.obj" })), &["scene.body[0].mesh = \"gone.obj\": its geometry was not given"]),
        (figure(json!({ "scale": 0 })), &["body[0].scale = 0: must be in"]),
        (figure(json!({ "scale": 1e6 })), &["body[0].mesh: vertex 1 is at [9, 9, 9]", "then body[0].scale = 0.001"]),
        (figure(json!({ "rotate": [1e7, 0, 0] })), &["body[0].rotate = [10000000, 0, 0]"]),
        (figure(json!({ "translate": [1e7, 0, 0] })), &["body[0].translate = [10000000, 0, 0]"]),
        (ball(|b| b["translate"] = json!([0, 0, 1])), &["body[0]: has scale, rotate or translate, which are for mesh; put"]),
        (ball(|b| b["friction"] = json!(-0.1)), &["body[0].friction = -0.1: must be 0 or in [1e-20, 10]; try 0.3"]),
        (ball(|b| b["friction"] = json!(11)), &["body[0].friction = 11: must be"]),
        (ball(|b| b["thickness"] = json!(2)), &["body[0].thickness = 2: must be in [0, 1]; try 0.001"]),
        (ball(|b| b["thickness"] = json!(-1)), &["body[0].thickness = -1: must be in [0, 1]"]),
        (ball(|b| b["name"] = json!("a\nb")), &["body[0].name", "none of them a control character"]),
        (
            with(json!({ "body": [{ "sphere": { "radius": 1 } }, { "name": "body0", "sphere": { "radius": 1 } }] })),
            &["scene.body[1].name = \"body0\": already the name of body[0]; choose another"],
        ),
        (ball(|b| b["motion"] = json!("walk.npy")), &["body[0].motion = \"walk.npy\": needs mesh", "`move` and `turn`"]),
        (figure(json!({ "motion": "" })), &["body[0].motion = \"\": must be the path of an .npy or .pc2 file"]),
        (figure(json!({ "motion": "walk.npy" })), &["body[0].motion = \"walk.npy\": its places were not given"]),
        (
            figure(json!({ "motion": "walk.npy", "move": [[1, [0, 0, 1]]] })),
            &["body[0].motion = \"walk.npy\": a body with a motion has neither `move` nor `turn`; leave"],
        ),
        (
            figure(json!({ "motion": "walk.npy", "turn": { "axis": [0, 0, 1] } })),
            &["body[0].motion = \"walk.npy\": a body with a motion has neither"],
        ),
        (ball(|b| b["move"] = json!([[1, [0, 0, 0]], [1, [0, 0, 1]]])), &["body[0].move[1] = 1: times must increase"]),
        (ball(|b| b["move"] = json!([[0, [0, 0, 1]]])), &["body[0].move[0]: at time 0 a body is where its shape is; begin"]),
        (ball(|b| b["move"] = json!([[1, [0, 0, 1e7]]])), &["body[0].move[0] = [0, 0, 10000000]: must be numbers in"]),
        (ball(|b| b["turn"] = json!({ "angle": [[1, 90]] })), &["body[0].turn.axis = [0.0, 0.0, 0.0]: must be a direction"]),
        (
            ball(|b| b["turn"] = json!({ "axis": [0, 0, 1], "point": [0, 1e9, 0] })),
            &["body[0].turn.point = [0, 1000000000, 0]: must be numbers in"],
        ),
        (
            ball(|b| b["turn"] = json!({ "axis": [0, 0, 1], "angle": [[2, 90], [1, 0]] })),
            &["body[0].turn.angle[1] = 1: times must increase from keyframe to keyframe"],
        ),
        (
            ball(|b| b["turn"] = json!({ "axis": [0, 0, 1], "angle": [[-1, 90]] })),
            &["body[0].turn.angle[0] = -1: must be in [0, 1000000000]"],
        ),
        (
            ball(|b| b["turn"] = json!({ "axis": [0, 0, 1], "angle": [[0, 90]] })),
            &["body[0].turn.angle[0] = 90: at time 0 the angle is 0 degrees; begin with [0, 0]"],
        ),
        (
            ball(|b| b["turn"] = json!({ "axis": [0, 0, 1], "angle": [[1, 1e9]] })),
            &["body[0].turn.angle[0] = 1000000000: must be in [-1000000, 1000000]; try 90.0"],
        ),
        (
            body(json!({ "plane": { "normal": [0, 0, 1] }, "turn": { "axis": [0, 0, 1], "angle": [[1, 90]] } })),
            &["body[0].turn: a plane has no end and cannot turn; take a box"],
        ),
        (sweeps, &["scene.solver.filter = \"sweeps\": knows no contact, but there are bodies", "\"coarse_to_fine\""]),
        (thick, &["scene.solver.filter = \"none\": knows no contact, but cloths collide", "or set contact.self = false"]),
        (with(json!({ "contact": { "slef": true } })), &["scene.contact.slef: no such field; did you mean `self`?"]),
        (with(json!({ "contact": { "self": 1 } })), &["scene.contact.self = 1: invalid type"]),
        (cloth("thickness", 0.0), &["scene.cloth[0].thickness = 0: must be in [1e-6, 1]; try 0.001"]),
        (cloth("thickness", 2.0), &["scene.cloth[0].thickness = 2: must be in"]),
        (cloth("friction", -1.0), &["scene.cloth[0].friction = -1: must be 0 or in [1e-20, 10]; try 0.3"]),
    ];
    for (scene, expected) in cases {
        let text = build(&scene, &BTreeMap::new()).expect_err("must be refused").to_string();
        for part in expected {
            assert!(text.contains(part), "{text:?} lacks {part:?}");
        }
        assert!(text.len() < 400, "{text}");
    }
}

#[test]
fn shapes_become_vertices_and_triangles() {
    let bodies = model(&with(json!({ "body": [
        { "sphere": { "center": [1, 2, 3], "radius": 0.5 }, "friction": 0.1 },
        { "capsule": { "from": [0, 0, 1], "to": [0, 0, 2], "radius": 0.25 }, "thickness": 0.0 },
        { "plane": { "point": [0, 0, -1], "normal": [0, 3, 4] } },
        { "box": { "center": [0, 0, 5], "size": [1, 2, 4] } },
        { "name": "walker", "mesh": "figure.obj", "scale": 2.0, "rotate": [0, 0, 90], "translate": [0, 0, 7] },
    ] })))
    .bodies;
    let shapes = bodies.list.iter().map(|body| (body.shape, body.vertices.clone(), body.triangles.clone(), body.radius));
    assert_eq!(
        shapes.collect::<Vec<_>>(),
        [
            (BodyShape::Sphere, 0..1, 0..0, 0.5),
            (BodyShape::Capsule, 1..3, 0..0, 0.25),
            (BodyShape::Plane, 3..5, 0..0, 0.0),
            (BodyShape::Surface, 5..13, 0..12, 0.0),
            (BodyShape::Surface, 13..18, 12..16, 0.0),
        ]
    );
    let first: Vec<DVec3> =
        [[1.0, 2.0, 3.0], [0.0, 0.0, 1.0], [0.0, 0.0, 2.0], [0.0, 0.0, -1.0], [0.0, 0.6, -0.2]].map(DVec3::from).into();
    assert!(near(&bodies.rest[..5], &first), "{:?}", bodies.rest);
    assert_eq!((bodies.list[0].friction, bodies.list[1].thickness, bodies.list[4].name.as_str()), (0.1, 0.0, "walker"));
    assert!(near(&bodies.rest[14..16], &[DVec3::new(-18.0, 18.0, 25.0), DVec3::new(0.0, 2.0, 7.0)]), "{:?}", bodies.rest);
    let used = |range: std::ops::Range<usize>, vertices: std::ops::Range<usize>| {
        bodies.triangles[range].iter().flatten().all(|&corner| vertices.contains(&(corner as usize)))
    };
    assert!(used(0..12, 5..13) && used(12..16, 13..18));
}

#[test]
fn a_box_faces_outwards_and_has_its_size() {
    let bodies = model(&body(json!({ "box": { "center": [3, -1, 2], "size": [1, 2, 4], "rotate": [20, 50, -70] } }))).bodies;
    assert!((volume(&bodies) - 6.0 * 8.0).abs() < 1e-10, "{}", volume(&bodies));
    let centre = bodies.rest.iter().sum::<DVec3>() / 8.0;
    assert!(centre.distance(DVec3::new(3.0, -1.0, 2.0)) < 1e-12);
    for corners in &bodies.triangles {
        let [a, b, c] = corners.map(|corner| bodies.rest[corner as usize]);
        assert!((b - a).cross(c - a).dot(a - centre) > 0.0, "{corners:?}");
    }
    let mut edges: Vec<[u32; 2]> = bodies.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    edges.sort_unstable();
    edges.dedup();
    assert!(edges.len() == 36 && edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok()), "closed");
    let upright = model(&body(json!({ "box": { "size": [1, 2, 4], "rotate": [0, 0, 90] } }))).bodies;
    let (low, high) = upright.rest.iter().fold((DVec3::MAX, DVec3::MIN), |(low, high), &place| (low.min(place), high.max(place)));
    assert!(near(&[low, high], &[DVec3::new(-1.0, -0.5, -2.0), DVec3::new(1.0, 0.5, 2.0)]), "{low} to {high}");
}

#[test]
fn a_mesh_keeps_its_order_and_its_faults_are_told() {
    let mesh = MeshData { counts: vec![3, 3, 3], corners: vec![0, 1, 2, 0, 1, 3, 0, 0, 1], vertices: figure().vertices };
    let scene = common::scene(&body(json!({ "mesh": "m" })));
    let built = |mesh: MeshData| Model::build(&scene, &BTreeMap::from([("m".to_owned(), mesh)]));
    let model = built(mesh.clone()).expect("a model");
    assert_eq!(model.bodies.rest, mesh.vertices.iter().copied().map(DVec3::from_array).collect::<Vec<_>>());
    assert_eq!(model.bodies.triangles, [[0, 1, 2], [0, 3, 1]]);
    for repair in ["body0 (body[0]): 1 faces without area were left out", "body0 (body[0]): 1 faces were turned round"] {
        assert!(model.warnings.iter().any(|text| text.contains(repair)), "{:?} lacks {repair}", model.warnings);
    }
    let quad = MeshData { counts: vec![4], corners: vec![0, 2, 1, 3], ..mesh.clone() };
    assert_eq!(built(quad).expect("a model").bodies.triangles.len(), 2);
    let text = built(MeshData { counts: vec![], corners: vec![], ..mesh.clone() }).expect_err("no face").to_string();
    assert!(text.contains("scene.body[0].mesh: has no face with an area; a body needs at least one triangle"), "{text}");
    let text = built(MeshData { counts: vec![3], corners: vec![0, 1, 5], ..mesh }).expect_err("no vertex").to_string();
    assert!(text.contains("scene.body[0].mesh: a face names vertex 5; there are 5"), "{text}");
}

#[test]
fn a_model_is_told_apart_by_its_bodies() {
    let of = |scene: &Value| model(scene).fingerprint;
    let ball = |radius: f64| body(json!({ "sphere": { "radius": radius } }));
    assert_eq!(of(&ball(0.5)), of(&ball(0.5)));
    assert_ne!(of(&ball(0.5)), of(&ball(0.6)));
    assert_ne!(of(&ball(0.5)), of(&with(json!({}))));
    let scene = common::scene(&body(json!({ "mesh": "m" })));
    let built = |mesh: MeshData| Model::build(&scene, &BTreeMap::from([("m".to_owned(), mesh)])).expect("a model").fingerprint;
    let mut other = figure();
    other.vertices[1][0] += 1e-9;
    assert_ne!(built(figure()), built(other));
}

#[test]
fn bodies_without_keyframes_stay_to_the_last_bit() {
    let prepared = prepared(&body(json!({ "box": { "center": [0.1, 0.2, 0.3], "size": [1, 2, 3], "rotate": [1, 2, 3] } })));
    assert!(!prepared.inputs.bodies.any_moves() && !prepared.inputs.bodies.moves(0));
    for time in [0.0, 0.7, 1e6] {
        assert_eq!(places(&prepared, time), prepared.model.bodies.rest);
    }
}

#[test]
fn a_body_turns_about_its_line_and_then_moves() {
    let still = json!({ "sphere": { "center": [5, 5, 5], "radius": 1 } });
    let scene = with(json!({ "body": [still, {
        "capsule": { "from": [2, 1, 0], "to": [3, 1, 0.5], "radius": 0.1 },
        "turn": { "axis": [0, 0, 5], "point": [1, 1, 9], "angle": [[2, 360], [4, 360], [5, 270]] },
        "move": [[1, [0, 0, 0]], [3, [4, 0, 0]]],
    }] }));
    let prepared = prepared(&scene);
    assert!(prepared.inputs.bodies.any_moves());
    assert_eq!([0, 1].map(|body| prepared.inputs.bodies.moves(body)), [false, true]);
    assert_eq!(places(&prepared, 0.0), prepared.model.bodies.rest, "to the last bit");
    // Angle [degrees], displacement along x [m].
    for (time, angle, way) in
        [(0.5, 90.0, 0.0), (1.0, 180.0, 0.0), (1.5, 270.0, 1.0), (2.0, 0.0, 2.0), (3.5, 0.0, 4.0), (9.0, 270.0, 4.0)]
    {
        let turned = |x: f64, z: f64| match angle as u32 {
            0 => DVec3::new(1.0 + x + way, 1.0, z),
            90 => DVec3::new(1.0 + way, 1.0 + x, z),
            180 => DVec3::new(1.0 - x + way, 1.0, z),
            _ => DVec3::new(1.0 + way, 1.0 - x, z),
        };
        let found = places(&prepared, time);
        let expected = [DVec3::splat(5.0), turned(1.0, 0.0), turned(2.0, 0.5)];
        assert!(near(&found, &expected), "{time}: {found:?}, not {expected:?}");
    }
}

#[test]
fn a_whole_turn_about_a_slanted_line_leads_back() {
    let scene = body(json!({
        "box": { "center": [3, 0, 1], "size": [1, 1, 1] },
        "turn": { "axis": [1, -2, 0.5], "point": [0.3, 0.2, 0.1], "angle": [[1, 360]] },
    }));
    let prepared = prepared(&scene);
    let rest = &prepared.model.bodies.rest;
    assert!(near(&places(&prepared, 1.0), rest));
    let half = places(&prepared, 0.5);
    let (axis, point) = (DVec3::new(1.0, -2.0, 0.5).normalize(), DVec3::new(0.3, 0.2, 0.1));
    // Half a turn mirrors in the line.
    let mirrored: Vec<DVec3> = rest.iter().map(|&place| 2.0 * (point + axis * (place - point).dot(axis)) - place).collect();
    assert!(near(&half, &mirrored), "{half:?}");
}

#[test]
fn a_plane_moves_with_its_normal() {
    let scene = body(json!({ "plane": { "point": [0, 0, 1], "normal": [0, 0, 2] }, "move": [[2, [0, 1, 3]]] }));
    assert!(near(&places(&prepared(&scene), 1.0), &[DVec3::new(0.0, 0.5, 2.5), DVec3::new(0.0, 0.5, 3.5)]));
}

#[test]
fn a_mesh_follows_its_motion() {
    let scene = body(json!({ "mesh": "figure.obj", "motion": "walk.npy" }));
    for (rate, given) in [(10.0, None), (4.0, Some(4.0))] {
        let prepared = build(&scene, &walk(3, given)).expect("a model");
        let rest = prepared.model.bodies.rest.clone();
        for (frame, way) in [(0.0, 0.0), (0.25, 0.25), (1.0, 1.0), (1.5, 1.5), (2.0, 2.0), (50.0, 2.0)] {
            let expected: Vec<DVec3> = rest.iter().map(|&place| place + DVec3::Z * way).collect();
            assert!(near(&places(&prepared, frame / rate), &expected), "frame {frame}");
        }
    }
}

#[test]
fn motions_that_do_not_fit_are_refused() {
    let scene = body(json!({ "mesh": "figure.obj", "motion": "walk.npy", "name": "walker" }));
    let changed = |change: fn(&mut Followed)| {
        let mut followed = walk(3, None);
        change(followed.get_mut("walk.npy").expect("an array"));
        build(&scene, &followed).expect_err("must be refused").to_string()
    };
    let cases: Vec<(String, &[&str])> = vec![
        (
            changed(|walk| walk.vertices = 3),
            &["has places of 3 vertices in every frame, the mesh of \"walker\" has 5 vertices; give one for each"],
        ),
        (changed(|walk| walk.vertices = 0), &["has places of 0 vertices"]),
        (changed(|walk| walk.places = [].into()), &["has no frame; give at least one"]),
        (changed(|walk| walk.places = walk.places[..7].into()), &["has no frame"]),
        (changed(|walk| walk.rate = Some(0.0)), &["has 0 frames per second; must be a finite number above 0"]),
        (
            changed(|walk| walk.places = walk.places.iter().map(|place| place / (place.z - 2.0)).collect()),
            &["has vertex 4 at [NaN, NaN, inf] in frame 1; all places must be finite numbers within 1e9 m of the origin"],
        ),
        (
            changed(|walk| walk.places = walk.places.iter().map(|place| place * 1.1).collect()),
            &[
                "has vertex 1 of \"walker\" at [9.9",
                "in frame 0, but the mesh, scaled, rotated and translated, has it at [9.0, 9.0, 9.0]",
            ],
        ),
    ];
    for (text, expected) in cases {
        for part in expected.iter().chain(&["scene.body[0].motion = \"walk.npy\": "]) {
            assert!(text.contains(part), "{text:?} lacks {part:?}");
        }
        assert!(text.len() < 450, "{text}");
    }
}
