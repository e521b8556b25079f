//! The parts of a step: kick, drift, kick; and with scaled masses fewer of them.

use crate::common::{Built, Simulation, model};
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
    let (stride, count) = (model.stride(&plan), plan.cloths[0].spring_steps);
    let length = (model.schedule.step_length / f64::from(count)) as f32;
    let mut forces = Forces::new(model);
    external(stride, &state, &mut forces, &pool);
    damp(stride, &model.cloths, plan.cloths[0].damping_stages, &mut state.velocities, &mut forces, &pool);
    let (mut ends, mut seen) = (state.positions.clone(), state.positions.clone());
    ends.set_scaled(particles.clone(), &state.positions, &state.velocities, 0.5 * length, &pool);
    for part in 1..=count {
        let ahead = plan.cloths[0].springs_ahead as f32;
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
        assert!(plan.cloths[0].spring_steps > 2 && plan.cloths[0].scaled.is_none(), "{cells:?}: {plan:?}");
        let expected = one_after_another(&model, state.clone());
        for threads in 1..=3 {
            let (pool, mut state) = (Pool::new(threads), state.clone());
            let (mut forces, mut integrator) = (Forces::new(&model), Integrator::new(&model, &plan));
            let mut ends = state.positions.clone();
            pool.install(usize::MAX, || {
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
        plan.cloths[0].scaled.map(|scaled| scaled.parts)
    };
    assert_eq!(parts(json!([{ "corner": "bottom-left" }]), 64, 0.0), Some(3));
    assert_eq!(parts(json!([{ "edge": "left" }]), 64, 0.0), Some(3));
    assert_eq!(parts(json!([{ "corner": "bottom-left" }]), 4, 0.0), None, "springs are slow enough as they are");
    // A narrow strip of board along what is held.
    assert_eq!(parts(json!([{ "box": [[-1, -1, -1], [0.9, 2, 1]] }]), 64, 1e-2), None);
}

/// A net of 73 points, as stiff as wire.
fn wire() -> serde_json::Value {
    let points: Vec<[f64; 3]> = (0..73).map(|point| [0.02 * f64::from(point), 3.0, 1.0]).collect();
    let links: Vec<[u32; 2]> = (0..72).map(|link| [link, link + 1]).collect();
    json!({
        "name": "wire", "network": { "points": points, "links": links, "mass": 1e-5 }, "stiffness": 1307.0, "damping": 0.0,
        "strain_limit": 0.05, "pins": [{ "vertices": [0] }],
    })
}

#[test]
fn each_cloth_takes_its_own_parts_of_a_step() {
    let soft = json!({
        "name": "sheet", "grid": { "size": [1.0, 1.0], "cells": [32, 32] }, "density": 0.2, "stiffness": 20.0, "strain_limit": 0.05,
        "pins": [{ "corner": "top-left" }],
    });
    let scene = |cloths: &[serde_json::Value], substeps: u32| {
        let mut scene = json!({ "cloth": cloths, "fps": 60.0, "solver": { "filter": "coarse_to_fine" } });
        if substeps > 0 {
            scene["solver"]["substeps"] = json!(substeps);
        }
        model(&scene)
    };
    let mut hard = soft.clone();
    (hard["stiffness"], hard["name"]) = (json!(2000.0), json!("hard"));
    for substeps in [4, 40] {
        let alone = [&soft, &hard, &wire()].map(|cloth| scene(std::slice::from_ref(cloth), substeps).plan());
        let together = scene(&[soft.clone(), hard.clone(), wire()], substeps).plan();
        for (index, plan) in alone.iter().enumerate() {
            assert_eq!(together.cloths[index], plan.cloths[0], "cloth {index}");
        }
        assert!(together.cloths[2].parts() > 4 * together.cloths[0].parts(), "{together:?}");
    }
    // And what a cloth does is what it does alone.
    let run = |cloths: &[serde_json::Value]| {
        let mut run = Simulation::of(scene(cloths, 20));
        run.steps(40);
        run.state.positions.iter().zip(run.state.velocities.iter()).take(33 * 33).collect::<Vec<_>>()
    };
    assert_eq!(run(&[soft.clone(), hard.clone(), wire()]), run(std::slice::from_ref(&soft)));
}

#[test]
fn a_stiff_net_takes_parts_and_what_makes_the_steps_of_all_short_is_named() {
    let sheet = |name: &str| json!({ "name": name, "grid": { "cells": [16, 16] }, "fabric": "cotton", "pins": [{ "corner": "top-left" }] });
    let built = |cloths: &[serde_json::Value]| model(&json!({ "cloth": cloths, "fps": 60.0 }));
    let substeps = |cloths: &[serde_json::Value]| built(cloths).schedule.substeps;
    let (alone, sheets) = (substeps(&[wire()]), substeps(&[sheet("one"), sheet("other")]));
    let together = substeps(&[sheet("one"), sheet("other"), wire()]);
    assert_eq!((alone, sheets, together), (20, 1, 3), "steps a frame");
    // The sheets take no more parts a step beside the wire than alone.
    let parts = |cloths: &[serde_json::Value]| built(cloths).plan().cloths.iter().map(|plan| plan.parts()).collect::<Vec<_>>();
    let (apart, beside) = (parts(&[sheet("one"), sheet("other")]), parts(&[sheet("one"), sheet("other"), wire()]));
    assert_eq!(apart, beside[..2], "parts a step: {apart:?}, {beside:?}");
    assert!(beside[2] > 20 * beside[0], "{beside:?}");
    let mut heavy = sheet("heavy");
    heavy["weights"] = json!([{ "corner": "bottom-right", "mass": 0.3 }]);
    let said = |cloths: &[serde_json::Value]| built(cloths).model.warnings.join("\n");
    let found = said(&[sheet("one"), heavy.clone(), wire()]);
    assert!(
        found.contains("scene.cloth[1] (heavy) needs ") && found.contains(" steps a frame, the others 3, and all"),
        "{found}"
    );
    for cloths in [&[sheet("one"), sheet("other"), wire()][..], &[wire()], &[heavy]] {
        assert_eq!(said(cloths), "");
    }
}
