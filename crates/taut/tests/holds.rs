//! Vertices held and let go while a simulation runs, and steps of any length: nothing of it is left in the workspace.

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::common::{Simulation, crooked, mesh_scene, scene_of, sheet, worst};
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use taut::advance::{Failure, advance, advance_in_turns};
use taut::inputs::Target;
use taut::state::State;
use taut::step::Work;

const CELLS: usize = 16;
/// The corner opposite the pinned edge of a sheet, and one of the pinned vertices.
const CORNER: u32 = (CELLS * (CELLS + 1) + CELLS) as u32;

/// A sheet of 1 m with these pins, as a grid or as a crooked mesh.
fn hung(source: &str, filter: &str, integrator: &str, pins: Value) -> Simulation {
    let substeps = if filter == "coarse_to_fine" && integrator == "euler" { 3 } else { 24 };
    let mut cloth = sheet([CELLS as u32, CELLS as u32], 0.05, pins);
    let mut scene = scene_of(json!({}), substeps, filter, 9.81);
    scene["solver"]["integrator"] = json!(integrator);
    scene["solver"]["force_step"] = json!(true);
    scene["wind"] = json!({ "velocity": [1.0, 0.5, 0.2], "gust": {} });
    if source == "grid" {
        scene["cloth"] = json!([cloth]);
        return Simulation::new(&scene);
    }
    cloth.as_object_mut().expect("a cloth").remove("grid");
    Simulation::of(mesh_scene(scene, cloth, crooked(CELLS as u32)))
}

/// Holds a particle where it is at rest.
fn hold_at_rest(run: &mut Simulation, particle: u32) {
    let place = run.model.particles.rest.get(particle as usize).as_dvec3();
    run.inputs.grips.hold(particle, Target { place, arrival: 0.0 });
}

#[test]
fn a_vertex_held_where_it_is_moves_as_one_that_the_scene_pins() {
    for source in ["grid", "mesh"] {
        for (filter, integrator) in
            [("coarse_to_fine", "euler"), ("sweeps", "euler"), ("xpbd", "euler"), ("coarse_to_fine", "bdf2"), ("none", "verlet")]
        {
            let pins = |vertices: &[u32]| json!([{ "vertices": vertices }]);
            let mut pinned = hung(source, filter, integrator, pins(&[0, CORNER]));
            let mut held = hung(source, filter, integrator, pins(&[0]));
            let corner = held.model.numbering.particle(CORNER);
            hold_at_rest(&mut held, corner);
            for round in 0..10 {
                let [one, other] = [&mut pinned, &mut held].map(|run| (run.steps(3), run.state.clone()));
                assert_eq!(one.1.positions, other.1.positions, "{source} {filter} {integrator}, round {round}");
                assert_eq!(one.1.velocities, other.1.velocities, "{source} {filter} {integrator}, round {round}");
                assert_eq!(one.0, other.0, "{source} {filter} {integrator}, round {round}");
            }
        }
    }
}

#[test]
fn held_vertices_are_where_they_shall_be_and_fall_when_let_go() {
    for source in ["grid", "mesh"] {
        let mut run = hung(source, "coarse_to_fine", "euler", json!([]));
        let all: Vec<u32> = (0..=CELLS as u32).map(|vertex| run.model.numbering.particle(vertex)).collect();
        for step in 0..60_u16 {
            for &particle in &all {
                let way = Vec3::new(0.1, 0.0, 0.3) * (f32::from(step + 1) / 60.0);
                let place = run.model.particles.rest.get(particle as usize) + way;
                run.inputs.grips.hold(particle, Target { place: place.as_dvec3(), arrival: 0.0 });
            }
            run.steps(1);
            for (particle, target) in run.inputs.grips.held() {
                assert_eq!(run.state.positions.get(particle as usize), target.place.as_vec3());
            }
            assert!(worst(&run.model, &run.state) <= 1.0 + 1e-5);
        }
        let height = |run: &Simulation| run.state.positions.get(all[0] as usize).z;
        let before = height(&run);
        for &particle in &all {
            run.inputs.grips.release(particle);
        }
        run.steps(180);
        assert!(height(&run) < before - 0.3, "{source}: let go, it falls");
    }
}

