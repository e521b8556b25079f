//! What a scene says about the course of wind, gravity, strain limits and pins.

use std::collections::BTreeMap;

use crate::common::{self, Simulation, crooked, mesh_scene, model, scene, scene_of, sheet};
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use taut::inputs::Followed;
use taut::prepare::{Prepared, prepare};
use taut::state::{Clock, State};
use taut::step::{Work, step};

/// Largest |X_uv| / L - 1.
fn stretch(run: &Simulation) -> f64 {
    let springs = &run.model.springs;
    let ratio = |index: usize| {
        let [u, v] = springs.ends[index].map(|end| run.state.positions.get(end as usize).as_dvec3());
        u.distance(v) / f64::from(springs.rest[index])
    };
    (0..springs.type1).map(ratio).fold(0.0, f64::max) - 1.0
}

#[test]
fn gravity_follows_its_keyframes() {
    let mut fields = scene_of(sheet([2, 2], 0.1, json!([])), 4, "coarse_to_fine", 10.0);
    fields["cloth"][0]["air_drag"] = json!(0.0);
    fields["gravity_keyframes"] = json!([[0.5, [0.0, 0.0, 0.0]], [1.0, [4.0, 0.0, 0.0]]]);
    let mut run = Simulation::new(&fields);
    run.steps(240);
    // Sums of the means of the straight lines: -5 * 0.5 along z, 2 * 0.5 along x.
    for velocity in run.state.velocities.iter() {
        assert!(velocity.distance(Vec3::new(1.0, 0.0, -2.5)) < 0.05, "{velocity}");
    }
}

#[test]
fn wind_follows_its_keyframes_and_gusts_grow_with_it() {
    let blown = |wind: Value| {
        let mut fields = scene_of(sheet([4, 4], 0.1, json!([])), 8, "coarse_to_fine", 0.0);
        fields["cloth"][0]["air_drag"] = json!(0.0);
        fields["wind"] = wind;
        model(&fields)
    };
    let push = |model: &common::Built, time: f64| {
        let mut state = State::new(model);
        state.clock = Clock::after(1, time);
        model.external(&state).iter().collect::<Vec<_>>()
    };
    let rising = blown(json!({ "keyframes": [[2.0, [1.0, 2.0, 8.0]]], "gust": { "seed": 3 } }));
    let full = blown(json!({ "velocity": [1.0, 2.0, 8.0], "gust": { "seed": 3 } }));
    assert_eq!(push(&rising, 2.0), push(&full, 2.0));
    assert_eq!(push(&rising, 7.5), push(&full, 7.5));
    assert!(push(&rising, 0.0).iter().all(|push| *push == Vec3::ZERO), "no wind, no gusts");
    // The force grows with the square of the speed, that of the gusts included, when they have the same phases.
    let air = rising.inputs.air.as_ref().expect("wind");
    assert_eq!((air.velocity(1.0), air.gusts(1.0)), (Vec3::new(0.5, 1.0, 4.0), 0.5));
    assert_eq!(rising.schedule.bound, full.schedule.bound);
}

#[test]
fn a_limit_that_loosens_and_tightens_is_kept_frame_by_frame() {
    for source in ["grid", "mesh"] {
        let pins = json!([{ "vertices": [240] }, { "vertices": [255] }]);
        let mut cloth = sheet([15, 15], 0.02, pins);
        cloth["strain_limit_keyframes"] = json!([[0.5, 0.15], [1.0, 0.15], [2.0, 0.02]]);
        // Soft enough to reach any of these limits.
        cloth["stiffness"] = json!(2.0);
        let mut fields = scene_of(json!({}), 4, "coarse_to_fine", 9.81);
        let mut run = if source == "grid" {
            fields["cloth"] = json!([cloth]);
            Simulation::new(&fields)
        } else {
            cloth.as_object_mut().expect("a cloth").remove("grid");
            Simulation::of(mesh_scene(fields, cloth, crooked(15)))
        };
        let (mut widest, mut moved) = (0.0_f64, 0.0_f32);
        for frame in 1..=180_u32 {
            let before = run.state.positions.clone();
            let worst_before = stretch(&run);
            run.steps(4);
            let limit = run.inputs.limits[0].at(f64::from(frame) / 60.0);
            let now = stretch(&run);
            // What is over its limit already may not grow.
            assert!(now <= limit.max(worst_before) + 2e-5, "{source}, frame {frame}: {now} of {limit}, {worst_before} before");
            widest = widest.max(now);
            if (60..120).contains(&frame) {
                let way = run.state.positions.iter().zip(before.iter()).map(|(a, b)| a.distance(b)).fold(0.0, f32::max);
                moved = moved.max(way);
            }
        }
        assert!(widest > 0.1, "{source}: it used the room that it was given, {widest}");
        assert!(moved > 1e-3, "{source}: it stood still while the limit tightened");
        assert!(stretch(&run) <= 0.02 + 2e-5, "{source}: {} at the end", stretch(&run));
    }
}

