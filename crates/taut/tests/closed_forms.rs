//! Motions whose answer is known in closed form.

use crate::common::{Simulation, chain_links, mesh_scene, network, scene_of};
use glam::Vec3;
use serde_json::{Value, json};
use taut::model::MeshData;

const G: f64 = 9.81;

/// Times at which a sampled signal passes zero, interpolated.
fn zero_crossings(step: f64, signal: &[f64]) -> Vec<f64> {
    let pairs = signal.windows(2).enumerate();
    pairs
        .filter(|(_, pair)| pair[0] * pair[1] < 0.0)
        .map(|(index, pair)| step * (index as f64 + pair[0] / (pair[0] - pair[1])))
        .collect()
}

#[test]
fn a_spring_has_the_period_of_its_mass_and_stiffness() {
    let (mass, stiffness) = (0.05, 20.0);
    let mut cloth = network(&[[0.0; 3], [0.0, 0.0, 1.0]], &[[0, 1]], mass);
    cloth["stiffness"] = json!(stiffness);
    cloth["pins"] = json!([{ "vertices": [0] }]);
    let mut run = Simulation::new(&scene_of(cloth, 40, "none", 0.0));
    run.state.velocities.set(1, Vec3::new(0.0, 0.0, 0.2));
    let step = run.step_length();
    let offset: Vec<f64> = (0..9600)
        .map(|_| {
            run.steps(1);
            f64::from(run.state.positions.z[1]) - 1.0
        })
        .collect();
    let crossings = zero_crossings(step, &offset);
    let halves = crossings.len() - 1;
    let period = 2.0 * (crossings[halves] - crossings[0]) / halves as f64;
    // The velocity-first Euler method has the period of sin(w' h / 2) = w h / 2.
    let frequency = (stiffness / mass).sqrt();
    let exact = std::f64::consts::PI * step / (frequency * step / 2.0).asin();
    assert!((period / exact - 1.0).abs() < 1e-5, "{period} s instead of {exact} s");
    assert!((period * frequency / std::f64::consts::TAU - 1.0).abs() < 1e-4);
}

#[test]
fn weights_add_inertia_and_gravity_and_the_air_does_not_see_them() {
    // On a spring: the period of both masses together.
    let mut cloth = network(&[[0.0; 3], [0.0, 0.0, 1.0]], &[[0, 1]], 0.01);
    (cloth["stiffness"], cloth["pins"]) = (json!(20.0), json!([{ "vertices": [0] }]));
    cloth["weights"] = json!([{ "vertices": [1, 1], "mass": 0.03 }, { "nearest": [0, 0, 1], "mass": 0.01 }]);
    let mut run = Simulation::new(&scene_of(cloth, 40, "none", 0.0));
    run.state.velocities.set(1, Vec3::new(0.0, 0.0, 0.2));
    let quarter = 0.25 * std::f64::consts::TAU * (0.05_f64 / 20.0).sqrt();
    run.steps((2.0 * quarter / run.step_length()).round() as u64);
    assert!((f64::from(run.state.positions.z[1]) - 1.0).abs() < 1e-4, "not back after half a period");
    // In still air: terminal velocity (M + m) g / (M k_A).
    let mut cloth = network(&[[0.0; 3], [1.0, 0.0, 0.0]], &[], 0.1);
    (cloth["air_drag"], cloth["weights"]) = (json!(2.5), json!([{ "vertices": [1], "mass": 0.1 }]));
    let mut run = Simulation::new(&scene_of(cloth, 4, "none", G));
    run.steps(2400);
    for (point, factor) in [(0, 1.0), (1, 2.0)] {
        assert!((f64::from(run.state.velocities.z[point]) / (-G / 2.5 * factor) - 1.0).abs() < 1e-5);
    }
    assert!((run.steps(0).last.kinetic_energy / (0.5 * 0.1 * (G / 2.5).powi(2) * (1.0 + 2.0 * 4.0)) - 1.0).abs() < 1e-4);
}

#[test]
fn free_fall_is_late_by_half_a_step_exactly() {
    let mut run = Simulation::new(&scene_of(network(&[[0.0; 3]], &[], 0.1), 4, "none", G));
    run.steps(240);
    let time = run.state.time();
    let expected = -0.5 * G * time * time - 0.5 * G * run.step_length() * time;
    assert!((run.state.place(0, 0).z / expected - 1.0).abs() < 1e-5);
    assert!((f64::from(run.state.velocities.z[0]) / (-G * time) - 1.0).abs() < 1e-5);
}

#[test]
fn stokes_drag_ends_at_g_over_k() {
    let mut cloth = network(&[[0.0; 3]], &[], 0.1);
    cloth["air_drag"] = json!(2.5);
    let mut run = Simulation::new(&scene_of(cloth, 4, "none", G));
    run.steps(2400);
    assert!((f64::from(run.state.velocities.z[0]) / (-G / 2.5) - 1.0).abs() < 1e-5);
}

