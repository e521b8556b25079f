//! Masses that hang on a cloth.

use super::part::Part;
use super::selection::choose;
use crate::scene::{Cloth, SceneError};

/// The extra mass of each vertex [kg]; `held` tells which vertices of the cloth are held.
pub(super) fn build(
    cloth: &Cloth,
    part: &Part,
    at: &str,
    held: impl Fn(u32) -> bool,
    notes: &mut Vec<String>,
) -> Result<Vec<f64>, SceneError> {
    let mut extra = vec![0.0; part.points.len()];
    for (index, weight) in cloth.weights.iter().enumerate() {
        let at = format!("{at}.weights[{index}]");
        let mut vertices = choose(cloth, &weight.selectors(), part, &at, notes)?;
        vertices.sort_unstable();
        vertices.dedup();
        if vertices.iter().any(|&vertex| held(vertex)) {
            notes.push(format!("scene.{at}: what lies on held vertices has no effect"));
        }
        vertices.iter().for_each(|&vertex| extra[vertex as usize] += weight.mass / vertices.len() as f64);
    }
    Ok(extra)
}
