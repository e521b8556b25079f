//! What must hold for every cloth, on random ones.

use crate::common::{Built, Simulation, model, network, scene_of};
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use serde_json::{Value, json};
use taut::filter::{Filter, apply};
use taut::forces::{Forces, elastic_energy, kick};
use taut::geometry::{Pool, Vectors};
use taut::inputs::{Grips, Target};
use taut::model::Model;
use taut::state::{Clock, State};
use taut::step::{glance, step};

type Points = Vec<[f64; 3]>;

/// A random net: points in a box of 1 m, each linked to the one before and some to any other.
fn nets() -> impl Strategy<Value = (Points, Vec<[u32; 2]>, Vec<[f32; 3]>)> {
    (3_usize..14).prop_flat_map(|count| {
        let points = prop::collection::vec([-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64], count);
        let points =
            points.prop_filter("two points at one place", |points| (1..points.len()).all(|a| !points[..a].contains(&points[a])));
        let extra = prop::collection::vec([0..count as u32, 0..count as u32], 0..count);
        let velocities = prop::collection::vec([-9.0..9.0_f32, -9.0..9.0_f32, -9.0..9.0_f32], count);
        (points, extra, velocities).prop_map(|(points, extra, velocities)| {
            let mut links: Vec<[u32; 2]> = (1..points.len() as u32).map(|end| [end - 1, end]).collect();
            links.extend(extra.into_iter().filter(|[a, b]| a != b));
            (points, links, velocities)
        })
    })
}

fn net(points: &[[f64; 3]], links: &[[u32; 2]], filter: &str, pinned: bool) -> Value {
    let mut cloth = network(points, links, 0.02);
    cloth["network"]["mass"] = json!((0..points.len()).map(|index| 0.01 * (1.0 + (index % 5) as f64)).collect::<Vec<f64>>());
    if pinned {
        cloth["pins"] = json!([{ "vertices": [0] }]);
    }
    let mut scene = scene_of(cloth, 4, filter, 9.81);
    scene["solver"]["iterations"] = json!(20_000);
    scene["solver"]["tolerance"] = json!(1e-6);
    scene
}

fn with_velocities(model: &Model, velocities: &[[f32; 3]]) -> State {
    let mut state = State::new(model);
    for (particle, velocity) in velocities.iter().enumerate() {
        state.velocities.set(particle, Vec3::from_array(*velocity));
    }
    state
}

fn kinetic_energy(model: &Model, state: &State) -> f64 {
    let free = (0..model.particle_count()).filter(|&particle| model.particles.inverse_mass[particle] > 0.0);
    free.map(|particle| {
        0.5 * f64::from(model.particles.mass[particle]) * state.velocities.get(particle).as_dvec3().length_squared()
    })
    .sum()
}

fn momentum(model: &Model, state: &State) -> DVec3 {
    state.velocities.iter().zip(&model.particles.mass).map(|(velocity, &mass)| velocity.as_dvec3() * f64::from(mass)).sum()
}

/// The number of sweeps that limiting a state takes.
fn limit(model: &Built, state: &mut State) -> f64 {
    let pool = Pool::new(1);
    let mut ends = state.positions.clone();
    ends.set_scaled(0..model.particle_count(), &state.positions, &state.velocities, model.schedule.step_length as f32, &pool);
    let plan = model.plan();
    let limited = apply(model.stride(&plan), state, &mut ends, &mut Filter::new(model, &plan), &pool);
    f64::from(limited.sweeps)
}

