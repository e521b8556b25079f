//! The certificate of the coarse-to-fine filter: the limit holds however few cycles there are, and only what a spring stops is slowed.

use crate::common::{Simulation, centre_of_mass, crooked, mesh_scene, network, scene_of, sheet, worst};
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use serde_json::{Value, json};

/// More than rounding to single precision explains: what counts as over the limit.
const ROUNDING: f64 = 1e-6;

/// A small cloth of any kind, far too few cycles, and pins that stand, move alike, move apart or are not there.
fn any_cloth(kind: u8, cells: [u32; 2], pins: u8, offset: f64) -> (Value, Option<u32>) {
    let moving = json!([[0.05, [0.2, 0.1, 0.0]], [0.1, [-0.03, 0.0, 0.1]], [0.2, [0.0, 0.0, 0.0]]]);
    let pins = match pins {
        0 => json!([]),
        1 => json!([{ "nearest": [offset, 0.0, 0.0] }, { "nearest": [offset + 1.0, 0.0, 0.0] }]),
        2 => json!([{ "nearest": [offset, 0.0, 0.0], "move": moving }]),
        _ => json!([{ "nearest": [offset, 0.0, 0.0], "move": moving }, { "nearest": [offset + 1.0, 0.0, 0.0] }]),
    };
    let mut cloth = match kind {
        0 => sheet(cells, 0.05, pins),
        1 => json!({ "fabric": "nylon", "density": 0.2, "strain_limit": 0.05, "pins": pins }),
        _ => {
            let points: Vec<[f64; 3]> = (0..=cells[0]).map(|i| [offset + f64::from(i) / f64::from(cells[0]), 0.0, 0.0]).collect();
            let links: Vec<[u32; 2]> = (0..cells[0]).map(|link| [link, link + 1]).collect();
            let mut net = network(&points, &links, 0.02);
            net["pins"] = pins;
            net
        }
    };
    match kind {
        0 => cloth["grid"]["origin"] = json!([offset, 0.0, 0.0]),
        1 => cloth["translate"] = json!([offset, 0.0, 0.0]),
        _ => (),
    }
    (cloth, (kind == 1).then_some(cells[0]))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn no_spring_is_over_its_limit_after_any_step_however_few_cycles_there_are(
        kind in 0_u8..3,
        cells in [2_u32..9, 2_u32..9],
        pins in 0_u8..4,
        offset in prop::sample::select(vec![0.0, 0.0, 3.0]),
        iterations in 1_u32..4,
        speed in 0.1_f32..10.0,
        seed: u32,
    ) {
        let (cloth, mesh) = any_cloth(kind, cells, pins, offset);
        let mut scene = scene_of(cloth.clone(), 2, "coarse_to_fine", 9.81);
        scene["solver"]["iterations"] = json!(iterations);
        scene["solver"]["force_step"] = json!(true);
        let mut run = match mesh {
            Some(cells) => {
                scene.as_object_mut().expect("an object").remove("cloth");
                Simulation::of(mesh_scene(scene, cloth, crooked(cells)))
            }
            None => Simulation::new(&scene),
        };
        for particle in 0..run.model.particle_count() {
            let noise = |salt: u32| (f64::from((particle as u32).wrapping_mul(7919).wrapping_add(seed).wrapping_add(salt)) * 0.618).sin() as f32;
            run.state.velocities.set(particle, Vec3::new(noise(0), noise(1), noise(2)) * speed);
        }
        let at_start = worst(&run.model, &run.state);
        for step in 0..24 {
            let report = run.steps(1);
            let worst = worst(&run.model, &run.state);
            prop_assert!(worst <= at_start.max(1.0) + ROUNDING, "step {step}: {worst}");
            prop_assert!(report.lost_motion > 0.0 || report.cuts == 0, "step {step}: cut without a loss");
            prop_assert!(report.lost_motion <= 1.0 && report.mean_lost_motion == report.lost_motion);
        }
    }
}

/// A sheet 1 m wide that hangs from a corner, with a fixed number of cycles a step.
fn hung(iterations: u32) -> Simulation {
    let mut scene = scene_of(sheet([32, 32], 0.1, json!([{ "corner": "bottom-left" }])), 2, "coarse_to_fine", 9.81);
    scene["solver"]["iterations"] = json!(iterations);
    Simulation::new(&scene)
}

#[test]
fn too_few_cycles_do_not_freeze_a_sheet() {
    let (mut few, mut enough) = (hung(1), hung(200));
    let (mut apart, mut lost) = (0.0_f64, 0.0_f64);
    for _ in 0..40 {
        lost = lost.max(few.steps(2).lost_motion);
        enough.steps(2);
        assert!(worst(&few.model, &few.state) <= 1.0 + ROUNDING);
        apart = apart.max(centre_of_mass(&few).distance(centre_of_mass(&enough)));
    }
    // What one cycle leaves over the limit is put right one by one, and nothing is left to cut. With one factor for the whole sheet they
    // part by 0.56 m.
    assert!(lost < 0.01, "{lost} of the motion was lost in a step");
    assert!(apart < 0.3, "the centres of mass part by {apart} m");
}

#[test]
fn a_free_sheet_with_one_cycle_a_step_keeps_its_momentum_and_gains_no_energy() {
    let mut cloth = sheet([17, 12], 0.05, json!([]));
    for field in ["stiffness", "damping", "air_drag"] {
        cloth[field] = json!(0.0);
    }
    let mut scene = scene_of(cloth, 4, "coarse_to_fine", 0.0);
    scene["solver"]["iterations"] = json!(1);
    let mut run = Simulation::new(&scene);
    for particle in 0..run.model.particle_count() {
        let wave = (particle as f32 * 0.7).sin();
        run.state.velocities.set(particle, Vec3::new(1.0 + 2.0 * wave, 0.3 * wave, wave));
    }
    let momentum = |run: &Simulation| {
        let moving = run.state.velocities.iter().zip(&run.model.particles.mass);
        moving.map(|(velocity, &mass)| velocity.as_dvec3() * f64::from(mass)).sum::<DVec3>()
    };
    let before = momentum(&run);
    let (mut limited, mut energy) = (0, f64::INFINITY);
    for _ in 0..120 {
        let summary = run.steps(1);
        limited += summary.limited_steps;
        assert!(worst(&run.model, &run.state) <= 1.0 + ROUNDING);
        let now = summary.last.kinetic_energy;
        assert!(now <= energy * (1.0 + 1e-5), "{energy} J grew to {now} J");
        energy = now;
    }
    let drift = (momentum(&run) - before).length() / before.length();
    assert!(limited > 10, "{limited} steps were limited only");
    assert!(drift < 5e-6, "momentum drifts by {drift} in {limited} steps that were limited");
}
