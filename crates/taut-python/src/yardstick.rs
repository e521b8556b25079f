//! The yardstick of the benchmarks: one plain spring-force pass over the same cloth, timed in the same process.
//!
//! Clocks differ between machines; frame / yardstick hardly does. The pass is written out here, apart from the engine's
//! own kernels, so that it stays put while those get faster: Hooke's law as printed, one gather for every spring of
//! every particle, square root and division, no damping, one thread.

use std::hint::black_box;
use std::time::Instant;

use pulp::{Simd, WithSimd};
use taut::geometry::{Vectors, arch};
use taut::model::{Adjacency, Model};

/// A spring as one of its ends sees it; the other end is `offset` particles further on.
#[derive(Clone, Copy, Default)]
struct Arm {
    offset: isize,
    rest: f32,
    stiffness: f32,
}

/// Neighbouring particles of a grid that all have the same arms.
struct Run {
    first: usize,
    len: usize,
    arms: [Arm; 8],
}

/// Runs `repeats` passes; returns how long each took [s], and the spring force on each particle [N].
pub fn measure(model: &Model, positions: &Vectors, repeats: usize) -> (Vec<f64>, Vectors) {
    let arms = arms(model);
    let runs = runs(model, &arms);
    let alone = alone(model.particle_count(), &runs);
    let mut forces = Vectors::zeros(model.particle_count());
    let mut pass = || {
        let start = Instant::now();
        for run in &runs {
            arch().dispatch(OfRun { run, positions: black_box(positions), forces: &mut forces });
        }
        for &particle in &alone {
            gather(arms.of(particle), positions, particle, &mut forces);
        }
        black_box(&mut forces);
        start.elapsed().as_secs_f64()
    };
    pass(); // brings the cloth into the caches
    let seconds = (0..repeats).map(|_| pass()).collect();
    (seconds, forces)
}

/// The springs around each particle, from the list of springs: independent of how the engine keeps them.
fn arms(model: &Model) -> Adjacency<Arm> {
    let springs = &model.springs;
    let arms = (0..springs.len()).flat_map(|spring| {
        let ([u, v], rest, stiffness) = (springs.ends[spring], springs.rest[spring], springs.stiffness[spring]);
        let offset = v as isize - u as isize;
        [(u, Arm { offset, rest, stiffness }), (v, Arm { offset: -offset, rest, stiffness })]
    });
    Adjacency::new(model.particle_count(), arms)
}

/// The inner rows of the grids, where they fill a vector register.
fn runs(model: &Model, arms: &Adjacency<Arm>) -> Vec<Run> {
    let mut runs = Vec::new();
    for lattice in model.lattices.iter() {
        let middle = lattice.first + lattice.columns + 1;
        let Ok(arms) = <[Arm; 8]>::try_from(arms.of(middle)) else { continue };
        if lattice.columns < 2 + LONGEST_REGISTER {
            continue;
        }
        let row = |row| Run { first: lattice.first + row * lattice.columns + 1, len: lattice.columns - 2, arms };
        runs.extend((1..lattice.rows - 1).map(row));
    }
    runs
}

/// Single-precision numbers in the longest vector registers there are.
const LONGEST_REGISTER: usize = 16;

/// The particles outside all runs.
fn alone(particles: usize, runs: &[Run]) -> Vec<usize> {
    let mut alone = vec![true; particles];
    runs.iter().for_each(|run| alone[run.first..run.first + run.len].fill(false));
    (0..particles).filter(|&particle| alone[particle]).collect()
}

/// The springs of one particle along its list.
fn gather(arms: &[Arm], positions: &Vectors, particle: usize, forces: &mut Vectors) {
    let Vectors { x, y, z } = positions;
    let mut force = [0.0; 3];
    for &Arm { offset, rest, stiffness } in arms {
        let other = particle.wrapping_add_signed(offset);
        let arm = [x[other] - x[particle], y[other] - y[particle], z[other] - z[particle]];
        let length = (arm[0] * arm[0] + arm[1] * arm[1] + arm[2] * arm[2]).sqrt();
        let factor = if length > 0.0 { stiffness * (1.0 - rest / length) } else { 0.0 };
        (0..3).for_each(|axis| force[axis] += arm[axis] * factor);
    }
    [forces.x[particle], forces.y[particle], forces.z[particle]] = force;
}

struct OfRun<'a> {
    run: &'a Run,
    positions: &'a Vectors,
    forces: &'a mut Vectors,
}

impl WithSimd for OfRun<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { run, positions: Vectors { x, y, z }, forces } = self;
        let load = |column: &[f32], at: usize| S::as_simd_f32s(&column[at..at + S::F32_LANES]).0[0];
        let store = |column: &mut [f32], at: usize, value| S::as_mut_simd_f32s(&mut column[at..at + S::F32_LANES]).0[0] = value;
        let (zero, one) = (simd.splat_f32s(0.0), simd.splat_f32s(1.0));
        for start in (0..run.len).step_by(S::F32_LANES) {
            // The last register of a run goes over some particles again.
            let here = run.first + start.min(run.len - S::F32_LANES);
            let from = [load(x, here), load(y, here), load(z, here)];
            let mut force = [zero; 3];
            for arm in &run.arms {
                let there = here.wrapping_add_signed(arm.offset);
                let to = [load(x, there), load(y, there), load(z, there)];
                let [dx, dy, dz] = [0, 1, 2].map(|axis| simd.sub_f32s(to[axis], from[axis]));
                let square = simd.add_f32s(simd.mul_f32s(dx, dx), simd.mul_f32s(dy, dy));
                let length = simd.sqrt_f32s(simd.add_f32s(square, simd.mul_f32s(dz, dz)));
                let slack = simd.sub_f32s(one, simd.div_f32s(simd.splat_f32s(arm.rest), length));
                let factor = simd.mul_f32s(simd.splat_f32s(arm.stiffness), slack);
                let factor = simd.select_f32s(simd.greater_than_f32s(length, zero), factor, zero);
                force = [(dx, 0), (dy, 1), (dz, 2)].map(|(part, axis)| simd.add_f32s(force[axis], simd.mul_f32s(part, factor)));
            }
            store(&mut forces.x, here, force[0]);
            store(&mut forces.y, here, force[1]);
            store(&mut forces.z, here, force[2]);
        }
    }
}
