//! The vector registers that the environment asks for.

use std::sync::OnceLock;

use pyo3::prelude::*;

use crate::scene_error;

/// Names the registers to use; the widest ones when it is not set.
const VARIABLE: &str = "TAUT_SIMD";

/// Has the engine use the registers that the environment names. It is read once: registers do not change while loops run.
pub fn chosen() -> PyResult<()> {
    static CHOSEN: OnceLock<Result<(), String>> = OnceLock::new();
    let read = || match std::env::var_os(VARIABLE) {
        Some(word) => taut::geometry::choose(&word.to_string_lossy())
            .map_err(|error| format!("{VARIABLE} = {error}; unset it for the widest registers")),
        None => Ok(()),
    };
    CHOSEN.get_or_init(read).clone().map_err(scene_error)
}
