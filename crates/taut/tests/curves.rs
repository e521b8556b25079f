//! Cloth given by measured curves, against answers in closed form.

use crate::common::{self, Built, Simulation, chain_links, mesh_scene, model, network, scene_of};
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use taut::diagnostics::StateReport;
use taut::forces::{Forces, kick};
use taut::geometry::{Pool, Vectors};
use taut::model::{MeshData, Model};
use taut::scene::Curve;
use taut::state::State;
use taut::step::Work;

const G: f64 = 9.81;

/// A J: soft up to 4 %, then twenty and sixty times as stiff [1, N/m].
const TENSION: [[f64; 2]; 4] = [[0.0, 0.0], [0.04, 2.0], [0.06, 22.0], [0.08, 82.0]];
/// [rad, N/m]
const SHEAR: [[f64; 2]; 3] = [[0.0, 0.0], [0.02, 0.8], [0.3, 5.0]];
/// [1/m, N m/m]: stiff at first, as friction between the yarns makes it.
const BENDING: [[f64; 2]; 3] = [[0.0, 0.0], [2.0, 2e-4], [100.0, 3.14e-3]];

/// A curve at x, straight on beyond its last point.
fn value(curve: &[[f64; 2]], x: f64) -> f64 {
    let piece = curve.windows(2).rfind(|pair| pair[0][0] <= x).unwrap_or(&curve[..2]);
    let ([x0, y0], [x1, y1]) = (piece[0], piece[1]);
    y0 + (y1 - y0) / (x1 - x0) * (x - x0)
}

/// Where a curve has a value.
fn inverse(curve: &[[f64; 2]], y: f64) -> f64 {
    value(&curve.iter().map(|[x, y]| [*y, *x]).collect::<Vec<_>>(), y)
}

/// Trapezoids under a curve from 0 to x.
fn integral(curve: &[[f64; 2]], x: f64) -> f64 {
    let mut knots: Vec<f64> = curve.iter().map(|point| point[0]).filter(|&at| at < x).collect();
    knots.push(x);
    knots.windows(2).map(|pair| 0.5 * (pair[1] - pair[0]) * (value(curve, pair[0]) + value(curve, pair[1]))).sum()
}

fn spring(mass: f64, length: f64) -> Value {
    let mut cloth = network(&[[0.0; 3], [0.0, 0.0, -length]], &[[0, 1]], mass);
    cloth.as_object_mut().expect("a table").remove("stiffness");
    cloth["curves"] = json!({ "tension": TENSION });
    cloth["pins"] = json!([{ "vertices": [0] }]);
    cloth
}

#[test]
fn a_weight_stretches_a_spring_by_the_inverse_of_its_curve() {
    for load in [0.3, 2.0, 9.0, 60.0, 120.0] {
        let mut cloth = spring(load / G, 0.5);
        cloth["air_drag"] = json!(20.0);
        let mut run = Simulation::new(&json!({ "cloth": [cloth], "solver": { "filter": "none" } }));
        run.steps((4.0 / run.step_length()) as u64);
        let strain = -f64::from(run.state.positions.z[1]) / 0.5 - 1.0;
        assert!((strain - inverse(&TENSION, load)).abs() < 2e-5, "{load} N: {strain}, not {}", inverse(&TENSION, load));
    }
}

#[test]
fn a_mass_that_is_shot_off_turns_where_the_integral_of_the_curve_is_its_energy_and_none_is_lost() {
    let (mass, length, speed) = (0.05, 0.5, 2.5);
    let mut run = Simulation::new(&scene_of(spring(mass, length), 400, "none", 0.0));
    run.state.velocities.set(1, Vec3::new(0.0, 0.0, -speed as f32));
    let energy = 0.5 * mass * speed * speed;
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if length * integral(&TENSION, middle) < energy { low = middle } else { high = middle }
    }
    let (mut furthest, mut off) = (0.0_f64, 0.0_f64);
    for _ in 0..24_000 {
        let report = run.steps(1).last;
        off = off.max(((report.kinetic_energy + report.elastic_energy) / energy - 1.0).abs());
        furthest = furthest.max(-f64::from(run.state.positions.z[1]) / length - 1.0);
    }
    assert!(low > 0.06, "it does not get past the knees");
    assert!((furthest / low - 1.0).abs() < 2e-3, "turns at {furthest}, not at {low}");
    assert!(off < 0.02, "energy off by {off} within a second");
}

