//! Integrators against exact solutions: orders, growth of vibrations, bounds of the step.

use crate::common::{self, Simulation, chain_links, network, scene_of};
use glam::Vec3;
use serde_json::json;
use taut::geometry::Vectors;

/// Every integrator and its order.
const ORDERS: [(&str, i32); 7] =
    [("euler", 1), ("forward_euler", 1), ("midpoint", 2), ("verlet", 2), ("rk4", 4), ("implicit_euler", 1), ("bdf2", 2)];

/// A mass on a spring of 1 m, pulled out by half of it, at w h of about so much: 1 kg, w = 20 /s. The spring force is linear.
fn oscillator(integrator: &str, filter: &str, damping: f64, substeps: u32) -> Simulation {
    // The mass is at the origin, where single precision is finest.
    let mut cloth = network(&[[0.0, 0.0, -1.0], [0.0; 3]], &[[0, 1]], 1.0);
    (cloth["stiffness"], cloth["damping"], cloth["strain_limit"]) = (json!(400.0), json!(damping), json!(0.9));
    cloth["pins"] = json!([{ "vertices": [0] }]);
    let mut scene = scene_of(cloth, substeps, filter, 0.0);
    scene["fps"] = json!(10.0);
    (scene["solver"]["integrator"], scene["solver"]["force_step"]) = (json!(integrator), json!(true));
    let mut run = Simulation::new(&scene);
    run.state.positions.set(1, Vec3::new(0.0, 0.0, 0.5));
    run
}

const W: f64 = 20.0;

/// Displacement and V / w of the mass on the spring [m].
fn phase(run: &Simulation) -> [f64; 2] {
    [f64::from(run.state.positions.z[1]), f64::from(run.state.velocities.z[1]) / W]
}

/// How far from the exact solution `x'' = -w^2 x - g x'` the oscillator is after one second.
fn error(integrator: &str, damping: f64, substeps: u32) -> f64 {
    let mut run = oscillator(integrator, "none", damping, substeps);
    run.steps(10 * u64::from(substeps));
    let (rate, time) = (0.5 * damping, run.state.time());
    let turning = (W * W - rate * rate).sqrt();
    let decay = 0.5 * (-rate * time).exp();
    let (sine, cosine) = (turning * time).sin_cos();
    let exact = [decay * (cosine + rate / turning * sine), -decay * W / turning * sine];
    let [x, v] = phase(&run);
    (x - exact[0]).hypot(v - exact[1])
}

fn order(errors: &[f64]) -> f64 {
    let last = errors.len() - 1;
    (errors[0] / errors[last]).log2() / last as f64
}

#[test]
fn an_oscillator_converges_with_the_order_of_the_method() {
    for damping in [0.0, 6.0] {
        for (integrator, expected) in ORDERS {
            // w h = 1/2, 1/4, 1/8 with order 4, finer otherwise; single precision must not be seen.
            let coarsest = match expected {
                4 => 4,
                2 => 40,
                _ => 160,
            };
            let errors = [1, 2, 4].map(|finer| error(integrator, damping, coarsest * finer));
            let order = order(&errors);
            assert!((order - f64::from(expected)).abs() < 0.15, "{integrator}, damping {damping}: {order} {errors:?}");
        }
    }
}

/// A small sheet that swings in a gusty wind, damped, with bending, a weight and a pinned edge that is carried about: every force
/// acts, and all of them are smooth.
fn sheet(integrator: &str, stiffness: f64, substeps: u32) -> Vectors {
    let cloth = json!({
        "grid": { "size": [1.0, 1.0], "cells": [4, 4], "origin": [-0.5, 0.0, -1.0] },
        "density": 0.2, "stiffness": stiffness, "shear_stiffness": 0.5 * stiffness, "damping": 0.02, "air_drag": 0.3,
        "bending": 1e-3, "drag_coefficient": 1.2, "weights": [{ "corner": "bottom-right", "mass": 0.01 }],
        "pins": [{ "edge": "top", "move": [[1.0, [0.3, 0.2, 0.0]]] }], "strain_limit": 0.9,
    });
    let mut scene = scene_of(cloth, substeps, "none", 2.0);
    let gust = json!({ "strength": 0.3, "period": 1.0, "seed": 3 });
    (scene["fps"], scene["wind"]) = (json!(5.0), json!({ "velocity": [1.0, 3.0, 0.0], "gust": gust, "model": "triangle" }));
    (scene["solver"]["integrator"], scene["solver"]["force_step"]) = (json!(integrator), json!(true));
    let mut run = Simulation::new(&scene);
    for particle in 0..run.model.particle_count() {
        // Zero where the sheet is held.
        let z = run.state.positions.z[particle];
        run.state.positions.z[particle] = z * 1.2;
        run.state.velocities.set(particle, Vec3::new(0.3 * z, -0.6 * z, 0.2 * z));
    }
    run.steps(2 * u64::from(substeps));
    run.state.positions
}

