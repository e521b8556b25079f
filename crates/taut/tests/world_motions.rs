//! The facade: what turns and what follows arrays does as the same scene in JSON does, goes where it shall, and is checked on its way in.
#![cfg_attr(not(feature = "json"), allow(unused_imports))]

use crate::facade::{FRAME, NAN, bits, frames, mesh, refused, sheet};
use taut::scene::AngleKeyframe;
use taut::{Axis, Body, Cloth, Corner, Edge, Keyframe, Pin, Turn, World, WorldBuilder};

/// The typed world and that of the JSON, after so many frames.
#[cfg(feature = "json")]
fn same_bits(typed: WorldBuilder, read: WorldBuilder, count: u32) -> [World; 2] {
    let [mut typed, mut read] = [typed, read].map(|asked| asked.build().expect("a world"));
    for frame in 0..count {
        assert_eq!(frames(&mut typed, 1), frames(&mut read, 1), "frame {frame}");
    }
    assert!((0..typed.cloth_count()).all(|cloth| bits(&typed, cloth) == bits(&read, cloth)), "other bits");
    assert!((0..typed.body_count()).all(|body| typed.body_positions(body) == read.body_positions(body)), "other bodies");
    [typed, read]
}

/// A sheet of 4 x 4 cells whose upper corners go up and down, as 11 frames that are 0.1 s apart.
fn corners() -> Vec<Vec<[f64; 3]>> {
    let lift = |frame: u32| 0.01 * f64::from(if frame <= 5 { frame } else { 10 - frame });
    (0..11).map(|frame| vec![[0.0, 0.0, 1.0 + lift(frame)], [1.0, 0.0, 1.0 - lift(frame)]]).collect()
}

/// A plate below it that comes closer, as three frames.
fn plate() -> (Vec<[f64; 3]>, Vec<Vec<[f64; 3]>>) {
    let at = |y: f64| vec![[-1.0, y, -1.0], [2.0, y, -1.0], [0.5, y, 2.0]];
    (at(0.3), vec![at(0.3), at(0.2), at(0.02)])
}

#[cfg(feature = "json")]
#[test]
fn what_turns_has_the_bits_of_the_same_scene_as_json() {
    let text = r#"{
        "cloth": [{ "grid": { "size": [1, 1], "cells": [8, 8] }, "strain_limit": 0.05, "pins": [
            { "edge": "top", "turn": { "axis": [0, 0, 2], "point": [0.5, 0, 1], "angle": [[0.2, 30], [0.5, -60]] }, "move": [[0.3, [0, 0.1, -0.1]]] },
            { "vertices": [4], "turn": { "axis": [1, 1, 0], "point": [0.4, 0, 0], "angle": [[1, 90]] } }
        ] }],
        "body": [
            { "box": { "center": [0.5, 0.4, 0.5], "size": [1.2, 0.1, 0.1] }, "turn": { "axis": [0, 0, 1], "point": [0.5, 0.4, 0.5], "angle": [[0.5, 180]] } },
            { "capsule": { "from": [0, -0.4, 0.3], "to": [1, -0.4, 0.3], "radius": 0.1 }, "move": [[0.5, [0, 0.3, 0]]],
              "turn": { "axis": [0, 1, 0], "point": [0.5, -0.4, 0.3], "angle": [[0, 0], [1, 45]] } }
        ]
    }"#;
    let edge = Pin { keyframes: vec![Keyframe(0.3, [0.0, 0.1, -0.1])], ..Pin::edge(Edge::Top) };
    let edge = edge.turn(Turn::about([0, 0, 2], [0.5, 0.0, 1.0]).at(0.2, 30.0).at(0.5, -60.0));
    let low = Pin::vertices([4]).turn(Turn::about([1, 1, 0], [0.4, 0.0, 0.0]).at(1.0, 90.0));
    let mill = Body::cuboid([0.5, 0.4, 0.5], [1.2, 0.1, 0.1]).turn(Turn::about([0, 0, 1], [0.5, 0.4, 0.5]).at(0.5, 180.0));
    let rod = Body::capsule([0.0, -0.4, 0.3], [1.0, -0.4, 0.3], 0.1)
        .turn(Turn::about([0, 1, 0], [0.5, -0.4, 0.3]).at(0.0, 0.0).at(1.0, 45.0))
        .with(|body| body.keyframes = vec![Keyframe(0.5, [0.0, 0.3, 0.0])]);
    let cloth = Cloth::grid([1, 1], [8, 8]).strain_limit(0.05).pin(edge).pin(low);
    let typed = World::builder().cloth(cloth).body(mill).body(rod);
    let [typed, read] = same_bits(typed, WorldBuilder::from_json(text).expect("a scene"), 40);
    assert_eq!(typed.snapshot(), read.snapshot());
    assert!(typed.report().contacts > 0, "it touches what turns: {:?}", typed.report());
}

