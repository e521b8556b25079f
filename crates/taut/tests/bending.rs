//! Bending against closed forms: the heavy elastica, rolled sheets, the buckled arc.

use std::f64::consts::PI;

use crate::common::{Built, mesh_scene, model};
use glam::{DVec2, DVec3, Vec3};
use serde_json::{Value, json};
use taut::advance::advance;
use taut::forces::{Forces, bending_energy, elastic_energy, kick};
use taut::geometry::{Pool, Vectors};
use taut::model::{Buckling, MeshData, Model};
use taut::state::State;
use taut::step::Work;

const LENGTH: f64 = 0.2;
const DENSITY: f64 = 0.2;
const G: f64 = 9.81;

/// Where the tip of a heavy strip hangs that leaves its clamp level: way out and drop, in lengths of the strip.
///
/// With the angle a below the horizontal `a'' = -load (1 - s) cos a`, `a(0) = 0`, `a'(1) = 0`, `load = sigma g L^3 / B`.
fn elastica(load: f64) -> DVec2 {
    const PARTS: usize = 4000;
    let step = 1.0 / PARTS as f64;
    let shoot = |start: f64| {
        let rate = |s: f64, [a, b, _, _]: [f64; 4]| [b, -load * (1.0 - s) * a.cos(), a.cos(), a.sin()];
        let add = |y: [f64; 4], k: [f64; 4], h: f64| [0, 1, 2, 3].map(|i| y[i] + h * k[i]);
        (0..PARTS).fold([0.0, start, 0.0, 0.0], |y, index| {
            let s = index as f64 * step;
            let k1 = rate(s, y);
            let k2 = rate(s + 0.5 * step, add(y, k1, 0.5 * step));
            let k3 = rate(s + 0.5 * step, add(y, k2, 0.5 * step));
            let k4 = rate(s + step, add(y, k3, step));
            [0, 1, 2, 3].map(|i| y[i] + step / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
        })
    };
    let (mut low, mut high) = (0.0, load);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if shoot(middle)[1] < 0.0 { low = middle } else { high = middle }
    }
    let [_, _, out, drop] = shoot(low);
    DVec2::new(out, drop)
}

#[test]
fn the_elastica_solved_here_is_the_known_one() {
    // Small loads: the drop is sigma g L^4 / (8 B).
    let drop = elastica(0.01).y;
    assert!((drop / (0.01 / 8.0) - 1.0).abs() < 1e-4, "{drop}");
    // Heavy ones: the strip hangs from a short bend.
    let tip = elastica(100.0);
    assert!(tip.x < 0.2 && tip.y > 0.9, "{tip}");
    // Peirce's cantilever test: where the tip is seen 41.5 degrees below the level, B = sigma g (L / 2)^3.
    let seen = elastica(8.0).to_angle().to_degrees();
    assert!((seen - 41.5).abs() < 0.5, "{seen} degrees");
}

/// Where the ends of a strip come to rest that lies across a line and droops on both sides, as [`elastica`] says it.
fn droop(model: &Built, tip: usize) -> DVec2 {
    let mut state = State::new(model);
    let mut work = Work::new(model, &model.schedule, 1);
    let steps = (2.0 / model.schedule.step_length) as u64;
    advance(model, &mut state, &model.inputs, model.schedule.step_length, steps, &mut work).expect("stays finite");
    let fastest = state.velocities.iter().map(Vec3::length).fold(0.0, f32::max);
    assert!(fastest < 5e-3, "still moving with {fastest} m/s");
    let end = state.positions.get(model.numbering.particle(tip as u32) as usize).as_dvec3();
    DVec2::new(end.x, -end.z) / LENGTH
}

fn material(load: f64) -> Value {
    json!({
        "density": DENSITY, "stiffness": 400.0, "damping": 0.002, "air_drag": 12.0,
        "bending": DENSITY * G * LENGTH.powi(3) / load,
        "pins": [{ "box": [[-1e-6, -1.0, -1.0], [1e-6, 1.0, 1.0]] }],
    })
}

