//! Networks touch bodies, cloths, each other and themselves: no link crosses anything, the limit is kept, friction is Coulomb's. What is
//! looked at is measured here, by other means than those of the engine.

use crate::common::lines::Watch;
use crate::common::nets::{crossings, net, rope, with};
use crate::common::oracle::places;
use crate::common::{Simulation, model};
use glam::DVec3;
use proptest::prelude::*;
use serde_json::{Value, json};

fn floor() -> Value {
    json!({ "plane": { "point": [0, 0, 0], "normal": [0, 0, 1] }, "friction": 0.3 })
}

fn simulation(cloths: Value, bodies: Value) -> Simulation {
    Simulation::new(&json!({ "cloth": cloths, "body": bodies }))
}

/// Steps frame by frame; every step is measured by the engine, and looked at here. Returns the least distance at its end, as a part of the
/// thickness.
fn run(run: &mut Simulation, frames: u64, mut look: impl FnMut(&Simulation)) -> f64 {
    let limit = run.model.cloths.iter().map(|cloth| cloth.strain_limit).fold(0.0, f64::max);
    let mut watch = Watch::new(run);
    let mut least = f64::INFINITY;
    for frame in 1..=frames {
        for _ in 0..run.model.schedule.substeps {
            let report = run.steps(1);
            assert!(report.worst_stretch <= limit * (1.0 + 1e-5), "frame {frame}: stretched by {}", report.worst_stretch);
            let seen = watch.look(run);
            assert_eq!(seen.passed, 0, "frame {frame}: {seen:?} {report:?}");
            least = seen.least;
        }
        assert_eq!(crossings(run), 0, "frame {frame}");
        look(run);
        if std::env::var("SHOW").is_ok() {
            let report = run.steps(1);
            watch = Watch::new(run);
            println!("{frame} {least:.3} {:?} cuts {} contacts {}", report.closest, report.contact_cuts, report.contacts);
        }
    }
    least
}

#[test]
fn a_net_falls_on_a_ball_and_drapes() {
    for cells in [8, 13] {
        let ball = json!({ "sphere": { "center": [0.03, 0.02, 0.4], "radius": 0.3 }, "friction": 0.4 });
        let net = net([cells; 2], 0.2, |u, v| DVec3::new(1.2 * u - 0.6, 1.2 * v - 0.6, 0.72));
        let mut run_of = simulation(json!([net]), json!([floor(), ball]));
        let least = run(&mut run_of, 90, |_| ());
        assert!(least > 0.5 && least < 1.2, "{cells} cells: whole links are one thickness away: {least}");
        let x = places(&run_of);
        let middle: DVec3 = x.iter().sum::<DVec3>() / x.len() as f64;
        assert!((0.25..0.6).contains(&middle.z), "{cells} cells: it lies on the ball: {middle}");
        assert!(x.iter().all(|place| place.z > 0.0));
    }
}

#[test]
fn a_net_hangs_on_the_corner_of_a_box() {
    for cells in [9, 14] {
        let cube = json!({ "box": { "center": [0.02, 0.01, 0.35], "size": [0.4, 0.4, 0.4], "rotate": [45, 35.264, 0] }, "friction": 0.5 });
        let net = net([cells; 2], 0.2, |u, v| DVec3::new(1.2 * u - 0.6, 1.2 * v - 0.6, 0.72));
        let mut hung = simulation(json!([net]), json!([floor(), cube]));
        let least = run(&mut hung, 90, |_| ());
        assert!(least > 0.5 && least < 1.2, "{cells} cells: {least}");
        let highest = places(&hung).iter().map(|place| place.z).fold(0.0, f64::max);
        assert!(highest > 0.5, "{cells} cells: it hangs on the corner: {highest}");
    }
}

