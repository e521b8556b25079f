//! The coarse-to-fine filter: no spring over its limit after any step, whatever the scene; and no needless harm to the motion.

use crate::common::{Simulation, centre_of_mass, chain_links, crooked, mesh_scene, network, scene_of, sheet, worst};
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use serde_json::json;

/// More than rounding to single precision explains: what counts as over the limit.
const ROUNDING: f64 = 1e-5;

#[test]
fn no_spring_is_over_its_limit_after_any_step() {
    let corner = json!([{ "corner": "bottom-left" }]);
    let odd_ones = json!([{ "vertices": [1] }, { "nearest": [0.9, 0.3, 0.0] }]);
    for cells in [[1, 1], [2, 2], [3, 5], [1, 20], [20, 1], [12, 7], [32, 32], [33, 18]] {
        for strain_limit in [0.01, 0.05, 0.10, 0.15] {
            for (rate, wind) in [(30.0, 0.0), (30.0, 40.0), (60.0, 40.0), (1000.0, 12.0)] {
                for pins in [&corner, &odd_ones] {
                    let mut scene = scene_of(sheet(cells, strain_limit, pins.clone()), 1, "coarse_to_fine", 9.81);
                    scene["fps"] = json!(rate);
                    scene["solver"]["force_step"] = json!(true);
                    scene["solver"]["iterations"] = json!(2000);
                    // A step far over the bound of springs would blow up without a limit; without springs it is stable.
                    scene["cloth"][0]["stiffness"] = json!(0.0);
                    scene["cloth"][0]["damping"] = json!(0.0);
                    scene["wind"] = json!({ "velocity": [wind, 0.2 * wind, 0.1 * wind], "gust": {} });
                    let mut run = Simulation::new(&scene);
                    for step in 0..40 {
                        run.steps(1);
                        let worst = worst(&run.model, &run.state);
                        assert!(
                            worst <= 1.0 + ROUNDING,
                            "{cells:?}, {strain_limit}, {rate} Hz, {wind} m/s, step {step}: {worst}"
                        );
                        // Twice the strongest gusts; the step is up to three times as long as the air would bear.
                        let fastest = run.state.velocities.iter().map(Vec3::length).fold(0.0, f32::max);
                        assert!(fastest < 200.0, "{cells:?}, {strain_limit}, {rate} Hz, {wind} m/s, step {step}: {fastest} m/s");
                    }
                }
            }
        }
    }
}

#[test]
fn the_drop_follows_converged_sweeps_and_nothing_is_cut() {
    let run = |filter: &str, iterations: u32| {
        let mut scene = scene_of(sheet([32, 32], 0.1, json!([{ "corner": "bottom-left" }])), 16, filter, 9.81);
        scene["solver"]["iterations"] = json!(iterations);
        scene["solver"]["tolerance"] = json!(1e-4);
        let mut run = Simulation::new(&scene);
        let (mut path, mut cuts) = (Vec::new(), 0);
        for _ in 0..36 {
            cuts += run.steps(16).cuts;
            let count = run.model.particle_count() as f64;
            path.push(run.state.positions.iter().map(Vec3::as_dvec3).sum::<DVec3>() / count);
        }
        (path, cuts)
    };
    let ((path, cuts), (reference, _)) = (run("coarse_to_fine", 200), run("sweeps", 3000));
    let apart = path.iter().zip(&reference).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    assert_eq!(cuts, 0);
    assert!(apart < 0.04, "the centres of mass part by {apart} m");
}

/// A square sheet of cotton that hangs from a corner, at the default settings.
fn hung(as_mesh: bool, cells: u32, stiffness: Option<f64>) -> Simulation {
    let mut cloth = json!({ "fabric": "cotton", "density": 0.2, "strain_limit": 0.1, "pins": [{ "nearest": [0.0, 0.0, 0.0] }] });
    if let Some(stiffness) = stiffness {
        cloth["stiffness"] = json!(stiffness);
    }
    if as_mesh {
        return Simulation::of(mesh_scene(json!({ "fps": 60.0 }), cloth, crooked(cells)));
    }
    cloth["grid"] = json!({ "size": [1.0, 1.0], "cells": [cells, cells], "axes": ["x", "y"] });
    Simulation::new(&json!({ "fps": 60.0, "cloth": [cloth] }))
}