/// The same, as a curve of moment over curvature that is straight.
fn curved_material(load: f64) -> Value {
    let mut cloth = material(load);
    let stiffness = cloth.as_object_mut().and_then(|cloth| cloth.remove("bending")).and_then(|value| value.as_f64());
    cloth["curves"] = json!({ "bending": [[0.0, 0.0], [10.0, 10.0 * stiffness.expect("a number")]] });
    cloth
}

fn grid_strip(mut cloth: Value, half: usize) -> DVec2 {
    let breadth = LENGTH / half as f64 * 2.0;
    cloth["grid"] = json!({
        "size": [2.0 * LENGTH, breadth], "cells": [2 * half, 2], "origin": [-LENGTH, 0.0, 0.0], "axes": ["x", "y"],
    });
    let model = model(&json!({ "cloth": [cloth], "solver": { "filter": "none" } }));
    droop(&model, 2 * half)
}

/// A strip of triangles whose inner vertices are moved off their places, and whose diagonals go either way. Its two halves are
/// mirror images, or it would tip over.
fn crooked_strip(half: usize, breadth: f64, rows: usize, crooked: f64) -> MeshData {
    let mut mesh = MeshData::default();
    let cell = DVec2::new(LENGTH / half as f64, breadth / rows as f64);
    for j in 0..=rows {
        for i in 0..=2 * half {
            let (way, side) = (i.abs_diff(half), if i < half { -1.0 } else { 1.0 });
            let random = |factor: f64| ((way * 7 + j * 13 + 3) as f64 * factor).fract() - 0.5;
            let inside = way > 0 && way < half;
            let x = side * cell.x * (way as f64 + if inside { crooked * random(0.618_034) } else { 0.0 });
            let y = cell.y * (j as f64 + if j > 0 && j < rows { crooked * random(0.732_051) } else { 0.0 });
            mesh.vertices.push([x, y, 0.0]);
        }
    }
    for j in 0..rows {
        for i in 0..2 * half {
            let a = (j * (2 * half + 1) + i) as i64;
            let (b, d) = (a + 1, a + 1 + 2 * half as i64);
            let c = d + 1;
            let way = if i < half { half - 1 - i } else { i - half };
            let rising = ((way * way + j) % 3 == 0) == (i < half);
            let two = if rising { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
            mesh.corners.extend(two.concat());
            mesh.counts.extend([3, 3]);
        }
    }
    mesh
}

#[test]
fn a_heavy_strip_droops_like_the_elastica_at_every_resolution() {
    for load in [4.0, 12.0] {
        let exact = elastica(load);
        let near = |what: String, found: DVec2| {
            let off = found.distance(exact) / exact.length();
            println!("load {load}, {what}: tip at {found:.4}, elastica {exact:.4}, off by {:.2} %", 100.0 * off);
            assert!(off < 0.02, "load {load}, {what}: {found} instead of {exact}");
        };
        for half in [10, 20, 40] {
            near(format!("grid of {half} cells"), grid_strip(material(load), half));
            near(format!("{half} links"), network_strip(load, half));
        }
        for half in [10, 16, 26] {
            let mesh = crooked_strip(half, LENGTH / half as f64 * 3.0, 3, 0.4);
            let rest = json!({ "solver": { "filter": "none" } });
            near(format!("mesh of {half} cells"), droop(&mesh_scene(rest, material(load), mesh), 2 * half));
        }
        near("grid of 16 cells, a straight curve".to_owned(), grid_strip(curved_material(load), 16));
        let mesh = crooked_strip(16, LENGTH / 16.0 * 3.0, 3, 0.4);
        let curved = mesh_scene(json!({ "solver": { "filter": "none" } }), curved_material(load), mesh);
        near("mesh of 16 cells, a straight curve".to_owned(), droop(&curved, 32));
    }
}

/// A line of links as heavy and as stiff as a strip that is 1 m broad.
fn network_strip(load: f64, half: usize) -> DVec2 {
    let link = LENGTH / half as f64;
    let points: Vec<[f64; 3]> = (0..=2 * half).map(|bead| [link * bead as f64 - LENGTH, 0.0, 0.0]).collect();
    let links: Vec<[usize; 2]> = (0..2 * half).map(|bead| [bead, bead + 1]).collect();
    let mass = |bead: usize| DENSITY * link * if bead == 0 || bead == 2 * half { 0.5 } else { 1.0 };
    let mut cloth = material(load);
    cloth["stiffness"] = json!(400.0 / link);
    cloth["network"] = json!({ "points": points, "links": links, "mass": (0..=2 * half).map(mass).collect::<Vec<f64>>() });
    droop(&model(&json!({ "cloth": [cloth], "solver": { "filter": "none" } })), 2 * half)
}

/// Of equilateral triangles, as a rhombus.
fn rhombus(n: usize) -> MeshData {
    let mut mesh = MeshData::default();
    let side = 2.0 * LENGTH / n as f64;
    for j in 0..=n {
        (0..=n).for_each(|i| mesh.vertices.push([side * (i as f64 + 0.5 * j as f64), side * 0.75_f64.sqrt() * j as f64, 0.0]));
    }
    for j in 0..n {
        for i in 0..n {
            let a = (j * (n + 1) + i) as i64;
            let (b, d) = (a + 1, a + 1 + n as i64);
            mesh.corners.extend([a, b, d, b, d + 1, d]);
            mesh.counts.extend([3, 3]);
        }
    }
    mesh
}

fn sheet(n: usize, source: &str) -> Built {
    let mut cloth = json!({ "density": 0.2, "stiffness": 0.0, "damping": 0.0, "air_drag": 0.0, "bending": 3e-4 });
    let rest = json!({ "solver": { "filter": "none" } });
    match source {
        "rhombus" => mesh_scene(rest, cloth, rhombus(n)),
        "crooked" => mesh_scene(rest, cloth, crooked_strip(n / 2, 2.0 * LENGTH, n, 0.4)),
        _ => {
            let side = 2.0 * LENGTH;
            cloth["grid"] = json!({ "size": [side, side], "cells": [n, n], "origin": [-LENGTH, 0.0, 0.0], "axes": ["x", "y"] });
            model(&json!({ "cloth": [cloth], "solver": { "filter": "none" } }))
        }
    }
}

fn shaped(model: &Model, shape: impl Fn(DVec3) -> DVec3) -> Vectors {
    model.particles.rest.iter().map(|place| shape(place.as_dvec3()).as_vec3()).collect()
}

/// Of bending, and of springs where they have a stiffness [J].
fn energy(model: &Model, positions: &Vectors) -> f64 {
    let bent: f64 = (0..model.particle_count()).map(|particle| bending_energy(model, positions, particle)).sum();
    let springs = model.springs.ends.iter().enumerate().map(|(spring, ends)| {
        let [a, b] = ends.map(|end| positions.get(end as usize).as_dvec3());
        elastic_energy(model.springs.stiffness[spring], model.springs.rest[spring], a.distance(b) as f32)
    });
    bent + springs.sum::<f64>()
}

fn bending_forces(model: &Model, positions: &Vectors) -> Vec<DVec3> {
    let mut velocities = Vectors::zeros(model.particle_count());
    kick(model, &model.cloths[0], positions, &mut velocities, 1.0, &mut Forces::new(model), &Pool::new(1));
    let masses = model.particles.mass.iter().map(|&mass| f64::from(mass));
    velocities.iter().zip(masses).map(|(velocity, mass)| velocity.as_dvec3() * mass).collect()
}

#[test]
fn a_sheet_rolled_up_in_any_direction_has_the_energy_of_its_curvature() {
    let radius = 0.3;
    for source in ["grid", "rhombus"] {
        for degrees in [0.0, 20.0, 45.0, 90.0, 130.0] {
            let along = DVec2::from_angle(f64::to_radians(degrees));
            let roll = |place: DVec3| {
                let (s, t) = (place.truncate().dot(along), place.truncate().perp_dot(along));
                let angle = s / radius;
                DVec3::new(radius * angle.sin(), t, radius * (1.0 - angle.cos()))
            };
            let model = sheet(48, source);
            let found = energy(&model, &shaped(&model, roll));
            let area: f64 = model.particles.mass.iter().map(|&mass| f64::from(mass) / 0.2).sum();
            let exact = 0.5 * 3e-4 / (radius * radius) * area;
            // Nothing resists bending across the borders: half a cell a side is missing.
            let relative = found / exact - 1.0;
            assert!((-1.0 / 48.0 - 0.005..0.005).contains(&relative), "{source}, {degrees} degrees: {found} J, not {exact} J");
        }
    }
}

#[test]
fn bending_resists_no_motion_of_the_whole_and_keeps_both_momenta() {
    for source in ["grid", "crooked"] {
        let model = sheet(12, source);
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.0);
        let moved = shaped(&model, |place| turn * place + DVec3::new(0.3, -0.2, 0.1));
        let scale = 3e-4 / LENGTH;
        assert!(bending_forces(&model, &moved).iter().all(|force| force.length() < 1e-3 * scale), "{source} resists a turn");

        let wavy = shaped(&model, |p| p + DVec3::new(0.01 * (9.0 * p.y).sin(), 0.0, 0.03 * (20.0 * p.x + 13.0 * p.y).sin()));
        let forces = bending_forces(&model, &wavy);
        let size: f64 = forces.iter().map(|force| force.length()).sum();
        let torque: DVec3 = wavy.iter().zip(&forces).map(|(place, force)| place.as_dvec3().cross(*force)).sum();
        assert!(forces.iter().sum::<DVec3>().length() < 1e-5 * size, "{source}: forces do not add up to zero");
        assert!(torque.length() < 1e-5 * LENGTH * size, "{source}: they turn the whole");
    }
}

