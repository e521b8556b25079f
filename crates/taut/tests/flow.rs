//! Flows that are superposed on the wind, and the laws by which it acts.

use std::f64::consts::{PI, TAU};

use crate::common::{Built, Simulation, mesh_scene, model, scene_of};
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use taut::inputs::Flows;
use taut::model::MeshData;
use taut::scene::Scene;
use taut::state::State;

const G: f64 = 9.81;

fn vortex() -> Value {
    json!({ "kind": "vortex", "centre": [0.3, -0.2, 0.5], "axis": [1.0, 2.0, -2.0], "circulation": 1.7, "core": 0.1 })
}

fn source(flow: f64) -> Value {
    json!({ "kind": "source", "centre": [-0.4, 0.6, 0.1], "flow": flow, "core": 0.2 })
}

fn flows(elements: &[Value]) -> Flows {
    let scene = json!({ "wind": { "elements": elements }, "cloth": [{ "grid": { "cells": [2, 2] } }] });
    model(&scene).inputs.air.expect("wind").flows
}

fn velocity(flows: &Flows, place: DVec3) -> DVec3 {
    let from = |centre: DVec3| (place - centre).as_vec3().to_array();
    let turning = flows.vortices.iter().map(|vortex| vortex.velocity(from(vortex.centre)));
    let spreading = flows.outflows.iter().map(|outflow| outflow.velocity(from(outflow.centre)));
    turning.chain(spreading).map(|velocity| Vec3::from_array(velocity).as_dvec3()).sum()
}

/// Integral of the velocity along a circle.
fn circulation(flows: &Flows, centre: DVec3, normal: DVec3, radius: f64) -> f64 {
    const PARTS: i32 = 400;
    let (across, up) = normal.any_orthonormal_pair();
    let part = |index: i32| {
        let angle = TAU * f64::from(index) / f64::from(PARTS);
        let place = centre + (across * angle.cos() + up * angle.sin()) * radius;
        velocity(flows, place).dot(up * angle.cos() - across * angle.sin()) * TAU * radius / f64::from(PARTS)
    };
    (0..PARTS).map(part).sum()
}

/// Flow out of a sphere: the midpoint rule in the height and in the angle (Archimedes: equal heights are equal areas).
fn outflow(flows: &Flows, centre: DVec3, radius: f64) -> f64 {
    const PARTS: i32 = 120;
    let step = f64::from(PARTS).recip();
    let indices = (0..PARTS).flat_map(|i| (0..PARTS).map(move |j| (i, j)));
    let part = |(i, j): (i32, i32)| {
        let height = -1.0 + 2.0 * (f64::from(i) + 0.5) * step;
        let (around, angle) = ((1.0 - height * height).sqrt(), TAU * (f64::from(j) + 0.5) * step);
        let normal = DVec3::new(around * angle.cos(), around * angle.sin(), height);
        velocity(flows, centre + normal * radius).dot(normal) * 4.0 * PI * radius * radius * step * step
    };
    indices.map(part).sum()
}

#[test]
fn a_vortex_has_its_circulation_on_every_circle_round_it_and_none_on_others() {
    let flows = flows(&[vortex()]);
    let (axis, centre) = (DVec3::new(1.0, 2.0, -2.0) / 3.0, DVec3::new(0.3, -0.2, 0.5));
    for (radius, along) in [(0.11, 0.0), (0.5, 3.0), (4.0, -1.0)] {
        let found = circulation(&flows, centre + axis * along, axis, radius);
        assert!((found / 1.7 - 1.0).abs() < 1e-4, "{found} m^2/s round it at {radius} m");
    }
    // In the core the air turns like a body: the circulation grows with the area.
    let inside = circulation(&flows, centre, axis, 0.05);
    assert!((inside / 1.7 - 0.25).abs() < 1e-4, "{inside} m^2/s in the core");
    let beside = circulation(&flows, centre + axis.any_orthonormal_vector(), axis, 0.7);
    assert!(beside.abs() < 1e-4, "{beside} m^2/s on a circle beside it");
}

#[test]
fn a_source_has_its_flow_through_every_sphere_round_it_and_a_sink_takes_as_much() {
    let centre = DVec3::new(-0.4, 0.6, 0.1);
    for flow in [0.8, -0.8] {
        let flows = flows(&[source(flow)]);
        for radius in [0.21, 1.0, 5.0] {
            let found = outflow(&flows, centre, radius);
            assert!((found / flow - 1.0).abs() < 1e-4, "{found} m^3/s at {radius} m");
        }
        let off = outflow(&flows, centre + DVec3::new(0.3, 0.0, 0.0), 1.0);
        assert!((off / flow - 1.0).abs() < 1e-3, "{off} m^3/s through a sphere about another centre");
    }
}