#[test]
fn a_mesh_falls_as_a_grid_does() {
    let (mut mesh, mut grid) = (hung(true, 32, None), hung(false, 32, None));
    let (mut apart, mut cuts) = (0.0_f64, 0);
    for _ in 0..36 {
        for run in [&mut mesh, &mut grid] {
            cuts += run.steps(u64::from(run.model.schedule.substeps)).cuts;
        }
        apart = apart.max(centre_of_mass(&mesh).distance(centre_of_mass(&grid)));
    }
    assert_eq!(cuts, 0);
    assert!(apart < 0.04, "the centres of mass part by {apart} m");
}

#[test]
fn automatic_steps_bear_any_stiffness() {
    for as_mesh in [false, true] {
        for stiffness in [1e2, 1e3, 1e4, 1e5] {
            let mut run = hung(as_mesh, 16, Some(stiffness));
            run.steps(60 * u64::from(run.model.schedule.substeps));
            let fastest = run.state.velocities.iter().map(Vec3::length).fold(0.0, f32::max);
            // A fall of 1.4 m ends with 5 m/s; a tip may be whipped faster.
            assert!(fastest < 15.0, "mesh: {as_mesh}, {stiffness} N/m: {fastest} m/s");
            assert!(worst(&run.model, &run.state) <= 1.0 + ROUNDING, "mesh: {as_mesh}, {stiffness} N/m");
        }
    }
}

/// What is held by several neighbours took six times the cycles of what is held by one, and frames fifty times as long.
#[test]
fn a_held_place_costs_as_few_cycles_as_a_held_vertex() {
    let cycles = |pins: serde_json::Value| {
        let mut scene = scene_of(sheet([64, 64], 0.05, pins), 2, "coarse_to_fine", 9.81);
        scene["wind"] = json!({ "velocity": [6.0, 1.0, 0.0], "gust": { "strength": 0.3, "period": 1.7, "seed": 1 } });
        let mut run = Simulation::new(&scene);
        let most = (0..100).map(|_| run.steps(1).sweeps).max().expect("a step");
        assert!(worst(&run.model, &run.state) <= 1.0 + ROUNDING);
        most
    };
    let vertex = cycles(json!([{ "corner": "top-left" }]));
    for place in [[[-0.01, 0.93], [0.07, 1.01]], [[0.4, 0.99], [0.5, 1.01]], [[0.4, 0.4], [0.6, 0.6]]] {
        let [[left, bottom], [right, top]] = place;
        let place = cycles(json!([{ "box": [[left, bottom, -9.0], [right, top, 9.0]] }]));
        assert!(place <= 2 * vertex, "{left}, {bottom}: {place} cycles in a step instead of {vertex}");
    }
}

/// Corners whose coarse cells were narrower than others had no diagonals that lead away from them: 49 cycles in a step instead of 15.
#[test]
fn a_taut_grid_takes_few_cycles_whatever_its_number_of_cells() {
    let pins = ["bottom-left", "bottom-right", "top-left", "top-right"].map(|corner| json!({ "corner": corner }));
    let grid = json!({ "size": [2.0, 2.0], "cells": [90, 90], "axes": ["x", "z"] });
    let mut scene =
        scene_of(json!({ "grid": grid, "fabric": "nylon", "strain_limit": 0.01, "pins": pins }), 2, "coarse_to_fine", 9.81);
    scene["wind"] = json!({ "velocity": [3.0, 2.0, 0.0], "gust": { "strength": 0.3, "period": 1.0, "seed": 3 } });
    let mut run = Simulation::new(&scene);
    let cycles: u64 = (0..120).map(|_| run.steps(1).sweeps).sum();
    assert!(cycles <= 120 * 25, "{} cycles in a step", cycles as f32 / 120.0);
    assert!(worst(&run.model, &run.state) <= 1.0 + ROUNDING);
}

/// Where coarse levels had a band of narrower cells in the middle, a line that is taut from corner to corner gave way there: there were 121 and 62
/// cuts. With cells that are alike there are still 16 in the second one where the worst spring alone ends the cycles.
#[test]
fn cloth_that_is_taut_from_corner_to_corner_goes_on_moving() {
    let corners = ["top-left", "top-right", "bottom-left", "bottom-right"];
    for (cells, size, held, limit, speed, seed) in
        [([82, 77], [2.855, 1.876], 3, 0.05, 7.14, 40), ([100, 61], [2.0, 1.22], 4, 0.01, 3.6, 1)]
    {
        let grid = json!({ "size": size, "cells": cells, "axes": ["x", "z"] });
        let pins: Vec<_> = corners[..held].iter().map(|corner| json!({ "corner": corner })).collect();
        let cloth = json!({ "grid": grid, "fabric": "nylon", "strain_limit": limit, "pins": pins });
        let mut scene = scene_of(cloth, 2, "coarse_to_fine", 9.81);
        let gust = json!({ "strength": 0.3, "period": 1.3, "seed": seed });
        scene["wind"] = json!({ "velocity": [0.6 * speed, 0.8 * speed, 0.0], "gust": gust });
        let mut run = Simulation::new(&scene);
        let cuts: u64 = (0..180).map(|_| run.steps(1).cuts).sum();
        assert_eq!(cuts, 0, "{cells:?} cells: cuts");
    }
}