#[test]
fn a_limit_goes_on_where_a_snapshot_was_taken() {
    let mut cloth = sheet([12, 12], 0.02, json!([{ "corner": "top-left" }]));
    cloth["strain_limit_keyframes"] = json!([[0.4, 0.12], [0.8, 0.03]]);
    cloth["stiffness"] = json!(2.0);
    let mut run = Simulation::new(&scene_of(cloth, 3, "coarse_to_fine", 9.81));
    run.steps(80);
    let bytes = run.state.to_bytes(&run.model, &run.inputs.grips);
    run.steps(50);
    let (mut state, _) = State::from_bytes(&bytes, &run.model).expect("a snapshot");
    let mut work = Work::new(&run.model, &run.model.schedule, 1);
    (0..50).for_each(|_| {
        step(&run.model, &mut state, &run.inputs, run.step_length(), &mut work);
    });
    assert_eq!(state, run.state);
}

fn followed(places: &[[f64; 3]], vertices: usize) -> BTreeMap<String, Followed> {
    let places = places.iter().map(|place| DVec3::from_array(*place)).collect();
    BTreeMap::from([("path.npy".to_owned(), Followed { vertices, places, rate: None })])
}

#[test]
fn pins_follow_an_array_along_straight_lines_between_its_frames() {
    let fields = scene_of(sheet([4, 4], 0.1, json!([{ "vertices": [20, 24], "follow": "path.npy" }])), 4, "coarse_to_fine", 9.81);
    let frames = [[0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.02, 1.0, 0.01], [0.98, 1.0, 0.01], [0.04, 1.0, 0.0], [0.97, 1.01, 0.03]];
    let Prepared { model, inputs, schedule } =
        prepare(&scene(&fields), &BTreeMap::new(), &followed(&frames, 2)).expect("places that fit");
    let (mut state, mut work) = (State::new(&model), Work::new(&model, &schedule, 1));
    for steps in 1..=12_usize {
        step(&model, &mut state, &inputs, schedule.step_length, &mut work);
        for (index, particle) in [20, 24].into_iter().enumerate() {
            let at = |frame: usize| DVec3::from_array(frames[2 * frame.min(2) + index]);
            let expected = at(steps / 4).lerp(at(steps / 4 + 1), (steps % 4) as f64 / 4.0);
            let off = state.positions.get(particle).as_dvec3().distance(expected);
            assert!(off < 1e-6, "{off} m off after {steps} steps");
        }
    }
}

