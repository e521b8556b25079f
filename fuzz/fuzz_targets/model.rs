//! Text of scenes that are small enough: built and stepped, or refused.
#![no_main]

use std::collections::BTreeMap;

use libfuzzer_sys::fuzz_target;
use taut::advance::advance;
use taut::prepare::prepare;
use taut::scene::{Scene, Source};
use taut::state::State;
use taut::step::Work;

/// Particles that are worth the time.
const MOST: u64 = 400;

fuzz_target!(|text: &str| {
    let Ok(scene) = Scene::from_json(text) else { return };
    let particles = |source: &Source<'_>| match source {
        Source::Grid(grid) => grid.cells.iter().map(|&cells| u64::from(cells) + 1).product(),
        Source::Network(network) => network.points.len() as u64,
        Source::Mesh(_) => 0,
    };
    let all: u64 = scene.cloth.iter().flat_map(|cloth| cloth.sources()).map(|source| particles(&source)).sum();
    if all > MOST {
        return;
    }
    let Ok(prepared) = prepare(&scene, &BTreeMap::new(), &BTreeMap::new()) else { return };
    let (model, schedule) = (prepared.model, prepared.schedule);
    let mut inputs = prepared.inputs;
    let mut state = State::new(&model);
    let mut work = Work::new(&model, &schedule, 1);
    let before = state.hash();
    if advance(&model, &mut state, &mut inputs, schedule.step_length, 2, &mut work).is_err() {
        assert_eq!(state.hash(), before, "a step that fails changes nothing");
    }
});