#[cfg(feature = "json")]
#[test]
fn what_follows_arrays_has_the_bits_of_the_same_scene_as_json() {
    let text = r#"{
        "cloth": [
            { "grid": { "size": [1, 1], "cells": [4, 4] }, "strain_limit": 0.05,
              "pins": [{ "corner": "bottom-right" }, { "vertices": [20, 24], "follow": "corners.npy" }] },
            { "mesh": "sheet.obj", "translate": [3, 0, 0], "pins": [{ "vertices": [8, 6], "follow": "hem.pc2" }] }
        ],
        "body": [{ "mesh": "plate.obj", "motion": "plate.npy" }]
    }"#;
    let (places, sides) = plate();
    let (positions, triangles) = mesh(2);
    // The order of a pin is that of its list, whatever the mesh is numbered by inside.
    let hem = |by: f64| [[4.0, by, 1.0], [3.0, 0.5 * by, 1.0]];
    let hems = [hem(0.0), hem(0.1), hem(-0.1)];
    let read = WorldBuilder::from_json(text)
        .expect("a scene")
        .mesh("sheet.obj", &positions, &triangles)
        .mesh("plate.obj", &places, &[[0, 1, 2]])
        .frames("corners.npy", &corners(), 10.0)
        .frames("hem.pc2", &hems, 8.0)
        .frames("plate.npy", &sides, 10.0);
    let grid = Cloth::grid([1, 1], [4, 4]).strain_limit(0.05).pin(Pin::corner(Corner::BottomRight));
    let typed = World::builder()
        .cloth(grid.pin_along(Pin::vertices([20, 24]), &corners(), 10.0))
        .cloth(Cloth::mesh(&positions, &triangles).translate([3, 0, 0]).pin_along(Pin::vertices([8, 6]), &hems, 8.0))
        .body(Body::mesh(&places, &[[0, 1, 2]]).motion(&sides, 10.0));
    let [world, read] = same_bits(typed, read, 30);
    // A snapshot begins with who it belongs to, the names of the arrays among that, and ends with a checksum.
    let state = |world: &World| world.snapshot()[16..].split_last_chunk::<8>().expect("a checksum").0.to_vec();
    assert_eq!(state(&world), state(&read));
    let place = |cloth: usize, vertex: usize| world.positions(cloth).expect("a cloth")[vertex].map(f64::from);
    assert_eq!(world.pinned(1, 0).expect("a pin"), [8, 6]);
    for (is, shall) in [(place(0, 20), corners()[5][0]), (place(0, 24), corners()[5][1]), (place(1, 8), hem(-0.1)[0])] {
        assert!((0..3).all(|axis| (is[axis] - shall[axis]).abs() < 1e-6), "{is:?}, not {shall:?}");
    }
}

#[test]
fn what_turns_is_where_its_angle_says() {
    // The upper edge goes round its own middle.
    let around = Turn::about([0, 0, 1], [0.5, 0.0, 1.0]).at(1.0, 90.0);
    let cloth = Cloth::grid([1, 1], [8, 8]).pin(Pin::edge(Edge::Top).turn(around));
    let ball = Body::sphere([3.0, 0.0, 0.0], 0.1).turn(Turn::about([0, 1, 0], [2, 0, 0]).at(0.25, 90.0).at(0.5, 90.0));
    let mut world = World::builder().cloth(cloth).body(ball).build().expect("a world");
    for frame in 1..=30 {
        world.step(FRAME).expect("stays finite");
        let time = f64::from(frame) * FRAME;
        let (sine, cosine) = (90.0 * time).to_radians().sin_cos();
        let corner = world.positions(0).expect("a cloth")[80].map(f64::from);
        let shall = [0.5 + 0.5 * cosine, 0.5 * sine, 1.0];
        assert!((0..3).all(|axis| (corner[axis] - shall[axis]).abs() < 1e-5), "frame {frame}: {corner:?}, not {shall:?}");
        let (sine, cosine) = (360.0 * time.min(0.25)).to_radians().sin_cos();
        let middle = world.body_positions(0).expect("a body")[0];
        let shall = [2.0 + cosine, 0.0, -sine];
        assert!((0..3).all(|axis| (middle[axis] - shall[axis]).abs() < 1e-9), "frame {frame}: {middle:?}, not {shall:?}");
    }
    assert!(world.report().worst_stretch <= 0.05 + 1e-5);
}

