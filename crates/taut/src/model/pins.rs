//! Held particles and the paths they follow.

use glam::{DVec3, Vec3};

use super::grid;
use super::part::Part;
use crate::scene::{Cloth, Keyframe, Pin, SceneError, Selector};

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
        for vertex in choose(cloth, pin, part, &at, notes)? {
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

fn choose(cloth: &Cloth, pin: &Pin, part: &Part, at: &str, notes: &mut Vec<String>) -> Result<Vec<u32>, SceneError> {
    let selectors = pin.selectors();
    let selector = selectors.first().ok_or_else(|| SceneError::at(at, "chooses nothing"))?;
    match (*selector, &cloth.grid) {
        (Selector::Corner(corner), Some(grid)) => Ok(vec![grid::corner(grid, corner)]),
        (Selector::Edge(edge), Some(grid)) => Ok(grid::edge(grid, edge)),
        (Selector::Corner(_) | Selector::Edge(_), None) => Err(SceneError::at(at, "corner and edge need a grid")),
        (Selector::Vertices(vertices), _) => {
            let count = part.points.len();
            match vertices.iter().find(|&&vertex| vertex as usize >= count) {
                Some(vertex) => {
                    let problem = format!("the cloth has {count} vertices, numbered 0 to {}", count - 1);
                    Err(SceneError::with_value(format!("{at}.vertices"), vertex, problem))
                }
                None => Ok(vertices.to_vec()),
            }
        }
        (Selector::Box([low, high]), _) => {
            let (low, high) = (DVec3::from_array(low), DVec3::from_array(high));
            let inside = |point: &DVec3| point.cmpge(low).all() && point.cmple(high).all();
            let vertices: Vec<u32> = (0..).zip(&part.points).filter(|(_, point)| inside(point)).map(|(index, _)| index).collect();
            if vertices.is_empty() {
                let (from, to) = extent(part);
                let problem = format!("holds no vertex; the cloth spans {from:.3} to {to:.3} m");
                return Err(SceneError::at(format!("{at}.box"), problem));
            }
            Ok(vertices)
        }
        (Selector::Nearest(target), _) => {
            let target = DVec3::from_array(target);
            let distances = part.points.iter().map(|point| point.distance_squared(target));
            let nearest = (0..).zip(distances).min_by(|a, b| a.1.total_cmp(&b.1));
            let (vertex, square) = nearest.ok_or_else(|| SceneError::at(at, "the cloth has no vertex"))?;
            let (from, to) = extent(part);
            if square.sqrt() > 0.5 * from.distance(to) {
                notes.push(format!("scene.{at}.nearest: vertex {vertex} is the nearest, yet {:.3} m away", square.sqrt()));
            }
            Ok(vec![vertex])
        }
    }
}

/// Lowest and highest corner of the box around a part [m].
fn extent(part: &Part) -> (DVec3, DVec3) {
    let nowhere = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    part.points.iter().fold(nowhere, |(low, high), &point| (low.min(point), high.max(point)))
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