#[test]
fn a_rope_hangs_over_a_capsule_however_its_links_lie() {
    for links in [7, 24] {
        let rod = json!({ "capsule": { "from": [-0.2, 0, 0.6], "to": [0.2, 0.05, 0.6], "radius": 0.08 }, "friction": 0.5 });
        let rope = rope(links, 0.1, |s| DVec3::new(0.02, 1.1 * s - 0.55, 0.71));
        let mut hung = simulation(json!([rope]), json!([floor(), rod]));
        let least = run(&mut hung, 120, |_| ());
        assert!(least > 0.7 && least < 1.1, "{links} links: {least}");
        let x = places(&hung);
        let highest = x.iter().map(|place| place.z).fold(0.0, f64::max);
        assert!(highest > 0.6 && x[0].z < 0.5, "{links} links: it hangs on the rod: {x:?}");
    }
}

#[test]
fn a_rope_hangs_on_the_end_of_a_capsule_and_on_a_small_ball() {
    // Neither has an edge or a triangle there: the nearest place is a vertex, and the inside of a link.
    let post = json!({ "capsule": { "from": [0, 0, 0.1], "to": [0, 0, 0.5], "radius": 0.03 }, "friction": 0.5 });
    let ball = json!({ "sphere": { "center": [0, 0, 0.5], "radius": 0.03 }, "friction": 0.5 });
    for body in [post, ball] {
        let held = |x: f64| {
            let rope = rope(3, 0.05, |s| DVec3::new(x, 0.6 * s - 0.3, 0.55));
            with(rope, "pins", json!([{ "vertices": [0, 3], "move": [[1.0, [0, 0, -0.25]]] }]))
        };
        let mut hung = simulation(json!([held(0.003)]), json!([body]));
        let mut highest = 0.0;
        let least = run(&mut hung, 50, |hung| highest = places(hung).iter().map(|place| place.z).fold(0.0, f64::max));
        assert!(least > 0.5 && least < 1.2, "on {body}: {least}");
        assert!(highest > 0.45, "on {body}: {highest}");
    }
}

/// How far a rope of two and a half turns around a rod slides in half a second, with ends of 0.15 and 0.45 m [m].
fn unwinds(friction: f64) -> f64 {
    let rod = json!({ "capsule": { "from": [-0.3, 0, 0.8], "to": [0.3, 0, 0.8], "radius": 0.05 }, "friction": friction });
    let (ends, radius, links) = ([0.15, 0.45], 0.0545, 120);
    let around = 5.0 * std::f64::consts::PI * radius;
    let rope = rope(links, 0.05, |s| {
        // Up on one side, around, down on the other.
        let along = s * (ends[0] + around + ends[1]) - ends[0];
        let angle = along.clamp(0.0, around) / radius;
        let down = along.min(0.0) - (along - around).max(0.0);
        DVec3::new(0.06 * angle / 15.7, -radius * angle.cos(), 0.8 + radius * angle.sin() + down)
    });
    let mut wound = simulation(json!([with(rope, "friction", json!(friction))]), json!([rod]));
    run(&mut wound, 20, |_| ());
    let before = places(&wound);
    let least = run(&mut wound, 30, |_| ());
    assert!(least > 0.5 && least < 1.2, "at {friction}: {least}");
    let last = links as usize;
    before[last].z - places(&wound)[last].z
}

#[test]
fn a_rope_wound_around_a_rod_holds_by_friction() {
    // Ends of three to one hold from mu = ln 3 / (5 pi) = 0.07 on.
    let [slippery, rough] = [0.02, 0.2].map(unwinds);
    println!("{slippery} {rough}");
    assert!(slippery > 0.1 && rough.abs() < 0.005, "it slides by {slippery} m and {rough} m");
}

#[test]
fn a_sheet_lies_in_a_hammock() {
    for (cells, across) in [(6, 24), (12, 10)] {
        let net = net([cells; 2], 0.2, |u, v| DVec3::new(0.8 * u - 0.4, 0.8 * v - 0.4, 0.4));
        let side = cells + 1;
        let pins = json!([{ "vertices": [0, cells, cells * side, side * side - 1] }]);
        let sheet = json!({
            "grid": { "size": [0.4, 0.4], "cells": [across, across], "axes": ["x", "y"], "origin": [-0.19, -0.21, 0.43] },
            "strain_limit": 0.05, "thickness": 0.004, "friction": 0.3, "density": 0.3,
        });
        let mut hammock = simulation(json!([with(net, "pins", pins), sheet]), json!([]));
        run(&mut hammock, 80, |_| ());
        let lowest = places(&hammock).iter().map(|place| place.z).fold(f64::INFINITY, f64::min);
        assert!(lowest > 0.0, "{cells} cells: the sheet lies in the net: {lowest}");
    }
}

