//! The proof that a step keeps the limit, and what is done where it would not.
//!
//! The ends of the step are the very numbers that become the new positions, and every spring is measured there.
//! Admissible positions are a convex set: of the segment from an admissible reference Y to the proposed P, a part up to
//! some t is admissible, and going only that far is always possible. Y is X, moved along with the pins if they all move
//! alike. Pins that move differently may ask for the impossible; then Y is X itself, and they come later.

use glam::Vec3;

use super::Motion;
use crate::geometry::{Pool, Vectors};
use crate::model::{ClothRange, Model};
use crate::schedule::Stride;
use crate::state::{State, measure};

/// What had to be done to a step.
pub(super) struct Verdict {
    /// Whether it was shortened.
    pub cut: bool,
    /// Whether pins were, too.
    pub held_back_pins: bool,
}

/// What one certificate speaks of: a cloth.
pub(super) struct Certificate {
    cloth: ClothRange,
    /// Its held particles.
    held: Vec<usize>,
}

impl Certificate {
    /// The certificate of a cloth.
    pub fn new(model: &Model, cloth: &ClothRange) -> Self {
        let particles = &model.particles;
        let held = cloth.particles().filter(|&index| particles.inverse_mass[index] == 0.0 && particles.mass[index] > 0.0);
        Self { cloth: cloth.clone(), held: held.collect() }
    }

    /// Whether nothing of the cloth is held.
    pub fn is_free(&self) -> bool {
        self.held.is_empty()
    }

    /// The displacement from X to Y [m]: that of the held particles if they move alike, that of the centre of mass if nothing
    /// is held; none if held particles move differently.
    pub fn frame(&self, positions: &Vectors, ends: &Vectors, motion: &Motion<'_>) -> Option<Vec3> {
        // Places are rounded one by one.
        const ALIKE: f32 = 1e-6;
        let Some(&one) = self.held.first() else { return Some(motion.mean()) };
        let displacement = |particle: usize| ends.get(particle) - positions.get(particle);
        let first = displacement(one);
        let alike = self.held.iter().all(|&particle| {
            let extent = positions.get(particle).abs().max_element() + first.abs().max_element();
            (displacement(particle) - first).abs().max_element() <= ALIKE * extent
        });
        alike.then_some(first)
    }

    /// Measures the ends of the step and goes only as far as all springs allow.
    pub fn enforce(
        &self,
        stride: Stride<'_>,
        state: &mut State,
        ends: &mut Vectors,
        frame: Option<Vec3>,
        pool: &Pool,
    ) -> Verdict {
        const ROUNDS: usize = 4;
        let model = stride.model;
        for round in 0..ROUNDS {
            if measure(model, &self.cloth, ends, pool).worst <= 1.0 {
                return Verdict { cut: round > 0, held_back_pins: round > 0 && frame.is_none() };
            }
            // Rounding of the shortened step can ask for another round; the last one stays at X, whatever pins are asked for: those
            // that move alike but for rounding would creep away from each other, step by step.
            if round + 1 < ROUNDS {
                let part = self.admissible_part(model, &state.positions, ends).min(1.0 - 1e-6);
                self.shorten(stride, state, ends, frame, part);
            } else {
                self.shorten(stride, state, ends, None, 0.0);
            }
        }
        Verdict { cut: true, held_back_pins: true }
    }

    /// Leaves `part` of the step relative to Y.
    fn shorten(&self, stride: Stride<'_>, state: &mut State, ends: &mut Vectors, frame: Option<Vec3>, part: f32) {
        let (model, step) = (stride.model, stride.plan.length as f32);
        for particle in self.cloth.particles() {
            if frame.is_some() && model.particles.inverse_mass[particle] == 0.0 {
                continue;
            }
            let frame = frame.unwrap_or_default();
            let (start, end) = (state.positions.get(particle), ends.get(particle));
            let (before, after) = (end - start, frame + (end - start - frame) * part);
            ends.set(particle, start + after);
            state.velocities.set(particle, state.velocities.get(particle) + (after - before) / step);
        }
    }

    /// Largest t in [0, 1] such that Y + t (P - Y) keeps every spring within its limit. A spring that is over its limit at
    /// X already may not grow.
    fn admissible_part(&self, model: &Model, positions: &Vectors, ends: &Vectors) -> f32 {
        /// Rounding of the ends must not lead over the limit again.
        const MARGIN: f32 = 1.0 - 4e-5;
        let mut part = 1.0_f32;
        for spring in self.cloth.springs.clone() {
            let [u, v] = model.springs.ends[spring].map(|end| end as usize);
            let x = (positions.get(v) - positions.get(u)).as_dvec3();
            let p = (ends.get(v) - ends.get(u)).as_dvec3();
            let limit = f64::from(model.springs.greatest_length(spring) * MARGIN).max(x.length());
            if p.length_squared() <= limit * limit {
                continue;
            }
            // |x + t (p - x)|^2 = limit^2
            let way = p - x;
            let (a, b, c) = (way.length_squared(), x.dot(way), x.length_squared() - limit * limit);
            part = part.min(((-b + (b * b - a * c).max(0.0).sqrt()) / a) as f32);
        }
        part.clamp(0.0, 1.0)
    }
}
