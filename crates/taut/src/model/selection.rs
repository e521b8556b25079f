//! The vertices that are meant by a selection in the scene.

use glam::DVec3;

use super::grid;
use super::part::Part;
use crate::scene::{Cloth, SceneError, Selector};

/// The vertices that a selection at the field `at` chooses; notes say what looks like a mistake.
///
/// # Errors
/// It names a vertex that is not there, or chooses none.
pub(super) fn choose(
    cloth: &Cloth,
    selectors: &[Selector<'_>],
    part: &Part,
    at: &str,
    notes: &mut Vec<String>,
) -> Result<Vec<u32>, SceneError> {
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
            let vertices: Vec<u32> =
                (0..).zip(part.places()).filter(|(_, place)| inside(place)).map(|(index, _)| index).collect();
            if vertices.is_empty() {
                let (from, to) = extent(part);
                let problem = format!("holds no vertex; the cloth spans {from:.3} to {to:.3} m");
                return Err(SceneError::at(format!("{at}.box"), problem));
            }
            Ok(vertices)
        }
        (Selector::Nearest(target), _) => {
            let target = DVec3::from_array(target);
            let distances = part.places().map(|place| place.distance_squared(target));
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
    part.places().fold(nowhere, |(low, high), place| (low.min(place), high.max(place)))
}
