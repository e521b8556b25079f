//! Cloth on bodies, on cloth and on itself: nothing crosses anything, the limit is kept, friction is Coulomb's. What is looked at is
//! measured here, by other means than those of the engine.

use crate::common::oracle::{crossings, places};
use crate::common::{Simulation, crooked, mesh_scene};
use glam::DVec3;
use proptest::prelude::*;
use serde_json::{Value, json};
use taut::geometry::CHUNK;
use taut::model::MeshData;
use taut::state::State;

/// A sheet of so many cells along each side, crooked but for its border; `place` takes coordinates from 0 to 1.
fn sheet(cells: u32, place: impl Fn(f64, f64) -> DVec3) -> MeshData {
    let mut mesh = crooked(cells);
    mesh.vertices.iter_mut().for_each(|vertex| *vertex = place(vertex[0], vertex[1]).into());
    mesh
}

fn cloth() -> Value {
    json!({ "density": 0.2, "strain_limit": 0.05, "thickness": 0.004, "friction": 0.3 })
}

fn simulation(rest: Value, cloth: Value, mesh: MeshData) -> Simulation {
    Simulation::of(mesh_scene(rest, cloth, mesh))
}

fn floor() -> Value {
    json!({ "plane": { "point": [0, 0, 0], "normal": [0, 0, 1] }, "friction": 0.3 })
}

/// The distance from a point to a triangle.
fn distance(p: DVec3, corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let inside = [(a, b), (b, c), (c, a)].iter().all(|(from, to)| (*to - *from).cross(p - *from).dot(normal) >= 0.0);
    if inside {
        return (p - a).dot(normal.normalize()).abs();
    }
    let to_edge = |(from, to): (DVec3, DVec3)| {
        let part = ((p - from).dot(to - from) / (to - from).length_squared()).clamp(0.0, 1.0);
        p.distance(from.lerp(to, part))
    };
    [(a, b), (b, c), (c, a)].into_iter().map(to_edge).fold(f64::INFINITY, f64::min)
}

/// The least distance of all triangles from a point.
fn nearest(run: &Simulation, point: DVec3) -> f64 {
    let x = places(run);
    let triangles = run.model.triangles.iter().map(|corners| corners.map(|corner| x[corner as usize]));
    triangles.map(|corners| distance(point, corners)).fold(f64::INFINITY, f64::min)
}

/// Steps frame by frame; every step is measured by the engine, every sixth frame is looked at here.
fn run(run: &mut Simulation, frames: u64, mut look: impl FnMut(&Simulation)) {
    let steps = run.model.schedule.substeps.into();
    let limit = run.model.cloths.iter().map(|cloth| cloth.strain_limit).fold(0.0, f64::max);
    for frame in 1..=frames {
        let report = run.steps(steps);
        assert!(report.worst_stretch <= limit * (1.0 + 1e-5), "frame {frame}: stretched by {}", report.worst_stretch);
        if frame % 6 == 0 {
            assert_eq!(crossings(run), 0, "frame {frame}");
            look(run);
        }
    }
}

#[test]
fn a_sheet_drapes_over_a_ball() {
    let (centre, radius) = (DVec3::new(0.03, 0.02, 0.4), 0.3);
    let bodies = json!([floor(), { "sphere": { "center": centre.to_array(), "radius": radius }, "friction": 0.3 }]);
    let mesh = sheet(20, |u, v| DVec3::new(u - 0.5, v - 0.5, 0.75));
    let mut sheet = simulation(json!({ "body": bodies }), cloth(), mesh);
    run(&mut sheet, 90, |sheet| {
        assert!(nearest(sheet, centre) > radius, "whole triangles stay outside");
        assert!(places(sheet).iter().all(|place| place.z > 0.0));
    });
    let middle: DVec3 = places(&sheet).iter().sum::<DVec3>() / 441.0;
    assert!((0.4..0.5).contains(&middle.z), "it lies on the ball: {middle}");
    let off = nearest(&sheet, centre) - radius;
    assert!(off > 0.0003 && off < 0.0035, "neither nearer than the floor nor hovering: {off}");
}

