//! Positions and velocities in, accelerations and velocities out: F_INT + F_EXT of the paper (section 2).
//!
//! Each force is a kernel in a file of its own. The Euler method looks once a step at what acts from outside, which gives an
//! acceleration. Springs and dampers are stiffer: they change velocities in as many parts of the step as they need. The other
//! integrators look at all forces together, stage by stage.

mod air_drag;
mod bending;
mod imperfection;
mod internal;
mod stiffness;
mod wind;

use glam::Vec3;
use pulp::{Simd, WithSimd};

use crate::geometry::{CHUNK, Pool, Vectors, VectorsChunk, arch};
use crate::model::{ClothRange, Model};
use crate::schedule::Stride;
use crate::state::{Moment, State};
use internal::{Damper, Hooke, Impulse, Workspace, curved_force};

pub use bending::bending_energy;
pub use internal::{curved_energy, elastic_energy};
pub(crate) use stiffness::Stiffness;

/// Workspace and results.
#[derive(Debug)]
pub struct Forces {
    /// F_EXT / M of each particle, or all forces / M [m/s^2]; zero for held ones.
    acceleration: Vectors,
    wind: wind::Wind,
    springs: Workspace,
    dampers: Workspace,
    /// The stage of the damping before the last one [m/s], or a sum of all forces in the making [m/s^2].
    stage: Vectors,
    bending: bending::Workspace,
}

impl Forces {
    /// Workspace for a model.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        let zeros = || Vectors::zeros(model.particle_count());
        Self {
            acceleration: zeros(),
            wind: wind::Wind::default(),
            springs: Workspace::new(Hooke, model),
            dampers: Workspace::new(Damper, model),
            stage: zeros(),
            bending: bending::Workspace::new(model),
        }
    }

    /// What [`external`] or [`all`] found [m/s^2].
    #[must_use]
    pub fn acceleration(&self) -> &Vectors {
        &self.acceleration
    }
}

/// Gravity, drag and wind on a state: F_EXT / M.
pub fn external(stride: Stride<'_>, state: &State, forces: &mut Forces, pool: &Pool) {
    external_at(stride, state.moment(), forces, pool);
}

fn external_at(stride: Stride<'_>, moment: Moment<'_>, forces: &mut Forces, pool: &Pool) {
    forces.wind.prepare(stride, moment, pool);
    let (wind, gravity) = (&forces.wind, stride.inputs.gravity.at(moment.time).as_vec3());
    forces.acceleration.for_each_chunk(pool, |mut chunk| {
        gravity_and_drag(stride, gravity, moment.velocities, &mut chunk);
        imperfection::accelerate(stride, gravity, &mut chunk);
        wind.accelerate(stride, &mut chunk);
    });
}

/// What would act in air at rest: (F_G + F_A) / M.
fn gravity_and_drag(stride: Stride<'_>, gravity: Vec3, velocities: &Vectors, chunk: &mut VectorsChunk<'_>) {
    let run = chunk.first..chunk.first + chunk.x.len();
    let (particles, step) = (&stride.model.particles, stride.plan.length as f32);
    let (drag, weights) = (&particles.air_drag[run.clone()], &particles.inverse_mass[run.clone()]);
    let columns = [
        (&mut *chunk.x, &velocities.x, gravity.x),
        (&mut *chunk.y, &velocities.y, gravity.y),
        (&mut *chunk.z, &velocities.z, gravity.z),
    ];
    for (acceleration, velocities, gravity) in columns {
        let velocities = &velocities[run.clone()];
        arch().dispatch(GravityAndDrag { acceleration, velocities, drag, weights, gravity, step });
    }
}

/// One coordinate of some particles.
struct GravityAndDrag<'a> {
    acceleration: &'a mut [f32],
    velocities: &'a [f32],
    drag: &'a [f32],
    weights: &'a [f32],
    gravity: f32,
    step: f32,
}

impl WithSimd for GravityAndDrag<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let particles = self.velocities.iter().zip(self.drag).zip(self.weights);
        for (acceleration, ((v, k), w)) in self.acceleration.iter_mut().zip(particles) {
            let free = self.gravity + air_drag::acceleration(*k, *v, self.step);
            *acceleration = if *w > 0.0 { free } else { 0.0 };
        }
    }
}

/// All forces at one moment: (F_INT + F_EXT) / M.
pub fn all(stride: Stride<'_>, moment: Moment<'_>, forces: &mut Forces, pool: &Pool) {
    inside_and_outside(stride, moment, moment, forces, pool);
}

