//! The proof that a step keeps the limit, and what is done where it would not.
//!
//! The ends of the step are the very numbers that become the new positions, and every spring is measured there.
//! Admissible positions are a convex set: on the way from an admissible reference Y to the proposed P every particle may go up to
//! some part of it, and those that no spring stops go all of it (field.rs). Y is X, moved along with the pins if they all move
//! alike. Pins that move differently may ask for the impossible; then Y is X itself, and they come later.

mod field;

use glam::{DVec3, Vec3};

use super::apart::way_of_held;
use super::{Motion, impulse};
use crate::geometry::{Pool, Vectors};
use crate::model::{ClothRange, Model};
use crate::schedule::Stride;
use crate::state::{State, measure};
pub(super) use field::largest;
use field::{Field, Proposal};

/// What had to be done to a step.
#[derive(Default)]
pub(super) struct Verdict {
    /// Whether it was shortened.
    pub cut: bool,
    /// Whether pins were, too.
    pub held_back_pins: bool,
    /// The part of the motion that was taken from it [1].
    pub lost_motion: f64,
}

/// What one certificate speaks of: a cloth.
pub(super) struct Certificate {
    cloth: ClothRange,
    /// Its held particles.
    held: Vec<usize>,
    field: Field,
}

impl Certificate {
    /// The certificate of a cloth.
    pub fn new(model: &Model, cloth: &ClothRange) -> Self {
        let held = model.particles.held(cloth.particles()).collect();
        Self { cloth: cloth.clone(), held, field: Field::new(model, cloth) }
    }

    /// Whether nothing of the cloth is held.
    pub fn is_free(&self) -> bool {
        self.held.is_empty()
    }

    /// The displacement from X to Y [m]: that of the held particles if they move alike, that of the centre of mass if nothing
    /// is held; none if held particles move differently.
    pub fn frame(&self, positions: &Vectors, ends: &Vectors, motion: &Motion<'_>) -> Option<Vec3> {
        if self.held.is_empty() { Some(motion.mean()) } else { way_of_held(&self.held, positions, ends) }
    }

    /// Measures the ends of a step, and lets every particle go only as far as all springs allow, towards where it starts, moved along with
    /// `frame`, and seen from `world`, the displacement of what velocities are relative to, if there is one [m]. The limit `tightens` in this
    /// scene, so that springs may be over it already.
    pub fn enforce(
        &mut self,
        stride: Stride<'_>,
        state: &mut State,
        ends: &mut Vectors,
        [frame, world]: [Option<Vec3>; 2],
        tightens: bool,
        pool: &Pool,
    ) -> Verdict {
        const ROUNDS: usize = 4;
        let (model, step) = (stride.model, stride.plan.length as f32);
        let admissible = |ends: &Vectors| measure(model, &self.cloth, ends, pool).worst <= 1.0;
        if admissible(ends) {
            return Verdict::default();
        }
        // Where a limit has tightened, springs are over it at X already. They come back as the filter can; none may grow. Elsewhere X is
        // within it but for rounding, and to let that grow again and again would lead over the limit.
        let tightened = tightens && !admissible(&state.positions);
        if tightened && self.nothing_grows(model, &state.positions, ends) {
            return Verdict::default();
        }
        let all = self.motion(model, &state.positions, ends, frame);
        let mut lost = 0.0;
        for round in 0..ROUNDS {
            // Rounding of what was shortened can ask for another round.
            let proposal = Proposal {
                springs: &model.springs,
                inverse_mass: &model.particles.inverse_mass,
                positions: &state.positions,
                ends,
                frame: frame.unwrap_or_default().as_dvec3(),
                pins_first: frame.is_some(),
                shifted: self.is_free(),
                round,
            };
            self.field.find(&proposal, model);
            lost += self.shorten(model, state, ends, [frame, world], step);
            if admissible(ends) || tightened && self.nothing_grows(model, &state.positions, ends) {
                let held_back_pins = frame.is_none() && !self.is_free();
                return Verdict { cut: true, held_back_pins, lost_motion: part(lost, all) };
            }
        }
        // The last resort is X itself, whatever pins are asked for: those that move alike but for rounding would creep away from
        // each other, step by step.
        for particle in self.cloth.particles() {
            let change = state.positions.get(particle) - ends.get(particle);
            ends.set(particle, state.positions.get(particle));
            impulse::take_back(&mut state.velocities, particle, change, world, step);
        }
        Verdict { cut: true, held_back_pins: !self.is_free(), lost_motion: 1.0 }
    }

    /// Whether no spring is over its limit and longer than it was, but for rounding.
    fn nothing_grows(&self, model: &Model, positions: &Vectors, ends: &Vectors) -> bool {
        const ROUNDING: f64 = 1.0 + 1e-6;
        self.cloth.springs.clone().all(|spring| {
            let [u, v] = model.springs.ends[spring].map(|end| end as usize);
            let length = |at: &Vectors| at.get(u).as_dvec3().distance(at.get(v).as_dvec3());
            length(ends) <= f64::from(model.springs.greatest_length(spring)).max(length(positions)) * ROUNDING
        })
    }

    /// Sum of M |D - frame| [kg m].
    fn motion(&self, model: &Model, positions: &Vectors, ends: &Vectors, frame: Option<Vec3>) -> f64 {
        let frame = frame.unwrap_or_default();
        let of = |particle: usize| {
            let d = ends.get(particle) - positions.get(particle) - frame;
            f64::from(model.particles.mass[particle]) * f64::from(d.length())
        };
        self.cloth.particles().map(of).sum()
    }

    /// Takes from each particle what its factor leaves of its step relative to Y. Returns the sum of M times what was taken [kg m].
    fn shorten(&self, model: &Model, state: &mut State, ends: &mut Vectors, [frame, world]: [Option<Vec3>; 2], step: f32) -> f64 {
        let (mut lost, mut way, mut impulse) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for (particle, factor) in self.field.cut() {
            let (start, end) = (state.positions.get(particle), ends.get(particle));
            let displacement = frame.unwrap_or_default() + (end - start - frame.unwrap_or_default()) * factor;
            let change = displacement - (end - start);
            ends.set(particle, start + displacement);
            let change_of_velocity = impulse::take_back(&mut state.velocities, particle, change, world, step);
            let mass = f64::from(model.particles.mass[particle]);
            lost += mass * f64::from(change.length());
            way += change.as_dvec3() * mass;
            impulse += change_of_velocity.as_dvec3() * mass;
        }
        if self.is_free() {
            let mass: f64 = model.particles.mass[self.cloth.particles()].iter().map(|&mass| f64::from(mass)).sum();
            let [way, velocity] = [way, impulse].map(|sum| (sum / mass).as_vec3());
            for particle in self.cloth.particles() {
                ends.set(particle, ends.get(particle) - way);
                state.velocities.set(particle, state.velocities.get(particle) - velocity);
            }
        }
        lost
    }
}

/// `lost` of `all`, if there was any.
fn part(lost: f64, all: f64) -> f64 {
    if all > 0.0 { (lost / all).min(1.0) } else { 0.0 }
}
