//! The two forms of the wind force, and gusts.

use crate::common::{self, Built, mesh_model, model};
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use serde_json::{Value, json};
use taut::model::MeshData;
use taut::state::{Clock, State};

/// Half a cylinder of radius 1 m and height 1 m as a mesh of `n` x `n` quads.
fn half_cylinder(n: usize) -> MeshData {
    let mut mesh = MeshData::default();
    for j in 0..=n {
        for i in 0..=n {
            let angle = std::f64::consts::PI * i as f64 / n as f64;
            mesh.vertices.push([angle.cos(), angle.sin(), j as f64 / n as f64]);
        }
    }
    for j in 0..n {
        for i in 0..n {
            let a = (j * (n + 1) + i) as i64;
            let up = n as i64 + 1;
            mesh.corners.extend([a, a + 1, a + 1 + up, a + up]);
            mesh.counts.push(4);
        }
    }
    mesh
}

fn forces(model: &Built, state: &State) -> Vec<DVec3> {
    let masses = model.particles.mass.iter().map(|&mass| f64::from(mass));
    model.external(state).iter().zip(masses).map(|(acceleration, mass)| acceleration.as_dvec3() * mass).collect()
}

fn wind_on_cylinder(n: usize, form: &str) -> Vec<DVec3> {
    // Built twice with one mesh: only the form differs.
    let mesh = half_cylinder(n);
    let cloth = json!({ "stiffness": 0.0, "damping": 0.0, "air_drag": 0.0, "drag_coefficient": 1.0, "mesh": "mesh" });
    let scene = json!({
        "gravity": [0, 0, 0], "cloth": [cloth],
        "wind": { "velocity": [2.0, 7.0, 1.0], "density": 1.2, "model": form },
    });
    let meshes = [("mesh".to_owned(), mesh)].into();
    let model = common::build(&common::scene(&scene), &meshes).expect("a model");
    forces(&model, &State::new(&model))
}

#[test]
fn particle_and_triangle_form_converge_to_each_other() {
    let difference = |n: usize| {
        let (particle, triangle) = (wind_on_cylinder(n, "particle"), wind_on_cylinder(n, "triangle"));
        let apart: f64 = particle.iter().zip(&triangle).map(|(a, b)| a.distance(*b)).sum();
        apart / triangle.iter().map(|force| force.length()).sum::<f64>()
    };
    let errors = [8, 16, 32, 64].map(difference);
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.6 * pair[0], "refining does not bring the forms together: {errors:?}");
    }
    assert!(errors[3] < 0.02, "{errors:?}");
}

#[test]
fn the_force_on_a_half_cylinder_is_the_integral_over_it() {
    // -1/2 rho C_d |V| (V.N) N over N = (cos a, sin a), a in [0, pi], height and radius 1 m, V = -W:
    // the integral of (W.N) N is (pi/2) (W_x, W_y).
    let expected = DVec3::new(2.0, 7.0, 0.0) * (0.5 * 1.2 * 54.0_f64.sqrt() * std::f64::consts::FRAC_PI_2);
    for form in ["particle", "triangle"] {
        let total: DVec3 = wind_on_cylinder(64, form).into_iter().sum();
        assert!(total.distance(expected) < 0.01 * expected.length(), "{form}: {total} N instead of {expected} N");
    }
}

fn sheet(gust: Value, wind: &str) -> Built {
    model(&json!({
        "gravity": [0, 0, 0],
        "wind": { "velocity": [0.0, 8.0, 0.0], "gust": gust, "model": wind },
        "cloth": [{ "grid": { "size": [1.0, 1.0], "cells": [16, 16] }, "air_drag": 0.0 }],
    }))
}

#[test]
fn a_flat_grid_in_a_steady_wind_is_pushed_as_one() {
    for form in ["particle", "triangle"] {
        let model = sheet(Value::Null, form);
        let state = State::new(&model);
        let pushes: Vec<f64> =
            forces(&model, &state).iter().zip(&model.particles.mass).map(|(f, &m)| f.y / f64::from(m)).collect();
        for push in &pushes {
            assert!((push / pushes[0] - 1.0).abs() < 1e-5, "{form}: accelerations differ: {push} and {}", pushes[0]);
        }
    }
}