fn follows_its_energy(model: &Model, positions: &Vectors) {
    let forces = bending_forces(model, positions);
    let largest = forces.iter().map(|force| force.length()).fold(0.0, f64::max);
    let step = 1e-4_f32;
    for particle in (0..model.particle_count()).step_by(5) {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            let at = |offset: f32| {
                let mut moved = positions.clone();
                moved.set(particle, moved.get(particle) + axis * offset);
                (energy(model, &moved), f64::from(moved.get(particle).dot(axis)))
            };
            let ((up, high), (down, low)) = (at(step), at(-step));
            let (slope, force) = ((up - down) / (high - low), forces[particle].dot(axis.as_dvec3()));
            assert!((force + slope).abs() < 0.01 * largest, "particle {particle}: {force} N where the energy falls by {slope} N");
        }
    }
}

#[test]
fn forces_are_the_slope_of_the_energy() {
    let wave = |p: DVec3| DVec3::new(0.93 * p.x, 0.95 * p.y, 0.01 * (20.0 * p.x + 13.0 * p.y).sin());
    for source in ["grid", "crooked"] {
        let model = sheet(8, source);
        follows_its_energy(&model, &shaped(&model, wave));
    }
    let cloth = json!({
        "grid": { "size": [0.4, 0.4], "cells": [8, 8], "axes": ["x", "y"] }, "stiffness": 0.5, "damping": 0.0,
        "bending": 3e-5, "bending_model": "choi_ko",
    });
    let model = model(&json!({ "cloth": [cloth] }));
    let buckled = shaped(&model, wave);
    let springs = model.bending.buckling.of(40);
    let distance = |spring: &Buckling| (buckled.get(spring.other as usize) - buckled.get(40)).length();
    assert!(springs.iter().any(|spring| distance(spring) < spring.rest * (1.0 - spring.knee)), "none buckles");
    assert!(model.springs.kind.iter().all(|kind| kind.is_type1()));
    follows_its_energy(&model, &shaped(&model, wave));
}

