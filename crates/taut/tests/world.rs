//! The facade: what it builds is what a scene says, what it is given is checked on every way in, and what it tells is true.
#![allow(missing_docs)]
#![cfg_attr(not(all(feature = "json", feature = "threads")), allow(unused_imports))]

mod facade;
mod world_motions;

use facade::{FRAME, NAN, bits, frames, mesh, refused, sheet, world};
use taut::scene::{Body as BodyOfScene, Solver, Substeps, WindLaw};
use taut::{Axis, Body, Cloth, Corner, Edge, Error, Fabric, Gust, Keyframe, Pin, Pool, Up, Weight, Wind, World, WorldBuilder};
use xxhash_rust::xxh3::xxh3_64;

#[cfg(feature = "json")]
#[test]
fn a_world_is_what_the_same_scene_as_json_is() {
    let text = r#"{
        "gravity": [0, 0, -9], "wind": { "velocity": [4, 1, 0], "gust": { "strength": 0.4 }, "law": "drag_lift" },
        "cloth": [
            { "grid": { "size": [1.0, 0.8], "cells": [10, 8] }, "fabric": "silk", "strain_limit": 0.04, "translate": [0, 0, 0.5],
              "thickness": 0.004, "pins": [{ "corner": "top-left" }, { "edge": "right" }], "weights": [{ "vertices": [3], "mass": 0.01 }] },
            { "network": { "points": [[2, 0, 1], [2.1, 0, 1], [2.2, 0, 1]], "links": [[0, 1], [1, 2]], "mass": 0.002 },
              "pins": [{ "nearest": [2, 0, 1] }] }
        ],
        "body": [{ "sphere": { "center": [0.5, 0.2, 0.4], "radius": 0.15 }, "friction": 0.5 }],
        "solver": { "substeps": 4 }
    }"#;
    let wind = Wind { gust: Some(Gust { strength: 0.4, ..Gust::default() }), law: WindLaw::DragLift, ..[4.0, 1.0, 0.0].into() };
    let flag =
        Cloth::grid([1.0, 0.8], [10, 8]).fabric(Fabric::Silk).strain_limit(0.04).translate([0.0, 0.0, 0.5]).thickness(0.004);
    let flag = flag.pin(Pin::corner(Corner::TopLeft)).pin(Pin::edge(Edge::Right)).weight(Weight::vertices([3]).of(0.01));
    let rope = Cloth::network(&[[2.0, 0.0, 1.0], [2.1, 0.0, 1.0], [2.2, 0.0, 1.0]], &[[0, 1], [1, 2]], 0.002);
    let typed = World::builder()
        .gravity([0, 0, -9])
        .wind(wind)
        .cloth(flag)
        .cloth(rope.pin(Pin::nearest([2.0, 0.0, 1.0])))
        .body(Body::sphere([0.5, 0.2, 0.4], 0.15).friction(0.5))
        .solver(Solver { substeps: Substeps::Count(4), ..Solver::default() });
    let [mut read, mut typed] =
        [WorldBuilder::from_json(text).expect("a scene"), typed].map(|asked| asked.build().expect("a world"));
    let reports = [frames(&mut read, 20), frames(&mut typed, 20)];
    assert_eq!(reports[0], reports[1]);
    assert!((0..2).all(|cloth| bits(&read, cloth) == bits(&typed, cloth)), "other bits");
    assert_eq!(read.snapshot(), typed.snapshot());
}

/// The same as text, with the mesh beside it.
#[cfg(feature = "json")]
fn from_json(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> World {
    let text = r#"{
        "wind": { "velocity": [3, 2, 0] },
        "cloth": [{ "mesh": "a.obj", "strain_limit": 0.03, "pins": [{ "vertices": [42, 48] }] }]
    }"#;
    WorldBuilder::from_json(text).expect("a scene").mesh("a.obj", positions, triangles).build().expect("a world")
}