#[test]
fn gusts_repeat_with_their_seed_vary_in_space_and_time_and_have_their_strength() {
    let speeds = |seed: u64, steps: u64| {
        let model = sheet(json!({ "strength": 0.3, "period": 1.5, "seed": seed }), "particle");
        let mut state = State::new(&model);
        state.clock = Clock::after(steps, model.schedule.step_length);
        forces(&model, &state)
    };
    assert_eq!(speeds(1, 5), speeds(1, 5));
    assert_ne!(speeds(1, 5), speeds(2, 5));
    assert_ne!(speeds(1, 5), speeds(1, 50));
    let (here, there) = (speeds(1, 5)[18].y, speeds(1, 5)[17 * 15 + 15].y);
    assert!((here / there - 1.0).abs() > 1e-4, "the same wind at {here} and {there}");

    // Root mean square of the speed over many seeds and times, from the waves themselves.
    let (mut square, mut count) = (0.0, 0.0);
    for seed in 0..50 {
        let model = sheet(json!({ "strength": 0.3, "period": 1.5, "seed": seed }), "particle");
        let waves = &model.inputs.air.as_ref().expect("wind").waves;
        square += waves.iter().map(|wave| 0.5 * f64::from(wave.amplitude.length_squared())).sum::<f64>();
        count += 1.0;
    }
    assert!(((square / count).sqrt() / (0.3 * 8.0) - 1.0).abs() < 1e-6);
}

#[test]
fn a_cloth_that_moves_with_the_air_feels_no_wind() {
    let model = mesh_model(json!({ "air_drag": 0.0, "stiffness": 0.0 }), half_cylinder(4));
    assert!(model.inputs.air.is_none());
    let model = sheet(Value::Null, "triangle");
    let mut state = State::new(&model);
    (0..model.particle_count()).for_each(|particle| state.velocities.set(particle, Vec3::new(0.0, 8.0, 0.0)));
    assert!(forces(&model, &state).iter().all(|force| force.length() < 1e-6));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Whatever the step: what moves against the air is slowed down, not thrown back faster.
    #[test]
    fn air_never_adds_energy_of_the_motion_against_it(
        cells in [1_u32..6, 1_u32..6], fps in 0.1_f64..1000.0, speed in 0.1_f32..100.0, seed: u32,
        as_mesh: bool, particle_form: bool,
    ) {
        let wind = Vec3::new(20.0, -7.0, 3.0);
        let mut cloth = json!({ "air_drag": 0.0, "drag_coefficient": 1.5, "density": 0.05 });
        if as_mesh {
            cloth["mesh"] = json!("mesh");
        } else {
            cloth["grid"] = json!({ "size": [1.0, 0.7], "cells": cells });
        }
        let scene = json!({
            "gravity": [0, 0, 0], "cloth": [cloth], "fps": fps, "solver": { "substeps": 1, "force_step": true, "filter": "none" },
            "wind": {
                "velocity": wind.to_array(), "density": 1.2, "model": if particle_form { "particle" } else { "triangle" },
            },
        });
        let meshes = [("mesh".to_owned(), half_cylinder(cells[0] as usize + 1))].into();
        let model = common::build(&common::scene(&scene), &meshes).expect("a model");
        let mut state = State::new(&model);
        let noise = |index: usize, salt: u32| (f64::from((index as u32).wrapping_mul(7919).wrapping_add(seed).wrapping_add(salt)) * 0.618).sin() as f32;
        for index in 0..model.particle_count() {
            state.velocities.set(index, Vec3::new(noise(index, 0), noise(index, 1), noise(index, 2)) * speed);
            let bent = state.positions.get(index) + Vec3::new(noise(index, 3), noise(index, 4), noise(index, 5)) * 0.1;
            state.positions.set(index, bent);
        }
        let found = model.external(&state);
        let energy = |step: f32| -> f64 {
            let against = |index: usize| state.velocities.get(index) + found.get(index) * step - wind;
            let one = |index: usize| f64::from(model.particles.mass[index]) * against(index).as_dvec3().length_squared();
            (0..model.particle_count()).map(one).sum()
        };
        let (before, after) = (energy(0.0), energy(model.schedule.step_length as f32));
        prop_assert!(after <= before * (1.0 + 1e-5), "{before} became {after}");
    }
}

#[test]
fn air_drag_brings_to_rest_at_most() {
    let scene = json!({
        "gravity": [0, 0, 0], "fps": 10, "solver": { "substeps": 1, "force_step": true },
        "cloth": [{ "network": { "points": [[0, 0, 0]] }, "air_drag": 300.0 }],
    });
    let mut run = common::Simulation::new(&scene);
    run.state.velocities.set(0, Vec3::new(3.0, 0.0, 0.0));
    run.steps(1);
    assert!(run.state.velocities.get(0).length() < 1e-6, "{}", run.state.velocities.get(0));
}
