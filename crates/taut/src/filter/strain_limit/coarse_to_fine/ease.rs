//! Cloth that intersects something is not thrown out of it.

use crate::geometry::Vectors;
use crate::model::ClothRange;
use crate::schedule::Stride;
use crate::state::State;

/// No particle goes further than it was proposed to, and so many times as far as a step brings things apart.
const LEEWAY: f32 = 2.0;

/// Lets a cloth go only such a part of its way that no particle goes too far, where rows contradict each other. A part of an admissible way
/// is admissible.
pub(super) fn ease(stride: Stride<'_>, cloth: &ClothRange, state: &mut State, proposed: &Vectors, ends: &mut Vectors, most: f64) {
    let (weights, step) = (&stride.model.particles.inverse_mass, stride.plan.length as f32);
    let mut part: f32 = 1.0;
    for particle in cloth.particles().filter(|&particle| weights[particle] > 0.0) {
        let start = state.positions.get(particle);
        let (way, asked) = ((ends.get(particle) - start).length(), (proposed.get(particle) - start).length());
        let allowed = asked + LEEWAY * most as f32;
        if way > allowed {
            part = part.min(allowed / way);
        }
    }
    if part < 1.0 {
        for particle in cloth.particles().filter(|&particle| weights[particle] > 0.0) {
            let (start, end) = (state.positions.get(particle), ends.get(particle));
            let back = (end - start) * (part - 1.0);
            ends.set(particle, end + back);
            state.velocities.set(particle, state.velocities.get(particle) + back / step);
        }
    }
}
