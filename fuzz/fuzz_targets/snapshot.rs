//! Bytes of snapshots: refused, or a state of this model. Half of them have a checksum that fits, to get past it.
#![no_main]

use std::collections::BTreeMap;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use taut::prepare::{Prepared, prepare};
use taut::scene::Scene;
use taut::state::State;
use xxhash_rust::xxh3::xxh3_64;

const SCENE: &str = r#"{
    "cloth": [{ "grid": { "cells": [3, 2] }, "pins": [{ "edge": "left" }] }],
    "solver": { "integrator": "bdf2" }
}"#;

static PREPARED: LazyLock<Prepared> = LazyLock::new(|| {
    let scene = Scene::from_json(SCENE).expect("a scene");
    prepare(&scene, &BTreeMap::new(), &BTreeMap::new()).expect("a model")
});

fuzz_target!(|given: (bool, bool, &[u8])| {
    let (fits, from_a_snapshot, bytes) = given;
    let Prepared { model, inputs, .. } = &*PREPARED;
    let mut content = Vec::new();
    if from_a_snapshot {
        // The bytes given are laid over those of a true one.
        content = State::new(model).to_bytes(model, &inputs.grips);
        content.truncate(content.len() - 8);
        let at = content.len().min(bytes.first().map_or(0, |&at| 4 * usize::from(at)));
        for (old, new) in content[at..].iter_mut().zip(bytes.iter().skip(1)) {
            *old ^= new;
        }
    } else {
        content.extend(bytes);
    }
    if fits {
        content.extend(xxh3_64(&content).to_le_bytes());
    }
    if let Ok((state, grips)) = State::from_bytes(&content, model) {
        assert_eq!(state.to_bytes(model, &grips), content, "a snapshot that is taken says the same again");
    }
});
