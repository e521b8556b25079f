//! The proof that a step keeps the limit, and what is done where it would not.
//!
//! The ends of the step are formed exactly as the integrator will form them, in the same single precision, and every
//! spring is measured. Admissible positions are a convex set: of the segment from an admissible reference Y to the
//! proposed P, a part up to some t is admissible, and going only that far is always possible.

use std::ops::Range;

use glam::{DVec3, Vec3};
use pulp::Arch;

use crate::geometry::Vectors;
use crate::model::{Lattice, Model};
use crate::state::State;

/// The part of the model that one certificate speaks of: a cloth.
pub(super) struct Extent {
    /// Its particles.
    pub particles: Range<usize>,
    /// Its type 1 springs.
    pub springs: Range<usize>,
    /// Its grid, if it is one, and the greatest lengths of its springs to the right, up, up-right and up-left [m].
    pub lattice: Option<(Lattice, [f32; 4])>,
}

impl Extent {
    /// What the springs of the cloth say at `positions`: springs over their limit, and the largest |X_uv| / R.
    pub fn measure(&self, model: &Model, positions: &Vectors) -> (u32, f32) {
        let (over, square) = match &self.lattice {
            Some((lattice, limits)) => Arch::new().dispatch(
                #[inline(always)]
                || measure_lattice(lattice, limits, positions),
            ),
            None => self.springs.clone().fold((0, 0.0_f32), |(over, worst), spring| {
                let limit = model.springs.greatest_length(spring);
                let ratio = length(model, positions, spring).powi(2) / (limit * limit);
                (over + u32::from(ratio > 1.0), worst.max(ratio))
            }),
        };
        (over, square.sqrt())
    }

    /// Writes X + V h, as the integrator does.
    pub fn ends_of_step(&self, state: &State, step: f32, ends: &mut Vectors) {
        let run = self.particles.clone();
        let columns = [
            (&state.positions.x, &state.velocities.x, &mut ends.x),
            (&state.positions.y, &state.velocities.y, &mut ends.y),
            (&state.positions.z, &state.velocities.z, &mut ends.z),
        ];
        for (positions, velocities, ends) in columns {
            let moving = positions[run.clone()].iter().zip(&velocities[run.clone()]);
            ends[run.clone()].iter_mut().zip(moving).for_each(|(end, (position, velocity))| *end = position + velocity * step);
        }
    }

    /// The velocity of an admissible motion of the whole cloth without strain [m/s]: that of its pins if they all move
    /// alike, that of its centre of mass if it has none. Pins that move differently leave no such motion.
    pub fn rigid_velocity(&self, model: &Model, state: &State) -> Option<Vec3> {
        let mut common = None;
        let (mut momentum, mut mass) = (DVec3::ZERO, 0.0);
        for particle in self.particles.clone() {
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
        let free = self.particles.clone().filter(|&particle| model.particles.inverse_mass[particle] > 0.0);
        free.map(|particle| {
            0.5 * f64::from(model.particles.mass[particle]) * (velocities.get(particle) - frame).as_dvec3().length_squared()
        })
        .sum()
    }

    /// Slows the cloth down to `part` of its motion relative to `frame`.
    pub fn slow_down(&self, model: &Model, velocities: &mut Vectors, frame: Vec3, part: f32) {
        for particle in self.particles.clone().filter(|&particle| model.particles.inverse_mass[particle] > 0.0) {
            let velocity = velocities.get(particle);
            velocities.set(particle, frame + (velocity - frame) * part);
        }
    }

    /// Largest t in [0, 1] such that Y + t (P - Y) keeps every spring within its limit, where Y is X moved with
    /// `frame` and P the ends of the step. Springs over their limit at X already have no say.
    pub fn admissible_part(&self, model: &Model, state: &State, ends: &Vectors) -> f32 {
        /// Rounding of the ends must not lead over the limit again.
        const MARGIN: f32 = 1.0 - 4e-5;
        let mut part = 1.0_f32;
        for spring in self.springs.clone() {
            let [u, v] = model.springs.ends[spring].map(|end| end as usize);
            let limit = f64::from(model.springs.greatest_length(spring) * MARGIN);
            let x = (state.positions.get(v) - state.positions.get(u)).as_dvec3();
            let p = (ends.get(v) - ends.get(u)).as_dvec3();
            if p.length_squared() <= limit * limit || x.length_squared() > limit * limit {
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

fn length(model: &Model, positions: &Vectors, spring: usize) -> f32 {
    let [u, v] = model.springs.ends[spring].map(|end| end as usize);
    positions.get(u).distance(positions.get(v))
}

/// Number of springs over their limit and the largest (|X_uv| / R)^2 of a lattice.
#[inline(always)]
fn measure_lattice(lattice: &Lattice, limits: &[f32; 4], positions: &Vectors) -> (u32, f32) {
    let (columns, rows) = (lattice.columns, lattice.rows);
    let (mut over, mut worst) = (0, 0_i32);
    for row in 0..rows {
        let left = lattice.first + row * columns;
        let mut run = |from: usize, to: usize, len: usize, limit: f32| {
            let [ax, ay, az] = [&positions.x[from..from + len], &positions.y[from..from + len], &positions.z[from..from + len]];
            let [bx, by, bz] = [&positions.x[to..to + len], &positions.y[to..to + len], &positions.z[to..to + len]];
            let inverse = 1.0 / (limit * limit);
            for i in 0..len {
                let (dx, dy, dz) = (bx[i] - ax[i], by[i] - ay[i], bz[i] - az[i]);
                let ratio = (dx * dx + dy * dy + dz * dz) * inverse;
                // Non-negative floats order like their bits, and integer maxima vectorise.
                worst = worst.max(ratio.to_bits().cast_signed());
                over += u32::from(ratio > 1.0);
            }
        };
        run(left, left + 1, columns - 1, limits[0]);
        if row + 1 < rows {
            run(left, left + columns, columns, limits[1]);
            run(left, left + columns + 1, columns - 1, limits[2]);
            run(left + 1, left + columns, columns - 1, limits[3]);
        }
    }
    (over, f32::from_bits(worst.cast_unsigned()))
}