#[test]
fn a_rope_falls_across_another_one() {
    for links in [5, 20] {
        let held = with(rope(2 * links, 0.1, |s| DVec3::new(s - 0.5, 0.0, 0.5)), "pins", json!([{ "vertices": [0, 2 * links] }]));
        let free = rope(links, 0.05, |s| DVec3::new(0.013, 0.8 * s - 0.4, 0.53));
        let mut ropes = simulation(json!([held, free]), json!([]));
        let least = run(&mut ropes, 100, |_| ());
        assert!(least > 0.8 && least < 1.1, "{links} links: {least}");
        let second = places(&ropes).split_off(2 * links as usize + 1);
        let highest = second.iter().map(|place| place.z).fold(f64::NEG_INFINITY, f64::max);
        assert!(highest > 0.35, "{links} links: it hangs over the other one: {highest}");
    }
}

#[test]
fn the_cells_of_a_net_close_until_their_links_touch() {
    // Hung from one corner its cells become narrow; links joined by one other keep their thickness.
    let net = net([9, 9], 0.2, |u, v| DVec3::new(0.54 * u, 0.0, 0.54 * v));
    let net = with(with(net, "thickness", json!(0.012)), "pins", json!([{ "vertices": [99] }]));
    let mut hung = simulation(json!([with(net, "air_drag", json!(2.0))]), json!([]));
    let least = run(&mut hung, 150, |_| ());
    assert!(least > 0.5 && least < 1.1, "{least}");
}

#[test]
fn a_rope_may_be_thicker_than_its_links_are_long() {
    let rope = |thickness: f64, place: fn(f64) -> DVec3| with(rope(60, 0.05, place), "thickness", json!(thickness));
    let straight = |s: f64| DVec3::new(0.6 * s, 0.0, 0.3);
    let mut floating = Simulation::new(&json!({ "cloth": [rope(0.018, straight)], "gravity": [0, 0, 0] }));
    assert!(floating.model.model.warnings.is_empty(), "{:?}", floating.model.model.warnings);
    let before = places(&floating);
    assert_eq!(floating.steps(60).contacts, 0, "nothing pushes a straight rope");
    let moved = before.iter().zip(places(&floating)).map(|(a, b)| a.distance(b)).fold(0.0, f64::max);
    assert!(moved < 1e-6, "{moved}");
    // What is further along it than a hairpin takes stays out of it.
    let mut coil = simulation(
        json!([rope(0.018, |s| DVec3::new(0.03 * (14.0 * s).cos(), 0.03 * (14.0 * s).sin(), 0.03 + 0.5 * s))]),
        json!([floor()]),
    );
    let mut least = f64::INFINITY;
    run(&mut coil, 90, |coil| {
        let x = places(coil);
        let pairs = (0..x.len()).flat_map(|a| (a + 4..x.len()).map(move |b| [a, b]));
        least = pairs.map(|[a, b]| x[a].distance(x[b])).fold(f64::INFINITY, f64::min);
    });
    // Heaped it is pressed flat: coils of other pitches keep 0.2 to 1 of the thickness.
    assert!(least > 0.2 * 0.018, "{least}");
    let fine = model(&json!({ "cloth": [rope(0.03, straight)] }));
    let told = "scene.cloth[0].thickness = 0.03: 60 of 60 links are shorter than half of that";
    assert!(
        fine.model.warnings.iter().any(|text| text.starts_with(told) && text.contains("at most 0.02 m")),
        "{:?}",
        fine.model.warnings
    );
}

#[test]
fn a_net_falls_on_its_edge_and_heaps() {
    let net = net([10, 14], 0.2, |u, v| DVec3::new(0.5 * u - 0.25, 0.02 * (7.0 * v).sin(), 0.03 + 0.7 * v));
    let mut heap = simulation(json!([net]), json!([floor()]));
    run(&mut heap, 90, |_| ());
    let highest = places(&heap).iter().map(|place| place.z).fold(0.0, f64::max);
    assert!(highest < 0.3, "it lies in a heap: {highest}");
}

