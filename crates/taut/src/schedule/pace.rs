//! How fast a cloth moves as a whole: the time by which its steps are measured.
//!
//! A step that is short for a curtain is long for a doll's skirt. For the sake of the motion a step may be a part of the time in
//! which the cloth falls through its own size. So a scene and the same scene at another scale are simulated alike.

use crate::inputs::Inputs;
use crate::model::ClothRange;

/// Longest step that "auto" takes where stability does not bound it, for the sake of the motion. It is a part of the time in which the
/// cloth moves by its size [1]: 1/60 s for a cloth of 1 m.
pub(super) const LONGEST: f64 = 0.0522;
/// Wind passes a cloth so many times before it has carried it by its size [1].
const PASSES: f64 = 5.0;
/// A step may be longer than the motion asks for by this part of the frame that it divides [1]. Otherwise a cloth of 0.99 m would take
/// twice the steps of one of 1 m.
const LENIENT: f64 = 0.25;

/// The time in which a cloth moves by its size [s]: sqrt(size / g), or what fast wind leaves of it, but no more than `longest`. Where
/// neither acts it moves as it is told, and the frames alone say how closely that is looked at.
pub(super) fn time(cloth: &ClothRange, inputs: &Inputs, longest: f64) -> f64 {
    // A single point has no size.
    if cloth.size == 0.0 {
        return longest;
    }
    let falls = (cloth.size / inputs.gravity.greatest()).sqrt();
    let wind = inputs.air.as_ref().map_or(0.0, |air| air.greatest_speed);
    falls.min(PASSES * cloth.size / wind).min(longest)
}

/// The longest of equal parts of `whole` that the motion bears, if it asks for `longest` [s].
pub(super) fn part(whole: f64, longest: f64) -> f64 {
    whole / parts(whole, longest)
}

/// How many of them there are [1].
pub(super) fn parts(whole: f64, longest: f64) -> f64 {
    // What is a whole number but for rounding needs no further part.
    (whole / longest * (1.0 - 1e-9) - LENIENT).ceil().max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_whole_and_a_little_longer_at_most() {
        for (whole, longest, expected) in
            [(1.0, 1.0, 1.0), (1.0, 0.8, 1.0), (1.0, 0.79, 2.0), (1.0, 0.5, 2.0), (1.0, f64::INFINITY, 1.0), (3.0, 1.0, 3.0)]
        {
            assert_eq!(parts(whole, longest), expected, "{whole} in parts of {longest}");
            assert_eq!(part(whole, longest), whole / expected);
        }
    }
}