/// A sheet in the x-y plane that has curves alone, or a mesh of equilateral triangles or of quads.
fn sheet(source: &str, cells: [usize; 2], size: [f64; 2], curves: &Value) -> Built {
    let mut cloth = json!({ "density": 0.2, "damping": 0.0, "air_drag": 0.0, "curves": curves });
    for (field, curve) in [("stiffness", "tension"), ("shear_stiffness", "shear")] {
        if curves.get(curve).is_none() {
            cloth[field] = json!(0.0);
        }
    }
    let rest = json!({ "gravity": [0, 0, 0], "solver": { "filter": "none" } });
    if source == "grid" {
        cloth["grid"] = json!({ "size": size, "cells": cells, "axes": ["x", "y"] });
        let mut scene = rest;
        scene["cloth"] = json!([cloth]);
        return model(&scene);
    }
    let [nx, ny] = cells;
    let mut mesh = MeshData::default();
    let slant = if source == "triangles" { 0.5 } else { 0.0 };
    for j in 0..=ny {
        for i in 0..=nx {
            let (u, v) = (i as f64 / nx as f64, j as f64 / ny as f64);
            mesh.vertices.push([size[0] * (u + slant * j as f64 / nx as f64), size[1] * v, 0.0]);
        }
    }
    for j in 0..ny {
        for i in 0..nx {
            let a = (j * (nx + 1) + i) as i64;
            let (b, d) = (a + 1, a + 1 + nx as i64);
            let (corners, counts) = match source {
                "quads" => (vec![a, b, d + 1, d], vec![4]),
                _ => (vec![a, b, d, b, d + 1, d], vec![3, 3]),
            };
            mesh.counts.extend(counts);
            mesh.corners.extend(corners);
        }
    }
    mesh_scene(rest, cloth, mesh)
}

fn shaped(model: &Model, shape: impl Fn(DVec3) -> DVec3) -> Vectors {
    model.particles.rest.iter().map(|place| shape(place.as_dvec3()).as_vec3()).collect()
}

fn energy(model: &Built, positions: &Vectors) -> f64 {
    let mut state = State::new(model);
    state.positions = positions.clone();
    let mut work = Work::new(model, &model.schedule, 1);
    taut::step::inspect(model, &state, &model.inputs, &mut work).elastic_energy
}

fn forces(model: &Model, positions: &Vectors) -> Vec<DVec3> {
    let mut velocities = Vectors::zeros(model.particle_count());
    kick(model, &model.cloths[0], positions, &mut velocities, 1.0, &mut Forces::new(model), &Pool::new(1));
    let masses = model.particles.mass.iter().map(|&mass| f64::from(mass));
    velocities.iter().zip(masses).map(|(velocity, mass)| velocity.as_dvec3() * mass).collect()
}

#[test]
fn a_stretched_sheet_pulls_with_the_force_per_width_of_its_curve_at_every_resolution() {
    let (weft, size) = (json!([[0.0, 0.0], [0.1, 7.0]]), [0.3, 0.2]);
    let curves = json!({ "tension": TENSION, "tension_weft": weft });
    for cells in [[3, 2], [6, 8], [24, 10]] {
        let model = sheet("grid", cells, size, &curves);
        for strain in [0.03, 0.05, 0.07, 0.1] {
            let along_warp = shaped(&model, |p| DVec3::new(p.x, p.y * (1.0 + strain), 0.0));
            let edge: f64 = forces(&model, &along_warp).iter().take(cells[0] + 1).map(|force| force.y).sum();
            let exact = value(&TENSION, strain) * size[0];
            assert!((edge / exact - 1.0).abs() < 1e-3, "{cells:?}, {strain}: {edge} N along the warp, not {exact} N");
            let stored = integral(&TENSION, strain) * size[0] * size[1];
            assert!((energy(&model, &along_warp) / stored - 1.0).abs() < 1e-3, "{cells:?}, {strain}: not {stored} J");
            let along_weft = shaped(&model, |p| DVec3::new(p.x * (1.0 + strain), p.y, 0.0));
            let edge: f64 = forces(&model, &along_weft).iter().step_by(cells[0] + 1).map(|force| force.x).sum();
            assert!((edge / (70.0 * strain * size[1]) - 1.0).abs() < 1e-3, "{cells:?}, {strain}: {edge} N along the weft");
        }
    }
}

