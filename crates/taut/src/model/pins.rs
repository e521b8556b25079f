//! Particles that a scene holds.

use glam::DVec3;

use super::part::Part;
use super::selection::choose;
use crate::scene::{Cloth, SceneError};

/// Particles that move together.
#[derive(Debug, Clone, PartialEq)]
pub struct PinGroup {
    /// The cloth that they belong to.
    pub cloth: usize,
    /// The particles.
    pub particles: Vec<u32>,
    /// Where they are at the start, from the origin that their cloth has then [m].
    pub start: Vec<DVec3>,
}

/// The pins of one cloth; `first` is the number of its first particle.
pub(super) fn build(
    cloth: &Cloth,
    part: &Part,
    at: &str,
    first: u32,
    notes: &mut Vec<String>,
) -> Result<Vec<PinGroup>, SceneError> {
    let mut groups: Vec<PinGroup> = Vec::new();
    let mut holder: Vec<Option<usize>> = vec![None; part.points.len()];
    for (index, pin) in cloth.pins.iter().enumerate() {
        let at = format!("{at}.pins[{index}]");
        let mut particles = Vec::new();
        for vertex in choose(cloth, &pin.selectors(), part, &at, notes)? {
            match holder[vertex as usize] {
                None => {
                    holder[vertex as usize] = Some(index);
                    particles.push(vertex);
                }
                Some(other) if cloth.pins[other].travels_like(pin) => {}
                Some(other) => {
                    let problem =
                        format!("vertex {vertex} is held by pins[{other}] too, which moves differently; drop one of them");
                    return Err(SceneError::at(at, problem));
                }
            }
        }
        let start = particles.iter().map(|&vertex| part.points[vertex as usize]).collect();
        particles.iter_mut().for_each(|particle| *particle += first);
        groups.push(PinGroup { cloth: 0, particles, start });
    }
    Ok(groups)
}