#[test]
fn pins_that_follow_arrays_go_straight_between_frames_and_stay_after_the_last() {
    let cloth = Cloth::grid([1, 1], [4, 4]).pin_along(Pin::vertices([20, 24]), &corners()[..3], 10.0);
    let mut world = World::builder().cloth(cloth).build().expect("a world");
    let mut height = |dt: f64| {
        world.step(dt).expect("stays finite");
        let places = world.positions(0).expect("a cloth");
        [20, 24].map(|vertex| f64::from(places[vertex][2]))
    };
    for (dt, lift) in [(0.05, 0.005), (0.05, 0.01), (0.025, 0.0125), (0.075, 0.02), (0.3, 0.02)] {
        let [left, right] = height(dt);
        assert!((left - 1.0 - lift).abs() < 1e-6 && (right - 1.0 + lift).abs() < 1e-6, "{left} and {right}, not {lift} off");
    }
}

#[test]
fn what_is_wrong_with_a_turn_is_refused() {
    let about = |axis: [f64; 3]| Turn::about(axis, [0.5, 0.0, 1.0]);
    let up = about([0.0, 0.0, 1.0]);
    let cases: [(Turn, &str); 7] = [
        (about([0.0; 3]).at(1.0, 90.0), "axis = "),
        (about([NAN, 0.0, 1.0]).at(1.0, 90.0), "axis = "),
        (Turn::about([0, 0, 1], [NAN, 0.0, 0.0]), "point = "),
        (up.clone().at(NAN, 90.0), "angle[0] = NaN"),
        (up.clone().at(1.0, f64::INFINITY), "angle[0] = inf"),
        (up.clone().at(1.0, 90.0).at(1.0, 0.0), "angle[1] = 1: times must increase"),
        (up.clone().at(0.0, 90.0), "angle[0] = 90: at time 0 the angle is 0 degrees; begin with [0, 0]"),
    ];
    for (turn, named) in cases {
        let pinned = World::builder().cloth(Cloth::grid([1, 1], [4, 4]).pin(Pin::edge(Edge::Top).turn(turn.clone())));
        refused(pinned.build(), &format!("scene.cloth[0].pins[0].turn.{named}"));
        let ball = Body::sphere([0.0, 9.0, 0.0], 0.1);
        refused(World::builder().cloth(sheet()).body(ball.turn(turn)).build(), &format!("scene.body[0].turn.{named}"));
    }
    assert_eq!(up.clone().at(1.0, 90.0).angle, [AngleKeyframe(1.0, 90.0)]);
    let floor = Body::plane([0, 9, 0], [0, 1, 0]).turn(up.clone());
    refused(World::builder().cloth(sheet()).body(floor).build(), "scene.body[0].turn: a plane has no end and cannot turn");
    // Two pins may hold one vertex only where both go the same way; and no further apart than the cloth between them reaches.
    let turning = |pin: Pin| pin.turn(up.clone().at(1.0, 90.0));
    let both = Cloth::grid([1, 1], [4, 4]).pin(turning(Pin::edge(Edge::Top)));
    refused(World::builder().cloth(both.clone().pin(Pin::corner(Corner::TopLeft))).build(), "scene.cloth[0].pins[1]: vertex 20 ");
    assert!(World::builder().cloth(both.pin(turning(Pin::corner(Corner::TopLeft)))).build().is_ok());
}