#[test]
fn cloth_that_lies_on_something_comes_to_rest() {
    let shapes = [
        json!({ "sphere": { "center": [0.03, 0.02, 0.4], "radius": 0.3 } }),
        json!({ "capsule": { "from": [-0.3, 0, 0.45], "to": [0.3, 0.05, 0.45], "radius": 0.1 } }),
        json!({ "box": { "center": [0.02, 0.01, 0.3], "size": [0.5, 0.4, 0.4] } }),
    ];
    for shape in shapes {
        let mut calm = cloth();
        (calm["bending"], calm["air_drag"]) = (json!("fabric"), json!(1.5));
        let mesh = sheet(20, |u, v| DVec3::new(u - 0.5, v - 0.5, 0.75));
        let mut sheet = simulation(json!({ "body": [floor(), shape] }), calm, mesh);
        run(&mut sheet, 450, |_| ());
        let mut frames = vec![places(&sheet)];
        for _ in 0..100 {
            run(&mut sheet, 1, |_| ());
            frames.push(places(&sheet));
        }
        let jerk = |three: &[Vec<DVec3>]| {
            let [before, now, after] = [0, 1, 2].map(|frame| &three[frame]);
            let jerks =
                before.iter().zip(now).zip(after).map(|((before, now), after)| (*before - *now * 2.0 + *after).length_squared());
            (jerks.sum::<f64>() / now.len() as f64).sqrt()
        };
        let mut jerks: Vec<f64> = frames.windows(3).map(jerk).collect();
        jerks.sort_by(f64::total_cmp);
        // It may slip a little now and then, but does not tremble.
        let jerk = jerks[jerks.len() / 2];
        assert!(jerk < 2e-5, "on {shape} it jerks by {jerk} m");
    }
}

#[test]
fn a_ball_that_turns_takes_its_cloth_along() {
    let ball = json!({
        "sphere": { "center": [0, 0, 0.4], "radius": 0.3 }, "friction": 1.0,
        "turn": { "axis": [0, 0, 1], "point": [0, 0, 0], "angle": [[1.5, 0], [3.5, 90]] },
    });
    let mut cloth = cloth();
    (cloth["friction"], cloth["bending"], cloth["air_drag"]) = (json!(1.0), json!("fabric"), json!(1.5));
    let mesh = sheet(16, |u, v| DVec3::new(u - 0.5, v - 0.5, 0.72));
    let mut sheet = simulation(json!({ "body": [ball] }), cloth, mesh);
    run(&mut sheet, 90, |_| ());
    let before = places(&sheet);
    run(&mut sheet, 150, |_| ());
    let turned: f64 = before.iter().zip(places(&sheet)).map(|(a, b)| (a.x * b.y - a.y * b.x).atan2(a.x * b.x + a.y * b.y)).sum();
    let mean = (turned / before.len() as f64).to_degrees();
    assert!((mean - 90.0).abs() < 3.0, "it has turned by {mean} degrees");
}

#[test]
fn what_is_joined_by_few_edges_does_not_collapse() {
    let mesh = sheet(16, |u, v| DVec3::new(0.6 * u - 0.3, 0.012 * (6.0 * v).sin(), 0.03 + 0.6 * v));
    let mut sheet = simulation(json!({ "body": [floor()] }), cloth(), mesh);
    sheet.steps(60 * u64::from(sheet.model.schedule.substeps));
    let report = sheet.steps(60 * u64::from(sheet.model.schedule.substeps));
    assert!(report.closest.expect("it lies in a heap") > 0.25 * 0.1 * 0.004, "{report:?}");
    assert!(report.contact_cuts * 50 <= report.steps, "{report:?}");
}

#[test]
fn sheets_hang_on_boxes_and_capsules_as_grids_too() {
    let shapes = [
        json!({ "box": { "center": [0.02, 0.01, 0.3], "size": [0.4, 0.4, 0.4], "rotate": [0, 0, 17] } }),
        json!({ "box": { "center": [0, 0, 0.3], "size": [0.4, 0.4, 0.4], "rotate": [45, 35.264, 0] } }),
        json!({ "capsule": { "from": [-0.3, 0, 0.45], "to": [0.3, 0.05, 0.45], "radius": 0.1 } }),
    ];
    for shape in shapes {
        let mut grid = cloth();
        grid["grid"] = json!({ "size": [0.9, 0.9], "cells": [16, 16], "axes": ["x", "y"], "origin": [-0.45, -0.45, 0.7] });
        let mut sheet = Simulation::new(&json!({ "body": [floor(), shape], "cloth": [grid] }));
        run(&mut sheet, 60, |_| ());
        let middle: DVec3 = places(&sheet).iter().sum::<DVec3>() / 289.0;
        assert!(middle.z > 0.15, "it hangs on {shape}: {middle}");
    }
}