/// Largest |P_uv| / R at the end of the step.
fn worst(model: &Built, state: &State) -> f32 {
    let step = model.schedule.step_length as f32;
    let end = |particle: u32| state.positions.get(particle as usize) + state.velocities.get(particle as usize) * step;
    let ratio = |spring: usize| {
        let [u, v] = model.springs.ends[spring];
        end(u).distance(end(v)) / model.springs.greatest_length(spring)
    };
    (0..model.springs.type1).map(ratio).fold(0.0, f32::max)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn sweeps_keep_the_limit_add_no_kinetic_energy_and_are_idempotent((points, links, velocities) in nets(), pinned: bool) {
        let model = model(&net(&points, &links, "sweeps", pinned));
        let mut state = with_velocities(&model, &velocities);
        if pinned {
            state.velocities.set(0, Vec3::ZERO);
        }
        let (energy, before) = (kinetic_energy(&model, &state), momentum(&model, &state));
        let fastest = state.velocities.iter().map(Vec3::length).fold(0.0, f32::max);
        let sweeps = limit(&model, &mut state);
        // Places are rounded in a box of 2 m: a short spring never meets the tolerance, and is swept until sweeps run out.
        let place = 2.0 * f32::EPSILON;
        let shortest = (0..model.springs.type1).map(|spring| model.springs.greatest_length(spring)).fold(f32::INFINITY, f32::min);
        prop_assert!(worst(&model, &state) <= 1.0 + 1e-5 + place / shortest, "{}", worst(&model, &state));
        prop_assert!(kinetic_energy(&model, &state) <= energy * (1.0 + 1e-5));
        if !pinned {
            // Velocities come from places, and every sweep rounds them once more.
            let speed = f64::from(place / model.schedule.step_length as f32) + f64::from(fastest * f32::EPSILON) * sweeps;
            let rounding = speed * f64::from(model.particles.mass.iter().sum::<f32>());
            let lost = (momentum(&model, &state) - before).length();
            prop_assert!(lost < 1e-5 * before.length() + rounding, "{lost} kg m/s lost, {rounding} by rounding");
        }
        let once = state.clone();
        limit(&model, &mut state);
        let changed = once.velocities.iter().zip(state.velocities.iter()).map(|(a, b)| a.distance(b)).fold(0.0, f32::max);
        let moved = changed * model.schedule.step_length as f32;
        // A chain that is taut goes aside by the square root of what its length lacks, here the tolerance, in a box of 2 m.
        prop_assert!(moved < 2.0 * 1e-6_f32.sqrt(), "a second pass moves a point by {moved} m");
        prop_assert!(moved == 0.0 || worst(&model, &once) > 1.0, "a second pass moves a point by {moved} m, with no spring too long");
    }

    #[test]
    fn the_spring_force_is_minus_the_gradient_of_the_elastic_energy((points, links, shift) in nets(), chosen: usize, axis in 0..3_usize) {
        let mut scene = net(&points, &links, "none", false);
        scene["cloth"][0]["stiffness"] = json!(10.0);
        scene["gravity"] = json!([0, 0, 0]);
        scene["solver"]["substeps"] = json!("auto");
        let model = model(&scene);
        let mut state = State::new(&model);
        for (particle, shift) in shift.iter().enumerate() {
            state.positions.set(particle, state.positions.get(particle) + Vec3::from_array(*shift) * 0.02);
        }
        let energy = |state: &State| -> f64 {
            let length = |[u, v]: [u32; 2]| state.positions.get(u as usize).distance(state.positions.get(v as usize));
            (0..model.springs.len()).map(|spring| elastic_energy(model.springs.stiffness[spring], model.springs.rest[spring], length(model.springs.ends[spring]))).sum()
        };
        let shortest = |state: &State| {
            let length = |[u, v]: &[u32; 2]| state.positions.get(*u as usize).distance(state.positions.get(*v as usize));
            model.springs.ends.iter().map(length).fold(f32::INFINITY, f32::min)
        };
        prop_assume!(shortest(&state) > 0.05);
        let mut forces = Forces::new(&model);
        // A second of the forces on a cloth at rest leaves F / M.
        let mut velocities = Vectors::zeros(points.len());
        kick(&model, &model.cloths[0], &state.positions, &mut velocities, 1.0, &mut forces, &Pool::new(1));
        let particle = chosen % points.len();
        let mut direction = Vec3::ZERO;
        direction[axis] = 2e-3;
        let moved = |sign: f32| {
            let mut moved = state.clone();
            moved.positions.set(particle, state.positions.get(particle) + direction * sign);
            energy(&moved)
        };
        let slope = (moved(1.0) - moved(-1.0)) / 4e-3;
        let force = f64::from(velocities.get(particle)[axis] * model.particles.mass[particle]);
        prop_assert!((slope + force).abs() < 2e-2 * (1.0 + force.abs()), "slope {slope}, force {force}");
    }

    #[test]
    fn a_snapshot_reads_back_as_itself_and_a_damaged_one_is_refused((points, links, velocities) in nets(), at: usize) {
        let model = model(&net(&points, &links, "none", true));
        let state = State { clock: Clock::after(at as u64, 0.1), ..with_velocities(&model, &velocities) };
        let mut grips = Grips::default();
        grips.hold(0, Target { place: DVec3::new(1.0, -2.0, 3.0), arrival: 0.7 });
        grips.lead(1, DVec3::Y, 2.5);
        grips.shift(0, DVec3::X, f64::INFINITY);
        let bytes = state.to_bytes(&model, &grips);
        prop_assert_eq!(State::from_bytes(&bytes, &model), Ok((state, grips)));
        let mut damaged = bytes.clone();
        damaged[at % bytes.len()] ^= 1;
        prop_assert!(State::from_bytes(&damaged, &model).is_err());
        prop_assert!(State::from_bytes(&bytes[..at % bytes.len()], &model).is_err());
    }

    #[test]
    fn a_turned_or_moved_scene_moves_alike((points, links, velocities) in nets()) {
        // A quarter turn about z and a displacement, in short runs: rounding grows with the motion.
        let turned: Points = points.iter().map(|[x, y, z]| [-y + 0.25, *x, *z]).collect();
        let turned_velocities: Vec<[f32; 3]> = velocities.iter().map(|[x, y, z]| [-y, *x, *z]).collect();
        let run = |points: &Points, velocities: &[[f32; 3]]| {
            let mut run = Simulation::new(&net(points, &links, "sweeps", true));
            run.state = with_velocities(&run.model, velocities);
            run.steps(3);
            (0..points.len()).map(|point| run.state.place(0, point)).collect::<Vec<_>>()
        };
        let (plain, moved) = (run(&points, &velocities), run(&turned, &turned_velocities));
        for (a, b) in plain.into_iter().zip(moved) {
            prop_assert!(DVec3::new(-a.y + 0.25, a.x, a.z).distance(b) < 2e-3, "{a} and {b}");
        }
    }
}

