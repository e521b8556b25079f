//! What single precision cannot simulate is refused before it is tried.
//!
//! Positions are single precision from the origin of their cloth: places as far from there as the cloth is large are told apart by its
//! size / 2^23. A spring must be long beside that, and its limit should be.

use glam::DVec3;

use super::part::Part;
use crate::scene::{Cloth, FARTHEST, MASSES, NEAREST, SceneError, brief};

/// Places that single precision tells apart, as a part of the size of the cloth [1].
const SPACING: f64 = f32::EPSILON as f64;
/// The shortest spring has at least so many of these spacings [1].
const LEAST_SPACINGS: f64 = 64.0;
/// A scale moves no part of a cloth further from the origin of the world than this [m]; all else adds up to less.
const FURTHEST: f64 = 4.0 * FARTHEST;

/// Refuses springs that single precision does not resolve, and says where it does not resolve their limit.
///
/// # Errors
/// Names where the points come from, the shortest spring and what is allowed.
pub(super) fn check_lengths(cloth: &Cloth, part: &Part, at: &str) -> Result<Option<String>, SceneError> {
    let far = part.places().map(|place| place.abs().max_element()).fold(0.0, f64::max);
    if far > FURTHEST {
        let problem =
            format!("brings the cloth to a coordinate of {far:.3e} m; places must be within {FARTHEST} m; scale it less");
        return Err(SceneError::with_value(format!("{at}.scale"), brief(cloth.scale), problem));
    }
    let lengths = part.springs.iter().filter(|seed| seed.kind.is_type1()).map(|seed| (part.rest_length(seed.ends), seed.ends));
    let Some((shortest, [a, b])) = lengths.min_by(|one, other| one.0.total_cmp(&other.0)) else { return Ok(None) };
    let nowhere = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = part.points.iter().fold(nowhere, |(low, high), &point| (low.min(point), high.max(point)));
    let size = (high - low).max_element();
    let least = NEAREST.max(LEAST_SPACINGS * SPACING * size);
    let (field, value) = source(cloth, at);
    let spring = format!("the spring from vertex {a} to {b} is {} m long", measured(shortest));
    if shortest < least {
        let problem = format!(
            "{spring}; in a cloth {} m large single precision needs springs of at least {} m: give it cells and links that are \
             more alike, or make cloths of its parts{}",
            measured(size),
            measured(least),
            if cloth.scale == 1.0 { String::new() } else { format!("; {at}.scale = {}", brief(cloth.scale)) }
        );
        return Err(SceneError::with_value(field, value, problem));
    }
    let limit = cloth.tightest_limit();
    Ok((limit * shortest < SPACING * size).then(|| {
        format!(
            "scene.{at}.strain_limit = {}: {spring} and may grow by less than the {} m that single precision tells apart in a cloth \
             {} m large; widen the limit or make cells and links longer",
            brief(limit),
            measured(SPACING * size),
            measured(size)
        )
    }))
}

/// Refuses the mass of a vertex that single precision has no room for.
///
/// # Errors
/// Names the mass and what it is made of.
pub(super) fn check_mass(cloth: &Cloth, mass: f64, area: f64, vertex: usize, at: &str) -> Result<(), SceneError> {
    if (MASSES[0]..=MASSES[1]).contains(&mass) {
        return Ok(());
    }
    // Masses of networks and weights are in range, each for itself.
    let (field, _) = source(cloth, at);
    let problem = format!(
        "with {area:.2e} m^2 of {field} at {at}.scale = {}, and its share of {at}.weights, vertex {vertex} has a mass of {mass:.2e} kg, which \
         must be in [{}, {}] kg; change density or size",
        brief(cloth.scale),
        brief(MASSES[0]),
        brief(MASSES[1])
    );
    Err(SceneError::with_value(format!("{at}.density"), brief(cloth.material().density), problem))
}

/// A length as it was found, in a few digits.
fn measured(length: f64) -> String {
    brief(format!("{length:.2e}").parse().unwrap_or(length))
}

/// The field that the points come from, and what it holds.
fn source(cloth: &Cloth, at: &str) -> (String, String) {
    match (&cloth.grid, &cloth.mesh) {
        (Some(grid), _) => {
            let [width, height] = grid.size.map(brief);
            (format!("{at}.grid.size"), format!("[{width}, {height}] ({at}.grid.cells = {:?})", grid.cells))
        }
        (_, Some(mesh)) => (format!("{at}.mesh"), format!("{mesh:?}")),
        _ => (format!("{at}.network.points"), String::new()),
    }
}
