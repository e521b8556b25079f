//! The proof that a step keeps the limit, and what is done where it would not.
//!
//! The ends of the step are formed exactly as the integrator will form them, in the same single precision, and every
//! spring is measured. Admissible positions are a convex set: of the segment from an admissible reference Y to the
//! proposed P, a part up to some t is admissible, and going only that far is always possible.

use glam::{DVec3, Vec3};

use crate::geometry::Vectors;
use crate::model::{ClothRange, Model};
use crate::state::{State, Stretch, measure};

/// What one certificate speaks of: a cloth.
pub(super) struct Certificate {
    cloth: ClothRange,
}

impl Certificate {
    /// The certificate of a cloth.
    pub fn new(cloth: &ClothRange) -> Self {
        Self { cloth: cloth.clone() }
    }

    /// Writes X + V h, as the integrator does, and measures it.
    pub fn measure(&self, model: &Model, state: &State, ends: &mut Vectors) -> Stretch {
        let step = model.timing.step_length as f32;
        let run = self.cloth.particles();
        let columns = [
            (&state.positions.x, &state.velocities.x, &mut ends.x),
            (&state.positions.y, &state.velocities.y, &mut ends.y),
            (&state.positions.z, &state.velocities.z, &mut ends.z),
        ];
        for (positions, velocities, ends) in columns {
            let moving = positions[run.clone()].iter().zip(&velocities[run.clone()]);
            ends[run.clone()].iter_mut().zip(moving).for_each(|(end, (position, velocity))| *end = position + velocity * step);
        }
        measure(model, &self.cloth, ends)
    }

    /// The velocity of an admissible motion of the whole cloth without strain [m/s]: that of its pins if they all move
    /// alike, that of its centre of mass if it has none. Pins that move differently leave no such motion.
    pub fn rigid_velocity(&self, model: &Model, state: &State) -> Option<Vec3> {
        let mut common = None;
        let (mut momentum, mut mass) = (DVec3::ZERO, 0.0);
        for particle in self.cloth.particles() {
            let velocity = state.velocities.get(particle);
            if model.particles.inverse_mass[particle] == 0.0 {
                if model.particles.mass[particle] > 0.0 && *common.get_or_insert(velocity) != velocity {
                    return None;
                }
            } else {
                let weight = f64::from(model.particles.mass[particle]);
                momentum += velocity.as_dvec3() * weight;
                mass += weight;
            }
        }
        common.or(Some((momentum / mass.max(f64::MIN_POSITIVE)).as_vec3()))
    }

    /// Kinetic energy of the free particles in a frame that moves with `frame` [J].
    pub fn kinetic_energy(&self, model: &Model, velocities: &Vectors, frame: Vec3) -> f64 {
        let free = self.cloth.particles().filter(|&particle| model.particles.inverse_mass[particle] > 0.0);
        free.map(|particle| {
            0.5 * f64::from(model.particles.mass[particle]) * (velocities.get(particle) - frame).as_dvec3().length_squared()
        })
        .sum()
    }

    /// Slows the cloth down to `part` of its motion relative to `frame`.
    pub fn slow_down(&self, model: &Model, velocities: &mut Vectors, frame: Vec3, part: f32) {
        for particle in self.cloth.particles().filter(|&particle| model.particles.inverse_mass[particle] > 0.0) {
            let velocity = velocities.get(particle);
            velocities.set(particle, frame + (velocity - frame) * part);
        }
    }

    /// Largest t in [0, 1] such that Y + t (P - Y) keeps every spring within its limit, where Y is X moved with
    /// `frame` and P the ends of the step. A spring that is over its limit at X already may not grow.
    pub fn admissible_part(&self, model: &Model, state: &State, ends: &Vectors) -> f32 {
        /// Rounding of the ends must not lead over the limit again.
        const MARGIN: f32 = 1.0 - 4e-5;
        let mut part = 1.0_f32;
        for spring in self.cloth.springs.clone() {
            let [u, v] = model.springs.ends[spring].map(|end| end as usize);
            let x = (state.positions.get(v) - state.positions.get(u)).as_dvec3();
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
