//! The filters that others have published, against what is known of them in closed form.

use std::collections::BTreeMap;

use crate::common::{self, Simulation, chain_links, model, network, scene, scene_of};
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use taut::filter::{Filter, apply};
use taut::geometry::Pool;
use taut::model::{MeshData, Model};
use taut::scene::Scene;
use taut::state::State;

const G: f64 = 9.81;

/// A row of points 1 m apart on the x axis, limit 10 %, first moved to `places`, then limited once.
fn row(filter: &str, places: &[f32], masses: &[f64], pinned: &[u32]) -> (Vec<f32>, Vec<f32>) {
    let points: Vec<[f64; 3]> = (0..places.len()).map(|point| [point as f64, 0.0, 0.0]).collect();
    let mut cloth = network(&points, &chain_links(places.len() as u32 - 1), 0.1);
    cloth["network"]["mass"] = json!(masses);
    cloth["pins"] = if pinned.is_empty() { json!([]) } else { json!([{ "vertices": pinned }]) };
    let mut scene = scene_of(cloth, 1, filter, 0.0);
    if filter == "fast_projection" {
        scene["solver"]["iterations"] = json!(1);
    }
    let mut run = Simulation::new(&scene);
    places.iter().enumerate().for_each(|(point, &x)| run.state.positions.x[point] = x);
    run.steps(1);
    (run.state.positions.x, run.state.velocities.x)
}

fn close(found: &[f32], expected: &[f32]) {
    let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 2e-5 * (1.0 + b.abs()));
    assert!(near, "{found:?} instead of {expected:?}");
}

#[test]
fn provot_moves_two_free_ends_by_half_whatever_they_weigh_and_a_held_one_not_at_all() {
    // 1.3 m, allowed are 1.1 m: 0.2 m too much, in a step of 1/60 s.
    let (places, velocities) = row("provot", &[0.0, 1.3], &[0.1, 0.5], &[]);
    close(&places, &[0.1, 1.2]);
    close(&velocities, &[6.0, -6.0]);
    let (places, velocities) = row("provot", &[0.0, 1.3], &[0.1, 0.5], &[0]);
    close(&places, &[0.0, 1.1]);
    close(&velocities, &[0.0, -12.0]);
}

#[test]
fn provot_over_stretches_the_neighbour_of_a_mended_spring() {
    // The second spring is 0.4 m too long; half of that goes to the first, which was at its limit and is not looked at again.
    let (places, _) = row("provot", &[0.0, 1.1, 2.6], &[0.1; 3], &[0]);
    close(&places, &[0.0, 1.3, 2.4]);
}

#[test]
fn a_rod_keeps_its_length_both_ways_and_its_centre_of_mass() {
    for length in [1.3_f32, 0.4] {
        // u weighs a third of v: it takes three quarters of the way.
        let (places, velocities) = row("rods", &[0.0, length], &[0.1, 0.3], &[]);
        let excess = length - 1.0;
        close(&places, &[0.75 * excess, length - 0.25 * excess]);
        close(&velocities, &[45.0 * excess, -15.0 * excess]);
    }
}

#[test]
fn an_iteration_of_fast_projection_is_herons_for_a_single_thread() {
    // Newton's method on |P|^2 = L^2 along P: the length l becomes (l^2 + L^2) / 2 l.
    for length in [1.2_f32, 0.8] {
        let (places, _) = row("fast_projection", &[0.0, length], &[0.1, 0.3], &[0]);
        close(&places, &[0.0, 0.5 * (length + 1.0 / length)]);
    }
}