#[test]
fn arrays_that_do_not_fit_are_refused() {
    let fields = scene_of(sheet([4, 4], 0.1, json!([{ "vertices": [20, 24], "follow": "path.npy" }])), 4, "coarse_to_fine", 9.81);
    let home = [[0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let bad = [
        (BTreeMap::new(), "were not given"),
        (followed(&home, 1), "places of 1 vertices, the pin holds 2"),
        (followed(&[], 2), "has no frame"),
        (followed(&[home[0], home[1], [f64::NAN; 3], home[1]], 2), "has vertex 0 at [NaN, NaN, NaN] in frame 1; all places"),
        (followed(&[home[1], home[0]], 2), "vertex 20"),
    ];
    for (arrays, words) in bad {
        let error = prepare(&scene(&fields), &BTreeMap::new(), &arrays).expect_err("no such array").to_string();
        assert!(error.contains("cloth[0].pins[0].follow = \"path.npy\"") && error.contains(words), "{error}");
    }
}

/// A sheet of 1 m whose left edge turns about an upright line and travels, all of it 100 m and more from the origin.
fn turned(cells: u32, angle: Value, way: Value) -> Value {
    let turn = json!({ "axis": [0, 0, 3], "point": [100.5, 7.0, 0.0], "angle": angle });
    let mut cloth = sheet([cells, cells], 0.05, json!([{ "edge": "left", "turn": turn, "move": way }]));
    cloth["translate"] = json!([100.0, 7.0, 0.0]);
    scene_of(cloth, 8, "coarse_to_fine", 9.81)
}

#[test]
fn pins_turn_about_their_line_and_then_move() {
    let fields = turned(4, json!([[0, 0], [2, 360]]), json!([[1, [0, 0, 0]], [2, [0, 0.25, 0.5]]]));
    let mut run = Simulation::new(&fields);
    let group = &run.model.pins[0];
    let (particles, start) = (group.particles.clone(), group.start.clone());
    let line = DVec3::new(100.5, 7.0, 0.0);
    let length = run.step_length();
    for frame in 1..=150_u32 {
        run.steps(8);
        let time = f64::from(frame) / 60.0;
        let (angle, way) = ((180.0 * time).min(360.0).to_radians(), (time - 1.0).clamp(0.0, 1.0));
        let way = way * DVec3::new(0.0, 0.25, 0.5);
        let origin = run.state.origins[0];
        for (index, &particle) in particles.iter().enumerate() {
            let from = start[index] + run.model.origins[0].at - line;
            let out =
                DVec3::new(from.x * angle.cos() - from.y * angle.sin(), from.x * angle.sin() + from.y * angle.cos(), from.z);
            let expected = line + out + way;
            let found = run.state.positions.get(particle as usize).as_dvec3() + origin;
            assert!(found.distance(expected) < 5e-7, "frame {frame}: {found}, not {expected}");
            // The velocity is that of the chord which the last step went: omega x r but for its second order.
            if frame < 60 {
                let omega = std::f64::consts::PI;
                let middle = angle - 0.5 * omega * length;
                let along = omega
                    * (DVec3::Z.cross(DVec3::new(
                        from.x * middle.cos() - from.y * middle.sin(),
                        from.x * middle.sin() + from.y * middle.cos(),
                        0.0,
                    )));
                let velocity = run.state.velocities.get(particle as usize).as_dvec3();
                assert!(velocity.distance(along) < 1e-3, "frame {frame}: {velocity}, not {along}");
            }
        }
    }
}

#[test]
fn what_has_not_turned_goes_as_if_there_were_no_turn() {
    let hash = |angle: Value| {
        let mut fields = turned(6, angle, json!([[0.5, [0.0, 0.2, 0.1]]]));
        if fields["cloth"][0]["pins"][0]["turn"]["angle"] == json!([]) {
            fields["cloth"][0]["pins"][0].as_object_mut().expect("a pin").remove("turn");
        }
        let mut run = Simulation::new(&fields);
        run.steps(80);
        run.state.hash()
    };
    assert_eq!(hash(json!([])), hash(json!([[3, 0]])));
}

#[test]
fn turning_pins_go_on_where_a_snapshot_was_taken_on_any_number_of_threads() {
    let fields = turned(24, json!([[0.5, 90], [1, -30]]), json!([[1, [0.1, 0, 0]]]));
    let mut run = Simulation::on_threads(&fields, 1);
    run.steps(60);
    let bytes = run.state.to_bytes(&run.model, &run.inputs.grips);
    run.steps(60);
    for threads in [1, 3] {
        let mut again = Simulation::on_threads(&fields, threads);
        again.state = State::from_bytes(&bytes, &again.model).expect("a snapshot").0;
        again.steps(60);
        assert_eq!(again.state, run.state, "{threads} threads");
    }
}

#[test]
fn turns_are_looked_at_between_their_keyframes() {
    // The right edge comes back after a whole turn; half way it is 3 m away from the left one.
    let turn = |degrees: f64| {
        let turn = json!({ "axis": [0, 0, 1], "point": [2.0, 0.0, 0.0], "angle": [[1, degrees]] });
        let cloth = sheet([4, 4], 0.05, json!([{ "edge": "left" }, { "edge": "right", "turn": turn }]));
        common::build(&scene(&scene_of(cloth, 8, "coarse_to_fine", 9.81)), &BTreeMap::new()).map(|_| ())
    };
    let error = turn(360.0).expect_err("out of reach").to_string();
    assert!(error.contains("infeasible: pins ") && error.contains("the cloth reaches"), "{error}");
    turn(2.0).expect("in reach");
}

#[test]
fn pins_that_turn_alike_may_share_a_vertex() {
    let pins = |angle: f64| {
        let turn = |angle: f64| json!({ "axis": [0, 0, 1], "angle": [[1, angle]] });
        let pins = json!([{ "edge": "left", "turn": turn(30.0) }, { "corner": "top-left", "turn": turn(angle) }]);
        common::build(&scene(&scene_of(sheet([4, 4], 0.05, pins), 8, "coarse_to_fine", 9.81)), &BTreeMap::new()).map(|_| ())
    };
    pins(30.0).expect("alike");
    let error = pins(31.0).expect_err("differently").to_string();
    assert!(error.contains("pins[1]: vertex 20 is held by pins[0] too, which moves differently"), "{error}");
}