#[test]
fn outside_of_the_cores_nothing_springs_up_and_nothing_turns() {
    let flows = flows(&[vortex(), source(0.8), source(-0.3)]);
    for centre in [DVec3::new(2.0, 0.0, 0.0), DVec3::new(-1.0, -1.0, 1.0), DVec3::new(0.3, 1.0, -1.2)] {
        assert!(outflow(&flows, centre, 0.4).abs() < 1e-4, "a sphere at {centre} swells");
        for normal in [DVec3::X, DVec3::Y, DVec3::Z] {
            let turning = circulation(&flows, centre, normal, 0.4);
            assert!(turning.abs() < 1e-4, "{turning} m^2/s round {normal} at {centre}");
        }
    }
}

#[test]
fn nowhere_is_the_air_faster_than_the_step_reckons_with() {
    let elements = json!([vortex(), source(-0.8), { "kind": "uniform", "velocity": [0.0, 1.0, 0.0] }]);
    let scene = |elements: Value| {
        let wind = json!({ "velocity": [3.0, 0.0, 0.0], "gust": { "strength": 0.5 }, "elements": elements });
        json!({ "wind": wind, "cloth": [{ "grid": { "cells": [8, 8] } }], "solver": { "filter": "none" } })
    };
    let (calm, blown) = (model(&scene(json!([]))), model(&scene(elements)));
    let air = blown.inputs.air.as_ref().expect("wind");
    assert_eq!(air.velocity(0.0), Vec3::new(3.0, 1.0, 0.0));
    let gusts: f64 = air.waves.iter().map(|wave| f64::from(wave.amplitude.length())).sum();
    let cores = 1.7 / (TAU * 0.1) + 0.8 / (4.0 * PI * 0.04);
    assert!((air.greatest_speed - (10.0_f64.sqrt() + gusts + cores)).abs() < 1e-6, "{} m/s", air.greatest_speed);
    assert!(blown.schedule.bound < calm.schedule.bound, "the flows do not shorten the step");

    let fastest = (0..40_000).map(|index| {
        let along = |factor: f64| -1.0 + 2.0 * (f64::from(index) * factor).fract();
        velocity(&air.flows, DVec3::new(along(0.618_034), along(0.414_214), along(0.732_051))).length()
    });
    let fastest = fastest.fold(0.0, f64::max);
    assert!(fastest <= cores && fastest > 0.5 * cores, "{fastest} m/s, cores allow {cores} m/s");
}

/// A triangle of half a square metre in the x-y plane, tilted about the x axis.
fn plate(law: &str, drag: f64, lift: f64, friction: f64, tilt: f64, wind: [f64; 3]) -> Built {
    let mesh = MeshData {
        vertices: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, tilt.cos(), tilt.sin()]],
        corners: vec![0, 1, 2],
        counts: vec![3],
    };
    let cloth = json!({
        "drag_coefficient": drag, "lift_coefficient": lift, "friction_coefficient": friction, "air_drag": 0.0,
    });
    let rest = json!({ "gravity": [0, 0, 0], "wind": { "velocity": wind, "law": law, "model": "triangle" } });
    mesh_scene(rest, cloth, mesh)
}

fn force(model: &Built, velocity: Vec3) -> DVec3 {
    let mut state = State::new(model);
    (0..model.particle_count()).for_each(|particle| state.velocities.set(particle, velocity));
    let masses = model.particles.mass.iter().map(|&mass| f64::from(mass));
    model.external(&state).iter().zip(masses).map(|(acceleration, mass)| acceleration.as_dvec3() * mass).sum()
}

#[test]
fn drag_goes_with_the_relative_wind_and_lift_across_it() {
    let wind = DVec3::new(1.5, 6.0, -2.0);
    let (dynamic, area) = (0.5 * 1.2 * wind.length_squared(), 0.5);
    for tilt in [0.3, 0.9, 1.4, 2.5] {
        let normal = DVec3::new(0.0, -f64::sin(tilt), f64::cos(tilt));
        let sine = (normal.dot(wind) / wind.length()).abs();
        let of = |law: &str, drag: f64, lift: f64| force(&plate(law, drag, lift, 0.0, tilt, wind.to_array()), Vec3::ZERO);

        let drag = of("drag_lift", 1.3, 0.0);
        let expected = wind.normalize() * (dynamic * 1.3 * area * sine);
        assert!(drag.distance(expected) < 1e-4 * drag.length(), "drag {drag} N instead of {expected} N");

        let lift = of("drag_lift", 0.0, 0.8);
        let size = dynamic * 0.8 * area * sine * (1.0 - sine * sine).sqrt();
        assert!((lift.length() / size - 1.0).abs() < 1e-4, "lift of {} N instead of {size} N", lift.length());
        assert!(lift.dot(wind).abs() < 1e-4 * lift.length() * wind.length(), "lift along the wind");
        assert!(lift.dot(normal) * wind.dot(normal) > 0.0, "lift towards the windward side");

        // The pressure law is a drag of C_d sin^2 and a lift of C_d sin cos.
        let pressure = of("pressure", 1.1, 0.0);
        let split = of("drag_lift", 1.1 * sine, 1.1);
        assert!(pressure.distance(split) < 1e-4 * pressure.length(), "{pressure} N and {split} N");
    }
}

