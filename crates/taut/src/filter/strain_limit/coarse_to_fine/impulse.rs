//! What velocities take of the corrections of positions.
//!
//! Where a cloth moves smoothly, V = D / h, and a correction C of the displacement D is one of C / h to V. Springs that vibrate
//! faster than the filter looks have turned round meanwhile: V is not D / h, and C / h would add to a velocity that points
//! inwards already (docs/equations.md, "Vibrations faster than H"). So velocities take the part of C / h that leaves the
//! least kinetic energy, and never more than all of it. A single part for the whole cloth: momentum stays what it is.

use glam::Vec3;
use pulp::{Simd, WithSimd};

use super::motion::{BLOCK, LANES};
use crate::geometry::{Pool, Vectors, arch, sum_of_chunks};
use crate::model::ClothRange;
use crate::schedule::Stride;

/// The factor [1/s] of corrections [m] in what velocities take of them: c / h, c being the place of the smallest
/// sum of M |V + c C / h - F / h|^2 in [0, 1]. `frame` is F, the displacement [m] of what is held; if held particles move
/// differently, there is no frame in which pulling them along costs nothing, and c is 1. It is 1 as well where a step is not
/// divided: there V is D / h, and stays so. `parts` is workspace, a place for every chunk of particles.
pub(super) fn rate(
    stride: Stride<'_>,
    cloth: &ClothRange,
    velocities: &Vectors,
    corrections: &Vectors,
    frame: Option<Vec3>,
    parts: &mut [[f64; 2]],
    pool: &Pool,
) -> f32 {
    let (model, plan) = (stride.model, stride.plan);
    let step = plan.length as f32;
    let frame = match frame {
        Some(frame) if plan.of(cloth).parts() > 1 => frame / step,
        _ => return 1.0 / step,
    };
    let columns = [
        (&velocities.x, &corrections.x, frame.x),
        (&velocities.y, &corrections.y, frame.y),
        (&velocities.z, &corrections.z, frame.z),
    ];
    let [along, square] = sum_of_chunks(cloth.count, parts, pool, |run| {
        let run = cloth.first + run.start..cloth.first + run.end;
        let masses = &model.particles.mass[run.clone()];
        let products = columns.map(|(velocities, corrections, frame)| {
            let (velocities, corrections) = (&velocities[run.clone()], &corrections[run.clone()]);
            arch().dispatch(Products { velocities, corrections, masses, frame })
        });
        [0, 1].map(|which| products.iter().map(|sums| sums[which]).sum())
    });
    let step = f64::from(step);
    if square > 0.0 { (-along / square).clamp(0.0, 1.0 / step) as f32 } else { 0.0 }
}

/// Gives a velocity its part of a change of its displacement [m], where a step of `step` seconds is shortened; returns what it took. That is
/// `change / h`, but less where the velocity would turn round and grow, seen from a displacement `frame`: it is not D / h where springs
/// vibrate within a step, nor where it took but a part of a correction.
pub(super) fn take_back(velocities: &mut Vectors, particle: usize, change: Vec3, frame: Option<Vec3>, step: f32) -> Vec3 {
    let velocity = velocities.get(particle);
    let along = |frame: Vec3| -(velocity - frame / step).dot(change) / change.length_squared();
    // What is not a number stays so, and the report of the step says it.
    let rate = frame.map(along).filter(|along| *along < 1.0 / step).map_or(1.0 / step, |along| along.max(0.0));
    velocities.set(particle, velocity + change * rate);
    change * rate
}

/// Sums of M (V - frame) C and M C C.
struct Products<'a> {
    velocities: &'a [f32],
    corrections: &'a [f32],
    masses: &'a [f32],
    frame: f32,
}

impl WithSimd for Products<'_> {
    type Output = [f64; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [f64; 2] {
        let Self { velocities, corrections, masses, frame } = self;
        let mut sums = [0.0; 2];
        let blocks = velocities.chunks(BLOCK).zip(corrections.chunks(BLOCK)).zip(masses.chunks(BLOCK));
        for ((velocities, corrections), masses) in blocks {
            let (mut along, mut square) = ([0.0_f32; LANES], [0.0_f32; LANES]);
            let lines = velocities.chunks(LANES).zip(corrections.chunks(LANES)).zip(masses.chunks(LANES));
            for ((velocities, corrections), masses) in lines {
                for (lane, ((v, c), m)) in velocities.iter().zip(corrections).zip(masses).enumerate() {
                    let weighted = c * m;
                    along[lane] += (v - frame) * weighted;
                    square[lane] += c * weighted;
                }
            }
            for lane in 0..LANES {
                sums[0] += f64::from(along[lane]);
                sums[1] += f64::from(square[lane]);
            }
        }
        sums
    }
}