/// An elastic rope with a load, which swings and keeps it taut.
fn rope(integrator: &str, stiffness: f64, substeps: u32) -> Vectors {
    let points: Vec<[f64; 3]> = (0..6).map(|knot| [0.0, 0.0, -0.2 * f64::from(knot)]).collect();
    let mut cloth = network(&points, &chain_links(5), 0.1);
    (cloth["stiffness"], cloth["damping"], cloth["air_drag"]) = (json!(stiffness), json!(0.05), json!(0.3));
    (cloth["bending"], cloth["weights"]) = (json!(1e-3), json!([{ "vertices": [5], "mass": 0.2 }]));
    cloth["pins"] = json!([{ "vertices": [0], "move": [[1.0, [0.2, 0.1, 0.0]]] }]);
    let mut scene = scene_of(cloth, substeps, "none", 9.81);
    (scene["fps"], scene["solver"]["integrator"]) = (json!(5.0), json!(integrator));
    scene["solver"]["force_step"] = json!(true);
    let mut run = Simulation::new(&scene);
    for particle in 0..6 {
        let z = run.state.positions.z[particle];
        run.state.positions.z[particle] = z * 1.16;
        run.state.velocities.set(particle, Vec3::new(-2.0 * z, z * z, 0.0));
    }
    for _ in 0..2 * substeps {
        run.steps(1);
        let places: Vec<Vec3> = run.state.positions.iter().collect();
        assert!(places.windows(2).all(|pair| pair[0].distance(pair[1]) > 0.2), "{integrator}: a spring is compressed");
    }
    run.state.positions
}

fn apart(one: &Vectors, other: &Vectors) -> f64 {
    let squares = one.iter().zip(other.iter()).map(|(a, b): (Vec3, Vec3)| (a.as_dvec3() - b.as_dvec3()).length_squared());
    (squares.sum::<f64>() / one.len() as f64).sqrt()
}

/// Compares with many steps of the classical Runge-Kutta method.
fn converges(case: fn(&str, f64, u32) -> Vectors, stiffness: f64, methods: &[(&str, i32)]) {
    let reference = case("rk4", stiffness, 100);
    for &(integrator, expected) in methods {
        // Coarse enough that rounding to single precision is not seen.
        let coarsest = if expected == 4 { 7 } else { 32 };
        let errors = [1, 2, 4].map(|finer| apart(&case(integrator, stiffness, coarsest * finer), &reference));
        let order = order(&errors);
        assert!((order - f64::from(expected)).abs() < 0.25, "{integrator}, {stiffness} N/m: {order} {errors:?}");
    }
}

#[test]
fn cloth_under_all_forces_converges_with_the_order_of_the_method() {
    let (bdf2, others) = ORDERS.split_last().expect("there are some");
    converges(sheet, 4.0, others);
    converges(rope, 60.0, &[("rk4", 4), ("implicit_euler", 1), *bdf2]);
    // Some springs of the sheet are compressed, whose derivatives this one leaves out; all other forces it takes in full.
    converges(sheet, 0.0, &[*bdf2]);
}

/// Amplitude of the oscillator before and after so many steps; of velocities half a step late or early the mean is taken.
fn growth(integrator: &str, substeps: u32, steps: u64) -> f64 {
    let mut run = oscillator(integrator, "none", 0.0, substeps);
    run.steps(steps);
    let [x, v] = phase(&run);
    x.hypot(v) / 0.5
}