#[test]
fn friction_goes_along_the_cloth_and_nothing_is_felt_in_still_air() {
    let wind = DVec3::new(2.0, 5.0, 1.0);
    let rubbed = force(&plate("pressure", 0.0, 0.0, 0.01, 0.0, wind.to_array()), Vec3::ZERO);
    let along = DVec3::new(2.0, 5.0, 0.0);
    let expected = along * (0.5 * 1.2 * 0.01 * 0.5 * wind.length());
    assert!(rubbed.distance(expected) < 1e-4 * expected.length(), "{rubbed} N instead of {expected} N");
    for law in ["pressure", "drag_lift"] {
        let still = force(&plate(law, 1.2, 1.2, 0.01, 0.7, wind.to_array()), wind.as_vec3());
        assert!(still.length() < 1e-9, "{law}: {still} N on what moves with the air");
    }
}

#[test]
fn the_step_bounds_the_derivative_of_every_law() {
    // The rate of section 4 of docs/equations.md: rho (C_d + C_l + C_f) A |V_rel| bounds |dF/dV|.
    const STEP: f32 = 1e-2;
    for (law, drag, lift, friction) in
        [("pressure", 1.0, 0.0, 0.0), ("pressure", 0.0, 0.0, 1.0), ("drag_lift", 1.0, 0.0, 0.0), ("drag_lift", 0.0, 1.0, 0.0)]
    {
        for tilt in [0.0, 0.2, 0.5, 0.8, 1.1, 1.4] {
            let model = plate(law, drag, lift, friction, tilt, [0.0, 10.0, 0.0]);
            let bound = 1.2 * 0.5 * 10.0;
            let columns = [Vec3::X, Vec3::Y, Vec3::Z]
                .map(|along| (force(&model, along * STEP) - force(&model, along * -STEP)) / (2.0 * f64::from(STEP)));
            // Every direction in the plane of wind and normal, where the derivative is largest.
            let steepest = (0..180).map(|degrees| {
                let angle = f64::from(degrees).to_radians();
                (columns[1] * angle.cos() + columns[2] * angle.sin()).length()
            });
            let steepest = steepest.chain([columns[0].length()]).fold(0.0, f64::max);
            assert!(steepest <= 1.005 * bound, "{law}, tilt {tilt}: {steepest} kg/s over {bound} kg/s");
        }
    }
}

#[test]
fn a_sheet_falls_at_the_speed_of_its_law() {
    // Flat on the air both laws have the same drag; edge on, friction alone holds the sheet.
    for (law, axes, coefficients, end) in [
        ("pressure", ["x", "y"], [1.2, 0.0], 1.2),
        ("drag_lift", ["x", "y"], [1.2, 0.0], 1.2),
        ("pressure", ["x", "z"], [1.2, 0.8], 0.8),
    ] {
        let cloth = json!({
            "grid": { "size": [1.0, 1.0], "cells": [9, 9], "axes": axes }, "density": 0.2, "air_drag": 0.0,
            "stiffness": 50.0, "damping": 0.05, "drag_coefficient": coefficients[0], "friction_coefficient": coefficients[1],
        });
        for form in ["particle", "triangle"] {
            let mut scene = scene_of(cloth.clone(), 30, "sweeps", G);
            scene["wind"] = json!({ "law": law, "model": form });
            let mut run = Simulation::new(&scene);
            run.steps(30 * 60 * 4);
            let speed = -run.state.velocities.z.iter().map(|&z| f64::from(z)).sum::<f64>() / 100.0;
            let expected = (2.0 * 0.2 * G / (1.2 * end)).sqrt();
            assert!((speed / expected - 1.0).abs() < 0.005, "{law}, {form}, {axes:?}: {speed} m/s instead of {expected} m/s");
        }
    }
}