#[test]
fn wind_ends_the_fall_of_a_flat_sheet_at_its_terminal_velocity() {
    for (form, weight) in [("particle", 0.0), ("triangle", 0.0), ("triangle", 0.6)] {
        let (density, drag) = (0.2, 1.2);
        // As much on the border and in the corners as the cloth itself has there, in proportion: it falls flat.
        let spread = |index: u32| [index % 10, index / 10].iter().map(|at| if at % 9 == 0 { 0.5 } else { 1.0 }).product::<f64>();
        let weights: Value = match weight {
            0.0 => json!([]),
            _ => (0..100).map(|index| json!({ "vertices": [index], "mass": weight * spread(index) / 81.0 })).collect(),
        };
        let cloth = json!({
            "grid": { "size": [1.0, 1.0], "cells": [9, 9], "axes": ["x", "y"] },
            "density": density, "drag_coefficient": drag, "air_drag": 0.0, "stiffness": 50.0, "damping": 0.05,
            "weights": weights,
        });
        let mut scene = scene_of(cloth, 30, "sweeps", G);
        scene["wind"] = json!({ "model": form, "density": 1.2 });
        let mut run = Simulation::new(&scene);
        run.steps(30 * 60 * 4);
        let count = run.model.particle_count() as f64;
        let speed = -run.state.velocities.z.iter().map(|&z| f64::from(z)).sum::<f64>() / count;
        let expected = (2.0 * (density + weight) * G / (1.2 * drag)).sqrt();
        assert!((speed / expected - 1.0).abs() < 0.005, "{form}, {weight} kg: {speed} m/s instead of {expected} m/s");
    }
}

#[test]
fn a_free_sheet_keeps_its_momentum() {
    for filter in ["none", "sweeps"] {
        let cloth = json!({
            "grid": { "size": [1.0, 1.0], "cells": [16, 16], "axes": ["x", "y"] },
            "density": 0.2, "air_drag": 0.0, "strain_limit": 0.05,
        });
        let mut run = Simulation::new(&scene_of(cloth, 20, filter, 0.0));
        for particle in 0..run.model.particle_count() {
            let wave = (particle as f32 * 0.7).sin();
            run.state.velocities.set(particle, Vec3::new(1.0 + 0.5 * wave, 0.3 * wave, wave));
        }
        let momentum = |run: &Simulation| {
            let moving = run.state.velocities.iter().zip(&run.model.particles.mass);
            moving.map(|(velocity, &mass)| velocity.as_dvec3() * f64::from(mass)).sum::<glam::DVec3>()
        };
        let before = momentum(&run);
        let summary = run.steps(20 * 60);
        assert_eq!(filter == "sweeps", summary.limited_steps > 0, "{filter}");
        let drift = (momentum(&run) - before).length() / before.length();
        assert!(drift < 2e-6, "{filter}: momentum drifts by {drift}");
    }
}

/// A chain of inextensible links, straight from `from` in direction `along`, the first bead held.
fn chain(links: u32, along: [f64; 3], filter: &str, iterations: u32, substeps: u32) -> Value {
    let length = 1.0 / f64::from(links);
    let points: Vec<[f64; 3]> = (0..=links).map(|bead| along.map(|part| part * length * f64::from(bead))).collect();
    let mut cloth = network(&points, &chain_links(links), 0.01);
    cloth["strain_limit"] = json!(1e-5);
    cloth["pins"] = json!([{ "vertices": [0] }]);
    let mut scene = scene_of(cloth, substeps, filter, G);
    scene["solver"]["iterations"] = json!(iterations);
    scene["solver"]["tolerance"] = json!(1e-5);
    scene
}

#[test]
fn a_hanging_chain_swings_with_the_period_of_the_laguerre_root() {
    // w^2 l / g is the smallest root of the Laguerre polynomial L_32: T = 1.68129 s for 32 links and 1 m.
    for (filter, iterations) in [("sweeps", 3000), ("fast_projection", 10)] {
        let angle = 0.04_f64;
        let mut run = Simulation::new(&chain(32, [angle.sin(), 0.0, -angle.cos()], filter, iterations, 8));
        let step = run.step_length();
        let swing: Vec<f64> = (0..8 * 60 * 6)
            .map(|_| {
                run.steps(1);
                f64::from(run.state.positions.x[32])
            })
            .collect();
        let crossings = zero_crossings(step, &swing);
        let halves = crossings.len() - 1;
        let period = 2.0 * (crossings[halves] - crossings[0]) / halves as f64;
        assert!(halves >= 4, "{filter}: only {halves} half swings");
        assert!((period / 1.68129 - 1.0).abs() < 0.01, "{filter}: period {period} s");
    }
}