#[test]
fn pins_torn_at_a_hundred_metres_per_second_leave_the_state_finite() {
    let pins = json!([
        { "edge": "left" },
        { "edge": "right", "move": [[0.1, [0, 0, 0]], [0.105, [-0.5, 0, 0]], [0.11, [0, 0, 0]]] },
    ]);
    let mut run = Simulation::new(&scene_of(sheet([16, 16], 0.05, pins), 20, "coarse_to_fine", 9.81));
    for _ in 0..400 {
        run.steps(1);
        assert!(run.state.positions.iter().all(|position| position.is_finite() && position.length() < 10.0));
        assert!(worst(&run.model, &run.state) <= 1.0 + ROUNDING);
    }
}

#[test]
fn pins_that_ask_for_the_impossible_are_held_back_and_counted_and_arrive_once_they_can() {
    // A star: no two of its tips are out of each other's reach, but its middle cannot follow all three.
    let tips = [0.0_f64, 120.0, 240.0].map(|angle| [angle.to_radians().cos(), angle.to_radians().sin(), 0.0]);
    let run = |outwards: f64| {
        let mut cloth = network(&[[0.0; 3], tips[0], tips[1], tips[2]], &[[0, 1], [0, 2], [0, 3]], 0.01);
        cloth["strain_limit"] = json!(0.05);
        let paths = tips.map(|tip| json!([[0.5, tip.map(|part| part * outwards)], [1.0, [0, 0, 0]]]));
        cloth["pins"] = (1..4).map(|tip| json!({ "vertices": [tip], "move": paths[tip - 1] })).collect();
        let mut run = Simulation::new(&scene_of(cloth, 4, "coarse_to_fine", 9.81));
        let (mut cuts, mut held_back, mut late) = (0, 0, 0.0_f32);
        for _ in 0..4 * 60 {
            let one = run.steps(1);
            (cuts, held_back) = (cuts + one.cuts, held_back + one.held_back_pins);
            assert!(worst(&run.model, &run.state) <= 1.0 + ROUNDING);
            let place = run.model.inputs.pins.position(&run.model, 0, 0, run.state.time()).as_vec3();
            late = late.max(place.distance(run.state.positions.get(1)));
        }
        (cuts, held_back, late, run.state.positions.get(1).distance(Vec3::X))
    };
    assert_eq!(run(0.04), (0, 0, 0.0, 0.0));
    let (cuts, held_back, late, left) = run(0.09);
    assert!(held_back > 10 && held_back == cuts, "held back in {held_back} steps of {cuts} cut ones");
    assert!((0.03..0.05).contains(&late), "pins are late by {late} m");
    assert!(left < 1e-6, "they still miss {left} m when they can be there");
}