#[test]
fn a_target_in_the_future_is_reached_in_time() {
    let mut run = hung("grid", "coarse_to_fine", "euler", json!([{ "edge": "left" }]));
    let start = run.state.positions.get(CORNER as usize);
    let place = start + Vec3::new(-0.2, 0.0, 0.1);
    run.inputs.grips.hold(CORNER, Target { place: place.as_dvec3(), arrival: 0.5 });
    run.steps(45);
    assert!(run.state.positions.get(CORNER as usize).distance(start.midpoint(place)) < 1e-5);
    run.steps(45);
    assert_eq!(run.state.positions.get(CORNER as usize), place);
}

#[test]
fn what_is_resumed_goes_on_with_the_same_bits() {
    for source in ["grid", "mesh"] {
        let mut run = hung(source, "coarse_to_fine", "euler", json!([{ "vertices": [0] }, { "vertices": [CORNER] }]));
        run.steps(10);
        let middle = (CORNER / 2) as usize;
        let place = run.state.positions.get(middle) + Vec3::Z * 0.1;
        run.inputs.grips.hold(middle as u32, Target { place: place.as_dvec3(), arrival: run.state.time() + 0.3 });
        run.inputs.grips.lead(40, Vec3::new(0.5, 0.5, 0.5), 1.0);
        run.inputs.grips.shift(1, glam::DVec3::new(-0.4, 0.0, 3.0), 20.0);
        run.steps(13);
        // As if it had to wait.
        let offset = &mut run.state.offsets[1];
        assert!(offset.now.length() > 0.0, "{offset:?}");
        offset.pace = 0.25;
        let bytes = run.state.to_bytes(&run.model, &run.inputs.grips);
        run.steps(30);
        let (mut state, grips) = State::from_bytes(&bytes, &run.model).expect("a snapshot");
        let mut inputs = run.model.inputs.clone();
        inputs.grips = grips;
        let mut work = Work::new(&run.model, &run.model.schedule, 2);
        advance(&run.model, &mut state, &inputs, run.step_length(), 30, &mut work).expect("stays finite");
        assert_eq!(state, run.state);
        assert_eq!(state.hash(), run.state.hash());
    }
}

#[test]
fn what_fails_leaves_no_trace() {
    for source in ["grid", "mesh"] {
        for (filter, integrator) in [("coarse_to_fine", "euler"), ("sweeps", "euler"), ("coarse_to_fine", "bdf2")] {
            let mut run = hung(source, filter, integrator, json!([{ "vertices": [0] }]));
            run.steps(5);
            let good = run.state.clone();
            let expected = run.steps(20);
            let after = run.state.clone();
            // Squares overflow in some sums and not in others: levels and momenta are left with what is no number.
            for speed in [1e20, 1e22, 1e24, 1e27, 1e30] {
                run.state = good.clone();
                for particle in 0..run.model.particle_count() {
                    run.state.velocities.set(particle, Vec3::splat(speed));
                }
                let bad = run.state.clone();
                if let Err(failure) = run.try_steps(3, run.step_length()) {
                    assert!(matches!(failure, Failure::NonFinite { .. }));
                    assert_eq!(run.state, bad, "{source} {filter} {integrator} {speed}");
                }
                run.state = good.clone();
                let again = run.try_steps(20, run.step_length());
                assert_eq!((&run.state, again), (&after, Ok(expected)), "{source} {filter} {integrator} {speed}");
            }
        }
    }
}

#[test]
fn who_does_not_want_to_wait_gets_the_state_before_back_and_turns_change_nothing() {
    let mut run = hung("grid", "coarse_to_fine", "euler", json!([{ "edge": "left" }]));
    let start = run.state.clone();
    let mut turns = [Some(1), Some(3), Some(0)].into_iter().cycle();
    let Simulation { model, inputs, state, work } = &mut run;
    let dt = model.schedule.step_length;
    advance_in_turns(model, state, inputs, dt, 20, work, &mut || turns.next().expect("a cycle")).expect("stays finite");
    let in_turns = std::mem::replace(state, start.clone());
    let mut left = 3;
    let stopped = advance_in_turns(model, state, inputs, dt, 1_000_000, work, &mut || {
        left -= 1;
        (left > 0).then_some(2)
    });
    assert_eq!((stopped, &*state), (Err(Failure::Stopped), &start));
    run.steps(20);
    assert_eq!(run.state, in_turns);
}

