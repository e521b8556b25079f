//! Networks that intersect something at the start: it is told, and what has a way out goes it.

use crate::common::lines::Watch;
use crate::common::nets::{crossings, net, rope, with};
use crate::common::oracle::places;
use crate::common::{Simulation, model};
use glam::DVec3;
use serde_json::{Value, json};
use taut::contact::{Fault, Intersection, Intersections, Other};

/// What is found in a scene, and the warnings that tell it.
fn found(scene: &Value) -> (Vec<Intersection>, Vec<String>) {
    let built = model(scene);
    let told = built.model.warnings.iter().filter(|text| text.contains(" at the start: ")).cloned().collect();
    (Intersections::at_start(&built).places, told)
}

fn straight() -> Value {
    rope(4, 0.01, |s| DVec3::new(0.8 * s, 0.0, 0.0))
}

#[test]
fn a_link_through_something_is_found_and_told() {
    // All points are outside; the second link, from 0.2 to 0.4 m, passes through.
    let sphere = json!({ "sphere": { "center": [0.3, 0.02, 0], "radius": 0.05 } });
    let capsule = json!({ "capsule": { "from": [0.3, 0.02, -0.3], "to": [0.3, 0.02, 0.3], "radius": 0.05 } });
    for body in [sphere, capsule] {
        let (places, told) = found(&json!({ "cloth": [straight()], "body": [body] }));
        assert_eq!(places.len(), 1, "{places:?}");
        let Intersection { cloth, other, fault, vertex, place, depth } = places[0];
        assert_eq!((cloth, other, fault), (0, Other::Body(0), Fault::Inside));
        assert!([1, 2].contains(&vertex) && (depth.expect("known") - 0.03).abs() < 1e-6, "{places:?}");
        assert!(place.distance(DVec3::new(0.3, 0.0, 0.0)) < 1e-6, "{places:?}");
        assert!(told.len() == 1 && told[0].contains("is inside of body[0]") && told[0].contains("0.03 m deep"), "{told:?}");
    }
    let cube = json!({ "box": { "center": [0.3, 0.02, 0.01], "size": [0.1, 0.1, 0.1] } });
    let (places, told) = found(&json!({ "cloth": [straight()], "body": [cube] }));
    assert!(places.len() == 2 && places.iter().all(|place| place.fault == Fault::Crosses), "{places:?}");
    assert!(told.len() == 1 && told[0].contains("intersects body[0]"), "{told:?}");
    let sheet = json!({ "grid": { "size": [1, 1], "cells": [1, 1], "axes": ["y", "z"], "origin": [0.3, -0.4, -0.5] } });
    let (places, told) = found(&json!({ "cloth": [straight(), sheet] }));
    assert_eq!((places.len(), places[0].cloth, places[0].other), (1, 0, Other::Cloth(1)), "{places:?}");
    assert!(told.len() == 1 && told[0].contains("intersects cloth[1]"), "{told:?}");
}

#[test]
fn a_point_in_a_box_is_inside() {
    let cube = json!({ "box": { "center": [0.41, 0.02, 0.01], "size": [0.1, 0.1, 0.1] } });
    let (places, _) = found(&json!({ "cloth": [straight()], "body": [cube] }));
    let inside: Vec<usize> = places.iter().filter(|at| at.fault == Fault::Inside).map(|at| at.vertex).collect();
    assert_eq!((inside, places.len()), (vec![2], 3));
}