/// F_INT at one moment and F_EXT at another: their sum / M.
pub fn inside_and_outside(stride: Stride<'_>, inside: Moment<'_>, outside: Moment<'_>, forces: &mut Forces, pool: &Pool) {
    let model = stride.model;
    external_at(stride, outside, forces, pool);
    let mut sum = std::mem::take(&mut forces.stage);
    for column in [&mut sum.x, &mut sum.y, &mut sum.z] {
        column.fill(0.0);
    }
    for cloth in &model.cloths {
        // What velocities gain in one second.
        kick(model, cloth, inside.positions, &mut sum, 1.0, forces, pool);
        let (field, other) = (inside.velocities, inside.velocities);
        let impulse = Impulse { field, other, out: &mut sum, keep: 1.0, add: 0.0, scale: 1.0 };
        impulse.apply(Damper, model, cloth, &mut forces.dampers, pool);
    }
    forces.stage = std::mem::replace(&mut forces.acceleration, sum);
}

/// Springs and bending of a cloth and [`external`] forces over `step` seconds: `V += (F_s + F_B + F_EXT) / M h`.
pub fn kick(
    model: &Model,
    cloth: &ClothRange,
    positions: &Vectors,
    velocities: &mut Vectors,
    step: f32,
    forces: &mut Forces,
    pool: &Pool,
) {
    impulse(model, cloth, positions, (velocities, 1.0), step, forces, pool);
}

/// What [`kick`] adds.
pub fn gains(
    model: &Model,
    cloth: &ClothRange,
    positions: &Vectors,
    gains: &mut Vectors,
    step: f32,
    forces: &mut Forces,
    pool: &Pool,
) {
    impulse(model, cloth, positions, (gains, 0.0), step, forces, pool);
}

/// `out = keep out + (F_s + F_B + F_EXT) / M h`.
fn impulse(
    model: &Model,
    cloth: &ClothRange,
    positions: &Vectors,
    (out, keep): (&mut Vectors, f32),
    step: f32,
    forces: &mut Forces,
    pool: &Pool,
) {
    let Forces { acceleration, springs, bending, .. } = forces;
    let impulse = Impulse { field: positions, other: acceleration, out, keep, add: step, scale: step };
    impulse.apply(Hooke, model, cloth, springs, pool);
    if cloth.curved {
        gather(model, cloth, out, step, pool, |particle| curved_force(model, positions, particle));
    }
    if cloth.bends {
        bending.take(model, cloth, positions, pool);
        gather(model, cloth, out, step, pool, |particle| bending.force(model, positions, particle));
    }
}

/// `V += F / M h` for a cloth, each particle asking for its force.
fn gather(
    model: &Model,
    cloth: &ClothRange,
    velocities: &mut Vectors,
    step: f32,
    pool: &Pool,
    force: impl Fn(usize) -> Vec3 + Sync,
) {
    velocities.for_each_part(cloth.particles(), CHUNK, pool, |chunk| {
        chunk.map(|particle, velocity| velocity + force(particle) * (step * model.particles.inverse_mass[particle]));
    });
}

/// What dampers would add to the velocities of a cloth over a whole step: `F_D / M h`.
pub fn damping_gains(
    stride: Stride<'_>,
    cloth: &ClothRange,
    velocities: &Vectors,
    gains: &mut Vectors,
    forces: &mut Forces,
    pool: &Pool,
) {
    let scale = stride.plan.length as f32;
    let impulse = Impulse { field: velocities, other: velocities, out: gains, keep: 0.0, add: 0.0, scale };
    impulse.apply(Damper, stride.model, cloth, &mut forces.dampers, pool);
}

/// Dampers of some cloths over a whole step: `V += F_D / M h` if one stage is stable. Otherwise as many stages of a
/// Runge-Kutta-Legendre method as make it stable (Meyer, Balsara & Aslam 2012, first order). s stages are stable for (s^2 + s) / 2
/// times the step.
pub fn damp(stride: Stride<'_>, cloths: &[ClothRange], stages: u32, velocities: &mut Vectors, forces: &mut Forces, pool: &Pool) {
    let Forces { dampers, stage, .. } = forces;
    let s = stages as f32;
    let part = 2.0 / (s * s + s) * stride.plan.length as f32;
    for number in 1..=stages {
        if number == 1 {
            stage.copy_from(velocities);
        }
        let j = number as f32;
        let (keep, add) = if number == 1 { (1.0, 0.0) } else { ((1.0 - j) / j, (2.0 * j - 1.0) / j) };
        let scale = if number == 1 { part } else { add * part };
        for cloth in cloths {
            let impulse = Impulse { field: velocities, other: velocities, out: stage, keep, add, scale };
            impulse.apply(Damper, stride.model, cloth, dampers, pool);
        }
        std::mem::swap(velocities, stage);
    }
}
