//! Held particles and the paths they follow.

use glam::{DVec3, Vec3};

use super::part::Part;
use super::selection::choose;
use crate::scene::{Cloth, Keyframe, SceneError};

/// Particles that move together.
#[derive(Debug, Clone, PartialEq)]
pub struct PinGroup {
    /// The particles.
    pub particles: Vec<u32>,
    /// Where they are at the start [m].
    pub start: Vec<DVec3>,
    /// Displacement over time; empty: they stay.
    pub keyframes: Vec<Keyframe>,
}

impl PinGroup {
    /// Displacement from the start [m] at `time` [s], straight lines between keyframes, constant after the last.
    #[must_use]
    pub fn displacement(&self, time: f64) -> DVec3 {
        let mut before = (0.0, DVec3::ZERO);
        for &Keyframe(at, value) in &self.keyframes {
            let value = DVec3::from_array(value);
            if time < at {
                return before.1.lerp(value, (time - before.0) / (at - before.0));
            }
            before = (at, value);
        }
        before.1
    }

    /// Where the group's particle number `index` is at `time` [m].
    #[must_use]
    pub fn position(&self, index: usize, time: f64) -> Vec3 {
        (self.start[index] + self.displacement(time)).as_vec3()
    }
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
                Some(other) if cloth.pins[other].keyframes == pin.keyframes => {}
                Some(other) => {
                    let problem =
                        format!("vertex {vertex} is held by pins[{other}] too, which moves differently; drop one of them");
                    return Err(SceneError::at(at, problem));
                }
            }
        }
        let start = particles.iter().map(|&vertex| part.points[vertex as usize]).collect();
        particles.iter_mut().for_each(|particle| *particle += first);
        groups.push(PinGroup { particles, start, keyframes: pin.keyframes.clone() });
    }
    Ok(groups)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keyframes_are_joined_by_straight_lines_and_held_after_the_last() {
        let keyframes = vec![Keyframe(1.0, [2.0, 0.0, 0.0]), Keyframe(3.0, [2.0, 4.0, 0.0])];
        let group = PinGroup { particles: vec![0], start: vec![DVec3::Z], keyframes };
        for (time, expected) in [(0.0, [0.0, 0.0]), (0.25, [0.5, 0.0]), (1.0, [2.0, 0.0]), (2.0, [2.0, 2.0]), (9.0, [2.0, 4.0])] {
            let at = group.position(0, time);
            assert!((at - Vec3::new(expected[0], expected[1], 1.0)).length() < 1e-6, "{time}: {at}");
        }
    }
}