#[test]
fn a_sheet_falls_on_its_edge_and_heaps() {
    let mesh = sheet(16, |u, v| DVec3::new(0.6 * u - 0.3, 0.012 * (6.0 * v).sin(), 0.03 + 0.6 * v));
    let mut sheet = simulation(json!({ "body": [floor()] }), cloth(), mesh);
    run(&mut sheet, 72, |_| ());
    let highest = places(&sheet).iter().map(|place| place.z).fold(0.0, f64::max);
    assert!(highest < 0.2, "it lies in a heap: {highest}");
}

#[test]
fn layers_lie_as_high_as_they_are_thick() {
    let mut layers = Vec::new();
    for index in 0..4 {
        let mut layer = cloth();
        let height = 0.01 + 0.015 * f64::from(index);
        layer["grid"] =
            json!({ "size": [0.3, 0.3], "cells": [10, 10], "axes": ["x", "y"], "origin": [0.003 * f64::from(index), 0, height] });
        layers.push(layer);
    }
    let mut stack = Simulation::new(&json!({ "body": [floor()], "cloth": layers }));
    run(&mut stack, 60, |_| ());
    for (index, cloth) in stack.model.cloths.iter().enumerate() {
        let x = places(&stack);
        let height = cloth.particles().map(|particle| x[particle].z).sum::<f64>() / cloth.count as f64;
        // Half of the lowest one and the skin of the floor, and so many whole ones.
        let exact = 0.003 + 0.004 * index as f64;
        assert!((height - exact).abs() < 0.02 * 0.016, "layer {index} is at {height} instead of {exact}");
    }
}

/// How far a small sheet slides down a slope within a second [m].
fn slides(degrees: f64, friction: f64) -> f64 {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let plane = json!({ "plane": { "point": [0, 0, 0], "normal": [sine, 0, cosine] }, "friction": friction });
    let height = 0.003 + 1e-6;
    let mesh = sheet(8, |u, v| {
        let along = 0.2 * (u - 0.5);
        DVec3::new(along * cosine + height * sine, 0.2 * (v - 0.5), height * cosine - along * sine)
    });
    let mut of_cloth = cloth();
    of_cloth["friction"] = json!(friction);
    of_cloth["air_drag"] = json!(0.0);
    let mut sheet = simulation(json!({ "body": [plane] }), of_cloth, mesh);
    let before: DVec3 = places(&sheet).iter().sum();
    let steps = 60 * u64::from(sheet.model.schedule.substeps);
    sheet.steps(steps);
    let after: DVec3 = places(&sheet).iter().sum();
    ((after - before) / 81.0).dot(DVec3::new(cosine, 0.0, -sine))
}

#[test]
fn friction_is_that_of_coulomb() {
    for friction in [0.2_f64, 0.5] {
        let slope = friction.atan().to_degrees();
        let stuck = slides(0.95 * slope, friction);
        assert!(stuck.abs() < 1e-4, "slid by {stuck} at {friction}");
        let steeper = 1.1 * slope;
        let (sine, cosine) = steeper.to_radians().sin_cos();
        let exact = 0.5 * 9.81 * (sine - friction * cosine);
        let slid = slides(steeper, friction);
        // A step holds at its end what gained speed during it: half a step of time.
        assert!((slid / exact - 1.0).abs() < 0.04, "slid by {slid} instead of {exact} at {friction}");
    }
}

/// A ball that is thrown at a hanging sheet after 0.1 s [m/s].
fn shot(speed: f64) -> Simulation {
    let thrown = json!({
        "sphere": { "center": [0.3, -0.4, 0.3], "radius": 0.08 },
        "move": [[0.1, [0, 0, 0]], [0.1 + 0.8 / speed, [0, 0.8, 0]]],
    });
    let mut held = cloth();
    held["pins"] = json!([{ "box": [[-1, -1, 0.599], [1, 1, 0.7]] }]);
    simulation(json!({ "body": [thrown] }), held, sheet(14, |u, v| DVec3::new(0.6 * u, 0.0, 0.6 * v)))
}