#[test]
fn vibrations_grow_or_decay_as_the_theory_says() {
    // h w = 1/4; |R(i h w)| is known for each method.
    let (substeps, steps) = (8, 12);
    let z = W * 0.1 / f64::from(substeps);
    let theory = [
        ("forward_euler", (1.0 + z.powi(2)).sqrt()),
        ("midpoint", (1.0 + z.powi(4) / 4.0).sqrt()),
        ("rk4", (1.0 - z.powi(6) / 72.0 + z.powi(8) / 576.0).sqrt()),
    ];
    for (integrator, factor) in theory {
        let (found, expected) = (growth(integrator, substeps, steps), factor.powi(steps as i32));
        assert!((found / expected - 1.0).abs() < 1e-4, "{integrator}: {found} instead of {expected}");
    }
}

#[test]
fn verlet_keeps_the_energy_and_has_the_period_of_its_discrete_oscillator() {
    let mut run = oscillator("verlet", "none", 0.0, 8);
    let step = run.step_length();
    // cos(w' h) = 1 - h^2 w^2 / 2, and X^2 (1 - h^2 w^2 / 4) + V^2 / w^2 is conserved.
    let turn = (1.0 - 0.5 * (W * step).powi(2)).acos();
    let squeeze = 1.0 - (0.5 * W * step).powi(2);
    for number in 1..=20_000_u32 {
        run.steps(1);
        let [x, v] = phase(&run);
        let energy = (squeeze * x * x + v * v) / (0.25 * squeeze);
        assert!((energy - 1.0).abs() < 2e-3, "step {number}: {energy}");
        if number == 500 {
            let expected = 0.5 * (turn * f64::from(number)).cos();
            assert!((x - expected).abs() < 1e-3, "{x} instead of {expected}");
        }
    }
}

#[test]
fn the_bound_of_the_step_is_where_vibrations_begin_to_grow() {
    // A spring between a pin and a mass meets the bound on w with equality.
    for (integrator, reach) in [("euler", 2.0), ("verlet", 2.0), ("rk4", 2.82)] {
        let bound = oscillator(integrator, "none", 0.0, 1).model.schedule.bound;
        assert!((bound * W / reach - 1.0).abs() < 1e-6, "{integrator}: {bound} s");
        for (part, stable) in [(0.98, true), (1.02, false)] {
            let mut scene = scene_of(network(&[[0.0, 0.0, -1.0], [0.0; 3]], &[[0, 1]], 1.0), 1, "none", 0.0);
            (scene["cloth"][0]["stiffness"], scene["fps"]) = (json!(400.0), json!(1.0 / (bound * part)));
            (scene["cloth"][0]["pins"], scene["solver"]["force_step"]) = (json!([{ "vertices": [0] }]), json!(true));
            scene["solver"]["integrator"] = json!(integrator);
            let mut run = Simulation::new(&scene);
            run.state.positions.set(1, Vec3::new(0.0, 0.0, 1e-3));
            let largest = (0..60).map(|_| {
                run.steps(1);
                phase(&run)[0].abs()
            });
            let largest = largest.fold(0.0, f64::max);
            assert_eq!(largest < 0.02, stable, "{integrator} at {part} of its bound reaches {largest} m");
        }
    }
}