#[test]
fn a_fast_ball_does_not_pass_a_net() {
    for (speed, beside) in [(5.0_f64, 0.0), (5.0, 0.01), (5.0, -0.003), (20.0, 0.0), (20.0, -0.003)] {
        let thrown = json!({
            "sphere": { "center": [0.32 + beside, -0.4, 0.27], "radius": 0.09 },
            "move": [[0.1, [0, 0, 0]], [0.1 + 0.8 / speed, [0, 0.8, 0]]],
        });
        // Cells of 6 cm, a ball of 18 cm.
        let held = with(
            net([10, 10], 0.1, |u, v| DVec3::new(0.6 * u, 0.0, 0.6 * v)),
            "pins",
            json!([{ "box": [[-1, -1, 0.599], [1, 1, 0.7]] }]),
        );
        // Steps in which the ball goes no further than a cell: the way between two looks is straight.
        let substeps = (speed / 60.0 / 0.05).ceil().max(4.0) as u32;
        let mut goal = Simulation::new(&json!({ "cloth": [held], "body": [thrown], "solver": { "substeps": substeps } }));
        let mut ahead = 0;
        run(&mut goal, 12 + (48.0 / speed) as u64, |goal| {
            let ball = goal.state.bodies[0].y;
            ahead = ahead.max(places(goal).iter().filter(|place| ball > 0.1 && place.y > ball).count());
            // Nothing goes beside the ball faster than the ball goes beside the pins, on the mean.
            let squares: f64 = goal.state.velocities.iter().map(|velocity| velocity.as_dvec3().length_squared()).sum();
            let mean = (squares / places(goal).len() as f64).sqrt();
            assert!(mean < 2.0 * speed, "{speed} m/s: the net goes at {mean} m/s");
        });
        assert!((goal.state.bodies[0].y - 0.4).abs() < 1e-9, "{speed} m/s: it has arrived");
        // A faster one throws the net up, over its pins, and when it comes down there is chance.
        let lowest = places(&goal).iter().map(|place| place.y).fold(f64::INFINITY, f64::min);
        assert!(speed > 5.0 || lowest > -0.1, "{speed} m/s: the net is not behind it: {lowest}");
        assert!(ahead > 0, "{speed} m/s: the net was in front of the ball");
        run(&mut goal, 24, |_| ());
    }
}

/// How far a rope or a net slides down the side of a box within a second [m].
fn slides(net: bool, degrees: f64, friction: f64) -> f64 {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let slope = json!({ "box": { "center": [-0.2 * sine, 0, -0.2 * cosine], "size": [8, 2, 0.4], "rotate": [0, degrees, 0] }, "friction": friction });
    let height = 0.004 + 1e-6;
    let place = |u: f64, v: f64| DVec3::new(u * cosine + height * sine, v, height * cosine - u * sine);
    let of = if net {
        self::net([5, 4], 0.05, |u, v| place(0.2 * u, 0.2 * v))
    } else {
        // A rope in waves, across the slope and along it.
        rope(20, 0.05, |s| place(0.03 * (9.0 * s).sin() + 0.2 * s, 0.4 * s - 0.2))
    };
    let of = with(with(of, "friction", json!(friction)), "air_drag", json!(0.0));
    let mut thing = simulation(json!([of]), json!([slope]));
    let mean = |thing: &Simulation| places(thing).iter().sum::<DVec3>() / places(thing).len() as f64;
    let before = mean(&thing);
    let steps = 60 * u64::from(thing.model.schedule.substeps);
    thing.steps(steps);
    (mean(&thing) - before).dot(DVec3::new(cosine, 0.0, -sine))
}

#[test]
fn friction_is_that_of_coulomb() {
    for (net, friction) in [(false, 0.2_f64), (true, 0.5)] {
        let slope = friction.atan().to_degrees();
        let stuck = slides(net, (0.95 * friction).atan().to_degrees(), friction);
        assert!(stuck.abs() < 1e-3, "slid by {stuck} at {friction}");
        let steeper = 1.1 * slope;
        let (sine, cosine) = steeper.to_radians().sin_cos();
        let exact = 0.5 * 9.81 * (sine - friction * cosine);
        let slid = slides(net, steeper, friction);
        assert!((slid / exact - 1.0).abs() < 0.05, "slid by {slid} instead of {exact} at {friction}");
    }
}