#[test]
fn a_sheet_in_a_uniform_flow_is_carried_away_with_it() {
    let cloth = json!({
        "grid": { "size": [0.5, 0.5], "cells": [8, 8] }, "density": 0.1, "air_drag": 0.0, "stiffness": 50.0, "damping": 0.05,
    });
    let mut scene = scene_of(cloth, 30, "sweeps", 0.0);
    scene["wind"] = json!({ "elements": [{ "kind": "uniform", "velocity": [0.0, 3.0, 0.0] }] });
    let mut run = Simulation::new(&scene);
    run.steps(30 * 60 * 10);
    let time = run.state.time();
    // dv/dt = a (W - v)^2 with a = rho C_d / (2 sigma): W - v = W / (1 + a W t).
    let expected = 3.0 - 3.0 / (1.0 + 0.5 * 1.2 * 1.2 / 0.1 * 3.0 * time);
    let found = run.state.velocities.y.iter().map(|&y| f64::from(y)).sum::<f64>() / 81.0;
    assert!((found / expected - 1.0).abs() < 2e-3, "{found} m/s instead of {expected} m/s");
}

/// A wavy sheet in a vortex and in front of a source.
fn on_wavy_sheet(n: usize, form: &str, law: &str) -> Vec<DVec3> {
    let mut mesh = MeshData::default();
    for j in 0..=n {
        for i in 0..=n {
            let (u, v) = (i as f64 / n as f64, j as f64 / n as f64);
            mesh.vertices.push([u, v, 0.1 * (5.0 * u).sin() * (1.0 + v)]);
        }
    }
    for j in 0..n {
        for i in 0..n {
            let a = (j * (n + 1) + i) as i64;
            mesh.corners.extend([a, a + 1, a + 2 + n as i64, a + 1 + n as i64]);
            mesh.counts.push(4);
        }
    }
    let elements = json!([
        { "kind": "vortex", "centre": [0.4, 0.5, 0.2], "axis": [0, 1, 0], "circulation": 2.0, "core": 0.15 },
        { "kind": "source", "centre": [0.5, 0.3, -0.6], "flow": 4.0, "core": 0.1 },
    ]);
    let rest = json!({
        "gravity": [0, 0, 0], "wind": { "velocity": [2.0, 1.0, 4.0], "elements": elements, "model": form, "law": law },
    });
    let model = mesh_scene(rest, json!({ "air_drag": 0.0, "friction_coefficient": 0.05 }), mesh);
    let state = State::new(&model);
    let masses = model.particles.mass.iter().map(|&mass| f64::from(mass));
    model.external(&state).iter().zip(masses).map(|(acceleration, mass)| acceleration.as_dvec3() * mass).collect()
}

#[test]
fn both_forms_converge_to_each_other_in_a_field_too() {
    for law in ["pressure", "drag_lift"] {
        let difference = |n: usize| {
            let (particle, triangle) = (on_wavy_sheet(n, "particle", law), on_wavy_sheet(n, "triangle", law));
            let apart: f64 = particle.iter().zip(&triangle).map(|(a, b)| a.distance(*b)).sum();
            apart / triangle.iter().map(|force| force.length()).sum::<f64>()
        };
        let errors = [12, 24, 48].map(difference);
        for pair in errors.windows(2) {
            assert!(pair[1] < 0.6 * pair[0], "{law}: refining does not bring the forms together: {errors:?}");
        }
        assert!(errors[2] < 0.04, "{law}: {errors:?}");
    }
}

#[test]
fn elements_that_make_no_sense_are_refused_with_their_field() {
    let refused = |element: Value| {
        let scene = json!({ "wind": { "elements": [vortex(), element] }, "cloth": [{ "grid": {} }] });
        Scene::from_json(&scene.to_string()).expect_err("must be refused").to_string()
    };
    let with = |field: &str, value: Value| {
        let mut element = vortex();
        element[field] = value;
        refused(element)
    };
    assert_eq!(with("core", json!(0.0)), "scene.wind.elements[1].core = 0: must be in [0.001, 100000]; try 0.1");
    assert_eq!(with("axis", json!([0, 0, 0])), "scene.wind.elements[1].axis: has no direction; try [0, 0, 1]");
    assert!(with("circulation", json!(1e9)).starts_with("scene.wind.elements[1].circulation = 1000000000: must be in"));
    assert_eq!(
        with("flow", json!(1.0)),
        "scene.wind.elements[1]: a vortex has centre [m], axis, circulation [m^2/s] and core [m], all of them and nothing else"
    );
    assert!(refused(json!({ "kind": "source", "core": 0.1 })).contains("a source has centre [m], flow"));
    assert!(with("kind", json!("vortx")).contains("did you mean `vortex`?"));
    assert!(with("radius", json!(1.0)).starts_with("scene.wind.elements[1].radius: no such field"));
}
