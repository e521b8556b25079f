//! Text of scenes: refused with a sentence, or read, and read the same again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use taut::scene::Scene;

fuzz_target!(|text: &str| {
    match Scene::from_json(text) {
        Ok(scene) => {
            let _ = scene.warnings();
            let again = Scene::from_json(&scene.to_json()).expect("a resolved scene is valid");
            assert!(again == scene, "a resolved scene reads otherwise");
        }
        Err(error) => assert!(error.to_string().chars().count() < 2000, "a sentence, not a book"),
    }
});