#[test]
fn fast_projection_keeps_warp_and_weft_within_its_tolerance_on_grids_and_quads() {
    let pins = json!([{ "nearest": [0.0, 0.0, 0.0] }]);
    let cloth = json!({ "density": 0.2, "fabric": "cotton", "strain_limit": 0.001, "pins": pins });
    let mut grid = cloth.clone();
    grid["grid"] = json!({ "size": [1.0, 1.0], "cells": [12, 12], "axes": ["x", "y"] });
    let mut quads = MeshData::default();
    for index in 0..169_i64 {
        quads.vertices.push([(index % 13) as f64 / 12.0, (index / 13) as f64 / 12.0, 0.0]);
        if index % 13 < 12 && index / 13 < 12 {
            quads.corners.extend([index, index + 1, index + 14, index + 13]);
            quads.counts.push(4);
        }
    }
    let mut mesh = cloth;
    mesh["mesh"] = json!("mesh");
    for cloth in [grid, mesh] {
        let scene = scene(&json!({ "cloth": [cloth], "solver": { "filter": "fast_projection" } }));
        let model = common::build(&scene, &BTreeMap::from([("mesh".to_owned(), quads.clone())])).expect("quads do not lock");
        let mut run = Simulation::of(model);
        for _ in 0..45 * run.model.schedule.substeps {
            run.steps(1);
            let off = furthest_off(&run.model, &run.state);
            assert!(off < 0.001 + 1e-5, "a thread is off its length by {off}");
        }
        let lowest = run.state.positions.z.iter().copied().fold(0.0, f32::min);
        assert!(lowest < -0.7, "has fallen to {lowest} m only");
    }
}

/// Largest ||X_uv| / L - 1| of the structural springs.
fn furthest_off(model: &Model, state: &State) -> f64 {
    let springs = &model.springs;
    let structural = (0..springs.type1).filter(|&spring| springs.kind[spring] == taut::model::SpringKind::Structural);
    let off = structural.map(|spring| {
        let [u, v] = springs.ends[spring].map(|end| state.positions.get(end as usize).as_dvec3());
        (u.distance(v) / f64::from(springs.rest[spring]) - 1.0).abs()
    });
    off.fold(0.0, f64::max)
}

/// Flat cloth of irregular triangles: a grid of `cells` by `cells` with its inner points moved about and one diagonal a cell.
fn irregular(cells: usize) -> MeshData {
    let mut mesh = MeshData::default();
    let side = cells + 1;
    for index in 0..side * side {
        let (i, j) = (index % side, index / side);
        let inside = i > 0 && i < cells && j > 0 && j < cells;
        let shift = |salt: f64| if inside { 0.2 * (index as f64 * salt).sin() } else { 0.0 };
        mesh.vertices.push([(i as f64 + shift(12.9898)) / cells as f64, (j as f64 + shift(78.233)) / cells as f64, 0.0]);
        if i < cells && j < cells {
            let [a, b, c, d] = [index, index + 1, index + side + 1, index + side].map(|corner| corner as i64);
            mesh.corners.extend([a, b, c, a, c, d]);
            mesh.counts.extend([3, 3]);
        }
    }
    mesh
}

#[test]
fn a_tether_is_as_long_as_the_way_along_the_cloth() {
    // Flat cloth: the way is the straight line to the nearest pin, whatever the triangles; an arc of pins is one place.
    let arc: Vec<u32> = (0..6).map(|step| 5 * 21 + 3 + step).chain([6 * 21 + 8, 7 * 21 + 8]).collect();
    let cloth = json!({ "strain_limit": 0.05, "stiffness": 0.0, "damping": 0.0, "pins": [{ "vertices": arc }] });
    let mut scene = json!({ "cloth": [cloth], "gravity": [0, 0, 0], "solver": { "filter": "tethers", "substeps": 1 } });
    scene["cloth"][0]["mesh"] = json!("mesh");
    let meshes = BTreeMap::from([("mesh".to_owned(), irregular(20))]);
    let model = common::build(&common::scene(&scene), &meshes).expect("a model");
    let arc: Vec<u32> = arc.iter().map(|&vertex| model.numbering.particle(vertex)).collect();
    let rest = |particle: u32| model.particles.rest.get(particle as usize).as_dvec3();
    let mut run = Simulation::of(common::build(&common::scene(&scene), &meshes).expect("a model"));
    // All is far above the pins, so that every tether is taut.
    for particle in (0..441).filter(|particle| !arc.contains(particle)) {
        run.state.positions.set(particle as usize, rest(particle).as_vec3() + Vec3::Z * 10.0);
    }
    run.steps(1);
    for particle in (0..441).filter(|particle| !arc.contains(particle)) {
        let straight = arc.iter().map(|&pin| rest(pin).distance(rest(particle))).fold(f64::INFINITY, f64::min);
        let end = run.state.place(0, particle as usize);
        let reached = arc.iter().map(|&pin| end.distance(rest(pin))).fold(f64::INFINITY, f64::min);
        // Never shorter, or the cloth could not lie flat; crooked triangles make it a little longer.
        let part = reached / straight / 1.05;
        assert!(part > 1.0 - 1e-4 && part < 1.005, "{particle}: {reached} m, straight {straight} m");
    }
}

