//! Velocities that users see are those of the motion, whatever the integrator goes on with.

use crate::common::{Simulation, chain_links, network, scene_of, sheet};
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use taut::geometry::Vectors;
use taut::inputs::Grips;
use taut::state::State;

const GRAVITY: f64 = 9.81;
/// What may be left of a velocity at rest [m/s].
const REST: f32 = 5e-3;
const INTEGRATORS: [&str; 7] = ["euler", "forward_euler", "midpoint", "rk4", "verlet", "implicit_euler", "bdf2"];
const FILTERS: [&str; 8] = ["coarse_to_fine", "sweeps", "none", "provot", "rods", "fast_projection", "tethers", "xpbd"];

/// A string of 1 m from a pin at the origin, down or sideways, with a bead at each of its joints. Its springs are so stiff that
/// they take several parts of a step.
fn string(links: u32, along: Vec3) -> Value {
    let point = |bead: u32| {
        let at = (along * (bead as f32 / links as f32)).as_dvec3();
        [at.x, at.y, at.z]
    };
    let points: Vec<[f64; 3]> = (0..=links).map(point).collect();
    let mut cloth = network(&points, &chain_links(links), 0.1);
    (cloth["strain_limit"], cloth["pins"], cloth["stiffness"]) = (json!(1e-3), json!([{ "vertices": [0] }]), json!(2e5));
    cloth
}

/// As many steps as the engine likes.
fn automatic(cloth: Value, gravity: f64) -> Simulation {
    let mut scene = scene_of(cloth, 1, "coarse_to_fine", gravity);
    scene["solver"]["substeps"] = json!("auto");
    Simulation::new(&scene)
}

fn fastest(velocities: &Vectors) -> f32 {
    velocities.iter().map(Vec3::length).fold(0.0, f32::max)
}

/// Sum of M V [kg m/s].
fn momentum(run: &Simulation, velocities: &Vectors) -> DVec3 {
    let masses = run.model.particles.mass.iter();
    velocities.iter().zip(masses).map(|(velocity, mass)| velocity.as_dvec3() * f64::from(*mass)).sum()
}

#[test]
fn what_hangs_still_has_no_velocity() {
    let mut sheet = sheet([16, 16], 0.05, json!([{ "edge": "top" }]));
    (sheet["grid"]["axes"], sheet["grid"]["origin"], sheet["air_drag"]) = (json!(["x", "z"]), json!([0, 0, 0]), json!(4.0));
    for (cloth, steps) in [(string(32, Vec3::NEG_Z), 400), (sheet, 1500)] {
        let mut run = automatic(cloth, GRAVITY);
        let last = run.steps(steps).last;
        let [own, told] = [&run.state.velocities, run.state.of_motion()].map(fastest);
        let half = (0.5 * GRAVITY * run.step_length()) as f32;
        // Springs that have room below their limit still bear a part.
        assert!((0.5..1.2).contains(&(own / half)), "V is about that of half a step's fall, {half} m/s, not {own} m/s");
        assert!(told < REST, "{told} m/s");
        let still: f32 = run.model.particles.mass.iter().sum::<f32>() * 0.5 * REST * REST;
        assert!(last.kinetic_energy < f64::from(still), "{} J", last.kinetic_energy);
    }
}

#[test]
fn nor_has_it_with_any_integrator_and_filter_or_with_steps_that_change() {
    for integrator in INTEGRATORS {
        for filter in FILTERS {
            let mut cloth = string(1, Vec3::NEG_Z);
            // What is no rod hangs by its spring where there is no limit; one that a rod replaces has no force.
            (cloth["stiffness"], cloth["damping"], cloth["air_drag"]) = (json!(50.0), json!(0.5), json!(5.0));
            cloth["strain_limit"] = json!(0.01);
            let mut scene = scene_of(cloth, 10, filter, GRAVITY);
            scene["solver"]["integrator"] = json!(integrator);
            let mut run = Simulation::new(&scene);
            run.steps(4000);
            let from = run.state.positions.get(1);
            run.steps(1);
            let trembles = (run.state.positions.get(1) - from).length() / run.step_length() as f32;
            let told = fastest(run.state.of_motion());
            assert!(told < REST + 2.0 * trembles && trembles < REST, "{integrator}, {filter}: {told} m/s");
            let mut before = run.step_length();
            for part in [0.3, 0.3, 0.9, 0.5, 0.5, 1.0] {
                let (from, step) = (run.state.positions.get(1), part * run.step_length());
                run.try_steps(1, step).expect("takes it");
                let moved = (run.state.positions.get(1) - from) / step as f32;
                let off = (run.state.of_motion().get(1) - moved).length();
                // V holds the weight of half a step, with forward Euler of all of it, and in steps of another length another one.
                let jerk = (0.5 * GRAVITY * (step - before).abs()) as f32;
                assert!(off < jerk + moved.length() + REST, "{integrator}, {filter}, {part} of a step: {off} m/s");
                before = step;
            }
        }
    }
}