#[test]
fn links_that_touch_exactly_are_told() {
    let across = |height: f64| rope(3, 0.01, move |s| DVec3::new(0.3, 0.9 * s - 0.5, height));
    let (places, told) = found(&json!({ "cloth": [straight(), across(0.0)] }));
    assert_eq!((places.len(), places[0].other, places[0].fault), (1, Other::Cloth(1), Fault::Crosses), "{places:?}");
    assert!(places[0].place.distance(DVec3::new(0.3, 0.0, 0.0)) < 1e-6, "{places:?}");
    assert!(told.len() == 1 && told[0].contains("if that does not end: move one of them away"), "{told:?}");
    assert_eq!(found(&json!({ "cloth": [straight(), across(0.001)] })), (vec![], vec![]), "apart");
    // A bow in a plane.
    let corners = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
    let (places, told) = found(&json!({ "cloth": [rope(3, 0.01, |s| corners[(3.0 * s).round() as usize])] }));
    assert!(
        places.len() == 1 && places[0].other == Other::Cloth(0) && places[0].place.distance(DVec3::new(0.5, 0.5, 0.0)) < 1e-6
    );
    assert!(told.len() == 1 && told[0].contains("intersects itself") && told[0].contains("move its points apart"), "{told:?}");
}

/// Frames until nothing intersects any more, by what the engine and this file find; then everything stays apart.
fn comes_apart(run: &mut Simulation, most: u64, left: impl Fn(&Simulation) -> usize) -> u64 {
    let steps = run.model.schedule.substeps;
    assert!(left(run) > 0, "it starts without anything to do");
    let limit = run.model.cloths.iter().map(|cloth| cloth.strain_limit).fold(0.0, f64::max);
    let taken = (1..=most).find(|frame| {
        let before = places(run);
        let reports: Vec<_> = (0..steps).map(|_| run.steps(1)).collect();
        let after = places(run);
        let fastest = before.iter().zip(after).map(|(a, b)| a.distance(b)).fold(0.0, f64::max) * 60.0;
        assert!(fastest < 2.0, "frame {frame}: {fastest} m/s");
        assert!(reports.iter().all(|report| report.worst_stretch <= limit * (1.0 + 1e-5)), "frame {frame}: {reports:?}");
        left(run) == 0 && !run.state.may_cross
    });
    let mut watch = Watch::new(run);
    for _ in 0..30 {
        run.steps(1);
        assert_eq!((watch.look(run).passed, left(run)), (0, 0), "after {taken:?} frames");
    }
    taken.unwrap_or_else(|| panic!("{} places are left", left(run)))
}

fn weightless(cloths: Value, bodies: Value) -> Simulation {
    Simulation::new(&json!({ "cloth": cloths, "body": bodies, "gravity": [0, 0, 0] }))
}

