//! The same scene gives the same bits, on any number of threads, and no step allocates.
#![allow(missing_docs, unsafe_code)]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::process::Command;

use common::{Built, Simulation, build, crooked, goldens};
use serde_json::{Value, json};
use taut::geometry::{CHUNK, Registers};
use taut::{Cloth, Edge, Pin, World};

/// Counts the allocations of the current thread.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn flag(cells: [u32; 2], filter: &str, wind: &str) -> Value {
    json!({
        "wind": { "velocity": [8.0, 1.5, 0.0], "gust": { "strength": 0.3, "period": 1.7, "seed": 1 }, "model": wind },
        "cloth": [{
            "grid": { "size": [1.5, 1.0], "cells": cells, "origin": [0.0, 0.0, 1.0] },
            "fabric": "nylon", "density": 0.2, "pins": [{ "edge": "left" }],
        }],
        "solver": { "filter": filter, "iterations": 10 },
    })
}

const FILTERS: [&str; 9] =
    ["coarse_to_fine", "sweeps", "sequential", "none", "provot", "rods", "fast_projection", "tethers", "xpbd"];

#[test]
fn the_number_of_threads_changes_no_bit() {
    let winds = FILTERS.map(|filter| (filter, if filter == "none" { "triangle" } else { "particle" }));
    for (filter, wind) in winds {
        // Large enough that every parallel loop is handed out.
        let scene = flag([144, 96], filter, wind);
        let hashes: Vec<u64> = [1, 2, 3, 4, 8]
            .map(|threads| {
                let mut run = Simulation::on_threads(&scene, threads);
                assert_eq!(run.work.pool().threads(), threads);
                run.steps(40);
                run.state.hash()
            })
            .into();
        assert!(hashes.iter().all(|&hash| hash == hashes[0]), "{filter}, {wind}: {hashes:x?}");
    }
}

/// The flag with all that may be added to it.
fn rich_flag(cells: [u32; 2], bending: &str) -> Value {
    let mut scene = flag(cells, "coarse_to_fine", "triangle");
    scene["wind"]["law"] = json!("drag_lift");
    scene["wind"]["elements"] = json!([
        { "kind": "vortex", "centre": [0.5, 0.3, 1.5], "axis": [0, 0, 1], "circulation": 2.0, "core": 0.2 },
        { "kind": "source", "centre": [-1.0, 0.0, 1.5], "flow": 3.0, "core": 0.2 },
    ]);
    scene["cloth"][0]["friction_coefficient"] = json!(0.01);
    if bending == "curves" {
        scene["cloth"][0]["curves"] = json!({
            "tension": [[0, 0], [0.03, 0.6], [0.05, 8]], "shear": [[0, 0], [0.05, 0.3], [0.3, 0.9]],
            "bending": [[0, 0], [5, 1e-4], [100, 1e-3]],
        });
    } else {
        scene["cloth"][0]["bending"] = json!(1e-5);
        scene["cloth"][0]["bending_model"] = json!(bending);
    }
    scene
}

#[test]
fn nor_do_they_with_bending_curves_and_flows() {
    for bending in ["quadratic", "choi_ko", "curves"] {
        let hash = |threads: usize| {
            let mut run = Simulation::on_threads(&rich_flag([144, 96], bending), threads);
            run.steps(15);
            run.state.hash()
        };
        assert_eq!(hash(1), hash(3), "{bending}");
        let mut run = Simulation::new(&rich_flag([48, 32], bending));
        run.steps(2);
        let before = ALLOCATIONS.with(Cell::get);
        run.steps(10);
        assert_eq!(ALLOCATIONS.with(Cell::get), before, "{bending}");
    }
}

/// Those that are not in every other test.
const INTEGRATORS: [&str; 6] = ["forward_euler", "midpoint", "rk4", "verlet", "implicit_euler", "bdf2"];

