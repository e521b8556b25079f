//! Where cloth touches something and how hard, and bodies that are moved off their paths.

use crate::common::{Simulation, crooked, mesh_scene};
use glam::DVec3;
use serde_json::{Value, json};
use taut::inputs::BodyShift;
use taut::model::MeshData;
use taut::state::State;
use taut::step::{Touch, touches};

const WEIGHT: f64 = 0.2 * 9.81;

fn sheet(cells: u32, height: f64) -> MeshData {
    let mut mesh = crooked(cells);
    mesh.vertices.iter_mut().for_each(|vertex| vertex[2] = height);
    mesh
}

fn simulation(body: &Value, height: f64, pins: Value) -> Simulation {
    let cloth = json!({ "density": 0.2, "strain_limit": 0.05, "thickness": 0.004, "friction": 0.3, "pins": pins });
    Simulation::of(mesh_scene(json!({ "fps": 60.0, "body": [body] }), cloth, sheet(12, height)))
}

fn floor() -> Value {
    json!({ "name": "floor", "plane": { "point": [0, 0, 0], "normal": [0, 0, 1] }, "friction": 0.3, "thickness": 0.002 })
}

fn ball() -> Value {
    json!({ "name": "ball", "sphere": { "center": [0.5, 0.5, -0.5], "radius": 0.2 }, "thickness": 0.002 })
}

fn lies_still(run: &mut Simulation) -> Vec<Touch> {
    run.steps(400);
    let mut mean = DVec3::ZERO;
    let mut last = Vec::new();
    for _ in 0..50 {
        run.steps(1);
        last = touches(&run.state, &run.work);
        mean += last.iter().map(|touch| touch.normal * touch.force + touch.friction).sum::<DVec3>() / 50.0;
    }
    assert!((mean - DVec3::Z * WEIGHT).length() < 0.02 * WEIGHT, "{mean} N bear {WEIGHT} N");
    last
}

#[test]
fn a_plane_bears_the_weight_of_what_lies_on_it() {
    let mut run = simulation(&floor(), 0.005, json!([]));
    assert!(touches(&run.state, &run.work).is_empty());
    let touches = lies_still(&mut run);
    assert!(touches.len() > 100, "{}", touches.len());
    for touch in &touches {
        assert_eq!((touch.body, touch.normal), (Some(0), DVec3::Z));
        let place = run.state.positions.get(touch.particle as usize).as_dvec3() + run.state.origins[0];
        assert!(touch.place.distance(place) < 1e-6, "{} is not {place}", touch.place);
        assert!(touch.force > 0.0 && touch.friction.length() <= 0.31 * touch.force, "{touch:?}");
    }
}

#[test]
fn normals_point_from_a_ball_to_the_cloth_on_it() {
    let ball = json!({ "name": "ball", "sphere": { "center": [0.5, 0.5, -0.5], "radius": 0.48 }, "friction": 0.3 });
    let mut run = simulation(&ball, 0.005, json!([]));
    run.steps(200);
    // In its folds it may touch itself.
    let found: Vec<Touch> = touches(&run.state, &run.work).into_iter().filter(|touch| touch.body == Some(0)).collect();
    assert!(found.len() > 5, "{}", found.len());
    for Touch { place, normal, .. } in found {
        let out = place - DVec3::new(0.5, 0.5, -0.5);
        assert!(normal.dot(out.normalize()) > 0.99, "{normal} at {place}");
        assert!((out.length() - 0.48).abs() < 0.01, "{place}");
    }
}

#[test]
fn a_state_from_elsewhere_touches_nothing_yet() {
    let mut run = simulation(&floor(), 0.005, json!([]));
    run.steps(100);
    assert!(!touches(&run.state, &run.work).is_empty());
    run.work.forget_step();
    assert!(touches(&run.state, &run.work).is_empty());
    run.steps(1);
    assert!(!touches(&run.state, &run.work).is_empty());
}

#[test]
fn a_shifted_body_pushes_cloth_before_it_and_nothing_crosses_it() {
    let mut run = simulation(
        &ball(),
        0.0,
        json!([{ "vertices": [0] }, { "vertices": [12] }, { "vertices": [156] }, { "vertices": [168] }]),
    );
    run.inputs.shift_body(BodyShift { to: DVec3::Z * 0.8, arrival: 0.2, ..BodyShift::constant(0, DVec3::ZERO) });
    let middle = |state: &State| state.bodies[0];
    for step in 1..=run.model.schedule.substeps * 60 {
        run.steps(1);
        let middle = middle(&run.state);
        for particle in 0..run.state.positions.len() {
            let place = run.state.positions.get(particle).as_dvec3() + run.state.origins[0];
            assert!(place.distance(middle) > 0.2, "step {step}: {place} is in the ball at {middle}");
        }
    }
    // Pinned at its corners the cloth gives way a little; the ball waits there.
    let height = middle(&run.state).z;
    assert!(height > -0.3 && height < 0.25, "{height}");
    assert_eq!(run.inputs.bodies.shift_of(0, run.state.time()), DVec3::Z * 0.8);
}

#[test]
fn snapshots_hold_where_bodies_were_sent() {
    let mut run = simulation(&ball(), 0.0, json!([{ "vertices": [0] }]));
    run.inputs.shift_body(BodyShift { to: DVec3::X, arrival: 0.5, ..BodyShift::constant(0, DVec3::ZERO) });
    run.steps(10);
    let bytes = run.state.to_bytes(&run.model, &run.inputs.grips);
    let mut again = simulation(&ball(), 0.0, json!([{ "vertices": [0] }]));
    let (state, grips) = State::from_bytes(&bytes, &again.model).expect("a snapshot");
    again.state = state;
    again.inputs.take(grips);
    run.steps(20);
    again.steps(20);
    assert_eq!((run.state.hash(), &run.state.bodies), (again.state.hash(), &again.state.bodies));
    // Back on its path it is as if it had never been moved.
    run.inputs.shift_body(BodyShift::constant(0, DVec3::ZERO));
    assert!(!run.inputs.bodies.any_moves());
}

#[test]
fn touches_do_not_depend_on_threads() {
    let of = |threads| {
        let cloth = json!({ "density": 0.2, "strain_limit": 0.05, "thickness": 0.004, "friction": 0.3 });
        let model = mesh_scene(json!({ "fps": 60.0, "body": [floor()] }), cloth, sheet(40, 0.004));
        let mut run = Simulation::with_threads(model, threads);
        run.steps(12);
        touches(&run.state, &run.work)
    };
    let one = of(1);
    assert!(!one.is_empty());
    assert_eq!(one, of(3));
}