#[test]
fn a_tether_follows_bent_cloth_and_its_moving_pin() {
    // A strip folded by a right angle halfway: the far end is 1 m along the cloth from the pin, 0.71 m through the air.
    let mesh = MeshData {
        vertices: vec![[0.0, 0.0, 0.5], [0.2, 0.0, 0.5], [0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.0, 0.5, 0.0], [0.2, 0.5, 0.0]],
        corners: vec![0, 1, 3, 2, 2, 3, 5, 4],
        counts: vec![4, 4],
    };
    let pins = json!([{ "vertices": [0, 1], "move": [[1.0, [0.0, 0.0, 6.0]]] }]);
    let cloth = json!({ "strain_limit": 0.1, "stiffness": 0.0, "damping": 0.0, "air_drag": 0.0, "pins": pins });
    let mut scene = json!({ "cloth": [cloth], "gravity": [0, 0, 0], "solver": { "filter": "tethers", "substeps": 1 } });
    scene["cloth"][0]["mesh"] = json!("mesh");
    let model = common::build(&common::scene(&scene), &BTreeMap::from([("mesh".to_owned(), mesh)])).expect("a model");
    let mut run = Simulation::of(model);
    for _ in 0..60 {
        run.steps(1);
        let apart = run.state.positions.get(0).distance(run.state.positions.get(4));
        assert!(apart < 1.1 + 1e-4, "{apart} m");
    }
    let apart = run.state.positions.get(0).distance(run.state.positions.get(4));
    assert!((apart - 1.1).abs() < 1e-4, "a cloth that is dragged along hangs {apart} m behind");
}

#[test]
fn a_compliant_spring_gives_f_over_k_whatever_the_steps_and_the_passes() {
    for (substeps, iterations) in [(2, 1), (8, 1), (32, 1), (2, 7), (8, 50)] {
        let (mass, stiffness) = (0.05, 12.0);
        let mut cloth = network(&[[0.0; 3], [0.0, 0.0, -1.0]], &[[0, 1]], mass);
        (cloth["stiffness"], cloth["air_drag"]) = (json!(stiffness), json!(8.0));
        cloth["pins"] = json!([{ "vertices": [0] }]);
        let mut scene = scene_of(cloth, substeps, "xpbd", G);
        scene["solver"]["iterations"] = json!(iterations);
        let mut run = Simulation::new(&scene);
        let report = run.steps(u64::from(substeps) * 600).last;
        let extension = f64::from(-run.state.positions.z[1]) - 1.0;
        let expected = mass * G / stiffness;
        assert!(expected < 0.1, "within the limit");
        assert!((extension / expected - 1.0).abs() < 1e-3, "{substeps}, {iterations}: {extension} m instead of {expected} m");
        // The spring has left the forces, not the energy.
        assert!((report.elastic_energy / (0.5 * stiffness * expected * expected) - 1.0).abs() < 3e-3);
    }
}

#[test]
fn a_compliant_spring_has_the_period_of_its_mass_and_stiffness_and_is_rigid_at_its_limit() {
    let (mass, stiffness) = (0.05, 20.0);
    let mut cloth = network(&[[0.0; 3], [0.0, 0.0, 1.0]], &[[0, 1]], mass);
    cloth["stiffness"] = json!(stiffness);
    cloth["pins"] = json!([{ "vertices": [0] }]);
    let mut run = Simulation::new(&scene_of(cloth, 200, "xpbd", 0.0));
    // 1 m/s would reach 5 cm, the limit is 10 cm; 5 m/s would reach 25 cm.
    run.state.velocities.set(1, Vec3::new(0.0, 0.0, 1.0));
    let mut sides = Vec::new();
    for step in 0..200 * 30 {
        let before = run.state.positions.z[1] - 1.0;
        run.steps(1);
        let after = run.state.positions.z[1] - 1.0;
        if before > 0.0 && after <= 0.0 {
            sides.push(f64::from(step) * run.step_length());
        }
    }
    let period = sides[1] - sides[0];
    let expected = std::f64::consts::TAU * (mass / stiffness).sqrt();
    assert!((period / expected - 1.0).abs() < 0.005, "period {period} s instead of {expected} s");
    run.state.positions.z[1] = 1.0;
    run.state.velocities.set(1, Vec3::new(0.0, 0.0, 5.0));
    let largest = (0..600).map(|_| run.steps(1).worst_stretch).fold(0.0, f64::max);
    assert!((largest - 0.1).abs() < 1e-5, "reaches {largest}");
}