#[test]
fn a_free_sheet_and_a_free_dumbbell_keep_their_momentum() {
    let dumbbell = network(&[[0.0; 3], [1.0, 0.0, 0.0]], &[[0, 1]], 0.1);
    let mut weighted = sheet([17, 12], 0.05, json!([]));
    weighted["weights"] = json!([{ "corner": "top-right", "mass": 0.01 }, { "edge": "left", "mass": 0.05 }]);
    for cloth in [sheet([17, 12], 0.05, json!([])), dumbbell, weighted] {
        let mut cloth = cloth;
        cloth["air_drag"] = json!(0.0);
        let mut run = Simulation::new(&scene_of(cloth, 24, "coarse_to_fine", 0.0));
        for particle in 0..run.model.particle_count() {
            let wave = (particle as f32 * 0.7).sin();
            run.state.velocities.set(particle, Vec3::new(1.0 + 2.0 * wave, 0.3 * wave, wave));
        }
        let momentum = |run: &Simulation| {
            let moving = run.state.velocities.iter().zip(&run.model.particles.mass);
            moving.map(|(velocity, &mass)| velocity.as_dvec3() * f64::from(mass)).sum::<DVec3>()
        };
        let before = momentum(&run);
        let summary = run.steps(24 * 600);
        assert!(summary.limited_steps > 0);
        let drift = (momentum(&run) - before).length() / before.length();
        assert!(drift < 5e-6, "momentum drifts by {drift} in 10 s");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn the_filter_adds_no_kinetic_energy(cells in [1_u32..9, 1_u32..9], speed in 0.1_f32..20.0, seed: u32, pinned: bool) {
        let pins = if pinned { json!([{ "corner": "top-left" }]) } else { json!([]) };
        let mut cloth = sheet(cells, 0.05, pins);
        for field in ["stiffness", "damping", "air_drag"] {
            cloth[field] = json!(0.0);
        }
        let mut run = Simulation::new(&scene_of(cloth, 4, "coarse_to_fine", 0.0));
        for particle in 0..run.model.particle_count() {
            let noise = |salt: u32| (f64::from((particle as u32).wrapping_mul(7919).wrapping_add(seed).wrapping_add(salt)) * 0.618).sin() as f32;
            run.state.velocities.set(particle, Vec3::new(noise(0), noise(1), noise(2)) * speed);
        }
        // Of the velocities that the filter changes: those of the motion are others.
        let kinetic = |run: &Simulation| {
            let of = |(v, m): (Vec3, &f32)| 0.5 * f64::from(*m) * f64::from(v.length_squared());
            let (masses, weights) = (&run.model.particles.mass, &run.model.particles.inverse_mass);
            let all = run.state.velocities.iter().zip(masses).zip(weights);
            all.filter(|(_, weight)| **weight > 0.0).map(|(particle, _)| of(particle)).sum::<f64>()
        };
        let mut energy = kinetic(&run);
        for _ in 0..8 {
            run.steps(1);
            let next = kinetic(&run);
            prop_assert!(next <= energy * (1.0 + 1e-4), "{energy} J grew to {next} J");
            prop_assert!(worst(&run.model, &run.state) <= 1.0 + ROUNDING);
            energy = next;
        }
    }
}

#[test]
fn a_chain_keeps_its_length_and_swings() {
    let links = 32;
    let points: Vec<[f64; 3]> = (0..=links).map(|bead| [f64::from(bead) / f64::from(links), 0.0, 0.0]).collect();
    let mut cloth = network(&points, &chain_links(links), 0.01);
    cloth["strain_limit"] = json!(0.01);
    cloth["pins"] = json!([{ "vertices": [0] }]);
    let mut run = Simulation::new(&scene_of(cloth, 8, "coarse_to_fine", 9.81));
    let mut lowest = 0.0_f32;
    for _ in 0..480 {
        run.steps(1);
        assert!(worst(&run.model, &run.state) <= 1.0 + ROUNDING);
        lowest = lowest.min(run.state.positions.z[32]);
    }
    assert!(lowest < -0.9, "the end of the chain falls to {lowest} m only");
}

#[test]
fn the_smallest_limits_are_no_reason_to_panic() {
    for strain_limit in [1e-3, 1e-5, 1e-9] {
        let mut scene = scene_of(sheet([6, 4], strain_limit, json!([{ "corner": "top-left" }])), 40, "coarse_to_fine", 9.81);
        scene["solver"]["iterations"] = json!(50);
        let mut run = Simulation::new(&scene);
        run.steps(40);
        assert!(worst(&run.model, &run.state) <= 1.0 + ROUNDING, "{strain_limit}");
    }
}

#[test]
fn a_cloth_may_lie_on_something_held_in_the_middle_of_it() {
    // Held vertices whose neighbours are all held have no spring that could move: as a network, and so without a lattice.
    let cells = 12;
    let id = |i: u32, j: u32| j * (cells + 1) + i;
    let places = (0..=cells).flat_map(|j| (0..=cells).map(move |i| (i, j)));
    let points: Vec<[f64; 3]> = places.clone().map(|(i, j)| [0.1 * f64::from(i), 0.1 * f64::from(j), 0.0]).collect();
    let along = places.clone().filter(|&(i, _)| i < cells).map(|(i, j)| [id(i, j), id(i + 1, j)]);
    let across = places.filter(|&(_, j)| j < cells).map(|(i, j)| [id(i, j), id(i, j + 1)]);
    let links: Vec<[u32; 2]> = along.chain(across).collect();
    let mut net = network(&points, &links, 0.001);
    net["pins"] = json!([{ "box": [[0.25, 0.25, -1.0], [0.95, 0.95, 1.0]] }]);
    let mut run = Simulation::new(&scene_of(net, 2, "coarse_to_fine", 9.81));
    run.steps(120);
    assert!(worst(&run.model, &run.state) < 1.0 + ROUNDING);
    assert!(run.state.positions.z[0] < -0.2, "its corner has not come down");
}
