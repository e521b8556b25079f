//! What the coarse-to-fine filter owes to physics, on random grids, meshes and networks in random folded states.

use crate::common::{Built, mesh_model, model, network, scene_of};
use glam::{Quat, Vec3};
use proptest::prelude::*;
use serde_json::{Value, json};
use taut::filter::{Filter, Limited, apply};
use taut::geometry::{Pool, Vectors};
use taut::model::{MeshData, Model};
use taut::state::State;

const LIMIT: f64 = 0.05;

/// Where the particles of a cloth come from.
#[derive(Debug, Clone)]
enum Cloth {
    Grid { cells: [u32; 2] },
    Mesh { cells: [usize; 2], seed: u32 },
    Net { points: usize, links: usize, seed: u32 },
}

fn cloths() -> impl Strategy<Value = Cloth> {
    prop_oneof![
        [1_u32..14, 1_u32..14].prop_map(|cells| Cloth::Grid { cells }),
        ([1_usize..11, 1_usize..11], any::<u32>()).prop_map(|(cells, seed)| Cloth::Mesh { cells, seed }),
        (3_usize..40, 0_usize..20, any::<u32>()).prop_map(|(points, links, seed)| Cloth::Net { points, links, seed }),
        (2_usize..40, any::<u32>()).prop_map(|(points, seed)| Cloth::Net { points, links: 0, seed }),
    ]
}

/// Numbers in [0, 1), the same for the same seed.
fn random(seed: u32) -> impl FnMut() -> f64 {
    let mut state = u64::from(seed) | 1 << 40;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / f64::from(1 << 24)
    }
}

/// A model; of a mesh or a network the vertex `order[i]` is number `i` of the plain one.
fn build(cloth: &Cloth, order: Option<&[u32]>, pinned: bool) -> Built {
    let number = |plain: usize| order.map_or(plain as u32, |order| order[plain]);
    let material = json!({ "stiffness": 0.0, "damping": 0.0, "air_drag": 0.0, "density": 0.2, "strain_limit": LIMIT });
    let with_pin = |mut fields: Value| {
        if pinned {
            fields["pins"] = json!([{ "vertices": [number(0)] }]);
        }
        fields
    };
    match cloth {
        Cloth::Grid { cells } => {
            let mut fields = with_pin(material);
            fields["grid"] = json!({ "size": [0.1 * f64::from(cells[0]), 0.1 * f64::from(cells[1])], "cells": cells });
            model(&scene_of(fields, 4, "coarse_to_fine", 0.0))
        }
        Cloth::Mesh { cells, seed } => mesh_model(with_pin(material), crooked(*cells, *seed, number)),
        Cloth::Net { points, links, seed } => {
            let mut random = random(*seed);
            let mut places = vec![[0.0; 3]; *points];
            (0..*points).for_each(|plain| places[number(plain) as usize] = [random(), random(), random()]);
            // Each tied to one of the five before it: a tree; then some more.
            let before = |end: usize, part: f64| end - 1 - (part * end.min(5) as f64) as usize;
            let mut pairs: Vec<[u32; 2]> = (1..*points).map(|end| [number(before(end, random())), number(end)]).collect();
            for _ in 0..*links {
                let [a, b] = [random(), random()].map(|part| (part * *points as f64) as usize);
                pairs.extend((a != b).then_some([number(a), number(b)]));
            }
            model(&scene_of(with_pin(network(&places, &pairs, 0.02)), 4, "coarse_to_fine", 0.0))
        }
    }
}

/// A crooked rectangle whose cells are cut along one diagonal or the other.
fn crooked(cells: [usize; 2], seed: u32, number: impl Fn(usize) -> u32) -> MeshData {
    let mut random = random(seed);
    let [columns, rows] = cells.map(|cells| cells + 1);
    let mut mesh = MeshData { vertices: vec![[0.0; 3]; columns * rows], ..MeshData::default() };
    for plain in 0..columns * rows {
        let [x, y] = [plain % columns, plain / columns].map(|at| 0.1 * at as f64 + 0.05 * random());
        mesh.vertices[number(plain) as usize] = [x, y, 0.0];
    }
    for cell in 0..cells[0] * cells[1] {
        let a = cell / cells[0] * columns + cell % cells[0];
        let [a, b, c, d] = [a, a + 1, a + columns + 1, a + columns].map(|plain| i64::from(number(plain)));
        mesh.corners.extend(if random() < 0.5 { [a, b, c, a, c, d] } else { [a, b, d, b, c, d] });
        mesh.counts.extend([3, 3]);
    }
    mesh
}

/// A step that the filter is asked about.
fn ends_of(model: &Built, state: &State) -> Vectors {
    let mut ends = state.positions.clone();
    ends.add_scaled(0..model.particle_count(), &state.velocities, model.schedule.step_length as f32, &Pool::new(1));
    ends
}

