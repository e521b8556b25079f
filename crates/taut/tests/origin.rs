//! Cloth far from the origin of the world moves as it does near it.

use std::collections::BTreeMap;

use crate::common::{Simulation, build, chain_links, crooked, network, scene, sheet, worst};
use glam::DVec3;
use serde_json::{Value, json};
use taut::model::MeshData;
use taut::state::State;
use taut::step::{Work, inspect};

/// More than rounding to single precision explains.
const ROUNDING: f64 = 1e-5;

/// A run for a second of one cloth; the mesh is that of the cloth if it asks for one.
fn second(cloth: &Value, mesh: &MeshData, wind: &Value) -> Simulation {
    let mut document = json!({ "fps": 60.0, "cloth": [cloth] });
    if !wind.is_null() {
        document["wind"] = wind.clone();
    }
    let meshes = BTreeMap::from([("mesh".to_owned(), mesh.clone())]);
    let mut run = Simulation::of(build(&scene(&document), &meshes).expect("a model"));
    let mut cuts = 0;
    for _ in 0..60 {
        cuts += run.steps(u64::from(run.model.schedule.substeps)).cuts;
        assert!(worst(&run.model, &run.state) <= 1.0 + ROUNDING);
    }
    assert_eq!(cuts, 0, "steps are not cut");
    run
}

fn places(run: &Simulation) -> Vec<DVec3> {
    (0..run.model.particle_count()).map(|particle| run.state.place(0, particle)).collect()
}

/// The mean of all places [m].
fn middle(run: &Simulation) -> DVec3 {
    places(run).iter().sum::<DVec3>() / run.model.particle_count() as f64
}

/// The largest distance of two runs, one of which is `way` off [m].
fn apart(one: &Simulation, other: &Simulation, way: DVec3) -> f64 {
    places(one).iter().zip(places(other)).map(|(a, b)| (b - way - *a).length()).fold(0.0, f64::max)
}

/// 20 links of 1 cm that fall from the level, held at one end, at a distance [m].
fn chain(way: DVec3) -> Value {
    let points: Vec<[f64; 3]> = (0..=20).map(|link| (way + DVec3::X * 0.01 * f64::from(link)).to_array()).collect();
    let mut cloth = network(&points, &chain_links(20), 1e-3);
    (cloth["strain_limit"], cloth["pins"]) = (json!(0.01), json!([{ "vertices": [0] }]));
    cloth
}

#[test]
fn a_chain_at_a_hundred_kilometres_swings_as_at_home() {
    let still = Value::Null;
    let home = second(&chain(DVec3::ZERO), &MeshData::default(), &still);
    assert!(home.state.place(0, 20).z < -0.05, "it swings");
    // 0.01 m is no whole number of bits: the points themselves are rounded, to 1e-11 m.
    let way = DVec3::new(99_999.0, -99_999.5, 0.0);
    let away = second(&chain(way), &MeshData::default(), &still);
    assert!(apart(&home, &away, way) < 1e-4 * 0.2, "{}", apart(&home, &away, way));
    // What is put there as a whole is the same to the last bit.
    let mut placed = chain(DVec3::ZERO);
    placed["translate"] = json!(way.to_array());
    let placed = second(&placed, &MeshData::default(), &still);
    assert_eq!(placed.state.positions, home.state.positions);
    assert_eq!(placed.state.origins, [way]);
}

#[test]
fn a_sheet_at_a_kilometre_falls_as_at_home() {
    let cloth = |origin: [f64; 3]| {
        let mut cloth = sheet([100, 100], 0.01, json!([{ "corner": "top-left" }]));
        cloth["grid"]["origin"] = json!(origin);
        cloth
    };
    // The air turns, and comes in gusts, where the cloth is.
    let wind = |way: DVec3| {
        json!({
            "velocity": [3.0, 0.0, 2.0],
            "elements": [
                { "kind": "vortex", "centre": (way + DVec3::new(0.5, 0.5, 0.0)).to_array(), "axis": [1, 0, 0], "circulation": 2.0, "core": 0.2 },
                { "kind": "source", "centre": (way - DVec3::Z).to_array(), "flow": 3.0, "core": 0.2 },
            ],
        })
    };
    let home = second(&cloth([0.0; 3]), &MeshData::default(), &wind(DVec3::ZERO));
    assert!((middle(&home) - DVec3::new(0.5, 0.5, 0.0)).length() > 0.1, "{}", middle(&home));
    for way in [DVec3::new(1024.0, 0.0, -2.0), DVec3::new(1000.123, 77.7, -3.3), DVec3::new(99_998.3, -99_998.0, 1e5)] {
        let away = second(&cloth(way.to_array()), &MeshData::default(), &wind(way));
        assert_eq!(away.state.positions, home.state.positions, "{way}");
        let energy = |run: &Simulation| {
            inspect(&run.model, &run.state, &run.model.inputs, &mut Work::new(&run.model, &run.model.schedule, 1))
                .potential_energy
        };
        let particles = &home.model.particles;
        let free = particles.mass.iter().zip(&particles.inverse_mass).filter(|(_, weight)| **weight > 0.0);
        let lifted = free.map(|(mass, _)| f64::from(*mass)).sum::<f64>() * 9.81 * way.z;
        let found = energy(&away) - energy(&home);
        assert!((found / lifted - 1.0).abs() < 1e-6, "{found} J, not {lifted} J");
    }
}