#[test]
fn what_grows_at_any_step_grows_by_e_in_ten_seconds_at_its_bound() {
    // Without damping, by dampers and by drag.
    for (damping, drag) in [(0.0, 0.0), (0.0, 0.5), (0.4, 0.0)] {
        for integrator in ["forward_euler", "midpoint"] {
            let mut cloth = network(&[[0.0, 0.0, -1.0], [0.0; 3]], &[[0, 1]], 1.0);
            (cloth["stiffness"], cloth["damping"], cloth["air_drag"]) = (json!(40.0), json!(damping), json!(drag));
            cloth["pins"] = json!([{ "vertices": [0] }]);
            let mut scene = scene_of(cloth, 1, "none", 0.0);
            (scene["solver"]["integrator"], scene["solver"]["substeps"]) = (json!(integrator), json!("auto"));
            let bound = common::model(&scene).schedule.bound;
            (scene["fps"], scene["solver"]["substeps"]) = (json!(1.0 / (0.9999 * bound)), json!(1));
            let mut run = Simulation::new(&scene);
            run.state.positions.set(1, Vec3::new(0.0, 0.0, 0.1));
            let steps = (10.0 / run.step_length()) as u64;
            run.steps(steps);
            let (x, v) = (f64::from(run.state.positions.z[1]), f64::from(run.state.velocities.z[1]) / 40.0_f64.sqrt());
            let factor = x.hypot(v) / 0.1;
            // Drag turns the circle of X and V / w into an ellipse.
            assert!((1.3..1.02 * std::f64::consts::E).contains(&factor), "{integrator}, {damping}, {drag}: {factor}");
            assert!(run.model.warnings.iter().any(|text| text.contains(integrator)), "{:?}", run.model.warnings);
        }
    }
}

#[test]
fn forward_euler_stays_slow_where_a_filter_takes_back_all_of_its_motion() {
    // A weight between two pins, with h g = 1.4 at the bound of a damped vibration alone.
    let mut cloth = network(&[[0.0, 0.0, -1.0], [0.0; 3], [0.0, 0.0, 1.0]], &[[0, 1], [1, 2]], 1.0);
    (cloth["stiffness"], cloth["damping"], cloth["strain_limit"]) = (json!(40.0), json!(5.6), json!(0.05));
    cloth["pins"] = json!([{ "vertices": [0, 2] }]);
    let mut scene = scene_of(cloth, 1, "coarse_to_fine", -9.81);
    (scene["solver"]["integrator"], scene["solver"]["substeps"]) = (json!("forward_euler"), json!("auto"));
    scene["fps"] = json!(1.0);
    let mut run = Simulation::new(&scene);
    run.state.velocities.set(1, Vec3::new(0.0, 0.0, 10.0));
    for step in 0..500 {
        run.steps(1);
        let speed = run.state.velocities.z[1].abs();
        assert!(speed < 12.0, "step {step}: {speed} m/s");
    }
}

#[test]
fn implicit_euler_takes_from_every_vibration_what_the_theory_says() {
    for (substeps, steps) in [(8, 40), (1, 10)] {
        let z = W * 0.1 / f64::from(substeps);
        let (found, expected) = (growth("implicit_euler", substeps, steps), (1.0 + z * z).sqrt().powi(-(steps as i32)));
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} instead of {expected}");
        // The second order keeps much more of what is slower than the step, and grows in no case.
        let kept = growth("bdf2", substeps, steps);
        assert!(kept < 1.0 && kept > 2.0 * expected, "{kept} against {expected}");
    }
}

#[test]
fn implicit_methods_are_stable_at_a_sixtieth_of_a_second_with_a_thousand_times_the_stiffness() {
    for integrator in ["implicit_euler", "bdf2"] {
        let cloth = json!({
            "grid": { "size": [1.0, 1.0], "cells": [16, 16], "axes": ["x", "y"] }, "density": 0.13,
            "stiffness": 20e3, "shear_stiffness": 10e3, "damping": 0.0, "air_drag": 0.15, "pins": [{ "corner": "top-left" }],
        });
        let mut scene = scene_of(cloth, 1, "none", 9.81);
        scene["solver"]["integrator"] = json!(integrator);
        let mut run = Simulation::new(&scene);
        let explicit = {
            scene["solver"]["integrator"] = json!("euler");
            scene["solver"]["force_step"] = json!(true);
            common::model(&scene).schedule.bound
        };
        assert!(run.step_length() > 100.0 * explicit);
        let energy = |run: &mut Simulation| {
            let last = run.steps(0).last;
            last.kinetic_energy + last.elastic_energy + last.potential_energy
        };
        let mut before = energy(&mut run);
        for second in 0..5 {
            let worst = run.steps(60).worst_stretch;
            let now = energy(&mut run);
            assert!(worst < 0.02, "{integrator}, second {second}: stretched by {worst}");
            assert!(now < before + 0.01, "{integrator}, second {second}: {before} J became {now} J");
            before = now;
        }
    }
}