/// Beads on the slowest swing of a taut chain of 1 m, 1 at the tip: K x = w^2 M x by inverse iteration.
fn slowest_swing(links: usize) -> Vec<f64> {
    // With weights of 1 the pull of the link above bead k is links - k; a load on the beads bends the chain link by link.
    let mut mode = vec![1.0; links];
    for _ in 0..60 {
        let (mut load, mut x) = (mode.iter().sum::<f64>(), 0.0);
        for (bead, part) in mode.iter_mut().enumerate() {
            let below = load;
            load -= *part;
            x += below / (links - bead) as f64;
            *part = x;
        }
        let tip = mode[links - 1];
        mode.iter_mut().for_each(|part| *part /= tip);
    }
    mode
}

#[test]
fn the_coarse_to_fine_filter_takes_nothing_from_the_swing_of_a_chain() {
    let (links, sway, strain_limit) = (32, 0.02, 1e-3);
    let mut scene = chain(links, [0.0, 0.0, -1.0 / (1.0 + strain_limit)], "coarse_to_fine", 200, 4);
    scene["cloth"][0]["strain_limit"] = json!(strain_limit);
    let mut run = Simulation::new(&scene);
    let (mut x, mut z) = (0.0, 0.0);
    for (bead, place) in (1..).zip(slowest_swing(links as usize)) {
        let across = sway * place - x;
        // Taut, but for what rounding may add.
        let length = (1.0 - 1e-6) / f64::from(links);
        (x, z) = (sway * place, z - (length * length - across * across).sqrt());
        run.state.positions.set(bead, Vec3::new(x as f32, 0.0, z as f32));
    }
    let swing: Vec<f64> = (0..240 * 17)
        .map(|_| {
            assert_eq!(run.steps(1).cuts, 0);
            f64::from(run.state.positions.x[32])
        })
        .collect();
    let crossings = zero_crossings(run.step_length(), &swing);
    let halves = crossings.len() - 1;
    let period = 2.0 * (crossings[halves] - crossings[0]) / halves as f64;
    assert!((period / 1.68129 - 1.0).abs() < 1e-3, "period {period} s");
    // The tenth swing is as wide as the first: energy is as its square.
    let last = swing[swing.len() - 240..].iter().fold(0.0, |widest: f64, x| widest.max(x.abs()));
    assert!((0.99..1.01).contains(&(last / sway)), "the tip still swings by {last} m");
}

#[test]
fn a_chain_between_two_pins_hangs_in_the_discrete_catenary() {
    for (filter, iterations) in [("sweeps", 2000), ("rods", 2000), ("fast_projection", 10)] {
        let (links, span) = (24_u32, 1.0 / 1.2);
        let length = 1.0 / f64::from(links);
        let (half, slope) = (0.5 * span, (0.25_f64 - 0.25 * span * span).sqrt());
        let bead = |index: u32| {
            let way = f64::from(index) / f64::from(links);
            [span * way, 0.0, -slope * (1.0 - (2.0 * way - 1.0).abs())]
        };
        let points: Vec<[f64; 3]> = (0..=links).map(bead).collect();
        assert!((half.hypot(slope) - 0.5).abs() < 1e-12);
        let mut cloth = network(&points, &chain_links(links), 0.01);
        cloth["strain_limit"] = json!(1e-5);
        cloth["air_drag"] = json!(6.0);
        cloth["pins"] = json!([{ "vertices": [0, links] }]);
        let mut scene = scene_of(cloth, 4, filter, G);
        scene["solver"]["iterations"] = json!(iterations);
        scene["solver"]["tolerance"] = json!(1e-5);
        let mut run = Simulation::new(&scene);
        run.steps(4 * 60 * 8);
        let expected = catenary(links, length, span);
        for (index, [x, z]) in expected.iter().enumerate() {
            let found = run.state.positions.get(index).as_dvec3();
            let error = (found.x - x).hypot(found.z - z);
            assert!(error < 1e-3, "{filter}: bead {index} is {error} m off its place");
        }
    }
}

/// Beads of the discrete catenary: the tangents of the links' angles are equally spaced by m g / H.
fn catenary(links: u32, length: f64, span: f64) -> Vec<[f64; 2]> {
    let tangent = |link: u32, spacing: f64| (f64::from(link) - 0.5 * f64::from(links - 1)) * spacing;
    let width = |spacing: f64| (0..links).map(|link| length / tangent(link, spacing).hypot(1.0)).sum::<f64>();
    let (mut low, mut high) = (0.0, 100.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if width(middle) > span { low = middle } else { high = middle }
    }
    let mut beads = vec![[0.0, 0.0]];
    for link in 0..links {
        let tangent = tangent(link, low);
        let across = length / tangent.hypot(1.0);
        let [x, z] = beads[beads.len() - 1];
        beads.push([x + across, z + across * tangent]);
    }
    beads
}