#[test]
fn a_sheared_sheet_resists_with_the_force_per_width_of_its_curve() {
    let size = [0.3, 0.2];
    for (source, cells) in [("grid", [6, 4]), ("grid", [12, 3]), ("grid", [5, 16]), ("quads", [6, 4])] {
        let model = sheet(source, cells, size, &json!({ "shear": SHEAR }));
        for angle in [-0.05_f64, -0.01, 0.01, 0.03, 0.08] {
            // Turned by half of the angle both ways: pure shear, in which diagonals grow and shrink alike to first order.
            let half = 0.5 * angle;
            let sheared = shaped(&model, |p| DVec3::new(p.x + half * p.y, p.y + half * p.x, 0.0));
            let forces = forces(&model, &sheared);
            let at_bottom = model.particles.rest.iter().zip(&forces).filter(|(place, _)| place.y < 1e-6);
            let bottom: f64 = at_bottom.map(|(_, force)| force.x).sum();
            let exact = value(&SHEAR, angle.abs()).copysign(angle) * size[0];
            assert!((bottom / exact - 1.0).abs() < 0.05, "{source} {cells:?}, {angle}: {bottom} N, not {exact} N");
            let stored = integral(&SHEAR, angle.abs()) * size[0] * size[1];
            let found = energy(&model, &sheared);
            assert!((found / stored - 1.0).abs() < 0.05, "{source} {cells:?}, {angle}: {found} J, not {stored} J");
        }
    }
}

#[test]
fn a_rolled_sheet_stores_the_integral_of_moment_over_curvature() {
    let size = [0.3, 0.3];
    let side = 0.3 / 16.0;
    let sources = [("grid", [32, 32], size), ("triangles", [16, 16], [0.3, 16.0 * side * 0.75_f64.sqrt()])];
    for (source, cells, size) in sources {
        let model = sheet(source, cells, size, &json!({ "bending": BENDING }));
        for radius in [1.0, 0.3, 0.1] {
            let roll = |p: DVec3| DVec3::new(radius * (p.x / radius).sin(), p.y, radius * (1.0 - (p.x / radius).cos()));
            let area: f64 = model.particles.mass.iter().map(|&mass| f64::from(mass) / 0.2).sum();
            let exact = integral(&BENDING, 1.0 / radius) * area;
            let relative = energy(&model, &shaped(&model, roll)) / exact - 1.0;
            // Nothing resists bending across the borders.
            let border = 1.0 / cells[0] as f64;
            assert!((-border - 0.01..0.01).contains(&relative), "{source}, radius {radius}: off by {relative}");
        }
    }
}

#[test]
fn straight_curves_are_the_stiffnesses_that_they_stand_for() {
    let wavy = |p: DVec3| {
        DVec3::new(1.02 * p.x + 0.004 * (9.0 * p.y).sin(), 0.99 * p.y + 0.1 * p.x, 0.02 * (20.0 * p.x + 13.0 * p.y).sin())
    };
    let curves = json!({ "tension": [[0, 0], [0.05, 4.0]], "shear": [[0, 0], [0.1, 1.5]], "bending": [[0, 0], [10, 4e-3]] });
    for source in ["grid", "quads", "triangles"] {
        let curved = sheet(source, [9, 6], [0.3, 0.2], &curves);
        let mut cloth = json!({ "density": 0.2, "stiffness": 80.0, "shear_stiffness": 30.0, "bending": 4e-4, "damping": 0.0, "air_drag": 0.0 });
        let straight = if source == "grid" {
            cloth["grid"] = json!({ "size": [0.3, 0.2], "cells": [9, 6], "axes": ["x", "y"] });
            model(&json!({ "cloth": [cloth], "solver": { "filter": "none" } }))
        } else {
            let rest = curved.numbering.to_vertices(&curved.particles.rest);
            let vertices = rest.iter().map(|p| p.as_dvec3().to_array()).collect();
            let polygons: Vec<Vec<i64>> = if source == "quads" {
                (0..6)
                    .flat_map(|j| (0..9).map(move |i| (j * 10 + i, 10)))
                    .map(|(a, n)| vec![a, a + 1, a + n + 1, a + n])
                    .collect()
            } else {
                let vertex = |corner: u32| i64::from(curved.numbering.vertex(corner));
                curved.triangles.iter().map(|corners| corners.map(vertex).to_vec()).collect()
            };
            let counts = polygons.iter().map(|polygon| polygon.len() as i64).collect();
            let mesh = MeshData { vertices, corners: polygons.concat(), counts };
            mesh_scene(json!({ "solver": { "filter": "none" } }), cloth, mesh)
        };
        let positions = shaped(&curved, wavy);
        let (found, expected) = (forces(&curved, &positions), forces(&straight, &positions));
        let size = expected.iter().map(|force| force.length()).fold(0.0, f64::max);
        for (one, other) in found.iter().zip(&expected) {
            // Gravity acts on neither: kicks of springs and bending alone.
            assert!((*one - *other).length() < 1e-3 * size, "{source}: {one} and {other} of {size}");
        }
        let (found, expected) = (energy(&curved, &positions), energy(&straight, &positions));
        assert!((found / expected - 1.0).abs() < 1e-3, "{source}: {found} and {expected} J");
        let rates = [&curved, &straight].map(|model| model.schedule.bound);
        assert!((rates[0] / rates[1] - 1.0).abs() < 1e-3, "{source}: bounds {rates:?}");
    }
}

