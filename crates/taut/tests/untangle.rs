//! What intersects at the start comes apart within its limit, without pops, and stays apart. What is looked at is measured here, by
//! other means than those of the engine.

use crate::common::oracle::{crossings, places};
use crate::common::{Simulation, build, crooked, scene};
use glam::DVec3;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use taut::model::MeshData;

/// A sheet of so many cells along each side, crooked but for its border; `place` takes coordinates from 0 to 1.
fn sheet(cells: u32, place: impl Fn(f64, f64) -> DVec3) -> MeshData {
    let mut mesh = crooked(cells);
    mesh.vertices.iter_mut().for_each(|vertex| *vertex = place(vertex[0], vertex[1]).into());
    mesh
}

/// A simulation of cloths with these meshes; `rest` holds the other fields of the scene.
fn simulation(mut rest: Value, cloths: &[(Value, MeshData)], threads: usize) -> Simulation {
    let mut meshes = BTreeMap::from([("shell".to_owned(), globe())]);
    let named = cloths.iter().enumerate().map(|(index, (fields, mesh))| {
        let mut cloth = json!({ "density": 0.2, "strain_limit": 0.05, "thickness": 0.004, "mesh": format!("mesh{index}") });
        fields.as_object().expect("fields").iter().for_each(|(name, value)| cloth[name] = value.clone());
        meshes.insert(format!("mesh{index}"), mesh.clone());
        cloth
    });
    rest["cloth"] = named.collect();
    Simulation::with_threads(build(&scene(&rest), &meshes).expect("a model"), threads)
}

/// A closed surface with the corners of a globe of 0.3 m.
fn globe() -> MeshData {
    let (mut mesh, (rings, sides)) = (MeshData::default(), (9, 16));
    let at = |ring: i64, side: i64| {
        let (up, around) =
            ((ring as f64 / f64::from(rings as u8 + 1) - 0.5).to_radians() * 180.0, (side as f64 * 22.5).to_radians());
        [0.3 * up.cos() * around.cos(), 0.3 * up.cos() * around.sin(), 0.3 * up.sin()]
    };
    mesh.vertices.push([0.0, 0.0, -0.3]);
    (1..=rings).for_each(|ring| (0..sides).for_each(|side| mesh.vertices.push(at(ring, side))));
    mesh.vertices.push([0.0, 0.0, 0.3]);
    let (top, vertex) = (mesh.vertices.len() as i64 - 1, |ring: i64, side: i64| 1 + ring * sides + side % sides);
    for side in 0..sides {
        mesh.corners.extend([0, vertex(0, side + 1), vertex(0, side), top, vertex(rings - 1, side), vertex(rings - 1, side + 1)]);
        mesh.counts.extend([3, 3]);
        for ring in 0..rings - 1 {
            let quad = [vertex(ring, side), vertex(ring, side + 1), vertex(ring + 1, side + 1), vertex(ring + 1, side)];
            mesh.corners.extend(quad);
            mesh.counts.push(4);
        }
    }
    mesh
}

/// Many places on all triangles of all cloths.
fn samples(run: &Simulation) -> Vec<DVec3> {
    let x = places(run);
    let parts = (0..=4).flat_map(|i| (0..=4 - i).map(move |j| (f64::from(i) / 4.0, f64::from(j) / 4.0)));
    let of = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| x[corner as usize]);
        parts.clone().map(move |(i, j)| a * i + b * j + c * (1.0 - i - j)).collect::<Vec<_>>()
    };
    run.model.triangles.iter().flat_map(of).collect()
}

/// How fast the fastest particle moved in a frame [m/s].
fn fastest(before: &[DVec3], after: &[DVec3], frame: f64) -> f64 {
    before.iter().zip(after).map(|(a, b)| a.distance(*b) / frame).fold(0.0, f64::max)
}