#[test]
fn steps_may_have_any_length() {
    for integrator in ["euler", "bdf2", "verlet", "rk4"] {
        let filter = if integrator == "euler" { "coarse_to_fine" } else { "sweeps" };
        let start = || hung("grid", filter, integrator, json!([{ "edge": "left" }]));
        let (mut even, mut uneven) = (start(), start());
        let dt = even.step_length();
        even.steps(60);
        for _ in 0..15 {
            for part in [0.5, 1.5, 1.9, 0.1] {
                uneven.try_steps(1, part * dt).expect("stays finite");
                assert!(filter == "sweeps" || worst(&uneven.model, &uneven.state) <= 1.0 + 1e-5);
            }
        }
        assert!((uneven.state.time() / even.state.time() - 1.0).abs() < 1e-12);
        assert_eq!(uneven.state.clock.steps, 60);
        let apart =
            uneven.state.positions.iter().zip(even.state.positions.iter()).map(|(a, b)| a.distance(b)).fold(0.0, f32::max);
        let moved =
            even.state.positions.iter().zip(even.model.particles.rest.iter()).map(|(a, b)| a.distance(b)).fold(0.0, f32::max);
        assert!(apart < 0.1 * moved, "{integrator}: {apart} m apart after {moved} m");
    }
}

#[test]
fn lengths_that_no_step_can_have_are_refused() {
    let mut run = hung("grid", "coarse_to_fine", "euler", json!([{ "edge": "left" }]));
    let before = run.state.clone();
    for dt in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
        let failure = run.try_steps(1, dt).expect_err("no length");
        let text = failure.to_string();
        assert!(
            matches!(failure, Failure::BadLength(_)) && text.contains("dt =") && text.contains("must be 1e-12 s or more"),
            "{text}"
        );
    }
    assert_eq!(run.state, before);
}

#[test]
fn a_panic_inside_a_step_leaves_no_trace_and_no_waiting_threads() {
    let sheet = json!({ "cloth": [{ "grid": { "cells": [80, 80] }, "fabric": "cotton", "pins": [{ "corner": "top-left" }] }] });
    for threads in [1, 3] {
        let mut run = Simulation::on_threads(&sheet, threads);
        run.steps(3);
        let (before, at) = (run.state.clone(), run.state.hash());
        run.steps(4);
        let expected = run.state.hash();
        run.state = before;
        // No such particle: the engine breaks down on a thread of the pool.
        let mut broken = run.inputs.clone();
        broken.grips.lead(u32::MAX - 1, DVec3::ZERO, 1.0);
        let dt = run.step_length();
        let fails = catch_unwind(AssertUnwindSafe(|| {
            let Simulation { model, state, work, .. } = &mut run;
            advance(model, state, &broken, dt, 4, work)
        }));
        assert!(fails.is_err(), "it should have panicked");
        assert_eq!(run.state.hash(), at, "{threads} threads: the state");
        let mut turns = 0;
        let fails = catch_unwind(AssertUnwindSafe(|| {
            let Simulation { model, state, inputs, work } = &mut run;
            advance_in_turns(model, state, inputs, dt, 4, work, &mut || {
                turns += 1;
                assert!(turns < 3, "the third turn");
                Some(1)
            })
        }));
        assert!(fails.is_err() && turns == 3, "it should have panicked in the third turn");
        assert_eq!(run.state.hash(), at, "{threads} threads: the state after two steps and a panic");
        run.steps(4);
        assert_eq!(run.state.hash(), expected, "{threads} threads: further steps");
    }
}

#[test]
fn what_no_spring_is_tied_to_goes_its_own_way() {
    // A link that swings over its limit, a lone point that is pinned beside its end, and one that falls.
    let points = json!([[0, 0, 0], [0, 0, 0], [0, 0, 1], [0, 1, 0], [5, 0, 0]]);
    let net = json!({ "points": points, "links": [[0, 2], [0, 3]], "mass": 0.001 });
    let cloth =
        json!({ "network": net, "strain_limit": 0.01, "stiffness": 1.0, "air_drag": 0.0, "pins": [{ "vertices": [2, 1] }] });
    let mut run = Simulation::new(&json!({ "cloth": [cloth] }));
    let (mut limited, mut time) = (0, 0.0);
    for _ in 0..60 {
        limited += run.steps(1).limited_steps;
        time += run.step_length();
        assert_eq!(run.state.positions.get(1), glam::Vec3::ZERO, "at {time} s");
        assert_eq!(run.state.positions.get(2), glam::Vec3::Z, "at {time} s");
        let fallen = -0.5 * 9.81 * time * time;
        let lone = run.state.positions.get(4);
        assert!((f64::from(lone.z) - fallen).abs() < 0.1 * time && lone.y == 0.0, "{lone} at {time} s instead of {fallen}");
    }
    assert!(limited > 3, "{limited}");
}