/// The state with filtered velocities, the ends of its step, and what the filter did.
fn filtered(model: &Built, state: &State) -> (State, Vectors, Limited) {
    let (mut state, mut ends) = (state.clone(), ends_of(model, state));
    let plan = model.plan();
    let limited = apply(model.stride(&plan), &mut state, &mut ends, &mut Filter::new(model, &plan), &Pool::new(1));
    (state, ends, limited)
}

/// Folded and still admissible: some steps of random velocities, each within the limit. Random velocities on top.
fn folded(model: &Built, seed: u32, speed: f32) -> State {
    let mut random = random(seed);
    let mut state = State::new(model);
    for step in 0..6 {
        for particle in 0..model.particle_count() {
            let noise = Vec3::from_array([(); 3].map(|()| random() as f32 - 0.5));
            let free = model.particles.inverse_mass[particle] > 0.0;
            state.velocities.set(particle, if free { noise * 2.0 * speed } else { Vec3::ZERO });
        }
        if step < 5 {
            let (_, ends, _) = filtered(model, &state);
            state.positions = ends;
        }
    }
    state
}

fn map(state: &State, place: impl Fn(Vec3) -> Vec3, direction: impl Fn(Vec3) -> Vec3) -> State {
    let mut mapped = state.clone();
    for particle in 0..state.positions.len() {
        mapped.positions.set(particle, place(state.positions.get(particle)));
        mapped.velocities.set(particle, direction(state.velocities.get(particle)));
    }
    mapped
}

/// Kinetic energy of the difference of two sets of velocities [J].
fn energy_between(model: &Model, a: &Vectors, b: &Vectors) -> f64 {
    let parts = a.iter().zip(b.iter()).zip(&model.particles.mass);
    parts.map(|((a, b), &mass)| 0.5 * f64::from(mass) * (a - b).as_dvec3().length_squared()).sum()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// A filtered step is admissible and stays bit by bit what it is.
    #[test]
    fn filtering_twice_is_filtering_once(cloth in cloths(), seed: u32, speed in 0.2_f32..15.0, pinned: bool) {
        let model = build(&cloth, None, pinned);
        let (once, ends, _) = filtered(&model, &folded(&model, seed, speed));
        let (twice, _, limited) = filtered(&model, &once);
        prop_assert_eq!(limited, Limited::default());
        prop_assert_eq!(&twice, &once);
        // The same with the very ends that the first pass left, not with those formed anew from its velocities.
        let (mut again, mut same) = (once.clone(), ends.clone());
        let plan = model.plan();
        apply(model.stride(&plan), &mut again, &mut same, &mut Filter::new(&model, &plan), &Pool::new(1));
        prop_assert!(again == once && same == ends);
    }

    #[test]
    fn no_kinetic_energy_is_added(cloth in cloths(), seed: u32, speed in 0.2_f32..15.0, pinned: bool) {
        let model = build(&cloth, None, pinned);
        let state = folded(&model, seed, speed);
        let at_rest = Vectors::zeros(state.positions.len());
        let (after, _, _) = filtered(&model, &state);
        let [before, after] = [&state, &after].map(|state| energy_between(&model, &state.velocities, &at_rest));
        prop_assert!(after <= before * (1.0 + 1e-5), "{before} J became {after} J");
    }

    /// A step of 4 ms over distances of a metre keeps velocities of 1 m/s to about 1e-5 in single precision, and so close are
    /// the two. Once in some ten thousand cases a spring is on the other side of a threshold then and is pulled or not, by a
    /// fraction of the limit.
    #[test]
    fn a_turned_and_moved_step_is_filtered_alike(cloth in cloths(), seed: u32, speed in 0.5_f32..15.0, angle in -3.0_f32..3.0) {
        let model = build(&cloth, None, false);
        let state = folded(&model, seed, speed);
        let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, -0.5).normalize(), angle);
        let moved = Vec3::new(0.3, -0.2, 0.5);
        let (plain, _, _) = filtered(&model, &state);
        let (turned, _, _) = filtered(&model, &map(&state, |x| turn * x + moved, |v| turn * v));
        let back = map(&turned, |x| x, |v| turn.inverse() * v);
        let apart = energy_between(&model, &plain.velocities, &back.velocities);
        let whole = energy_between(&model, &state.velocities, &Vectors::zeros(state.positions.len()));
        prop_assert!(apart.sqrt() <= 1e-2 * whole.sqrt(), "{}", (apart / whole).sqrt());
    }
}