#[test]
fn bits_do_not_depend_on_threads() {
    let hash = |threads: usize| {
        let ball = json!({ "sphere": { "center": [0.03, 0.02, 0.4], "radius": 0.3 } });
        let net = net([30, 30], 0.2, |u, v| DVec3::new(1.2 * u - 0.6, 1.2 * v - 0.6, 0.72));
        let mut run = Simulation::on_threads(&json!({ "cloth": [net], "body": [floor(), ball] }), threads);
        run.steps(30);
        run.state.hash()
    };
    assert_eq!(hash(1), hash(3));
}

#[test]
fn points_without_links_are_grains() {
    // Four fall on a ball, a rope, a sheet and the floor, and one on another.
    let grains = json!({
        "network": { "points": [[0, 0, 0.35], [1, 0.02, 0.3], [2.03, 0.01, 0.3], [3, 0, 0.2], [3.0001, 0, 0.3]], "links": [], "mass": 0.001 },
        "thickness": 0.01, "friction": 1.0, "air_drag": 0.5,
    });
    let held = with(rope(4, 0.1, |s| DVec3::new(0.5 + s, 0.02, 0.25)), "pins", json!([{ "vertices": [0, 1, 2, 3, 4] }]));
    let sheet = json!({
        "grid": { "size": [0.4, 0.4], "cells": [6, 6], "axes": ["x", "y"], "origin": [1.8, -0.2, 0.2] }, "thickness": 0.004, "friction": 1.0,
        "pins": [{ "edge": "left" }, { "edge": "right" }],
    });
    let ball = json!({ "sphere": { "center": [0, 0, 0.2], "radius": 0.1 }, "friction": 1.0 });
    let mut fallen = simulation(json!([grains, held, sheet]), json!([floor(), ball]));
    run(&mut fallen, 30, |_| ());
    assert_eq!(fallen.steps(8).contact_cuts, 0, "rows hold them, not the certificate");
    let x = places(&fallen);
    let expected = [0.306, 0.258, 0.2, 0.006, 0.016];
    for (index, (grain, height)) in x[..5].iter().zip(expected).enumerate() {
        // The sheet sags.
        let room = if index == 2 { 0.05 } else { 0.0005 };
        assert!((grain.z - height).abs() < room, "{grain} instead of {height}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10))]

    #[test]
    fn random_bodies_are_not_passed(
        kind in 0_usize..4,
        at in prop::array::uniform3(-0.15_f64..0.15),
        size in 0.04_f64..0.2,
        turn in prop::array::uniform3(0.0_f64..90.0),
        speed in prop::array::uniform3(-2.0_f64..2.0),
        thickness in 0.001_f64..0.008,
        friction in 0.0_f64..0.8,
        cells in 4_u32..14,
    ) {
        let [x, y, z] = at;
        let mut body = match kind {
            0 => json!({ "sphere": { "center": [x, y, z], "radius": size } }),
            1 => json!({ "capsule": { "from": [x - 0.2, y, z], "to": [x + 0.2, y + 0.1, z], "radius": 0.6 * size } }),
            2 => json!({ "capsule": { "from": [x, y, z - 0.1], "to": [x + 0.1 * size, y, z + 0.1], "radius": 0.2 * size } }),
            _ => json!({ "box": { "center": [x, y, z], "size": [size, 1.5 * size, size], "rotate": turn } }),
        };
        body["friction"] = json!(friction);
        body["move"] = json!([[0.1, [0, 0, 0]], [0.3, speed.map(|part| 0.2 * part)]]);
        let of = net([cells; 2], 0.1, |u, v| DVec3::new(0.6 * u - 0.3, 0.6 * v - 0.3, 0.4));
        let of = with(with(of, "thickness", json!(thickness)), "friction", json!(friction));
        let mut thrown = simulation(json!([of]), json!([body]));
        run(&mut thrown, 36, |_| ());
    }
}