#[test]
fn a_mesh_keeps_its_order_and_its_limit() {
    let (positions, triangles) = mesh(6);
    let cloth = Cloth::mesh(&positions, &triangles).strain_limit(0.03).pin(Pin::vertices([42, 48]));
    let mut world = World::builder().cloth(cloth).wind([3.0, 2.0, 0.0]).build().expect("a world");
    assert_eq!(world.positions(0).expect("a cloth"), positions);
    assert_eq!(world.pinned(0, 0).expect("a pin"), [42, 48]);
    let same = |a: &[u32; 3], b: &[u32; 3]| (0..3).any(|turn| [0, 1, 2].map(|corner| a[(corner + turn) % 3]) == *b);
    assert!(world.faces(0).expect("a cloth").iter().zip(&triangles).all(|(told, given)| same(told, given)));
    let report = frames(&mut world, 60);
    assert!(report.worst_stretch <= 0.03 + 1e-5 && report.limited_steps > 0, "{report:?}");
    let now = world.positions(0).expect("a cloth");
    assert_eq!((now[42], now[48]), (positions[42], positions[48]));
    #[cfg(feature = "json")]
    assert_eq!(frames(&mut from_json(&positions, &triangles), 60), report);
    // By another route than the report's.
    let length = |of: &[[f32; 3]], a: u32, b: u32| {
        let [a, b] = [a, b].map(|vertex| of[vertex as usize].map(f64::from));
        (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
    };
    let worst = triangles.iter().map(|&[a, b, _]| length(now, a, b) / length(&positions, a, b)).fold(0.0, f64::max);
    assert!(worst <= 1.03 + 1e-5 && worst > 1.0, "{worst}");
    assert!((report.time - 1.0).abs() < 1e-12);
}

#[test]
fn time_passes_as_it_is_told() {
    let mut world = world();
    let start = bits(&world, 0);
    let report = world.step(0.0).expect("a look");
    assert_eq!((report.steps, report.time, bits(&world, 0)), (0, 0.0, start));
    let report = world.step(0.25).expect("many steps");
    assert_eq!(report.steps as f64, (0.25 / world.step_length()).ceil());
    assert!((world.time() - 0.25).abs() < 1e-12);
    world.step(1e-6).expect("a short one");
    for dt in [-FRAME, NAN, f64::INFINITY, 1e9, 1e-300] {
        let before = bits(&world, 0);
        refused(world.step(dt), "dt = ");
        assert_eq!(bits(&world, 0), before);
    }
}

#[test]
fn what_is_held_is_where_it_shall_be_and_falls_when_it_is_released() {
    let mut world = world();
    let start = world.positions(0).expect("a cloth")[0];
    let place = [start[0] + 0.1, start[1] + 0.2, start[2] + 0.1];
    world.hold(0, &[0], &[place], 10.0 * FRAME).expect("a vertex");
    frames(&mut world, 5);
    let half = world.positions(0).expect("a cloth")[0];
    assert!((0..3).all(|axis| (half[axis] - 0.5 * (start[axis] + place[axis])).abs() < 1e-4), "{half:?} half way");
    frames(&mut world, 10);
    assert_eq!(world.positions(0).expect("a cloth")[0], place);
    world.release(0, &[0]).expect("a vertex");
    frames(&mut world, 30);
    assert!(world.positions(0).expect("a cloth")[0][2] < place[2] - 0.05);
    world.lead(0, 0, [0.0, 0.4, 0.2], 2.0).expect("a vertex");
    frames(&mut world, 60);
    let led = world.positions(0).expect("a cloth")[0];
    assert!((led[1] - 0.4).abs() < 0.03, "led, as far as the cloth around it lets it go: {led:?}");
}

#[test]
fn a_pin_is_left_as_far_as_its_springs_reach_and_taken_up_again() {
    let mut world = world();
    let corner = world.pinned(0, 0).expect("a pin")[0];
    let home = world.positions(0).expect("a cloth")[corner as usize];
    world.hold(0, &[corner], &[[home[0], home[1], home[2] - 0.1]], FRAME).expect("a vertex");
    // The vertex beside it is pinned.
    let report = frames(&mut world, 30);
    assert!(report.worst_stretch <= 0.05 + 1e-5 && report.held_back_pins > 0, "{report:?}");
    let height = world.positions(0).expect("a cloth")[corner as usize][2];
    assert!(height < home[2] - 0.01 && height > home[2] - 0.09, "{height}");
    world.release(0, &[corner]).expect("a vertex");
    frames(&mut world, 30);
    assert_eq!(world.positions(0).expect("a cloth")[corner as usize], home);
}

#[test]
fn setters_act() {
    let mut world = World::builder()
        .cloth(Cloth::grid([1.0, 1.0], [4, 4]).with(|cloth| cloth.air_drag = Some(0.0)))
        .build()
        .expect("a world");
    world.set_gravity([0.0, 0.0, 2.0]).expect("a gravity");
    assert_eq!(world.gravity(), [0.0, 0.0, 2.0]);
    world.step(0.5).expect("stays finite");
    let speeds = world.velocities(0).expect("a cloth");
    assert!(speeds.iter().all(|speed| (speed[2] - 1.0).abs() < 1e-4), "free fall upwards: {:?}", speeds[0]);
    world.set_gravity([0, 0, 0]).expect("a gravity");
    world.set_wind([0.0, 20.0, 0.0]).expect("a wind");
    assert_eq!(world.wind().expect("a wind").velocity, [0.0, 20.0, 0.0]);
    world.step(0.5).expect("stays finite");
    assert!(world.velocities(0).expect("a cloth").iter().all(|speed| speed[1] > 1.0), "blown");
}

#[test]
fn bodies_carry_cloth_and_contacts_say_where() {
    let cloth = Cloth::grid([0.4, 0.4], [10, 10]).axes([Axis::X, Axis::Y]).translate([-0.2, -0.2, 0.53]).thickness(0.01);
    let ball = Body::sphere([0.0, 0.0, 0.3], 0.2).name("ball").friction(0.6);
    let floor = Body::cuboid([0.0, 0.0, -0.1], [4.0, 4.0, 0.2]);
    let mut world = World::builder().cloth(cloth).body(ball).body(floor).build().expect("a world");
    assert_eq!((world.body_count(), world.body_named("ball"), world.body_named("body1")), (2, Some(0), Some(1)));
    frames(&mut world, 30);
    let touched = world.contacts();
    assert!(!touched.is_empty(), "it lies on the ball");
    for contact in &touched {
        assert_eq!((contact.cloth, contact.body), (0, Some(0)));
        let vertex = world.positions(0).expect("a cloth")[contact.vertex as usize];
        assert!((0..3).all(|axis| (f64::from(vertex[axis]) - contact.place[axis]).abs() < 0.05), "{contact:?} at {vertex:?}");
        assert!(contact.force >= 0.0 && contact.normal[2] > 0.0, "{contact:?}");
    }
    for frame in 1..=30 {
        world.move_body(0, [0.0, 0.0, 0.01 * f64::from(frame)], FRAME).expect("a body");
        frames(&mut world, 1);
    }
    assert!((world.body_positions(0).expect("a body")[0][2] - 0.6).abs() < 1e-9);
    let top = world.positions(0).expect("a cloth").iter().map(|place| place[2]).fold(0.0, f32::max);
    assert!(top > 0.8, "carried up: {top}");
    world.move_body(0, [0.0, 0.0, 0.0], 0.0).expect("a body");
    assert!((world.body_positions(0).expect("a body")[0][2] - 0.3).abs() < 1e-12, "at once");
}

#[test]
fn a_body_that_is_turned_takes_cloth_along() {
    let cloth = Cloth::grid([0.3, 0.3], [8, 8]).axes([Axis::X, Axis::Y]).translate([-0.15, -0.15, 0.02]).thickness(0.01);
    let table = Body::cuboid([0.0, 0.0, -0.1], [2.0, 2.0, 0.2]).friction(0.9);
    let mut world = World::builder().cloth(cloth).body(table).build().expect("a world");
    let side = |world: &World| {
        let places = world.positions(0).expect("a cloth");
        let [a, b] = [places[0], places[8]];
        f64::from(b[1] - a[1]).atan2(f64::from(b[0] - a[0]))
    };
    frames(&mut world, 30);
    let before = side(&world);
    for frame in 1..=60 {
        world.pose_body(0, [0.0; 3], [0.0, 0.0, 0.01 * f64::from(frame)], FRAME).expect("a body");
        frames(&mut world, 1);
    }
    assert!((side(&world) - before - 0.6).abs() < 0.02, "turned by {}", side(&world) - before);
    let corner = world.body_positions(0).expect("a body")[0];
    let (sine, cosine) = 0.6_f64.sin_cos();
    assert!((corner[0] + cosine - sine).abs() < 1e-9 && (corner[1] + cosine + sine).abs() < 1e-9, "{corner:?}");
    world.move_body(0, [0.0, 0.0, -0.5], 0.0).expect("a body");
    let lower = world.body_positions(0).expect("a body")[0];
    assert!((0..2).all(|axis| (lower[axis] - corner[axis]).abs() < 1e-9), "{lower:?} stays turned as {corner:?}");
}

#[test]
fn a_body_whose_vertices_are_told_goes_there() {
    let (positions, triangles) = mesh(2);
    let mut world = World::builder()
        .cloth(sheet().translate([0.0, 1.0, 0.0]))
        .body(Body::mesh(&positions, &triangles))
        .build()
        .expect("a world");
    let to: Vec<[f32; 3]> = positions.iter().map(|place| [place[0], 0.5 * place[1], place[2] + 0.25]).collect();
    world.set_body_vertices(0, &to, 2.0 * FRAME).expect("a body");
    let off = |world: &World, part: f64| {
        let now = world.body_positions(0).expect("a body");
        let ways = now.iter().zip(positions.iter().zip(&to)).flat_map(|(now, (from, to))| {
            (0..3).map(|axis| (now[axis] - f64::from(from[axis]) * (1.0 - part) - f64::from(to[axis]) * part).abs())
        });
        ways.fold(0.0, f64::max)
    };
    for part in [0.5, 1.0, 1.0] {
        frames(&mut world, 1);
        assert!(off(&world, part) < 1e-7, "{} off at {part}", off(&world, part));
    }
    world.set_body_vertices(0, &positions, 0.0).expect("a body");
    assert!(off(&world, 0.0) < 1e-7, "at once");
}

#[test]
fn animated_bodies_go_their_way() {
    let (positions, triangles) = mesh(2);
    let moved = |by: f32| positions.iter().map(|place| [place[0], place[1] + by, place[2]]).collect::<Vec<_>>();
    let wall = Body::mesh(&positions, &triangles).motion(&[moved(0.0), moved(0.1)], 10.0);
    let mut world = World::builder().cloth(sheet().translate([0.0, 1.0, 0.0])).body(wall).build().expect("a world");
    world.step(0.05).expect("stays finite");
    assert!(world.body_positions(0).expect("a body").iter().all(|place| (place[1] - 0.05).abs() < 1e-6));
}

#[test]
fn a_snapshot_goes_on_with_the_same_bits() {
    let asked =
        || World::builder().cloth(sheet().thickness(0.002)).body(Body::sphere([0.5, 0.3, 0.3], 0.1)).wind([0.0, 4.0, 0.0]);
    let mut world = asked().build().expect("a world");
    frames(&mut world, 5);
    world.hold(0, &[0], &[[0.1, 0.1, 0.1]], 0.5).expect("a vertex");
    world.move_body(0, [0.0, -0.1, 0.0], 0.5).expect("a body");
    frames(&mut world, 5);
    let snapshot = world.snapshot();
    let report = frames(&mut world, 20);
    let end = bits(&world, 0);
    world.restore(&snapshot).expect("a snapshot");
    assert!((world.time() - 10.0 * FRAME).abs() < 1e-9 && bits(&world, 0) != end, "back");
    assert_eq!((frames(&mut world, 20), bits(&world, 0)), (report, end.clone()));
    let mut other = asked().pool(&Pool::new(3).expect("threads")).build().expect("a world");
    other.restore(&snapshot).expect("a snapshot");
    assert_eq!((frames(&mut other, 20), bits(&other, 0)), (report, end));

    let before = bits(&world, 0);
    refused(world.restore(b"no snapshot"), "these bytes are not a taut snapshot");
    refused(world.restore(&snapshot[..snapshot.len() - 1]), "the snapshot is damaged");
    refused(world.restore(&self::world().snapshot()), "the snapshot belongs to another scene");
    // The first position, no number, under a checksum that fits.
    let mut made_up = snapshot[..snapshot.len() - 8].to_vec();
    made_up[80..84].copy_from_slice(&f32::NAN.to_le_bytes());
    made_up.extend(xxh3_64(&made_up).to_le_bytes());
    refused(world.restore(&made_up), "cloth[0], vertex 0: no longer at a finite place");
    assert_eq!(bits(&world, 0), before);
}

#[cfg(feature = "threads")]
#[test]
fn threads_are_its_own_or_the_hosts_or_none() {
    let asked = || World::builder().cloth(Cloth::grid([1.0, 1.0], [40, 40]).pin(Pin::corner(Corner::TopLeft)));
    let mut alone = asked().build().expect("a world");
    frames(&mut alone, 5);
    let pool = Pool::new(3).expect("threads");
    assert_eq!((pool.threads(), Pool::default().threads()), (3, 1));
    let host = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
    for pool in [pool, Pool::of_host()] {
        let mut world = asked().pool(&pool).build().expect("a world");
        frames(&mut world, 2);
        host.install(|| frames(&mut world, 3));
        assert_eq!(bits(&world, 0), bits(&alone, 0), "{pool:?}");
    }
    refused(Pool::new(0), "threads = 0");
}

#[test]
fn a_world_can_be_sent_and_shared() {
    fn sent_and_shared<T: Send + Sync>() {}
    sent_and_shared::<World>();
    sent_and_shared::<WorldBuilder>();
    sent_and_shared::<Error>();
}

#[test]
fn what_is_wrong_with_a_cloth_is_refused() {
    let (positions, triangles) = mesh(2);
    let with = |cloth: Cloth, name: &str| refused(World::builder().cloth(cloth).build(), name);
    let mut broken = positions.clone();
    broken[3][1] = f32::NAN;
    with(Cloth::mesh(&broken, &triangles), "scene.cloth[0].mesh: vertex 3 ");
    broken[3][1] = f32::INFINITY;
    with(Cloth::mesh(&broken, &triangles), "scene.cloth[0].mesh: vertex 3 ");
    with(Cloth::mesh(&positions, &[[0, 1, 9]]), "scene.cloth[0].mesh: a face names vertex 9");
    with(Cloth::mesh(&positions, &[]), "scene.cloth[0].mesh");
    with(Cloth::mesh::<f64>(&[], &[]), "scene.cloth[0].mesh");
    with(Cloth::mesh(&positions, &triangles).pin(Pin::edge(Edge::Top)), "scene.cloth[0].pins[0]");
    with(Cloth::mesh(&positions, &triangles).axes([Axis::X, Axis::Y]), "scene.cloth[0]: needs exactly one");
    with(
        Cloth::from(taut::scene::Cloth { mesh: Some("nowhere".to_owned()), ..Default::default() }),
        "scene.cloth[0].mesh = \"nowhere\"",
    );
    with(Cloth::grid([NAN, 1.0], [4, 4]), "scene.cloth[0].grid.size[0] = NaN");
    with(Cloth::grid([1.0, -1.0], [4, 4]), "scene.cloth[0].grid.size[1] = -1");
    with(Cloth::grid([1.0, 1.0], [4, 0]), "scene.cloth[0].grid.cells[1] = 0");
    with(Cloth::grid([1.0, 1.0], [u32::MAX, u32::MAX]), "scene.cloth[0].grid.cells");
    with(sheet().axes([Axis::X, Axis::MinusX]), "scene.cloth[0].grid.axes");
    with(Cloth::network::<f64>(&[], &[], 0.1), "scene.cloth[0].network.points");
    with(Cloth::network(&[[0.0; 3], [1.0, 0.0, NAN]], &[[0, 1]], 0.1), "scene.cloth[0].network.points[1]");
    with(Cloth::network(&[[0.0; 3], [1.0, 0.0, 0.0]], &[[0, 2]], 0.1), "scene.cloth[0].network.links[0]");
    with(Cloth::network(&[[0.0; 3], [1.0, 0.0, 0.0]], &[[0, 1]], NAN), "scene.cloth[0].network.mass");
    with(sheet().pin(Pin::vertices([81])), "scene.cloth[0].pins[1].vertices");
    with(sheet().pin(Pin::vertices([])), "scene.cloth[0].pins[1].vertices");
    with(sheet().pin(Pin::nearest([NAN, 0.0, 0.0])), "scene.cloth[0].pins[1].nearest");
    with(sheet().pin(Pin::inside([5.0; 3], [6.0; 3])), "scene.cloth[0].pins[1]");
    with(sheet().pin(Pin::default()), "scene.cloth[0].pins[1]");
    with(
        sheet().pin(Pin { keyframes: vec![Keyframe(NAN, [0.0; 3])], ..Pin::nearest([0, 0, 0]) }),
        "scene.cloth[0].pins[1].move[0]",
    );
    with(sheet().weight(Weight::vertices([0])), "scene.cloth[0].weights[0].mass = 0");
    with(sheet().weight(Weight::vertices([99]).of(0.1)), "scene.cloth[0].weights[0].vertices");
    with(sheet().translate([0.0, NAN, 0.0]), "scene.cloth[0].translate");
    with(sheet().rotate([f64::INFINITY, 0.0, 0.0]), "scene.cloth[0].rotate");
    type Set = fn(Cloth, f64) -> Cloth;
    let fields: [(&str, Set); 7] = [
        ("strain_limit", Cloth::strain_limit),
        ("density", Cloth::density),
        ("stiffness", Cloth::stiffness),
        ("bending", |cloth, value| cloth.bending(taut::Bending::Given(value))),
        ("thickness", Cloth::thickness),
        ("friction", Cloth::friction),
        ("scale", Cloth::scale),
    ];
    for (field, set) in fields {
        for value in [NAN, f64::INFINITY, -1.0] {
            with(set(sheet(), value), &format!("scene.cloth[0].{field} = {value}"));
        }
    }
    with(sheet().layer(1001), "scene.cloth[0].layer = 1001");
    with(sheet().name("bell \u{7}"), "scene.cloth[0].name");
}

#[test]
fn what_is_wrong_with_a_world_is_refused() {
    let with = |set: fn(WorldBuilder) -> WorldBuilder, name: &str| refused(set(World::builder().cloth(sheet())).build(), name);
    refused(World::builder().build(), "scene.cloth: there is none");
    with(|world| world.cloth(sheet().name("a")).cloth(sheet().name("a")), "scene.cloth[2].name");
    with(|world| world.gravity([NAN, 0.0, 0.0]), "scene.gravity");
    with(|world| world.wind([0.0, f64::INFINITY, 0.0]), "scene.wind.velocity");
    with(|world| world.wind(Wind { density: -1.0, ..Wind::default() }), "scene.wind.density");
    with(|world| world.frames_per_second(0.0), "scene.fps = 0");
    with(|world| world.solver(Solver { substeps: Substeps::Count(0), ..Solver::default() }), "scene.solver.substeps = 0");
    with(|world| world.solver(Solver { tolerance: NAN, ..Solver::default() }), "scene.solver.tolerance");
    with(|world| world.body(Body::sphere([0.0; 3], 0.0)), "scene.body[0].sphere.radius = 0");
    with(|world| world.body(Body::sphere([NAN; 3], 1.0)), "scene.body[0].sphere.center");
    with(|world| world.body(Body::capsule([0.0; 3], [0.0; 3], 0.1)), "scene.body[0].capsule.to");
    with(|world| world.body(Body::cuboid([0.0; 3], [1.0, NAN, 1.0])), "scene.body[0].box.size[1]");
    with(|world| world.body(Body::plane([0.0; 3], [0.0; 3])), "scene.body[0].plane.normal");
    with(|world| world.body(Body::plane([9.0; 3], [0.0, 0.0, 1.0]).friction(NAN)), "scene.body[0].friction");
    with(|world| world.body(Body::plane([9.0; 3], [0.0, 0.0, 1.0]).thickness(-1.0)), "scene.body[0].thickness");
    with(|world| world.body(BodyOfScene::default().into()), "scene.body[0]: needs exactly one");
    with(|world| world.body(Body::mesh(&[[0.0; 3]], &[[0, 0, 1]])), "scene.body[0].mesh");
    let corners = [[0.0, 9.0, 0.0], [1.0, 9.0, 0.0], [0.0, 9.0, 1.0]];
    let moved = |frames: &[Vec<[f64; 3]>], rate: f64| {
        World::builder().cloth(sheet()).body(Body::mesh(&corners, &[[0, 1, 2]]).motion(frames, rate)).build()
    };
    let frame = corners.to_vec();
    refused(moved(&[], 30.0), "scene.body[0].motion");
    refused(moved(&[frame.clone(), frame[1..].to_vec()], 30.0), "scene.body[0].motion[1]");
    refused(moved(&[frame[1..].to_vec()], 30.0), "scene.body[0].motion");
    refused(moved(&[frame.clone(), vec![[NAN; 3]; 3]], 30.0), "scene.body[0].motion");
    refused(moved(std::slice::from_ref(&frame), NAN), "scene.body[0].motion");
    assert!(moved(&[frame], 30.0).is_ok());
    #[cfg(feature = "json")]
    refused(WorldBuilder::from_json(r#"{ "cloht": [] }"#), "scene.cloht");
}

#[cfg(not(feature = "direct"))]
#[test]
fn a_filter_that_needs_a_feature_is_refused_without_it() {
    let solver = Solver { filter: taut::scene::FilterKind::FastProjection, ..Solver::default() };
    refused(World::builder().cloth(sheet()).solver(solver).build(), "scene.solver.filter = \"fast_projection\"");
}

#[test]
fn what_is_wrong_with_a_call_is_refused_and_changes_nothing() {
    let mut world = World::builder().cloth(sheet()).body(Body::sphere([0.0, 9.0, 0.0], 0.1)).up(Up::Z).build().expect("a world");
    frames(&mut world, 1);
    let before = world.snapshot();
    let home = [0.0; 3];
    for read in [World::positions, World::velocities] {
        refused(read(&world, 1).map(<[_]>::len), "cloth = 1: there are 1");
    }
    refused(world.faces(1).map(<[_]>::len), "cloth = 1");
    refused(world.exact_positions(1), "cloth = 1");
    refused(world.pinned(1, 0), "cloth = 1");
    refused(world.pinned(0, 1), "pin = 1");
    refused(world.hold(1, &[0], &[home], 0.0), "cloth = 1");
    refused(world.hold(0, &[0, 81], &[home, home], 0.0), "vertices[1] = 81");
    refused(world.hold(0, &[0, 1], &[home], 0.0), "places = a list of 1");
    refused(world.hold(0, &[0, 1], &[home, [0.0, NAN, 0.0]], 0.0), "places[1]");
    refused(world.hold(0, &[0], &[[1e30, 0.0, 0.0]], 0.0), "places[0]");
    refused(world.hold(0, &[0], &[home], -1.0), "over = -1");
    refused(world.hold(0, &[0], &[home], NAN), "over = NaN");
    refused(world.lead(0, 81, home, 1.0), "vertices[0] = 81");
    refused(world.lead(0, 0, [NAN; 3], 1.0), "place = ");
    for speed in [0.0, -1.0, NAN, f64::INFINITY] {
        refused(world.lead(0, 0, home, speed), "speed = ");
    }
    refused(world.release(0, &[81]), "vertices[0] = 81");
    refused(world.release(1, &[]), "cloth = 1");
    refused(world.set_gravity([0.0, 0.0, NAN]), "scene.gravity");
    refused(world.set_gravity([0.0, 0.0, 1e9]), "scene.gravity");
    refused(world.set_wind([NAN, 0.0, 0.0]), "scene.wind.velocity");
    refused(world.move_body(1, home, 0.0), "body = 1");
    refused(world.move_body(0, [NAN; 3], 0.0), "offset = ");
    refused(world.move_body(0, home, -1.0), "over = -1");
    refused(world.pose_body(1, home, home, 0.0), "body = 1");
    refused(world.pose_body(0, [NAN; 3], home, 0.0), "offset = ");
    refused(world.pose_body(0, home, [0.0, f64::INFINITY, 0.0], 0.0), "rotation = ");
    refused(world.pose_body(0, home, home, NAN), "over = NaN");
    refused(world.set_body_vertices(1, &[home], 0.0), "body = 1");
    refused(world.set_body_vertices(0, &[home; 2], 0.0), "positions = ");
    refused(world.set_body_vertices(0, &[[NAN; 3]], 0.0), "positions[0] = ");
    refused(world.set_body_vertices(0, &[home], -1.0), "over = -1");
    refused(world.body_positions(1), "body = 1");
    assert_eq!((world.snapshot(), world.gravity(), world.wind()), (before, [0.0, 0.0, -9.81], None));
}