#[test]
fn the_step_is_bounded_by_the_stiffest_bending() {
    for (source, most) in [("grid", 1.1), ("rhombus", 2.0), ("crooked", 2.5)] {
        let model = sheet(12, source);
        let bound = (2.0 / model.schedule.bound).powi(2);
        // Power iteration for the largest eigenvalue of the matrix over the masses.
        let mut shape: Vectors = (0..model.particle_count()).map(|i| Vec3::Z * if i % 2 == 0 { 1.0 } else { -0.9 }).collect();
        let mut largest = 0.0;
        for _ in 0..400 {
            let mut next = Vectors::zeros(shape.len());
            kick(&model, &model.cloths[0], &shape, &mut next, 1.0, &mut Forces::new(&model), &Pool::new(1));
            let size = next.z.iter().fold(0.0_f32, |size, z| size.max(z.abs()));
            let before = shape.z.iter().fold(0.0_f32, |size, z| size.max(z.abs()));
            largest = f64::from(size / before);
            shape = next.iter().map(|value| value / size).collect();
        }
        assert!(largest <= 1.001 * bound && bound < most * largest, "{source}: w^2 = {largest}, the step reckons with {bound}");
    }
}

/// Over two links in a line that are compressed together with so many N/m.
fn spring(compression: f64) -> Buckling {
    let cloth = json!({
        "network": { "points": [[0, 0, 0], [0.05, 0, 0], [0.1, 0, 0]], "links": [[0, 1], [1, 2]], "mass": 0.001 },
        "stiffness": 2.0 * compression, "bending": 2e-6, "bending_model": "choi_ko",
    });
    let model = model(&json!({ "cloth": [cloth] }));
    assert!(model.springs.kind.iter().all(|kind| kind.is_type1()));
    model.bending.buckling.of(0)[0]
}

