//! What users do with their hands while a simulation runs: nothing of it breaks the limit or stops the cloth.

use crate::common::{Simulation, chain_links, network, scene_of, sheet, worst};
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use taut::state::State;
use taut::step::admit;

/// More than rounding to single precision explains.
const ROUNDING: f64 = 1e-5;
const CELLS: usize = 16;
/// The particle in the middle of the right edge of a sheet, and the pinned edge opposite.
const HELD: u32 = (8 * (CELLS + 1) + CELLS) as u32;

/// A sheet of 1 m, 0.2 kg, held along its left edge; a hand of `hand` kg is at the other one.
fn held_sheet(filter: &str, hand: f64) -> Simulation {
    let mut cloth = sheet([CELLS as u32, CELLS as u32], 0.05, json!([{ "edge": "left" }]));
    if hand > 0.0 {
        cloth["weights"] = json!([{ "vertices": [HELD], "mass": hand }]);
    }
    // The bare cloth needs short steps.
    let substeps = if filter == "none" { 40 } else { 4 };
    Simulation::new(&scene_of(cloth, substeps, filter, 9.81))
}

/// A chain of 1 m in ten links from the origin along x.
fn chain(pins: Value) -> Simulation {
    let points: Vec<[f64; 3]> = (0..=10).map(|index| [0.1 * f64::from(index), 0.0, 0.0]).collect();
    let mut cloth = network(&points, &chain_links(10), 0.01);
    cloth["strain_limit"] = json!(0.05);
    cloth["pins"] = pins;
    Simulation::new(&scene_of(cloth, 4, "coarse_to_fine", 9.81))
}

#[test]
fn a_hand_goes_straight_at_its_speed_and_stays_at_its_target() {
    let mut run = held_sheet("none", 0.0);
    let home = run.state.positions.get(HELD as usize);
    let target = home + Vec3::new(-0.3, 0.4, 0.0);
    run.inputs.grips.lead(HELD, target, 2.0);
    for step in 1..=240 {
        run.steps(1);
        // 0.5 m at 2 m/s take 0.25 s; it slows down over the last 2 / 60 m.
        let expected = 2.0 * f64::from(step) * run.step_length();
        let gone = f64::from(run.state.positions.get(HELD as usize).distance(home));
        if expected < 0.46 {
            assert!((gone - expected).abs() < 1e-4, "{gone} m after step {step}, not {expected} m");
        }
    }
    run.steps(1200);
    assert!(run.state.positions.get(HELD as usize).distance(target) < 1e-4);
    run.inputs.grips.release(HELD);
    run.steps(600);
    assert!(run.state.positions.get(HELD as usize).distance(target) > 0.1, "let go, it falls");
}

#[test]
fn a_strong_hand_is_followed_and_a_fast_one_never_breaks_the_limit() {
    let mut run = held_sheet("coarse_to_fine", 0.1);
    let home = run.state.positions.get(HELD as usize);
    let gap = |run: &Simulation, target: Vec3| run.state.positions.get(HELD as usize).distance(target);
    run.inputs.grips.lead(HELD, home + Vec3::new(-0.3, 0.3, 0.2), 3.0);
    run.steps(240);
    assert!(gap(&run, home + Vec3::new(-0.3, 0.3, 0.2)) < 0.01, "it holds the sheet's weight where it was asked to");
    let mut cuts = 0;
    for turn in 0..24_u8 {
        let corner = Vec3::new(-1.5, f32::from(turn % 3) - 1.0, f32::from(turn % 2) * 2.0 - 1.0) * 3.0;
        run.inputs.grips.lead(HELD, home + corner, 40.0);
        for _ in 0..10 {
            cuts += run.steps(1).cuts;
            assert!(worst(&run.model, &run.state) <= 1.0 + ROUNDING);
        }
    }
    assert_eq!(cuts, 0, "the cloth is never stopped");
}

#[test]
fn a_hand_that_pulls_too_far_stays_behind_and_the_chain_is_taut() {
    let mut run = chain(json!([{ "vertices": [0] }]));
    run.inputs.grips.lead(10, Vec3::new(5.0, 0.0, 0.0), 4.0);
    run.steps(480);
    let tip = run.state.positions.get(10);
    assert!(f64::from(tip.x) <= 1.05 * (1.0 + ROUNDING) && tip.x > 1.03, "the chain of 1.05 m at most reaches {tip}");
}

#[test]
fn pins_moved_off_their_paths_arrive_or_wait_and_come_back() {
    let mut run = chain(json!([{ "vertices": [0] }, { "vertices": [10] }]));
    run.inputs.grips.shift(1, DVec3::new(-0.2, 0.0, 0.3), 1.0);
    run.steps(240);
    assert!(run.state.positions.get(10).distance(Vec3::new(0.8, 0.0, 0.3)) < 1e-6);
    run.inputs.grips.shift(1, DVec3::new(2.0, 0.0, 0.0), 5.0);
    let mut farthest = 0.0_f32;
    for _ in 0..480 {
        run.steps(1);
        assert!(worst(&run.model, &run.state) <= 1.0 + ROUNDING);
        farthest = farthest.max(run.state.positions.get(10).x);
    }
    assert!(farthest > 1.0, "3 m were asked for, the chain of 1 m allows 1.05 m, the pin went to {farthest} m");
    run.inputs.grips.shift(1, DVec3::ZERO, 5.0);
    run.steps(480);
    assert!(run.state.positions.get(10).distance(Vec3::X) < 1e-6);
}

#[test]
fn a_state_from_elsewhere_is_brought_within_the_limit_and_goes_on() {
    let mut bare = held_sheet("none", 0.0);
    bare.inputs.grips.lead(HELD, Vec3::new(1.5, 0.8, 0.3), 2.0);
    bare.steps(1200);
    let mut run = held_sheet("coarse_to_fine", 0.0);
    let State { positions, velocities, clock, .. } = bare.state;
    run.state = State::at(&run.model, positions, velocities, clock);
    assert!(worst(&run.model, &run.state) > 1.5, "the bare sheet is stretched: {}", worst(&run.model, &run.state));
    admit(&run.model, &mut run.state, &run.inputs, &mut run.work);
    assert!(worst(&run.model, &run.state) <= 1.0);
    for &pin in &run.model.pins[0].particles {
        assert_eq!(run.state.positions.get(pin as usize), run.model.particles.rest.get(pin as usize));
    }
    let before = run.state.clone();
    admit(&run.model, &mut run.state, &run.inputs, &mut run.work);
    assert_eq!(run.state, before, "what is within the limit is left as it is");
    assert_eq!(run.steps(240).cuts, 0);
    let way = run.state.positions.get(HELD as usize).distance(before.positions.get(HELD as usize));
    assert!(way > 0.01, "the sheet moves on");
}
