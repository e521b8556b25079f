//! Any mesh or network.

use super::Hierarchy;
use crate::filter::strain_limit::coloured::{ColouredSprings, Pass};
use crate::geometry::{Pool, Vectors};
use crate::model::{ClothRange, Model};
use crate::state::{State, measure};

/// Sweeps in a cycle.
const SWEEPS: usize = 4;

/// The springs of one cloth by colour.
pub(super) struct GeneralLevels {
    springs: ColouredSprings,
    cloth: ClothRange,
    aim: f32,
    step: f32,
    /// P = X + V h [m] and V [m/s], now and one cycle ago.
    now: [Vectors; 2],
    previous: [Vectors; 2],
    backwards: bool,
    pool: Pool,
}

impl GeneralLevels {
    /// The springs of a cloth, aimed `delta` of R below their limit.
    pub fn new(model: &Model, cloth: &ClothRange, delta: f32) -> Self {
        let zeros = || [Vectors::zeros(model.particle_count()), Vectors::zeros(model.particle_count())];
        Self {
            springs: ColouredSprings::new(model, cloth.springs.clone()),
            cloth: cloth.clone(),
            aim: 1.0 - delta,
            step: model.timing.step_length as f32,
            now: zeros(),
            previous: zeros(),
            backwards: false,
            pool: Pool::new(1),
        }
    }
}

impl Hierarchy for GeneralLevels {
    fn load(&mut self, _: &Model, state: &State) {
        let [ends, velocities] = &mut self.now;
        for particle in self.cloth.particles() {
            let velocity = state.velocities.get(particle);
            velocities.set(particle, velocity);
            ends.set(particle, state.positions.get(particle) + velocity * self.step);
        }
        self.backwards = false;
    }

    fn cycle(&mut self, model: &Model, momentum: f32, _: f32) -> f32 {
        for (now, previous) in self.now.iter_mut().zip(&mut self.previous) {
            for particle in self.cloth.particles() {
                let value = now.get(particle);
                if momentum > 0.0 {
                    now.set(particle, value + (value - previous.get(particle)) * momentum);
                }
                previous.set(particle, value);
            }
        }
        let [ends, velocities] = &mut self.now;
        for _ in 0..SWEEPS {
            let pass = Pass { step: self.step, aim: self.aim, backwards: self.backwards };
            self.springs.sweep(ends, velocities, pass, &self.pool);
            self.backwards = !self.backwards;
        }
        measure(model, &self.cloth, &self.now[0]).worst
    }

    fn store(&self, _: &Model, state: &mut State) {
        for particle in self.cloth.particles() {
            state.velocities.set(particle, self.now[1].get(particle));
        }
    }
}
