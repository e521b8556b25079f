//! Any mesh or network.

use super::{Hierarchy, Motion};
use crate::filter::strain_limit::coloured::{ColouredSprings, Pass};
use crate::geometry::{Pool, Vectors};
use crate::model::{ClothRange, Model};

/// Sweeps in a cycle.
const SWEEPS: usize = 4;

/// The springs of one cloth by colour.
pub(super) struct GeneralLevels {
    springs: ColouredSprings,
    cloth: ClothRange,
    aim: f32,
    /// Ends of the step P and displacements D [m], now and one cycle ago.
    now: [Vectors; 2],
    previous: [Vectors; 2],
    weights: Vec<f32>,
    backwards: bool,
}

impl GeneralLevels {
    /// The springs of a cloth, aimed `delta` of R below their limit.
    pub fn new(model: &Model, cloth: &ClothRange, delta: f32) -> Self {
        let zeros = || [Vectors::zeros(model.particle_count()), Vectors::zeros(model.particle_count())];
        let mut weights = vec![0.0; model.particle_count()];
        weights[cloth.particles()].copy_from_slice(&model.particles.inverse_mass[cloth.particles()]);
        Self {
            springs: ColouredSprings::new(model, cloth.springs.clone()),
            cloth: cloth.clone(),
            aim: 1.0 - delta,
            now: zeros(),
            previous: zeros(),
            weights,
            backwards: false,
        }
    }
}

impl Hierarchy for GeneralLevels {
    fn load(&mut self, positions: &Vectors, ends: &Vectors) {
        let [now, displacements] = &mut self.now;
        for particle in self.cloth.particles() {
            let end = ends.get(particle);
            now.set(particle, end);
            displacements.set(particle, end - positions.get(particle));
        }
        self.backwards = false;
    }

    fn cycle(&mut self, momentum: f32, _: f32, pool: &Pool) -> f32 {
        for (now, previous) in self.now.iter_mut().zip(&mut self.previous) {
            for particle in self.cloth.particles() {
                let value = now.get(particle);
                if momentum > 0.0 {
                    now.set(particle, value + (value - previous.get(particle)) * momentum);
                }
                previous.set(particle, value);
            }
        }
        let [ends, displacements] = &mut self.now;
        for _ in 0..SWEEPS {
            // Displacements take the corrections as they are: they stand for velocities over one second.
            let pass = Pass { step: 1.0, aim: self.aim, backwards: self.backwards };
            self.springs.sweep(ends, displacements, pass, pool);
            self.backwards = !self.backwards;
        }
        self.springs.worst(ends)
    }

    fn motion(&mut self) -> Motion<'_> {
        Motion { d: &mut self.now[1], weights: &self.weights }
    }

    fn store(&self, step: f32, positions: &Vectors, ends: &mut Vectors, velocities: &mut Vectors) {
        for particle in self.cloth.particles().filter(|&particle| self.weights[particle] > 0.0) {
            let (start, after) = (positions.get(particle), self.now[1].get(particle));
            let before = ends.get(particle) - start;
            if after != before {
                velocities.set(particle, velocities.get(particle) + (after - before) / step);
                ends.set(particle, start + after);
            }
        }
    }
}
