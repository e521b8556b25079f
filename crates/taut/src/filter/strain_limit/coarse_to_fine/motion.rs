//! The displacements of a cloth's particles in one step, in whatever order its levels keep them.

use glam::{DVec3, Vec3};
use pulp::{Simd, WithSimd};

use crate::geometry::{Pool, Vectors, arch, sum_of_chunks};
use crate::model::Model;

/// Displacements and inverse masses; what has no inverse mass is held, or is no particle at all.
pub(super) struct Motion<'a> {
    /// D [m].
    pub d: &'a mut Vectors,
    /// [1/kg]
    pub weights: &'a [f32],
}

/// So many sums go on side by side, whatever the length of the vector registers, so that bits do not depend on it.
pub(super) const LANES: usize = 16;
/// So many products are summed in single precision before the sum goes on in double precision.
pub(super) const BLOCK: usize = 256;

impl Motion<'_> {
    /// Sum of M |D - frame|^2 [kg m^2]: twice the kinetic energy in a moving frame, times the square of the step.
    /// `parts` is workspace, a place for every chunk of particles.
    pub fn energy(&self, frame: Vec3, parts: &mut [[f64; 1]], pool: &Pool) -> f64 {
        let Vectors { x, y, z } = &*self.d;
        let [sum] = sum_of_chunks(self.weights.len(), parts, pool, |run| {
            let d = [x, y, z].map(|column| &column[run.clone()]);
            [arch().dispatch(Energy { d, weights: &self.weights[run], frame })]
        });
        sum
    }

    /// The displacement of the centre of mass [m].
    pub fn mean(&self) -> Vec3 {
        let (mut sum, mut mass) = (DVec3::ZERO, 0.0);
        for (d, &weight) in self.d.iter().zip(self.weights).filter(|(_, weight)| **weight > 0.0) {
            sum += d.as_dvec3() / f64::from(weight);
            mass += 1.0 / f64::from(weight);
        }
        (sum / mass.max(f64::MIN_POSITIVE)).as_vec3()
    }

    /// Moves all particles further by `way` [m].
    pub fn shift(&mut self, way: Vec3) {
        for (d, way) in [(&mut self.d.x, way.x), (&mut self.d.y, way.y), (&mut self.d.z, way.z)] {
            d.iter_mut().for_each(|d| *d += way);
        }
    }

    /// Leaves `part` of the motion relative to `frame`.
    pub fn slow_down(&mut self, frame: Vec3, part: f32) {
        let columns = [(&mut self.d.x, frame.x), (&mut self.d.y, frame.y), (&mut self.d.z, frame.z)];
        for (d, frame) in columns {
            for (d, _) in d.iter_mut().zip(self.weights).filter(|(_, weight)| **weight > 0.0) {
                *d = frame + (*d - frame) * part;
            }
        }
    }
}

struct Energy<'a> {
    d: [&'a [f32]; 3],
    weights: &'a [f32],
    frame: Vec3,
}

impl WithSimd for Energy<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let Self { d: [x, y, z], weights, frame } = self;
        let mut energy = 0.0;
        for first in (0..weights.len()).step_by(BLOCK) {
            let run = first..weights.len().min(first + BLOCK);
            let [x, y, z, weights] = [x, y, z, weights].map(|column| &column[run.clone()]);
            let mut sums = [0.0_f32; LANES];
            let columns = x.chunks(LANES).zip(y.chunks(LANES)).zip(z.chunks(LANES)).zip(weights.chunks(LANES));
            for (((x, y), z), weights) in columns {
                let particles = x.iter().zip(y).zip(z).zip(weights);
                for (sum, (((x, y), z), weight)) in sums.iter_mut().zip(particles) {
                    let [x, y, z] = [x - frame.x, y - frame.y, z - frame.z];
                    *sum += if *weight > 0.0 { (x * x + y * y + z * z) / weight } else { 0.0 };
                }
            }
            energy += sums.iter().map(|sum| f64::from(*sum)).sum::<f64>();
        }
        energy
    }
}

/// Sum of M |D| of the particles of each cloth [kg m].
pub(super) fn ways<'a>(model: &'a Model, from: &'a Vectors, to: &'a Vectors) -> impl Iterator<Item = f64> + 'a {
    let way = |particle: usize| f64::from(model.particles.mass[particle] * (to.get(particle) - from.get(particle)).length());
    model.cloths.iter().map(move |cloth| cloth.particles().map(way).sum())
}

/// The part of such a sum that is lost [1].
pub(super) fn lost(way: f64, all: f64) -> f64 {
    if all > 0.0 { (way / all).min(1.0) } else { 0.0 }
}