#[test]
fn nor_do_they_with_any_integrator() {
    for integrator in INTEGRATORS {
        let scene = |cells: [u32; 2]| {
            let mut scene = rich_flag(cells, "quadratic");
            (scene["solver"]["integrator"], scene["solver"]["substeps"]) = (json!(integrator), json!(120));
            scene["solver"]["force_step"] = json!(true);
            scene
        };
        let hash = |threads: usize| {
            let mut run = Simulation::on_threads(&scene([80, 60]), threads);
            run.steps(2);
            run.state.hash()
        };
        assert_eq!(hash(1), hash(3), "{integrator}");
        let mut run = Simulation::new(&scene([48, 32]));
        run.steps(2);
        let before = ALLOCATIONS.with(Cell::get);
        run.steps(5);
        assert_eq!(ALLOCATIONS.with(Cell::get), before, "{integrator}");
    }
}

#[test]
fn the_same_bits_as_ever() {
    let run = |filter: &str| {
        let mut run = Simulation::new(&flag([24, 16], filter, "particle"));
        run.steps(600);
        (format!("flag, {filter}"), run.state.hash())
    };
    goldens::check(&FILTERS.map(run));
}

/// A crooked sheet of triangles 1 m wide, held at a corner, in the wind of the flag.
fn mesh_cloth(name: &str) -> Value {
    json!({
        "name": name, "mesh": "crooked", "fabric": "nylon", "density": 0.2, "bending": 1e-5, "friction_coefficient": 0.01,
        "translate": [0.0, 0.0, 1.0], "rotate": [80.0, 10.0, -30.0], "pins": [{ "nearest": [0.0, 0.0, 1.0] }],
    })
}

/// A net of so many points along a side, held along one of them, which travels.
fn net_cloth(name: &str, side: u32) -> Value {
    let at = |index: u32| f64::from(index) / f64::from(side - 1);
    let points: Vec<[f64; 3]> = (0..side * side).map(|point| [at(point % side), 2.0, at(point / side)]).collect();
    let id = |i: u32, j: u32| j * side + i;
    let along = (0..side * (side - 1))
        .map(|link| [id(link % (side - 1), link / (side - 1)), id(link % (side - 1) + 1, link / (side - 1))]);
    let up = (0..side * (side - 1)).map(|link| [id(link % side, link / side), id(link % side, link / side + 1)]);
    let links: Vec<[u32; 2]> = along.chain(up).collect();
    json!({
        "name": name, "network": { "points": points, "links": links, "mass": 2e-5 }, "stiffness": 2.0, "damping": 1e-5,
        "strain_limit": 0.02, "pins": [{ "box": [[-1, 1, 0.999], [2, 3, 1.1]], "move": [[0.02, [0.02, 0.0, 0.01]]] }],
    })
}

/// A scene with the wind of the flag and these cloths; the mesh has so many cells a side.
fn of_cloths(cloths: &[Value], filter: &str, cells: u32) -> Built {
    let mut scene = flag([1, 1], filter, "triangle");
    scene["wind"]["law"] = json!("drag_lift");
    scene["cloth"] = json!(cloths);
    build(&common::scene(&scene), &BTreeMap::from([("crooked".to_owned(), crooked(cells))])).expect("a model")
}