#[test]
fn what_is_wrong_with_an_array_is_refused() {
    let along = |pin: Pin, frames: &[Vec<[f64; 3]>], rate: f64| {
        World::builder().cloth(Cloth::grid([1, 1], [4, 4]).pin(Pin::vertices([0])).pin_along(pin, frames, rate)).build()
    };
    let field = "scene.cloth[0].pins[1].follow = \"frames of cloth 0, pin 1\": ";
    let with = |frames: &[Vec<[f64; 3]>], rate: f64, problem: &str| {
        refused(along(Pin::vertices([20, 24]), frames, rate), &format!("{field}{problem}"));
    };
    let good = corners();
    assert!(along(Pin::vertices([20, 24]), &good, 10.0).is_ok());
    for rate in [0.0, -10.0, NAN, f64::INFINITY] {
        with(&good, rate, &format!("has {rate} frames per second; must be a finite number above 0"));
    }
    with(&[], 10.0, "has places of 0 vertices, the pin holds 2; give one for each");
    with(&[vec![good[0][0]]], 10.0, "has places of 1 vertices, the pin holds 2; give one for each");
    with(&[good[0].clone(), vec![[NAN; 3]; 2]], 10.0, "has vertex 0 at [NaN, NaN, NaN] in frame 1; all places must be finite");
    with(&good[5..], 10.0, "has vertex 20 at [0.0, 0.0, 1.05] in its first frame, but the cloth has it at [0.0, 0.0, 1.0]");
    let ragged = [good[0].clone(), good[1][..1].to_vec()];
    let name = "scene.cloth[0].pins[1].follow[1] = a list of 1: must have 2 places as the first frame has, one for each vertex";
    refused(along(Pin::vertices([20, 24]), &ragged, 10.0), name);
    let turning = Pin::vertices([20, 24]).turn(Turn::about([0, 0, 1], [0, 0, 0]).at(1.0, 90.0));
    refused(
        along(turning, &good, 10.0),
        &format!("{field}a pin that follows an array has neither `move` nor `turn`; leave them out"),
    );
    refused(along(Pin::vertices([99]), &good, 10.0), "scene.cloth[0].pins[1].vertices");
}

#[cfg(feature = "json")]
#[test]
fn arrays_that_a_scene_names_must_be_given() {
    let text = r#"{ "cloth": [{ "grid": { "size": [1, 1], "cells": [4, 4] }, "pins": [{ "vertices": [20, 24], "follow": "a.npy" }] }] }"#;
    let asked = || WorldBuilder::from_json(text).expect("a scene");
    refused(asked().build(), "scene.cloth[0].pins[0].follow = \"a.npy\": its places were not given");
    refused(
        asked().frames("b.npy", &corners(), 10.0).build(),
        "scene.cloth[0].pins[0].follow = \"a.npy\": its places were not given",
    );
    let ragged = [vec![[0.0; 3]; 2], vec![[0.0; 3]]];
    refused(asked().frames("a.npy", &ragged, 10.0).build(), "scene.cloth[0].pins[0].follow[1] = a list of 1");
    assert!(asked().frames("a.npy", &corners(), 10.0).build().is_ok());
}

#[test]
fn a_world_at_rest_sleeps_if_it_may_until_something_moves() {
    let lies = |sleep: bool| {
        let cloth = Cloth::grid([0.5, 0.5], [12, 12]).axes([Axis::X, Axis::Y]).translate([-0.25, -0.25, 0.02]).thickness(0.004);
        let floor = Body::plane([0.0; 3], [0, 0, 1]);
        World::builder().cloth(cloth).body(floor).sleep(sleep).build().expect("a world")
    };
    let [mut sleeps, mut wakes] = [true, false].map(lies);
    assert!(!frames(&mut wakes, 240).asleep && frames(&mut sleeps, 240).asleep);
    let before = bits(&sleeps, 0);
    assert!(frames(&mut sleeps, 60).asleep && bits(&sleeps, 0) == before);
    assert!(sleeps.velocities(0).expect("a cloth").iter().flatten().all(|part| *part == 0.0));
    sleeps.hold(0, &[0], &[[-0.25, -0.25, 0.3]], 0.2).expect("a vertex");
    assert!(!frames(&mut sleeps, 12).asleep && bits(&sleeps, 0) != before);
}