#[test]
fn a_fast_ball_does_not_pass_a_sheet() {
    for speed in [5.0, 20.0] {
        let mut sheet = shot(speed);
        let outside = |sheet: &Simulation| {
            let centre = sheet.state.bodies[0];
            assert!(nearest(sheet, centre) > 0.08, "{speed} m/s: whole triangles stay outside");
        };
        run(&mut sheet, 8 + (48.0 / speed) as u64, outside);
        assert!((sheet.state.bodies[0].y - 0.4).abs() < 1e-9, "{speed} m/s: it has arrived");
        // Later the sheet swings back, above the ball or beside it.
        let lowest = places(&sheet).iter().map(|place| place.y).fold(f64::INFINITY, f64::min);
        assert!(lowest > -0.1, "{speed} m/s: the sheet is not behind it, {lowest}");
        run(&mut sheet, 24, outside);
    }
}

#[test]
fn what_would_be_cut_is_taken_in_parts_which_snapshots_remember() {
    let (mut halved, mut cut) = (0, 0);
    for speed in [30.0, 34.0, 38.0] {
        let mut sheet = shot(speed);
        for step in 0..30 {
            let snapshot = sheet.state.to_bytes(&sheet.model, &sheet.inputs.grips);
            let report = sheet.steps(1);
            assert!(report.contact_cuts > 0 || report.held_back_bodies == 0, "{speed} m/s, step {step}");
            halved += report.halved_steps;
            cut += report.contact_cuts;
            let (state, _) = State::from_bytes(&snapshot, &sheet.model).expect("a snapshot");
            let mut other = shot(speed);
            other.state = state;
            other.steps(1);
            assert_eq!(other.state.hash(), sheet.state.hash(), "{speed} m/s, step {step}");
        }
    }
    // Of 40 speeds from 20 to 59 m/s 28 steps are cut, and 202 taken in parts.
    assert!(halved > 0 && 5 * cut <= halved, "{cut} cut, {halved} in parts");
}

#[test]
fn what_touches_nothing_moves_as_without_contact() {
    let (mut without, mut with) = {
        let mut free = cloth();
        free["pins"] = json!([{ "vertices": [0] }]);
        let mesh = sheet(12, |u, v| DVec3::new(u, v, 0.0));
        let alone = json!({ "contact": { "self": false } });
        let mut far = alone.clone();
        far["body"] = json!([{ "sphere": { "center": [0, 0, 50], "radius": 1.0 } }]);
        (simulation(alone, free.clone(), mesh.clone()), simulation(far, free, mesh))
    };
    for step in 0..60 {
        without.steps(1);
        with.steps(1);
        assert!(without.state.positions == with.state.positions, "step {step}");
    }
}

#[test]
fn bits_do_not_depend_on_threads() {
    let hash = |threads: usize| {
        let bodies = json!([floor(), { "sphere": { "center": [0.03, 0.02, 0.4], "radius": 0.3 } }]);
        let mesh = sheet(72, |u, v| DVec3::new(u - 0.5, v - 0.5, 0.72));
        let model = mesh_scene(json!({ "body": bodies }), cloth(), mesh);
        let mut sheet = Simulation::with_threads(model, threads);
        sheet.steps(23);
        let report = sheet.steps(1);
        assert!(report.contacts > 2 * CHUNK as u64, "{} rows are too few to be handed to several threads", report.contacts);
        sheet.state.hash()
    };
    let hashes = [1, 2, 3, 8].map(hash);
    assert!(hashes.iter().all(|&hash| hash == hashes[0]), "{hashes:x?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn random_bodies_are_not_passed(
        kind in 0_usize..3,
        at in prop::array::uniform3(-0.15_f64..0.15),
        size in 0.05_f64..0.2,
        turn in prop::array::uniform3(0.0_f64..90.0),
        speed in prop::array::uniform3(-2.0_f64..2.0),
        thickness in 0.001_f64..0.008,
        friction in 0.0_f64..0.8,
    ) {
        let [x, y, z] = at;
        let mut body = match kind {
            0 => json!({ "sphere": { "center": [x, y, z], "radius": size } }),
            1 => json!({ "capsule": { "from": [x - 0.2, y, z], "to": [x + 0.2, y + 0.1, z], "radius": 0.6 * size } }),
            _ => json!({ "box": { "center": [x, y, z], "size": [size, 1.5 * size, size], "rotate": turn } }),
        };
        body["friction"] = json!(friction);
        body["move"] = json!([[0.1, [0, 0, 0]], [0.3, speed.map(|part| 0.2 * part)]]);
        let mut of_cloth = cloth();
        of_cloth["thickness"] = json!(thickness);
        of_cloth["friction"] = json!(friction);
        let mesh = sheet(12, |u, v| DVec3::new(0.6 * u - 0.3, 0.6 * v - 0.3, 0.4));
        let mut sheet = simulation(json!({ "body": [body] }), of_cloth, mesh);
        run(&mut sheet, 36, |_| ());
    }
}