#[test]
fn a_mesh_of_a_centimetre_at_twenty_kilometres_falls_as_at_home() {
    // Edges of 1 cm; the file has the coordinates of the world.
    let at = |way: DVec3| {
        let mut mesh = crooked(24);
        for vertex in &mut mesh.vertices {
            // Whole multiples of 2^-20 m, so that 20 km more are exact.
            *vertex = vertex.map(|part| (part * 0.24 * f64::from(1 << 20)).round() / f64::from(1 << 20));
            *vertex = (DVec3::from_array(*vertex) + way).to_array();
        }
        mesh
    };
    let cloth =
        json!({ "mesh": "mesh", "density": 0.2, "strain_limit": 0.01, "bending": 1e-6, "pins": [{ "vertices": [0, 24] }] });
    let home = second(&cloth, &at(DVec3::ZERO), &Value::Null);
    for way in [DVec3::new(20_000.0, -20_000.0, 512.0), DVec3::new(12.5, 20_000.5, 0.0)] {
        let away = second(&cloth, &at(way), &Value::Null);
        assert_eq!(away.state.positions, home.state.positions, "{way}");
    }
    // Coordinates that are rounded anew, by 1e-8 m. The coarse-to-fine filter magnifies any difference to some millimetres within a
    // second, at home too; these do not.
    let mut calm = cloth.clone();
    calm["pins"] = json!([{ "vertices": (0..25).map(|i| 25 * 24 + i).collect::<Vec<u32>>() }]);
    let hanging = |way: DVec3| {
        let mut mesh = at(DVec3::ZERO);
        for vertex in &mut mesh.vertices {
            let [x, y, z] = *vertex;
            *vertex = [x + way.x, 0.28 * y - z + way.y, 0.96 * y + way.z];
        }
        mesh
    };
    let way = DVec3::new(20_000.123, 1.0 / 3.0, -7.7);
    for filter in ["none", "sweeps"] {
        let [home, away] = [DVec3::ZERO, way].map(|way| {
            let meshes = BTreeMap::from([("mesh".to_owned(), hanging(way))]);
            let document = json!({ "fps": 60.0, "cloth": [calm], "solver": { "filter": filter } });
            let mut run = Simulation::of(build(&scene(&document), &meshes).expect("a model"));
            run.steps(60 * u64::from(run.model.schedule.substeps));
            run
        });
        assert!(apart(&home, &away, way) < 1e-5 * 0.24, "{filter}: {}", apart(&home, &away, way));
    }
}

#[test]
fn cloth_that_is_carried_a_kilometre_stays_within_its_limit() {
    // 1 km in 10 s, at 112 m/s.
    let carried = |way: f64| {
        let mut cloth = sheet([16, 16], 0.05, json!([{ "edge": "top", "move": [[10.0, [way, 0.5 * way, 0.0]]] }]));
        (cloth["grid"]["axes"], cloth["air_drag"], cloth["damping"]) = (json!(["x", "z"]), json!(0.0), json!(0.05));
        let mut run = Simulation::new(&json!({ "fps": 60.0, "cloth": [cloth] }));
        let frame = u64::from(run.model.schedule.substeps);
        let mut cuts = 0;
        for _ in 0..720 {
            cuts += run.steps(frame).cuts;
            assert!(worst(&run.model, &run.state) <= 1.0 + ROUNDING);
        }
        assert_eq!(cuts, 0);
        run
    };
    let run = carried(1000.0);
    let pin = run.model.pins[0].particles[0] as usize;
    assert!((run.state.place(0, pin) - DVec3::new(1000.0, 500.0, 1.0)).length() < 1e-6, "{}", run.state.place(0, pin));
    assert!(run.state.origins[0].x > 990.0 && run.state.positions.x.iter().all(|x| x.abs() < 4.0));
    // The state goes on from its bytes, and from its places in the world.
    let (again, _) = State::from_bytes(&run.state.to_bytes(&run.model, &Default::default()), &run.model).expect("a state");
    assert_eq!(again, run.state);
    assert_eq!(again.hash(), run.state.hash());
    let world =
        State::in_world(&run.model, |particle| run.state.place(0, particle), run.state.velocities.clone(), run.state.clock);
    let off =
        (0..run.model.particle_count()).map(|at| (world.place(0, at) - run.state.place(0, at)).length()).fold(0.0, f64::max);
    assert!(off < 1e-6, "{off}");
    let mut rows = vec![[0.0; 3]; run.model.particle_count()];
    run.state.write_places(&run.model, &mut rows, &run.work.pool());
    assert_eq!(rows[pin], [1000.0, 500.0, 1.0]);
}

#[test]
fn vertices_that_are_too_far_away_are_refused_by_name() {
    let mut mesh = crooked(2);
    mesh.vertices[3] = [2e4, 0.0, -3e3];
    let cloth = json!({ "mesh": "mesh", "scale": 10.0, "density": 0.2 });
    let meshes = BTreeMap::from([("mesh".to_owned(), mesh)]);
    let error = build(&scene(&json!({ "cloth": [cloth] })), &meshes).expect_err("is too far away").to_string();
    assert!(error.contains("cloth[0].mesh") && error.contains("vertex 3 is at [20000, 0, -3000], times scale = 10"), "{error}");
    let cloth = json!({ "grid": { "cells": [2, 2] }, "translate": [0.0, 2e5, 0.0] });
    let error = taut::scene::Scene::from_json(&json!({ "cloth": [cloth] }).to_string()).expect_err("is too far away").to_string();
    assert!(error.contains("cloth[0].translate = [0, 200000, 0]: must be numbers in [-100000, 100000]"), "{error}");
}