#[test]
fn forces_are_the_slopes_of_the_energy_and_keep_both_momenta() {
    let curves = json!({ "tension": TENSION, "shear": SHEAR, "bending": BENDING });
    for source in ["grid", "quads", "triangles"] {
        let model = sheet(source, [6, 5], [0.3, 0.25], &curves);
        let wavy = |p: DVec3| {
            let wave = DVec3::new(0.01 * (9.0 * p.y).sin(), 0.008 * (17.0 * p.x).cos(), 0.03 * (20.0 * p.x + 13.0 * p.y).sin());
            p + wave
        };
        let positions = shaped(&model, wavy);
        let forces = forces(&model, &positions);
        let size: f64 = forces.iter().map(|force| force.length()).sum();
        let torque: DVec3 = positions.iter().zip(&forces).map(|(place, force)| place.as_dvec3().cross(*force)).sum();
        assert!(forces.iter().sum::<DVec3>().length() < 1e-5 * size && torque.length() < 1e-5 * size, "{source}");
        for particle in (0..model.particle_count()).step_by(4) {
            for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                let at = |offset: f32| {
                    let mut moved = positions.clone();
                    moved.set(particle, moved.get(particle) + axis * offset);
                    (energy(&model, &moved), f64::from(moved.get(particle).dot(axis)))
                };
                let ((up, high), (down, low)) = (at(2e-5), at(-2e-5));
                let slope = -(up - down) / (high - low);
                let force = forces[particle].dot(axis.as_dvec3());
                assert!((slope - force).abs() < 2e-3 * size, "{source} {particle} {axis}: {force} N, energy says {slope} N");
            }
        }
    }
}

#[test]
fn the_knee_is_lambda_unless_the_scene_gives_one() {
    let knee = |points: &[[f64; 2]]| Curve(points.to_vec()).knee();
    assert_eq!(knee(&TENSION), 0.06);
    assert_eq!(knee(&[[0.0, 0.0], [0.05, 1.0], [0.1, 100.0]]), 0.05);
    assert_eq!(knee(&[[0.0, 0.0], [0.02, 4.0], [0.08, 16.0]]), 0.08, "a straight line has its knee at its end");
    assert_eq!(knee(&[[0.0, 0.0], [0.02, 8.0], [0.08, 16.0]]), 0.08, "and so has one that flattens");
    // An exponential: where its slope is its mean slope.
    let steep = 60.0_f64;
    let points: Vec<[f64; 2]> = (0..=60).map(|i| f64::from(i) * 0.001).map(|x| [x, (steep * x).exp_m1()]).collect();
    let exact = ((steep * 0.06).exp_m1() / (steep * 0.06)).ln() / steep;
    assert!((knee(&points) - exact).abs() < 1e-3);

    let lambda = |cloth: Value| {
        let scene = common::scene(&json!({ "cloth": [cloth], "solver": { "filter": "none" } }));
        assert!(scene.cloth[0].stiffness.is_none(), "a curve has no single stiffness");
        // A scene that was filled in reads the same again.
        assert_eq!(common::scene(&serde_json::from_str(&scene.to_json()).expect("JSON")), scene);
        scene.cloth[0].strain_limit
    };
    let grid = json!({ "size": [1, 1], "cells": [4, 4] });
    assert_eq!(lambda(json!({ "grid": grid, "curves": { "tension": TENSION } })), Some(0.06));
    let weft = [[0.0, 0.0], [0.03, 1.0], [0.04, 10.0]];
    assert_eq!(lambda(json!({ "grid": grid, "curves": { "tension": TENSION, "tension_weft": weft } })), Some(0.03));
    assert_eq!(lambda(json!({ "grid": grid, "curves": { "tension": TENSION }, "strain_limit": 0.1 })), Some(0.1));
}