#[test]
fn nets_come_out_of_bodies() {
    let flat = |cells: u32, height: f64| net([cells; 2], 0.1, |u, v| DVec3::new(0.6 * u - 0.3, 0.6 * v - 0.3, height));
    let (centre, radius) = (DVec3::new(0.02, 0.01, 0.0), 0.2);
    let inside = |run: &Simulation| {
        let x = places(run);
        let to = |a: DVec3, b: DVec3| a.lerp(b, ((centre - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0));
        run.model
            .springs
            .ends
            .iter()
            .map(|ends| ends.map(|end| x[end as usize]))
            .filter(|[a, b]| to(*a, *b).distance(centre) < 0.1999)
            .count()
    };
    // Points inside; and a net of wide cells that only its links are inside with.
    for (cells, height) in [(12, 0.17), (3, 0.175)] {
        let ball = json!({ "sphere": { "center": centre.to_array(), "radius": radius } });
        let mut run = weightless(json!([flat(cells, height)]), json!([ball]));
        println!("ball, {cells} cells: {} frames", comes_apart(&mut run, 40, inside));
    }
    let block = json!({ "box": { "center": [0.02, 0.01, 0.0], "size": [0.4, 0.4, 0.4], "rotate": [0, 0, 20] } });
    let mut run = weightless(json!([flat(12, 0.19)]), json!([block]));
    println!(
        "box: {} frames",
        comes_apart(&mut run, 40, |run| {
            let turn = taut::geometry::turn([0.0, 0.0, 20.0]).inverse();
            crossings(run) + places(run).iter().filter(|&&place| (turn * (place - centre)).abs().max_element() < 0.1999).count()
        })
    );
}

#[test]
fn a_net_that_crosses_a_sheet_goes_to_one_side() {
    let sheet = json!({
        "grid": { "size": [0.5, 0.5], "cells": [15, 15], "axes": ["x", "y"] }, "strain_limit": 0.05, "thickness": 0.004, "density": 0.2,
    });
    let wavy = |low: f64| {
        net([14, 14], 0.05, move |u, v| DVec3::new(0.48 * u + 0.01, 0.48 * v + 0.01, low + 0.006 * (9.0 * u + 4.0 * v).sin()))
    };
    for (low, up) in [(0.003, true), (-0.003, false)] {
        for net_first in [false, true] {
            let cloths = if net_first { json!([wavy(low), sheet]) } else { json!([sheet, wavy(low)]) };
            let mut run = weightless(cloths, json!([]));
            let frames = comes_apart(&mut run, 60, crossings);
            let mean = |cloth: usize| {
                let range = &run.model.cloths[cloth];
                places(&run)[range.particles()].iter().map(|place| place.z).sum::<f64>() / range.count as f64
            };
            let above = (mean(1) - mean(0)) * if net_first { -1.0 } else { 1.0 };
            println!("sheet, from {low}, net first {net_first}: {frames} frames, {above} m");
            assert!(if up { above > 0.002 } else { above < -0.002 }, "{above}");
        }
    }
}

#[test]
fn layers_say_on_which_side_of_a_sheet_a_net_belongs() {
    // The sheet looks away from the ball.
    let ball = json!({ "sphere": { "center": [0.25, 0.25, -0.25], "radius": 0.2 } });
    let sheet = json!({
        "grid": { "size": [0.5, 0.5], "cells": [15, 15], "axes": ["x", "y"] }, "strain_limit": 0.05, "thickness": 0.004, "density": 0.2,
        "layer": 1,
    });
    for (layer, up) in [(2, true), (0, false)] {
        let wavy = net([14, 14], 0.05, |u, v| DVec3::new(0.48 * u + 0.01, 0.48 * v + 0.01, 0.006 * (9.0 * u + 4.0 * v).sin()));
        let mut run = weightless(json!([sheet, with(wavy, "layer", json!(layer))]), json!([ball]));
        comes_apart(&mut run, 80, crossings);
        let x = places(&run);
        let mean = |cloth: usize| {
            let range = &run.model.cloths[cloth];
            x[range.particles()].iter().map(|place| place.z).sum::<f64>() / range.count as f64
        };
        assert!(
            if up { mean(1) > mean(0) + 0.002 } else { mean(1) < mean(0) - 0.002 },
            "layer {layer}: {} and {}",
            mean(0),
            mean(1)
        );
    }
}

#[test]
fn ropes_drawn_in_one_plane_part() {
    // A grid of ropes, all in one plane, and one that crosses itself.
    let along = (0..3).map(|index| rope(7, 0.05, move |s| DVec3::new(0.6 * s - 0.3, 0.1 * f64::from(index) - 0.1, 0.0)));
    let up = (0..3).map(|index| rope(8, 0.05, move |s| DVec3::new(0.1 * f64::from(index) - 0.11, 0.5 * s - 0.26, 0.0)));
    let corners = [[1.0, 1.0], [2.0, 2.0], [2.0, 1.0], [1.0, 2.0]].map(|[x, y]| DVec3::new(0.3 * x, 0.3 * y, 0.0));
    let bow = rope(3, 0.05, |s| corners[(3.0 * s).round() as usize]);
    let ropes: Vec<Value> = along.chain(up).chain([bow]).collect();
    assert_eq!(found(&json!({ "cloth": ropes })).0.len(), 10);
    let mut run = weightless(json!(ropes), json!([]));
    run.steps(1);
    let mut watch = Watch::new(&mut run);
    let mut least = 0.0;
    for _ in 0..60 {
        run.steps(1);
        let seen = watch.look(&run);
        assert_eq!(seen.passed, 0);
        least = seen.least;
    }
    assert!(least > 0.8, "{least}");
}