/// Steps one by one: within `most` frames nothing intersects any more, and then for good. Every step keeps the limit, none is faster than
/// `speed` [m/s]. Returns the frames that it took.
fn comes_apart(run: &mut Simulation, most: u64, speed: f64, is_inside: impl Fn(DVec3) -> bool) -> u64 {
    let steps = u64::from(run.model.schedule.substeps);
    let limit = run.model.cloths.iter().map(|cloth| cloth.strain_limit).fold(0.0, f64::max);
    let mut taken = None;
    let left = |run: &Simulation| crossings(run) + samples(run).into_iter().filter(|&place| is_inside(place)).count();
    assert!(left(run) > 0, "it starts without anything to do");
    for frame in 1..=most + 45 {
        let before = places(run);
        let mut told = 0;
        for _ in 0..steps {
            let report = run.steps(1);
            assert!(report.worst_stretch <= limit * (1.0 + 1e-5), "frame {frame}: stretched by {}", report.worst_stretch);
            told = report.penetrations;
        }
        let now = fastest(&before, &places(run), run.step_length() * steps as f64);
        if std::env::var_os("TAUT_TELL").is_some() {
            println!("frame {frame}: {} left, {told} told, {now:.3} m/s", left(run));
        }
        assert!(taken.is_some() || now < speed, "frame {frame}: {now} m/s");
        if taken.is_some() {
            assert_eq!((told, left(run)), (0, 0), "frame {frame}: it intersects again");
        } else if left(run) == 0 && !run.state.may_cross {
            taken = Some(frame);
        }
        if taken.is_some_and(|taken| frame >= taken + 45) {
            break;
        }
    }
    assert!(taken.is_some_and(|taken| taken <= most), "{} places are left", left(run));
    taken.unwrap_or_default()
}

const NO_WEIGHT: [f64; 3] = [0.0, 0.0, 0.0];

#[test]
fn cloth_comes_out_of_a_ball() {
    let ball = json!({ "sphere": { "center": [0.02, 0.01, 0.0], "radius": 0.3 } });
    for (gravity, height) in [(NO_WEIGHT, 0.27), ([0.0, 0.0, -9.81], 0.27), (NO_WEIGHT, 0.15)] {
        let mesh = sheet(14, |u, v| DVec3::new(0.6 * u - 0.3, 0.6 * v - 0.3, height));
        let mut run = simulation(json!({ "body": [ball], "gravity": gravity }), &[(json!({}), mesh)], 1);
        let frames = comes_apart(&mut run, 40, 3.0, |place| place.distance(DVec3::new(0.02, 0.01, 0.0)) < 0.2999);
        println!("ball, {height} m: {frames} frames");
    }
}

#[test]
fn a_tube_comes_out_of_a_capsule() {
    let body = json!([{ "capsule": { "from": [0, 0, -0.4], "to": [0, 0, 0.4], "radius": 0.15 } }]);
    let mesh = tube(32, 14, |turn, up| 0.155 + 0.02 * (3.0 * turn).sin() * (9.0 * up).cos());
    let mut run = simulation(json!({ "body": body, "gravity": NO_WEIGHT }), &[(json!({}), mesh)], 1);
    let frames = comes_apart(&mut run, 40, 2.0, |place| place.truncate().length() < 0.1499 && place.z.abs() < 0.4);
    println!("capsule: {frames} frames");
}

/// A tube of 0.5 m around the z axis.
fn tube(sides: i64, rows: i64, radius: impl Fn(f64, f64) -> f64) -> MeshData {
    let mut mesh = MeshData::default();
    for row in 0..=rows {
        for side in 0..sides {
            let (turn, up) = (side as f64 / sides as f64 * std::f64::consts::TAU, row as f64 / rows as f64);
            let radius = radius(turn, up);
            mesh.vertices.push([radius * turn.cos(), radius * turn.sin(), 0.5 * up - 0.25]);
        }
    }
    let vertex = |row: i64, side: i64| row * sides + side % sides;
    for row in 0..rows {
        for side in 0..sides {
            mesh.corners.extend([vertex(row, side), vertex(row, side + 1), vertex(row + 1, side + 1), vertex(row + 1, side)]);
            mesh.counts.push(4);
        }
    }
    mesh
}