fn hanging(filter: &str) -> Value {
    json!({
        "cloth": [{
            "grid": { "size": [0.4, 0.4], "cells": [24, 24] }, "density": 0.2, "pins": [{ "edge": "top" }],
            "curves": { "tension": TENSION, "shear": SHEAR, "bending": BENDING }, "weights": [{ "edge": "bottom", "mass": 2.0 }],
        }],
        "solver": { "filter": filter },
    })
}

#[test]
fn the_limit_takes_over_at_the_knee_and_the_step_sees_the_curve_below_it_only() {
    let (limited, bare) = (model(&hanging("sweeps")), model(&hanging("none")));
    // Twenty against sixty times the first slope.
    let squares = (limited.schedule.bound / bare.schedule.bound).powi(2);
    assert!((2.5..3.0).contains(&squares), "{squares}");
    let mut run = Simulation::of(model(&hanging("coarse_to_fine")));
    let summary = run.steps((1.0 / run.step_length()) as u64);
    assert!(summary.worst_stretch < 0.06 + 1e-5 && summary.worst_stretch > 0.055, "{}", summary.worst_stretch);
    assert_eq!(summary.cuts, 0);
}

#[test]
fn the_bound_holds_along_the_whole_curve() {
    let mut scene = hanging("none");
    scene["cloth"][0]["weights"][0]["mass"] = json!(6.0);
    let mut run = Simulation::new(&scene);
    let fallen = run.steps(0).last;
    let (mut worst, mut gain) = (0.0_f64, f64::NEG_INFINITY);
    for _ in 0..10 {
        let summary = run.steps((0.1 / run.step_length()) as u64);
        let StateReport { kinetic_energy, elastic_energy, potential_energy, .. } = summary.last;
        worst = worst.max(summary.worst_stretch);
        gain = gain.max(kinetic_energy + elastic_energy + potential_energy - fallen.potential_energy);
    }
    assert!(worst > 0.08, "it stays below its steepest part: {worst}");
    assert!(gain < 0.01 * 6.0 * G * 0.08 * 0.4, "it gained {gain} J");
}

#[test]
fn curves_work_with_every_filter_that_has_springs() {
    for filter in ["none", "sequential", "sweeps", "coarse_to_fine", "provot", "rods", "fast_projection", "tethers"] {
        let mut run = Simulation::new(&hanging(filter));
        let summary = run.steps(20);
        assert!(summary.last.non_finite.is_none() && summary.last.kinetic_energy > 0.0, "{filter}");
    }
    let mut chain = network(&[[0.0; 3], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0]], &chain_links(2), 0.01);
    chain.as_object_mut().expect("a table").remove("stiffness");
    chain["curves"] = json!({ "tension": TENSION, "bending": [[0, 0], [5, 1e-5]] });
    chain["pins"] = json!([{ "vertices": [0] }]);
    let mut run = Simulation::new(&json!({ "cloth": [chain] }));
    // `network` gives a limit of its own.
    assert!(run.steps(60).last.worst_stretch <= 0.1);
}

#[test]
fn a_single_triangle_does_not_bend_and_does_no_harm() {
    let vertices = vec![[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]];
    let mesh = MeshData { vertices, corners: vec![0, 1, 2], counts: vec![3] };
    let cloth = json!({ "curves": { "bending": BENDING, "tension": TENSION }, "pins": [{ "vertices": [0] }] });
    let mut run = Simulation::of(mesh_scene(json!({}), cloth, mesh));
    assert!(run.steps(30).last.non_finite.is_none());
    assert!(run.state.positions.z.iter().any(|&z| z < -0.01), "it does not fall");
}

#[test]
fn curves_that_can_do_nothing_are_named() {
    let warned = |source: &str| {
        let model = sheet(source, [4, 4], [0.3, 0.3], &json!({ "shear": SHEAR }));
        model.warnings.iter().any(|warning| warning.contains("cloth[0].curves.shear has no effect"))
    };
    assert!(warned("triangles") && !warned("grid") && !warned("quads"));
}
