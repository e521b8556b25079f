//! The backward differences of second order (Choi & Ko, *Stable but responsive cloth*, 2002, section 4), linearised.
//!
//! With D and E for what the last step added to X and V, and b = 2 h / 3,
//! `V' = V + E / 3 + F(X', V') b / M`, `X' = X + D / 3 + V' b`. Order 2, stable for springs, bending and dampers at any step; it
//! damps much less than backward Euler what is slower than the step. D and E are part of the state; without them (both zero: at
//! the start, or where a state was set) a step is one of backward Euler, `V' = V + F(X', V') h / M`, `X' = X + V' h`.
//!
//! *Where the forces are linear.* Around what the last step points to, V + E and X + D / 3 + (V + E) b, at the end of the step.
//! Choi & Ko take the beginning. That needs exact derivatives for order 2; here they may be anything (those of compressed springs
//! are not exact, those of the wind are left out), since what is extrapolated is off by h^2 only.
//!
//! *Filters.* E is what forces added: a velocity that a filter has changed is taken to have always been that much less.
//! A plain V - V_before would carry a third of every stop into the next step, as a bounce.

use super::{LinearSystem, Method, Step};
use crate::forces::{self, Forces};
use crate::geometry::{Pool, Vectors};
use crate::model::Model;
use crate::state::{Moment, Past, State};

/// A linear system for each cloth.
pub(super) struct Bdf2 {
    systems: Vec<LinearSystem>,
    /// Where forces are linear around: X and V [m], [m/s].
    positions: Vectors,
    velocities: Vectors,
}

/// How much the last step counts, and b [s].
struct Weights {
    last: f32,
    reach: f64,
}

impl Bdf2 {
    pub fn new(model: &Model) -> Self {
        let zeros = || Vectors::zeros(model.particle_count());
        let systems = model.cloths.iter().map(|cloth| LinearSystem::new(model, cloth)).collect();
        Self { systems, positions: zeros(), velocities: zeros() }
    }
}

impl Method for Bdf2 {
    fn propose(&mut self, step: Step<'_>, forces: &mut Forces, pool: &Pool) -> u32 {
        let Step { model, state, ends } = step;
        let (all, length, start) = (0..model.particle_count(), model.timing.step_length, state.time(model));
        let weights = if state.past.is_blank() {
            Weights { last: 0.0, reach: length }
        } else {
            Weights { last: 1.0 / 3.0, reach: 2.0 / 3.0 * length }
        };
        let State { positions, velocities, past: Past { displacements, gains }, .. } = state;
        // X + D / 3, from where b V' leads to the end of the step.
        ends.set_scaled(all.clone(), positions, displacements, weights.last, pool);
        self.velocities.set_scaled(all.clone(), velocities, gains, 1.0, pool);
        self.positions.set_scaled(all.clone(), ends, &self.velocities, weights.reach as f32, pool);
        hold(model, positions, velocities, &mut self.positions, &mut self.velocities);
        let around = Moment { positions: &self.positions, velocities: &self.velocities, time: start + length };
        forces::all(model, around, forces, pool);
        let mut passes = 1;
        for system in &mut self.systems {
            system.look(&self.positions, weights.reach, pool);
            // M (V + E / 3 - (V + E)) / b + F.
            let back = f64::from(weights.last - 1.0) / weights.reach;
            passes += system.solve(|own, particle| own.force(forces, particle) + own.momentum(gains, particle) * back, pool);
            system.add_changes(&mut self.velocities, pool);
        }
        ends.add_scaled(all.clone(), &self.velocities, weights.reach as f32, pool);
        gains.set_scaled(all, &self.velocities, velocities, -1.0, pool);
        std::mem::swap(velocities, &mut self.velocities);
        passes
    }
}

/// What is held goes through the step with the velocity of its path.
fn hold(model: &Model, from: &Vectors, speeds: &Vectors, positions: &mut Vectors, velocities: &mut Vectors) {
    let step = model.timing.step_length as f32;
    for particle in model.pins.iter().flat_map(|group| &group.particles).map(|&particle| particle as usize) {
        velocities.set(particle, speeds.get(particle));
        positions.set(particle, from.get(particle) + speeds.get(particle) * step);
    }
}
