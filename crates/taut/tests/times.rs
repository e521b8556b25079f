//! What steps spend their time on, by a clock that the host brings: here one that counts how often it is asked.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use crate::common::{Simulation, crooked, mesh_scene, sheet};
use serde_json::{Value, json};
use taut::advance::Summary;
use taut::diagnostics::Times;
use taut::inputs::Target;

/// A clock of its own for each test: they run at the same time.
macro_rules! counting {
    ($clock:ident, $asked:ident) => {
        static $asked: AtomicU64 = AtomicU64::new(0);
        fn $clock() -> f64 {
            $asked.fetch_add(1, Relaxed) as f64
        }
    };
}

/// A ball that is thrown at a sheet, so fast that steps are halved.
fn shot() -> Simulation {
    let mut mesh = crooked(14);
    mesh.vertices.iter_mut().for_each(|[x, y, z]| (*x, *y, *z) = (0.6 * *x, 0.0, 0.6 * *y));
    let cloth = json!({
        "density": 0.2, "strain_limit": 0.05, "thickness": 0.004, "pins": [{ "box": [[-1, -1, 0.599], [1, 1, 0.7]] }],
    });
    let ball =
        json!({ "sphere": { "center": [0.3, -0.4, 0.3], "radius": 0.08 }, "move": [[0.02, [0, 0, 0]], [0.06, [0, 0.8, 0]]] });
    Simulation::of(mesh_scene(json!({ "body": [ball] }), cloth, mesh))
}

fn flag(limits: Value) -> Simulation {
    let mut cloth = sheet([12, 12], 0.06, json!([{ "vertices": [0, 12] }]));
    cloth["strain_limit_keyframes"] = limits;
    Simulation::new(&json!({ "cloth": [cloth], "contact": { "self": false } }))
}

fn all(times: Times) -> f64 {
    times.detection + times.solve + times.certificate
}

fn without_times(summary: Summary) -> Summary {
    Summary { times: Times::default(), ..summary }
}

#[test]
fn without_a_clock_there_are_no_times() {
    assert_eq!(shot().steps(20).times, Times::default());
}

#[test]
fn nothing_depends_on_the_clock() {
    counting!(clock, ASKED);
    fn broken() -> f64 {
        f64::NAN
    }
    let mut plain = shot();
    let expected = plain.steps(60);
    assert!(expected.halved_steps > 0 && expected.contacts > 0);
    for clock in [clock as fn() -> f64, broken] {
        let mut timed = shot();
        timed.work.set_clock(Some(clock));
        assert_eq!(without_times(timed.steps(60)), expected);
        let bytes = |run: &Simulation| run.state.to_bytes(&run.model, &run.inputs.grips);
        assert_eq!((timed.state.hash(), bytes(&timed)), (plain.state.hash(), bytes(&plain)));
    }
    assert!(ASKED.load(Relaxed) > 0);
}

#[test]
fn phases_share_what_the_clock_counts_and_it_is_asked_a_few_times_a_step() {
    counting!(clock, ASKED);
    let mut run = shot();
    run.work.set_clock(Some(clock));
    let (mut sum, mut tried) = (Times::default(), 0);
    for _ in 0..60 {
        let before = ASKED.load(Relaxed);
        let summary = run.steps(1);
        let asked = (ASKED.load(Relaxed) - before) as f64;
        // Each time that the filter runs, with all that steps have given up, a tick is lost before it starts and none in it.
        let runs = asked - all(summary.times);
        assert!(runs >= 1.0 && runs.fract() == 0.0, "{asked} ticks, {:?}", summary.times);
        tried += runs as u64;
        // Rows are made once, and certified at most once more than the repairs and shortenings that a step may take.
        assert!(asked <= 40.0 * runs, "asked {asked} times in {runs} parts");
        sum = sum.and(summary.times);
    }
    assert!(tried > 60, "steps were halved: {tried}");
    // Rows are made once of each part that is tried, and pairs are looked for again before each certificate. What intersects at the
    // start is looked for in the first step.
    assert_eq!(sum.detection - sum.certificate, 1.0 + tried as f64);
    assert!(sum.certificate >= tried as f64 && sum.solve > 0.0);
}

#[test]
fn what_cannot_touch_is_solved_only_and_goes_on_being_measured() {
    counting!(clock, ASKED);
    let mut run = flag(json!([[0.1, 0.06], [0.3, 0.05]]));
    run.work.set_clock(Some(clock));
    // The limit tightens, and something is held: the filter is made anew.
    for step in 0..30 {
        if step == 10 {
            let place = run.state.positions.get(140).as_dvec3();
            run.inputs.grips.hold(140, Target { place, arrival: run.state.time() });
        }
        let times = run.steps(1).times;
        assert_eq!(times, Times { solve: 1.0, ..Times::default() }, "step {step}");
    }
    run.work.set_clock(None);
    let asked = ASKED.load(Relaxed);
    assert_eq!((run.steps(5).times, ASKED.load(Relaxed)), (Times::default(), asked));
}

#[test]
fn states_and_admissions_take_no_time_of_steps() {
    counting!(clock, ASKED);
    let mut run = shot();
    run.work.set_clock(Some(clock));
    let (model, state, inputs) = (&run.model, &mut run.state, &run.inputs);
    taut::step::admit(model, state, inputs, &mut run.work);
    assert_eq!(run.steps(0).times, Times::default());
    let first = run.steps(1).times;
    let mut other = shot();
    other.work.set_clock(Some(clock));
    assert_eq!(other.steps(1).times, first);
}