#[test]
fn cloth_comes_out_of_boxes_and_closed_meshes() {
    let block =
        |turn: [f64; 3], size: f64| json!({ "box": { "center": [0.02, 0.01, 0.0], "size": [size, size, size], "rotate": turn } });
    let cases = [
        (block([0.0; 3], 0.4), 0.18),
        (block([0.0, 0.0, 20.0], 0.4), 0.17),
        // Its corner is 3 cm through the cloth.
        (block([45.0, 35.264, 0.0], 0.2), 0.5 * 0.2 * 3_f64.sqrt() - 0.03),
        (json!({ "mesh": "shell" }), 0.27),
    ];
    for (body, height) in cases {
        let is_box = body["box"].is_object();
        let turn: [f64; 3] = serde_json::from_value(body["box"]["rotate"].clone()).unwrap_or_default();
        let (turn, half) = (taut::geometry::turn(turn).inverse(), 0.4999 * body["box"]["size"][0].as_f64().unwrap_or_default());
        let mesh = sheet(14, |u, v| DVec3::new(0.6 * u - 0.3, 0.6 * v - 0.3, height));
        let mut run = simulation(json!({ "body": [body], "gravity": NO_WEIGHT }), &[(json!({}), mesh)], 1);
        let frames = comes_apart(&mut run, 40, 2.0, |place| {
            let own = (turn * (place - DVec3::new(0.02, 0.01, 0.0))).abs();
            if is_box { own.max_element() < half } else { place.length() < 0.28 }
        });
        println!("{body}: {frames} frames");
    }
}

#[test]
fn cloth_behind_a_plane_comes_in_front_of_it() {
    let body = json!([{ "plane": { "point": [0, 0, 0], "normal": [0, 0.6, 0.8] } }]);
    let mesh = sheet(10, |u, v| DVec3::new(u - 0.5, v - 0.5, 0.03 * (7.0 * u).sin() - 0.75 * (v - 0.5)));
    let mut run = simulation(json!({ "body": body }), &[(json!({}), mesh)], 1);
    let frames = comes_apart(&mut run, 40, 3.0, |place| place.dot(DVec3::new(0.0, 0.6, 0.8)) < -1e-5);
    println!("plane: {frames} frames");
}

/// How much higher the second of two cloths is, mean of its vertices [m].
fn above(run: &Simulation) -> f64 {
    let x = places(run);
    let [one, other] = [0, 1].map(|cloth: usize| {
        let cloth = &run.model.cloths[cloth];
        x[cloth.particles()].iter().map(|place| place.z).sum::<f64>() / cloth.count as f64
    });
    other - one
}

#[test]
fn layers_part_as_they_are_told() {
    let flat = sheet(16, |u, v| DVec3::new(0.5 * u, 0.5 * v, 0.0));
    let wavy =
        |low: f64| sheet(15, move |u, v| DVec3::new(0.5 * u - 0.01, 0.5 * v + 0.01, low + 0.006 * (9.0 * u + 4.0 * v).sin()));
    for (layers, low, up) in [([0, 1], 0.002, true), ([0, 0], 0.003, true), ([0, 0], -0.003, false), ([1, 0], -0.002, false)] {
        let cloths = [(json!({ "layer": layers[0] }), flat.clone()), (json!({ "layer": layers[1] }), wavy(low))];
        let mut run = simulation(json!({ "gravity": NO_WEIGHT }), &cloths, 1);
        let frames = comes_apart(&mut run, 60, 2.0, |_| false);
        let above = above(&run);
        println!("layers {layers:?}: {frames} frames, {above} m");
        assert!(if up { above > 0.002 } else { above < -0.002 }, "{layers:?}: {above}");
    }
}