fn refusal(cloth: &Value, filter: &str, mesh: MeshData) -> String {
    let scene = json!({ "cloth": [cloth], "solver": { "filter": filter } });
    let meshes = BTreeMap::from([("mesh".to_owned(), mesh)]);
    let built = Scene::from_json(&scene.to_string()).and_then(|scene| common::build(&scene, &meshes));
    built.expect_err("must be refused").to_string()
}

#[test]
fn what_a_filter_cannot_do_is_refused_with_the_reason() {
    let cape = json!({ "name": "cape", "mesh": "mesh", "pins": [{ "vertices": [0] }] });
    for filter in ["rods", "fast_projection"] {
        let text = refusal(&cape, filter, irregular(20));
        for part in [&format!("scene.solver.filter = \"{filter}\": cloth[0] (cape) would lock"), "quads", "coarse_to_fine"] {
            assert!(text.contains(part), "{text:?} lacks {part:?}");
        }
        // A strip of triangles can bend at each of its edges.
        let strip = MeshData {
            vertices: (0..20).map(|index| [0.5 * f64::from(index), f64::from(index % 2), 0.0]).collect(),
            corners: (0..18).flat_map(|index| [index, index + 1, index + 2]).collect(),
            counts: vec![3; 18],
        };
        let mut scene = json!({ "cloth": [cape], "solver": { "filter": filter } });
        scene["cloth"][0]["pins"] = json!([]);
        assert!(common::build(&common::scene(&scene), &BTreeMap::from([("mesh".to_owned(), strip)])).is_ok());
    }
    let loose = json!({ "name": "sheet", "grid": { "cells": [4, 4] } });
    let text = refusal(&loose, "tethers", MeshData::default());
    assert!(text.contains("scene.solver.filter = \"tethers\": cloth[0] (sheet) has no pin"), "{text}");
    // A piece that no pin holds is told of.
    let mut cloth = network(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]], &[[0, 1], [2, 3]], 0.1);
    cloth["pins"] = json!([{ "vertices": [0] }]);
    let model = model(&scene_of(cloth, 4, "tethers", G));
    assert!(model.warnings.iter().any(|text| text.contains("2 vertices are tied to no pin")), "{:?}", model.warnings);
}

#[test]
fn rods_fast_projection_and_compliant_springs_keep_momentum() {
    // A free dumbbell net under no forces: momentum stays.
    for filter in ["rods", "fast_projection", "xpbd"] {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let mut cloth = network(&points, &[[0, 1], [1, 2], [2, 3], [3, 0]], 0.1);
        cloth["network"]["mass"] = json!([0.1, 0.2, 0.4, 0.3]);
        let model = model(&scene_of(cloth, 8, filter, 0.0));
        let mut state = State::new(&model);
        for particle in 0..4 {
            let wave = (particle as f32 * 1.7).sin();
            state.velocities.set(particle, Vec3::new(1.0 + wave, 2.0 * wave, 3.0 - wave));
        }
        let momentum = |state: &State| {
            let moving = state.velocities.iter().zip(&model.particles.mass);
            moving.map(|(velocity, &mass)| velocity.as_dvec3() * f64::from(mass)).sum::<DVec3>()
        };
        let before = momentum(&state);
        let plan = model.plan();
        let mut filter_of = Filter::new(&model, &plan);
        for _ in 0..50 {
            let mut ends = state.positions.clone();
            ends.add_scaled(0..4, &state.velocities, model.schedule.step_length as f32, &Pool::new(1));
            let done = apply(model.stride(&plan), &mut state, &mut ends, &mut filter_of, &Pool::new(1));
            assert!(done.sweeps > 0);
            state.positions = ends;
        }
        assert!((momentum(&state) - before).length() < 1e-5, "{filter}: {before} became {}", momentum(&state));
    }
}