/// The bound on the step is sharp for two free particles on a spring and safe for random nets.
#[test]
fn the_step_bound_divides_stable_from_unstable() {
    for (damping, factor, stays) in [(0.0, 0.98, true), (0.0, 1.02, false), (0.3, 0.98, true), (0.3, 1.02, false)] {
        let mut cloth = network(&[[0.0; 3], [1.0, 0.0, 0.0]], &[[0, 1]], 0.02);
        (cloth["stiffness"], cloth["damping"]) = (json!(30.0), json!(damping));
        let mut scene = scene_of(cloth, 1, "none", 0.0);
        scene["solver"]["force_step"] = json!(true);
        let bound = model(&scene).schedule.bound;
        scene["fps"] = json!(1.0 / (bound * factor));
        let mut run = Simulation::new(&scene);
        run.state.velocities.set(1, Vec3::new(1e-3, 0.0, 0.0));
        let mut worst = || {
            step(&run.model, &mut run.state, &run.model.inputs, run.model.schedule.step_length, &mut run.work);
            glance(&run.model, &run.state, &mut run.work).worst_stretch
        };
        let largest = (0..2000).map(|_| worst()).fold(0.0, f64::max);
        assert_eq!(largest < 0.1, stays, "damping {damping}, {factor} of the bound: stretch {largest}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn random_nets_stay_stable_under_the_automatic_step((points, links, velocities) in nets(), stiffness in 1.0..500.0_f64, damping in 0.0..0.5_f64) {
        let mut scene = net(&points, &links, "none", false);
        (scene["cloth"][0]["stiffness"], scene["cloth"][0]["damping"]) = (json!(stiffness), json!(damping));
        scene["gravity"] = json!([0, 0, 0]);
        scene["solver"]["substeps"] = json!("auto");
        let mut run = Simulation::new(&scene);
        run.state = with_velocities(&run.model, &velocities);
        let energy = kinetic_energy(&run.model, &run.state);
        let last = run.steps(3000).last;
        // The velocity-first method keeps a neighbouring energy, not the energy itself.
        prop_assert!(last.kinetic_energy + last.elastic_energy < 5.0 * energy, "{energy} J grew to {} J", last.kinetic_energy + last.elastic_energy);
    }
}