#[test]
fn a_type_2_spring_pushes_like_a_buckled_arc_and_never_pulls() {
    // Half of the 2e-6 N m^2: two springs lie over every stretch.
    let (rest, stiffness) = (0.1, 1e-6);
    let spring = spring(1e6);
    for half_angle in [0.05, 0.3, 0.8, 1.4, 2.0, 2.6, 3.0] {
        let distance = rest * f64::sin(half_angle) / half_angle;
        let curvature = 2.0 * half_angle / rest;
        let force = stiffness * curvature * curvature / (f64::cos(half_angle) - f64::sin(half_angle) / half_angle);
        let found = f64::from(spring.pull(distance as f32));
        assert!((found / force - 1.0).abs() < 0.01, "half angle {half_angle}: {found} N instead of {force} N");
        let energy = 0.5 * stiffness * curvature * curvature * rest;
        let found = spring.energy(distance as f32);
        assert!((found / energy - 1.0).abs() < 0.01, "half angle {half_angle}: {found} J instead of {energy} J");
    }
    // It buckles under 12 k_b / L^2, Euler's load with 12 for pi^2 because the arc is circular.
    let first = f64::from(spring.pull(0.0999));
    assert!((first * rest * rest / (-12.0 * stiffness) - 1.0).abs() < 0.01 && PI * PI < 12.0);
    assert!(spring.pull(0.1001) == 0.0 && spring.energy(0.1001) == 0.0);
}

#[test]
fn a_type_2_spring_is_compressed_before_it_buckles() {
    let soft = spring(0.5);
    assert!((soft.pull(0.0995) / (-0.5 * 0.0005) - 1.0).abs() < 0.01, "{} N", soft.pull(0.0995));
    // Where the two forces meet there is no jump.
    let knee = 0.1 * (1.0 - soft.knee);
    assert!((soft.pull(knee * 1.0001) / soft.pull(knee * 0.9999) - 1.0).abs() < 0.05);
    assert!(soft.knee > 1e-3 && soft.knee < 0.1, "{}", soft.knee);
}

#[test]
fn provots_springs_store_the_fourth_power_of_the_curvature() {
    let cloth = json!({
        "grid": { "size": [1.0, 0.2], "cells": [20, 4], "axes": ["x", "y"] }, "stiffness": 0.0, "flexion_stiffness": 30.0,
    });
    let model = model(&json!({ "cloth": [cloth] }));
    assert!(!model.cloths[0].bends && model.springs.len() > model.springs.type1);
    for curvature in [2.0_f64, 4.0] {
        let rolled = shaped(&model, |p| {
            let angle = curvature * p.x;
            DVec3::new(angle.sin() / curvature, p.y, (1.0 - angle.cos()) / curvature)
        });
        // A chord over an arc of length L is shorter by k^2 L^3 / 24; there are 19 such springs in each of 5 rows.
        let shorter = curvature * curvature * 0.1_f64.powi(3) / 24.0;
        let expected = 19.0 * 5.0 * 0.5 * 30.0 * shorter * shorter;
        let found = energy(&model, &rolled);
        assert!((found / expected - 1.0).abs() < 0.01, "curvature {curvature}: {found} J instead of {expected} J");
    }
}