#[test]
fn a_pendulum_has_the_speed_of_its_swing() {
    let mut run = Simulation::new(&scene_of(string(1, Vec3::X), 2, "coarse_to_fine", GRAVITY));
    assert!(run.model.schedule.plan(&run.model, run.step_length()).cloths[0].parts() > 1);
    let step = run.step_length();
    let mut places = vec![run.state.positions.get(1).as_dvec3()];
    let mut told = vec![Vec3::ZERO];
    for _ in 0..(1.0 / step) as usize {
        let last = run.steps(1).last;
        let (place, velocity) = (run.state.positions.get(1).as_dvec3(), run.state.of_motion().get(1));
        places.push(place);
        told.push(velocity);
        let mass = f64::from(run.model.particles.mass[1]);
        assert!((last.kinetic_energy - 0.5 * mass * f64::from(velocity.length_squared())).abs() < 1e-6);
        if place.z < -0.1 {
            let exact = (-2.0 * GRAVITY * place.z).sqrt();
            let speed = f64::from(velocity.length());
            assert!((speed / exact - 1.0).abs() < 0.02, "{speed} instead of {exact} m/s");
            assert!((last.kinetic_energy / (-mass * GRAVITY * place.z) - 1.0).abs() < 0.04);
        }
    }
    let (mut off, mut all) = (0.0, 0.0);
    for (place, velocity) in places.windows(3).zip(&told[1..]) {
        let moved = (place[2] - place[0]) / (2.0 * step);
        off += (velocity.as_dvec3() - moved).length_squared();
        all += moved.length_squared();
    }
    let off = (off / all).sqrt();
    assert!(off < 0.01, "off the motion by {off}");
}

#[test]
fn what_falls_freely_is_as_fast_as_gravity_makes_it() {
    for substeps in [json!("auto"), json!(40)] {
        let mut scene = scene_of(sheet([8, 8], 0.05, json!([])), 1, "coarse_to_fine", GRAVITY);
        (scene["solver"]["substeps"], scene["cloth"][0]["air_drag"]) = (substeps, json!(0.0));
        let mut run = Simulation::new(&scene);
        for _ in 0..60 {
            run.steps(1);
            let expected = -GRAVITY * run.state.time();
            for (own, told) in run.state.velocities.iter().zip(run.state.of_motion().iter()) {
                assert!((f64::from(told.z) / expected - 1.0).abs() < 1e-3, "{told} instead of {expected} m/s");
                assert!((told - own).length() < 1e-3);
            }
        }
    }
}

#[test]
fn momentum_is_that_of_what_is_free() {
    let mut cloth = network(&[[0.0; 3], [1.0, 0.0, 0.0]], &[[0, 1]], 0.1);
    cloth["strain_limit"] = json!(0.05);
    let mut run = automatic(cloth, 0.0);
    run.state.set_velocities([Vec3::new(1.0, -2.0, 0.0), Vec3::new(1.0, 2.0, 0.0)].into_iter().collect());
    let before = momentum(&run, run.state.of_motion());
    for _ in 0..600 {
        run.steps(1);
        let off = (momentum(&run, run.state.of_motion()) - before).length() / before.length();
        assert!(off < 1e-6, "{off}");
    }
}

#[test]
fn what_is_held_has_the_velocity_of_its_target() {
    let mut run = automatic(string(4, Vec3::X), GRAVITY);
    run.inputs.grips.hold(2, taut::inputs::Target { place: DVec3::new(0.4, 0.0, 0.2), arrival: 0.5 });
    let mut before = run.state.positions.clone();
    for _ in 0..20 {
        run.steps(1);
        for held in [0, 2] {
            let moved = (run.state.positions.get(held) - before.get(held)) / run.step_length() as f32;
            assert!((run.state.of_motion().get(held) - moved).length() < 1e-6, "{held}");
        }
        before.copy_from(&run.state.positions);
    }
}

#[test]
fn they_are_part_of_the_state() {
    let mut run = automatic(string(8, Vec3::X), GRAVITY);
    run.steps(50);
    assert_ne!(run.state.of_motion(), &run.state.velocities);
    let told = run.state.of_motion().clone();
    let hash = run.state.hash();

    // What does not stay finite leaves all of it as it was.
    let before = run.state.clone();
    run.inputs.gravity = taut::inputs::Track::constant(DVec3::new(0.0, 0.0, -1e38));
    run.try_steps(40, run.step_length()).expect_err("too much");
    run.inputs.gravity = run.model.inputs.gravity.clone();
    assert_eq!((&run.state, run.state.hash()), (&before, hash));

    let bytes = run.state.to_bytes(&run.model, &Grips::default());
    let (read, _) = State::from_bytes(&bytes, &run.model).expect("is whole");
    assert_eq!(read, run.state);
    // A cache keeps what users see, and the memory.
    let State { positions, clock, .. } = run.state.clone();
    let mut resumed = State { clock, ..State::at(&run.model, positions, told.clone(), run.state.clock) };
    for (vectors, kept) in resumed.memory_mut().zip(run.state.memory()) {
        vectors.clone_from(kept);
    }
    assert_eq!(resumed, run.state);
    run.steps(20);
    let expected = run.state.clone();
    for state in [read, resumed] {
        run.state = state;
        run.steps(20);
        assert_eq!(run.state, expected);
    }

    // Those that are given are told until the next step.
    let given: Vectors = (0..9).map(|bead| Vec3::splat(bead as f32)).collect();
    run.state.set_velocities(given.clone());
    assert_eq!((run.state.of_motion(), &run.state.velocities), (&given, &given));
    run.steps(0);
    assert_eq!(run.state.of_motion(), &given);
}

#[test]
fn there_is_no_second_array_where_velocities_are_those_of_the_motion() {
    for (integrator, filter, apart) in [
        ("euler", "none", false),
        ("euler", "sweeps", false),
        ("euler", "coarse_to_fine", true),
        ("verlet", "none", false),
        ("verlet", "sweeps", true),
        ("implicit_euler", "sweeps", false),
    ] {
        let mut scene = scene_of(string(1, Vec3::X), 60, filter, GRAVITY);
        scene["solver"]["integrator"] = json!(integrator);
        let mut run = Simulation::new(&scene);
        run.steps(3);
        assert_eq!(!run.state.motion.is_empty(), apart, "{integrator}, {filter}");
    }
}