#[test]
fn the_literal_method_freezes_a_taut_pendulum_and_sweeps_do_not() {
    for (filter, swings) in [("sequential", false), ("sweeps", true)] {
        let mut cloth = network(&[[0.0; 3], [1.0, 0.0, 0.0]], &[[0, 1]], 0.1);
        cloth["pins"] = json!([{ "vertices": [0] }]);
        let mut run = Simulation::new(&scene_of(cloth, 16, filter, G));
        // Out to the limit: the spring is taut, gravity pulls at right angles.
        run.state.positions.set(1, Vec3::new(1.1, 0.0, 0.0));
        run.steps(16 * 30);
        let fallen = -run.state.positions.z[1];
        assert_eq!(fallen > 0.5, swings, "{filter}: fell {fallen} m in half a second");
        assert!(swings || fallen < 1e-3, "{filter}: fell {fallen} m in half a second");
    }
}

#[test]
fn a_strip_that_bears_something_heavy_swings_as_a_pendulum() {
    // Hundreds to thousands of times the mass of the cloth; let go where it is level, a pendulum needs K(1/2) sqrt(l / g) to its lowest place.
    const ELLIPTIC: f64 = 1.854_074_677;
    for (source, size, cells, mass, limit) in [
        ("grid", [0.3, 0.3], [16, 3], 2.0, 0.01),
        ("grid", [0.2, 0.05], [20, 6], 0.5, 0.05),
        ("grid", [0.5, 0.1], [10, 2], 0.5, 0.01),
        ("grid", [1.0, 0.2], [64, 12], 2.0, 0.05),
        ("grid", [1.0, 0.2], [100, 20], 2.0, 0.01),
        ("mesh", [0.3, 0.06], [16, 3], 2.0, 0.01),
        ("mesh", [0.1, 0.02], [10, 2], 0.1, 0.005),
    ] {
        let (length, place) = (size[0], format!("{source} {cells:?} {mass} kg"));
        let column = |x: u32| (0..=cells[1]).map(|y| y * (cells[0] + 1) + x).collect::<Vec<u32>>();
        let mut cloth = json!({
            "grid": { "size": size, "cells": cells, "axes": ["x", "y"] }, "fabric": "cotton", "strain_limit": limit,
            "pins": [{ "vertices": column(0) }], "weights": [{ "vertices": column(cells[0]), "mass": mass }],
        });
        let mut run = if source == "grid" {
            Simulation::new(&json!({ "cloth": [cloth] }))
        } else {
            cloth.as_object_mut().expect("a cloth").remove("grid");
            Simulation::of(mesh_scene(json!({}), cloth, strip(size, cells)))
        };
        let bob = run.model.numbering.particle(cells[0]) as usize;
        let (mut time, mut lost, mut most, mut steps) = (0.0, 0.0, 0.0_f64, 0);
        let quarter = ELLIPTIC * (length * (1.0 + 0.5 * limit) / G).sqrt();
        while run.state.positions.x[bob] > 0.0 && time < 2.0 * quarter {
            let part = run.steps(1).lost_motion;
            (lost, most, steps) = (lost + part, most.max(part), steps + 1);
            time += run.step_length();
        }
        assert!((time / quarter - 1.0).abs() < 0.06, "{place}: at its lowest place after {time} s instead of {quarter} s");
        // Cloth of over 6000 springs is solved directly where cycles double its energy only: there the mean counts.
        let lost = if run.model.springs.ends.len() <= 6000 { most } else { lost / f64::from(steps) };
        assert!(lost < 0.01, "{place}: lost {lost} of its motion");
    }
}

/// A strip of triangles, cells cut either way.
fn strip(size: [f64; 2], cells: [u32; 2]) -> MeshData {
    let mut mesh = MeshData::default();
    for vertex in 0..(cells[0] + 1) * (cells[1] + 1) {
        let [x, y] = [vertex % (cells[0] + 1), vertex / (cells[0] + 1)].map(f64::from);
        mesh.vertices.push([size[0] * x / f64::from(cells[0]), size[1] * y / f64::from(cells[1]), 0.0]);
    }
    for cell in 0..cells[0] * cells[1] {
        let a = i64::from(cell / cells[0] * (cells[0] + 1) + cell % cells[0]);
        let [b, c, d] = [a + 1, a + i64::from(cells[0]) + 2, a + i64::from(cells[0]) + 1];
        mesh.corners.extend(if cell % 2 == 0 { [a, b, c, a, c, d] } else { [a, b, d, b, c, d] });
        mesh.counts.extend([3, 3]);
    }
    mesh
}