/// The state with particle `i` as particle `order[i]`, mirrored if asked for.
fn renumbered(state: &State, order: &[u32], mirrored: bool) -> State {
    let mut other = state.clone();
    let image = |vector: Vec3| if mirrored { Vec3::new(-vector.x, vector.y, vector.z) } else { vector };
    for (from, &to) in order.iter().enumerate() {
        other.positions.set(to as usize, image(state.positions.get(from)));
        other.velocities.set(to as usize, image(state.velocities.get(from)));
    }
    other
}

fn momentum(model: &Model, velocities: &Vectors) -> Vec3 {
    velocities.iter().zip(&model.particles.mass).map(|(velocity, &mass)| velocity * mass).sum()
}

/// Differences of the corrections of two equal steps, in parts of the correction (root of the energy), for many steps.
fn differences(cases: impl Iterator<Item = (Built, Built, Vec<u32>, bool)>) -> Vec<f64> {
    let mut found = Vec::new();
    for (seed, (one, other, order, mirrored)) in (0_u32..).zip(cases) {
        let state = folded(&one, seed, [0.5, 3.0, 12.0][seed as usize % 3]);
        let (plain, _, limited) = filtered(&one, &state);
        let (image, _, _) = filtered(&other, &renumbered(&state, &order, mirrored));
        let expected = renumbered(&plain, &order, mirrored);
        let scale: f32 = plain.velocities.iter().zip(&one.particles.mass).map(|(velocity, &mass)| velocity.length() * mass).sum();
        let drift = momentum(&other, &image.velocities).distance(momentum(&other, &expected.velocities));
        assert!(drift <= 2e-5 * scale, "case {seed}: the momenta differ by {drift} of {scale} kg m/s");
        if limited.sweeps > 0 {
            let correction = energy_between(&one, &plain.velocities, &state.velocities);
            found.push((energy_between(&other, &image.velocities, &expected.velocities) / correction).sqrt());
        }
    }
    assert!(found.len() > 100, "only {} steps were limited", found.len());
    found
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

/// Sweeps have an order. Of all admissible steps near the proposed one, another order leads to another: on the average a
/// fifth of the correction apart (measured: 0.20 for mirrors, 0.18 for numbers). Only momentum and admissibility are exact.
#[test]
fn a_mirrored_step_is_corrected_much_alike() {
    let cases = (0..160_u32).map(|seed| {
        let mut random = random(seed);
        let cells = [(); 2].map(|()| 1 + (random() * 13.0) as u32);
        let width = cells[0] + 1;
        let order = (0..width * (cells[1] + 1)).map(|place| place / width * width + (width - 1 - place % width)).collect();
        let cloth = Cloth::Grid { cells };
        (build(&cloth, None, false), build(&cloth, None, false), order, true)
    });
    let apart = root_mean_square(&differences(cases));
    assert!(apart < 0.3, "{apart}");
}

/// A model, the same with other numbers, and which particle is which.
fn shuffled(cloth: &Cloth, random: &mut impl FnMut() -> f64) -> (Built, Built, Vec<u32>, bool) {
    let plain = build(cloth, None, false);
    let mut order: Vec<u32> = (0..plain.particle_count() as u32).collect();
    for last in (1..order.len()).rev() {
        order.swap(last, (random() * (last + 1) as f64) as usize);
    }
    let other = build(cloth, Some(&order), false);
    let vertex = |particle: u32| order[plain.numbering.vertex(particle) as usize];
    let particles = (0..order.len() as u32).map(|particle| other.numbering.particle(vertex(particle))).collect();
    (plain, other, particles, false)
}

#[test]
fn other_numbers_lead_to_much_the_same_correction() {
    let cases = (0..240_u32).map(|seed| {
        let mut random = random(seed);
        let cloth = match seed % 2 {
            0 => Cloth::Mesh { cells: [(); 2].map(|()| 1 + (random() * 10.0) as usize), seed },
            _ => Cloth::Net { points: 3 + (random() * 37.0) as usize, links: 1 + seed as usize % 20, seed },
        };
        shuffled(&cloth, &mut random)
    });
    let apart = root_mean_square(&differences(cases));
    assert!(apart < 0.3, "{apart}");
}

/// What is solved exactly has no order. It is, unless links turn so far in one step that their directions at its start say
/// nothing about its end: some of the steps here go a tenth of a metre and more.
#[test]
fn other_numbers_of_a_tree_lead_to_the_same_correction() {
    let cases = (0..240_u32).map(|seed| {
        let mut random = random(seed);
        shuffled(&Cloth::Net { points: 2 + (random() * 38.0) as usize, links: 0, seed }, &mut random)
    });
    let found = differences(cases);
    let alike = found.iter().filter(|apart| **apart < 1e-3).count();
    assert!(10 * alike >= 9 * found.len(), "{alike} of {} are alike", found.len());
}