#[test]
fn a_body_that_presses_cloth_onto_another_is_held_back_and_told() {
    // A box comes down on a sheet on the floor, to a place at which there would be no room for it.
    for (down, is_held_back) in [(-0.15, false), (-0.2, true)] {
        let press = json!({
            "box": { "center": [0.0, 0.0, 0.3], "size": [0.3, 0.3, 0.2] }, "thickness": 0.001, "move": [[0.1, [0, 0, 0]], [0.6, [0, 0, down]]],
        });
        let mesh = sheet(10, |u, v| DVec3::new(0.4 * u - 0.2, 0.4 * v - 0.2, 0.004));
        let mut sheet = simulation(json!({ "body": [floor(), press] }), cloth(), mesh);
        run(&mut sheet, 60, |_| ());
        let report = sheet.steps(1);
        assert_eq!(report.held_back_bodies > 0, is_held_back, "{report:?}");
        let bottom = sheet.state.bodies[2..].iter().map(|corner| corner.z).fold(f64::INFINITY, f64::min);
        assert!(bottom > 0.0, "the cloth is between the box and the floor: {bottom}");
    }
}

#[test]
fn what_is_pinched_stays_in_the_middle_and_is_not_thrown() {
    // Two boxes close on a sheet that hangs between them: until half of its thicknesses is left, and until they would overlap by 2 cm.
    for (left, is_held_back) in [(0.002, false), (-0.02, true)] {
        let close = |side: f64| {
            let way = [0.0, -side * (0.1 - left / 2.0), 0.0];
            json!({
                "box": { "center": [0.0, 0.15 * side, 0.0], "size": [0.2, 0.1, 0.2] }, "thickness": 0.001, "friction": 0.3,
                "move": [[0.2, [0, 0, 0]], [0.7, way], [1.2, way], [1.7, [0, 0, 0]]],
            })
        };
        let mesh = sheet(16, |u, v| DVec3::new(0.5 * u - 0.25, 0.0, 0.5 * v - 0.25));
        let mut of_cloth = cloth();
        of_cloth["thickness"] = json!(0.002);
        of_cloth["pins"] = json!([{ "box": [[-1.0, -1.0, 0.2499], [1.0, 1.0, 1.0]] }]);
        let mut sheet = simulation(json!({ "body": [close(1.0), close(-1.0)] }), of_cloth, mesh);
        run(&mut sheet, 45, |_| ());
        let (mut furthest, mut cuts) = (0.0_f64, 0);
        for _ in 0..25 {
            let before = places(&sheet);
            let report = sheet.steps(sheet.model.schedule.substeps.into());
            cuts += report.contact_cuts;
            assert!(report.pinched > 0);
            assert_eq!(report.held_back_bodies > 0, is_held_back, "{report:?}");
            furthest = before.iter().zip(places(&sheet)).map(|(from, to)| from.distance(to)).fold(furthest, f64::max);
        }
        assert!(furthest < 0.005, "goes by {furthest} m in a frame");
        let middle = places(&sheet).into_iter().filter(|place| place.x.abs() < 0.095 && place.z.abs() < 0.095);
        let aside = middle.map(|place| place.y.abs()).fold(0.0, f64::max);
        assert!(aside < if is_held_back { 0.002 } else { 1e-4 }, "{aside} m from the middle");
        assert!(is_held_back || cuts == 0, "{cuts} cuts");
        run(&mut sheet, 40, |_| ());
        let report = sheet.steps(1);
        assert_eq!((report.held_back_bodies, report.pinched), (0, 0), "on their paths again");
    }
}
