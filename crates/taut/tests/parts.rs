//! The parts of a step: kick, drift, kick; and with scaled masses fewer of them.
#![allow(missing_docs)]

mod common;

use common::{Built, Simulation, model};
use glam::Vec3;
use serde_json::json;
use taut::forces::{Forces, damp, external, kick};
use taut::geometry::{Pool, Vectors};
use taut::integrate::{Integrator, propose};
use taut::state::State;

/// A sheet of so many cells, crumpled and moving, whose springs take several parts of a step, but not so many that masses are
/// scaled.
fn crumpled(cells: [u32; 2], damping: f64) -> (Built, State) {
    let model = model(&json!({
        "cloth": [{
            "grid": { "size": [1.0, 0.7], "cells": cells, "axes": ["x", "y"] },
            "density": 0.2, "stiffness": 400.0 / f64::from(cells[0].max(cells[1])).powi(2), "damping": damping,
            "pins": [{ "corner": "bottom-left" }],
        }],
        "fps": 6.0,
        "solver": { "substeps": 1, "force_step": true },
    }));
    let mut state = State::new(&model);
    for particle in 0..model.particle_count() {
        let phase = particle as f32;
        let wave = Vec3::new((1.3 * phase).sin(), (2.9 * phase).sin(), (4.7 * phase).sin());
        state.positions.set(particle, state.positions.get(particle) + wave * 1e-3);
        if model.particles.inverse_mass[particle] > 0.0 {
            state.velocities.set(particle, wave);
        }
    }
    (model, state)
}

/// Ends and velocities, one part after another.
fn one_after_another(model: &Built, mut state: State) -> (Vectors, Vectors) {
    let (pool, particles) = (Pool::new(1), 0..model.particle_count());
    let plan = model.plan();
    let (stride, count) = (model.stride(&plan), plan.spring_steps);
    let length = (model.schedule.step_length / f64::from(count)) as f32;
    let mut forces = Forces::new(model);
    external(stride, &state, &mut forces, &pool);
    damp(stride, &model.cloths, &mut state.velocities, &mut forces, &pool);
    let (mut ends, mut seen) = (state.positions.clone(), state.positions.clone());
    ends.set_scaled(particles.clone(), &state.positions, &state.velocities, 0.5 * length, &pool);
    for part in 1..=count {
        let ahead = plan.springs_ahead as f32;
        seen.set_scaled(particles.clone(), &ends, &state.velocities, ahead, &pool);
        kick(model, &model.cloths[0], &seen, &mut state.velocities, length, &mut forces, &pool);
        let after = if part < count { length } else { length - 0.5 * length };
        ends.add_scaled(particles.clone(), &state.velocities, after, &pool);
    }
    (ends, state.velocities)
}

#[test]
fn parts_are_taken_one_after_another_on_any_number_of_threads() {
    // Rows shorter and longer than a register, and a whole number of registers long.
    for (cells, damping) in [([2, 2], 0.0), ([6, 9], 0.0), ([15, 4], 0.5), ([31, 33], 0.0), ([47, 70], 0.1), ([130, 20], 0.0)] {
        let (model, state) = crumpled(cells, damping);
        let plan = model.plan();
        assert!(plan.spring_steps > 2 && plan.scaled.is_none(), "{cells:?}: {plan:?}");
        let expected = one_after_another(&model, state.clone());
        for threads in 1..=3 {
            let (pool, mut state) = (Pool::new(threads), state.clone());
            let (mut forces, mut integrator) = (Forces::new(&model), Integrator::new(&model, &plan));
            let mut ends = state.positions.clone();
            pool.install(|| {
                propose(model.stride(&plan), &mut state, &mut ends, &mut forces, &mut integrator, &pool);
            });
            assert_eq!((&ends, &state.velocities), (&expected.0, &expected.1), "{cells:?} on {threads} threads");
        }
    }
}

#[test]
fn cloth_between_dense_pins_sets_out_as_fast_as_any() {
    // Coarse particles are all tied to pins: scaled masses would hold the cloth back.
    let sag = |filter: &str| {
        let pins: Vec<_> =
            (0..81).map(|pin| json!({ "nearest": [0.125 * f64::from(pin % 9), 0.125 * f64::from(pin / 9), 0.0] })).collect();
        let mut run = Simulation::new(&json!({
            "cloth": [{
                "grid": { "size": [1.0, 1.0], "cells": [64, 64], "axes": ["x", "y"] },
                "density": 0.2, "stiffness": 20.0, "strain_limit": 0.1, "pins": pins,
            }],
            "fps": 60.0, "solver": { "filter": filter },
        }));
        run.steps(3 * u64::from(run.model.schedule.substeps));
        -run.state.positions.z.iter().map(|z| f64::from(*z)).sum::<f64>() / run.model.particle_count() as f64
    };
    let (found, expected) = (sag("coarse_to_fine"), sag("none"));
    assert!((found / expected - 1.0).abs() < 0.15, "{found} m instead of {expected} m");
}

#[test]
fn masses_are_scaled_where_that_saves_parts_and_slows_nothing_down() {
    let parts = |pins: serde_json::Value, cells: u32, bending: f64| {
        let cloth = json!({
            "grid": { "size": [1.0, 1.0], "cells": [cells, cells], "axes": ["x", "y"] },
            "density": 0.2, "stiffness": 20.0, "strain_limit": 0.1, "bending": bending, "pins": pins,
        });
        let plan = model(&json!({ "cloth": [cloth], "fps": 60.0 })).plan();
        plan.scaled.map(|scaled| scaled.parts)
    };
    assert_eq!(parts(json!([{ "corner": "bottom-left" }]), 64, 0.0), Some(3));
    assert_eq!(parts(json!([{ "edge": "left" }]), 64, 0.0), Some(3));
    assert_eq!(parts(json!([{ "corner": "bottom-left" }]), 4, 0.0), None, "springs are slow enough as they are");
    // A narrow strip of board along what is held.
    assert_eq!(parts(json!([{ "box": [[-1, -1, -1], [0.9, 2, 1]] }]), 64, 1e-2), None);
}