#[test]
fn of_two_tubes_on_a_body_the_outer_layer_comes_outside() {
    let body = json!([{ "capsule": { "from": [0, 0, -0.4], "to": [0, 0, 0.4], "radius": 0.14 } }]);
    let round = tube(30, 14, |_, _| 0.15);
    let wavy = tube(31, 13, |turn, up| 0.1505 + 0.006 * (4.0 * turn).sin() * (7.0 * up).cos());
    for layers in [[0, 1], [1, 0]] {
        let cloths = [(json!({ "layer": layers[0] }), round.clone()), (json!({ "layer": layers[1] }), wavy.clone())];
        let mut run = simulation(json!({ "body": body, "gravity": NO_WEIGHT }), &cloths, 1);
        let frames = comes_apart(&mut run, 60, 2.0, |place| place.truncate().length() < 0.1399);
        println!("tubes {layers:?}: {frames} frames");
        let x = places(&run);
        let [one, other] = [0, 1].map(|cloth: usize| {
            let cloth = &run.model.cloths[cloth];
            x[cloth.particles()].iter().map(|place| place.truncate().length()).sum::<f64>() / cloth.count as f64
        });
        assert_eq!(other > one, layers[1] > layers[0], "{one} m, {other} m");
    }
}

/// A sheet folded over, whose upper half dips through the lower one at its corner and at a wave.
fn folded() -> MeshData {
    sheet(20, |u, v| {
        let (u, v) = (0.6 * u, 0.6 * v - 0.3);
        let (bend, half) = (0.012, 0.3 - 0.012 * std::f64::consts::FRAC_PI_2);
        if u < half {
            return DVec3::new(u, v, 0.0);
        }
        let turn = (u - half) / bend;
        if turn < std::f64::consts::PI {
            return DVec3::new(half + bend * turn.sin(), v, bend * (1.0 - turn.cos()));
        }
        let back = u - half - bend * std::f64::consts::PI;
        DVec3::new(half - back, v, 2.0 * bend - 0.25 * (back - 0.1).max(0.0) * (0.5 + 1.6 * v).max(0.0))
    })
}

#[test]
fn cloth_that_crosses_itself_comes_apart() {
    let mut run = simulation(json!({ "gravity": NO_WEIGHT }), &[(json!({}), folded())], 1);
    // How long that takes is chance: 16 folds that differ in their depth took 21 to 136 frames.
    let frames = comes_apart(&mut run, 150, 2.0, |_| false);
    println!("itself: {frames} frames");
}

#[test]
fn sizes_do_not_matter() {
    for size in [0.1, 1.0, 10.0] {
        let ball = json!({ "sphere": { "center": [0.0, 0.0, 0.0], "radius": 0.3 * size } });
        let mesh = sheet(14, |u, v| DVec3::new(0.6 * u - 0.3, 0.6 * v - 0.31, 0.27) * size);
        let mut run =
            simulation(json!({ "body": [ball], "gravity": NO_WEIGHT }), &[(json!({ "thickness": 0.004 * size }), mesh)], 1);
        let frames = comes_apart(&mut run, 40, 3.0 * size, |place| place.length() < 0.2999 * size);
        println!("{size} m: {frames} frames");
    }
}

#[test]
fn bits_do_not_depend_on_threads() {
    let hash = |threads: usize| {
        let body = json!([{ "sphere": { "center": [0.1, 0.1, -0.28], "radius": 0.3 } }]);
        let flat = sheet(34, |u, v| DVec3::new(0.5 * u, 0.5 * v, 0.0));
        let wavy = sheet(20, |u, v| DVec3::new(0.5 * u, 0.5 * v + 0.01, 0.006 * (9.0 * u + 4.0 * v).sin()));
        let cloths = [(json!({}), flat), (json!({ "layer": 1 }), wavy)];
        let mut run = simulation(json!({ "body": body }), &cloths, threads);
        assert!(run.steps(20).penetrations > 0 || !run.state.may_cross);
        run.state.hash()
    };
    let one = hash(1);
    assert_eq!((hash(2), hash(8)), (one, one));
}