#[test]
fn springs_that_a_filter_replaces_do_not_bound_the_step() {
    let sheet = |filter: &str| {
        let mut cloth = json!({ "grid": { "cells": [8, 8], "axes": ["x", "y"] }, "pins": [{ "corner": "top-left" }] });
        (cloth["stiffness"], cloth["shear_stiffness"]) = (json!(1e6), json!(if filter == "xpbd" { 1e6 } else { 1.0 }));
        (cloth["damping"], cloth["density"]) = (json!(0.0), json!(0.2));
        scene_of(cloth, 10, filter, G)
    };
    let refused = common::build(&scene(&sheet("provot")), &BTreeMap::new()).expect_err("a million newtons per metre");
    assert!(refused.to_string().contains("over the stability bound"), "{refused}");
    for filter in ["rods", "fast_projection", "xpbd"] {
        let mut run = Simulation::new(&sheet(filter));
        let report = run.steps(600);
        assert!(run.state.positions.z.iter().all(|z| z.is_finite() && z.abs() < 3.0), "{filter}");
        assert!(report.last.kinetic_energy < 0.2 * G * 2.0, "{filter}: {} J", report.last.kinetic_energy);
    }
}

#[test]
fn the_number_of_passes_is_the_authors_unless_it_is_given() {
    for (filter, usual) in [("sweeps", 200), ("rods", 200), ("fast_projection", 10), ("provot", 1), ("tethers", 1), ("xpbd", 1)] {
        let mut value = scene_of(network(&[[0.0; 3], [1.0, 0.0, 0.0]], &[[0, 1]], 0.1), 4, filter, G);
        assert_eq!(scene(&value).solver.iterations, Some(usual), "{filter}");
        value["solver"]["iterations"] = json!(7);
        assert_eq!(scene(&value).solver.iterations(), 7, "{filter}");
    }
}

#[test]
fn rough_treatment_leaves_every_state_finite() {
    let torn = json!([
        { "edge": "left" },
        { "edge": "right", "move": [[0.1, [0, 0, 0]], [0.105, [-0.5, 0, 0]], [0.11, [0, 0, 0]]] },
    ]);
    let folded_shut = json!([{ "edge": "left" }, { "edge": "right", "move": [[0.1, [-1.0, 0, 0]]] }]);
    for filter in ["provot", "rods", "fast_projection", "tethers", "xpbd"] {
        for (pins, strain_limit) in [(&torn, 0.05), (&folded_shut, 0.05), (&torn, 1e-9)] {
            let grid = json!({ "size": [1.0, 1.0], "cells": [16, 16], "axes": ["x", "y"] });
            let cloth = json!({ "grid": grid, "fabric": "nylon", "strain_limit": strain_limit, "pins": pins });
            let mut scene = scene_of(cloth, 40, filter, G);
            scene["wind"] = json!({ "velocity": [0.0, 3.0, 30.0], "gust": {} });
            scene["solver"]["iterations"] = json!(10);
            let mut run = Simulation::new(&scene);
            run.steps(400);
            let furthest = run.state.positions.iter().map(|position| position.length()).fold(0.0, f32::max);
            assert!(furthest < 20.0, "{filter}, {strain_limit}: {furthest} m");
        }
    }
}

#[test]
fn sweeps_that_leave_out_what_no_pass_could_change_end_with_the_same_bits() {
    let cloths = [
        json!({ "grid": { "size": [1.5, 1.0], "cells": [24, 16] }, "fabric": "nylon", "pins": [{ "edge": "left" }] }),
        json!({ "grid": { "size": [1.0, 1.0], "cells": [20, 20] }, "fabric": "cotton", "pins": [{ "corner": "bottom-left" }] }),
    ];
    for cloth in cloths {
        let hashes = [true, false].map(|local| {
            let mut scene = scene_of(cloth.clone(), 20, "sweeps", -9.81);
            scene["wind"] = json!({ "velocity": [8.0, 1.5, 0.0] });
            scene["solver"]["iterations"] = json!(60);
            scene["solver"]["local_correction"] = json!(local);
            let mut run = Simulation::new(&scene);
            let swept = run.steps(600).sweeps;
            assert!(swept > 2000, "{swept} passes");
            run.state.hash()
        });
        assert_eq!(hashes[0], hashes[1]);
    }
}
