//! In how many parts steps are taken where bodies move.

use serde_json::{Value, json};

use crate::common::Simulation;

const SPEED: f64 = 2.9; // [m/s]
const FRAME: f64 = 1.0 / 60.0; // [s]

/// Keyframes of what goes along x at a speed [m/s].
fn along(speed: f64) -> Value {
    json!([[0, [0, 0, 0]], [1, [speed, 0, 0]]])
}

/// The most parts that a step is taken in while a sheet of 0.4 m, held everywhere and carried at a speed, meets a body.
fn parts(sheet: f64, body: Value) -> usize {
    let mut run = Simulation::new(&json!({
        "fps": 1.0 / FRAME,
        "gravity": [0, 0, 0],
        "cloth": [{
            "grid": { "size": [0.4, 0.4], "cells": [20, 20], "origin": [0, 0, 0], "axes": ["x", "y"] },
            "density": 0.2, "thickness": 0.004,
            "pins": [{ "box": [[-1, -1, -1], [1, 1, 1]], "move": along(sheet) }],
        }],
        "body": [body],
    }));
    run.work.keep_trace(true);
    run.steps(1); // what is held sets out
    let mut most = 0;
    for _ in 0..3 {
        run.steps(1);
        most = most.max(run.work.trace().expect("is kept").len());
    }
    most
}

fn ball(height: f64, speed: f64) -> Value {
    json!({ "sphere": { "center": [0.2, 0.2, height], "radius": 0.05 }, "move": along(speed) })
}

#[test]
fn a_body_that_moves_against_cloth_goes_half_its_radius_in_a_part() {
    // 48 mm a step, and 25 mm a part.
    assert_eq!(parts(0.0, ball(0.06, SPEED)), 2);
    assert_eq!(parts(0.0, ball(0.06, 2.0 * SPEED)), 4);
    assert_eq!(parts(0.0, ball(0.06, 0.2 * SPEED)), 1);
}

#[test]
fn a_body_that_goes_along_with_cloth_asks_for_no_parts() {
    assert_eq!(parts(SPEED, ball(0.06, SPEED)), 1);
    // Cloth alone asks for none, however fast it is: it may be seen from the body.
    assert_eq!(parts(SPEED, ball(0.06, 0.0)), 1);
    assert_eq!(parts(SPEED, ball(0.06, -SPEED)), 2);
}

#[test]
fn a_body_far_from_cloth_asks_for_no_parts() {
    assert_eq!(parts(0.0, ball(0.3, SPEED)), 1);
    let plate = |height: f64| json!({ "box": { "center": [0.2, 0.2, height], "size": [4.0, 4.0, 0.1] }, "move": along(SPEED) });
    // Its vertices are all far, its upper side is not. It goes a cell a part.
    assert_eq!(parts(0.0, plate(-0.06)), 3);
    assert_eq!(parts(0.0, plate(-0.3)), 1);
    let floor = json!({ "plane": { "point": [9, 9, -0.01], "normal": [0, 0, 1] }, "move": along(SPEED) });
    assert_eq!(parts(0.0, floor), 3);
}

#[test]
fn of_a_long_body_that_swings_what_is_near_cloth_counts() {
    // A rod that ends 2 m below the sheet swings by 6 rad/s about its upper end: 100 mm a step at the middle, and hardly any near the sheet.
    let rod = |point: f64| {
        json!({
            "capsule": { "from": [0.2, 0.2, -0.06], "to": [0.2, 0.2, -2.06], "radius": 0.05 },
            "turn": { "axis": [1, 0, 0], "point": [0.2, 0.2, point], "angle": [[0, 0], [1, 6.0_f64.to_degrees()]] },
        })
    };
    assert_eq!(parts(0.0, rod(-0.06)), 1);
    assert!(parts(0.0, rod(-2.06)) >= 7);
}