#[test]
fn a_clean_start_is_looked_at_once_and_goes_on_as_without() {
    let hash = |untangle: bool| {
        let body = json!([{ "sphere": { "center": [0.3, 0.3, -0.33], "radius": 0.3 } }]);
        let mesh = sheet(12, |u, v| DVec3::new(0.6 * u, 0.6 * v, 0.0));
        let mut run = simulation(json!({ "body": body, "contact": { "untangle": untangle } }), &[(json!({}), mesh)], 1);
        assert_eq!(run.state.may_cross, untangle);
        run.steps(30);
        assert!(!run.state.may_cross);
        run.state.hash()
    };
    assert_eq!(hash(true), hash(false));
}

#[test]
fn a_snapshot_goes_on_to_the_same_bits() {
    let start = || {
        let mesh = sheet(12, |u, v| DVec3::new(0.6 * u - 0.3, 0.6 * v - 0.3, 0.26));
        let body = json!([{ "sphere": { "center": [0, 0, 0], "radius": 0.3 } }]);
        simulation(json!({ "body": body }), &[(json!({}), mesh)], 1)
    };
    let mut run = start();
    run.steps(2);
    let bytes = run.state.to_bytes(&run.model, &run.inputs.grips);
    let mut other = start();
    other.state = taut::state::State::from_bytes(&bytes, &other.model).expect("a snapshot").0;
    assert!(other.state == run.state && run.state.may_cross);
    run.steps(20);
    other.steps(20);
    assert!(other.state == run.state);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn cloth_comes_out_of_random_bodies(
        kind in 0_usize..3,
        aside in prop::array::uniform2(-0.1_f64..0.1),
        size in 0.1_f64..0.2,
        turn in prop::array::uniform3(0.0_f64..90.0),
        depth in 0.003_f64..0.03,
        thickness in 0.001_f64..0.006,
    ) {
        let turned = taut::geometry::turn(turn);
        // The highest place of the body is so deep above the cloth.
        let (body, high): (Value, f64) = match kind {
            0 => (json!({ "sphere": { "center": [aside[0], aside[1], 0], "radius": size } }), size),
            1 => {
                let along = turned * DVec3::new(0.2, 0.0, 0.0);
                let end = |sign: f64| (along * sign + DVec3::new(aside[0], aside[1], 0.0)).to_array();
                (json!({ "capsule": { "from": end(1.0), "to": end(-1.0), "radius": 0.5 * size } }), along.z.abs() + 0.5 * size)
            }
            _ => {
                let corner = |bits: u32| {
                    let part = |bit: u32| if bits >> bit & 1 == 1 { size } else { -size };
                    (turned * DVec3::new(part(0), part(1), part(2))).z
                };
                let (high, edge) = ((0..8).map(corner).fold(0.0, f64::max), 2.0 * size);
                (json!({ "box": { "center": [aside[0], aside[1], 0], "size": [edge, edge, edge], "rotate": turn } }), high)
            }
        };
        let mesh = sheet(14, |u, v| DVec3::new(0.6 * u - 0.3, 0.6 * v - 0.3, high - depth));
        let mut run = simulation(json!({ "body": [body], "gravity": NO_WEIGHT }), &[(json!({ "thickness": thickness }), mesh)], 1);
        if crossings(&run) > 0 || run.model.warnings.iter().any(|text| text.contains(" at the start")) {
            run.steps(60);
            prop_assert!(!run.state.may_cross, "{} left of {body}", crossings(&run));
            prop_assert_eq!(crossings(&run), 0);
        }
    }
}