#[test]
fn nor_do_they_with_meshes_networks_and_all_together() {
    // 4096 particles are the least that are handed to several threads.
    let grid = |name: &str, cells: [u32; 2]| {
        let mut cloth = flag(cells, "none", "triangle")["cloth"][0].clone();
        (cloth["name"], cloth["weights"]) = (json!(name), json!([{ "corner": "top-right", "mass": 0.01 }]));
        cloth
    };
    let mesh = [mesh_cloth("mesh")];
    let net = [net_cloth("net", 68)];
    let mut patched = grid("patched", [96, 64]);
    patched["pins"] = json!([{ "box": [[-0.01, -1.0, 1.9], [0.1, 1.0, 2.01]] }]);
    let patched = [patched];
    let mixed = [grid("large", [96, 64]), mesh_cloth("mesh"), net_cloth("net", 66), grid("small", [3, 3])];
    let scenes: [(&str, &[Value], &str, u32, u64); 10] = [
        ("mesh", &mesh, "coarse_to_fine", 72, 30),
        ("mesh", &mesh, "none", 72, 30),
        ("mesh", &mesh, "sweeps", 72, 120),
        ("mesh", &mesh, "xpbd", 72, 20),
        ("patched", &patched, "coarse_to_fine", 1, 40),
        ("net", &net, "coarse_to_fine", 1, 20),
        ("net", &net, "sequential", 1, 80),
        ("net", &net, "tethers", 1, 80),
        ("mixed", &mixed, "coarse_to_fine", 66, 12),
        ("mixed", &mixed, "provot", 66, 80),
    ];
    // With other registers than the usual ones it is the bits of the same goldens that count: one number of threads will do.
    let threads: &[usize] = if std::env::var_os(REGISTERS).is_some() { &[2] } else { &[1, 2, 3, 8] };
    let mut found = Vec::new();
    for (name, cloths, filter, cells, steps) in scenes {
        let hash = |&threads: &usize| {
            let mut run = Simulation::with_threads(of_cloths(cloths, filter, cells), threads);
            assert_eq!(run.work.pool().threads(), threads);
            assert!(
                run.model.cloths.iter().all(|cloth| cloth.count >= 4 * CHUNK || cloth.name == "small"),
                "{name} is too small"
            );
            let summary = run.steps(steps);
            assert_eq!(summary.limited_springs > 0, filter != "none", "{name}, {filter}");
            run.state.hash()
        };
        let hashes: Vec<u64> = threads.iter().map(hash).collect();
        assert!(hashes.iter().all(|&hash| hash == hashes[0]), "{name}, {filter}: {hashes:x?}");
        found.push((format!("{name}, {filter}"), hashes[0]));
    }
    goldens::check(&found);
}

/// Names the registers that a process shall use.
const REGISTERS: &str = "TAUT_SIMD";

/// Every golden once more, with each kind of registers that this processor has; they are chosen once a process.
#[test]
fn the_width_of_registers_changes_no_bit() {
    let tests = ["the_same_bits_as_ever", "nor_do_they_with_meshes_networks_and_all_together"];
    let this = std::env::current_exe().expect("a file");
    let kinds: Vec<Registers> = Registers::here().collect();
    let runs = kinds.iter().map(|registers| {
        Command::new(&this).args(tests).arg("--exact").env(REGISTERS, registers.word()).env_remove("TAUT_GOLDENS").output()
    });
    for (registers, run) in kinds.iter().zip(runs) {
        let run = run.expect("it starts");
        let told = String::from_utf8_lossy(&run.stdout);
        assert!(
            run.status.success() && told.contains("2 passed"),
            "{registers:?}: {told}{}",
            String::from_utf8_lossy(&run.stderr)
        );
    }
}

#[test]
fn a_step_allocates_nothing() {
    for filter in FILTERS {
        let mut run = Simulation::new(&flag([48, 32], filter, "particle"));
        run.steps(2);
        let before = ALLOCATIONS.with(Cell::get);
        run.steps(20);
        assert_eq!(ALLOCATIONS.with(Cell::get), before, "{filter}");
    }
    let mut run = Simulation::of(of_cloths(&[mesh_cloth("mesh"), net_cloth("net", 20)], "coarse_to_fine", 20));
    run.steps(2);
    let before = ALLOCATIONS.with(Cell::get);
    run.steps(20);
    assert_eq!(ALLOCATIONS.with(Cell::get), before, "a mesh and a net");
    let sheet = Cloth::grid([1.0, 1.0], [16, 16]).pin(Pin::edge(Edge::Left));
    let mut world = World::builder().cloth(sheet).wind([4.0, 2.0, 0.0]).build().expect("a world");
    let mut frame = || world.step(1.0 / 60.0).expect("stays finite");
    frame();
    let before = ALLOCATIONS.with(Cell::get);
    frame();
    assert_eq!(ALLOCATIONS.with(Cell::get), before, "the facade");
}
