//! Velocities of the motion, as users see them.
//!
//! Between two kicks a step of constant acceleration A moves a particle by D = (V_0 + V_1) h / 2, V_0 and V_1 being its velocities
//! before and after. So the velocity after it is `D / h + (V_1 - V_0) / 2`: how fast the particle really went, and half of what the
//! step added. Without a filter that is V_1 itself. A filter adds C to D and C / h to V, however: its impulse lies wholly before
//! the end of the step, while that of the forces is divided there. What hangs at rest has V = g h / 2, but neither moves nor gains
//! (docs/equations.md, "Velocities of the motion").

use glam::{DVec3, Vec3};
use pulp::{Simd, WithSimd};

use crate::geometry::{Pool, Vectors, arch};
use crate::model::{ClothRange, Model};
use crate::scene::IntegratorKind;
use crate::schedule::Stride;
use crate::state::State;

/// So many roundings of a coordinate a step may add up to, seen from the centre of mass.
const ROUNDINGS: f32 = 8.0;

/// What hangs from something, and can touch nothing, gains no more in half a step than this part of how fast it went: from rest it gains as much
/// as that. Where V of light particles beside a pin turns round in every step, half of what the step added is no motion.
const LARGEST_GAIN: f32 = 1.001;

/// Who tells them.
pub(super) struct Motion {
    /// The cloths that nothing holds.
    free: Vec<usize>,
    /// V_0 [m/s]; empty where V is the velocity of the motion. Until the step is over, the state keeps how it moved before.
    before: Vectors,
}

impl Motion {
    pub fn new(model: &Model) -> Self {
        let is_free = |cloth: &ClothRange| cloth.particles().all(|particle| model.particles.inverse_mass[particle] > 0.0);
        let apart = model.solver.tells_motion_apart();
        let free = model.cloths.iter().enumerate().filter(|(_, cloth)| apart && is_free(cloth));
        let count = if apart { model.particle_count() } else { 0 };
        Self { free: free.map(|(index, _)| index).collect(), before: Vectors::zeros(count) }
    }

    /// Takes down V_0; what is held has the velocity of its path already, so that it keeps that.
    pub fn note(&mut self, state: &State, pool: &Pool) {
        if !self.before.is_empty() {
            self.before.copy_on(&state.velocities, pool);
        }
    }

    /// Takes what someone outside gave a particle besides for its own from the start of the step on [m/s].
    pub fn push(&mut self, particle: usize, by: Vec3) {
        if !self.before.is_empty() {
            self.before.set(particle, self.before.get(particle) + by);
        }
    }

    /// Tells the velocities after a step from `starts` [m].
    pub fn tell(&self, stride: Stride<'_>, state: &mut State, starts: &Vectors, pool: &Pool) {
        let Stride { model, plan, .. } = stride;
        let State { positions, velocities, motion, .. } = state;
        if motion.is_empty() {
            return;
        }
        let step = plan.length as f32;
        for (index, cloth) in model.cloths.iter().enumerate() {
            // An undivided step of the Euler method goes by V h: at rest V is zero, and in free fall it is exact.
            let undivided = model.solver.integrator == IntegratorKind::Euler && plan.of(cloth).parts() == 1;
            let is_bounded = !model.contact.is_on && !self.free.contains(&index);
            let bound = if is_bounded { LARGEST_GAIN } else { f32::INFINITY };
            motion.for_each_chunk_of(cloth.particles(), pool, |chunk| {
                let run = chunk.first..chunk.first + chunk.x.len();
                let [before, after, starts, ends] =
                    [&self.before, velocities, starts, positions].map(|all| all.columns().map(|column| &column[run.clone()]));
                let columns = [chunk.x, chunk.y, chunk.z];
                if undivided {
                    columns.into_iter().zip(after).for_each(|(column, after)| column.copy_from_slice(after));
                } else {
                    arch().dispatch(Tell { columns, starts, ends, before, after, step, bound });
                }
            });
        }
        for &cloth in &self.free {
            keep_momentum(model, &model.cloths[cloth], (positions, velocities), motion, step, pool);
        }
    }
}

/// Places are rounded one by one, and what single precision leaves of their differences has a momentum that is not there. A free
/// cloth has that of V, which is kept with care; its velocities are shifted by what is missing, if rounding explains it.
fn keep_momentum(
    model: &Model,
    cloth: &ClothRange,
    (positions, velocities): (&Vectors, &Vectors),
    motion: &mut Vectors,
    step: f32,
    pool: &Pool,
) {
    let (mut missing, mut mass) = (DVec3::ZERO, 0.0);
    for particle in cloth.particles() {
        let own = f64::from(model.particles.mass[particle]);
        missing += (velocities.get(particle).as_dvec3() - motion.get(particle).as_dvec3()) * own;
        mass += own;
    }
    let shift: Vec3 = (missing / mass).as_vec3();
    // Also false where it is no number.
    if shift.abs().max_element() <= ROUNDINGS * f32::EPSILON * positions.reach(cloth.particles(), pool) / step {
        motion.for_each_chunk_of(cloth.particles(), pool, |chunk| chunk.map(|_, velocity| velocity + shift));
    }
}

/// `(ends - starts) / step + (after - before) / 2`, the latter no more than `bound` times the former.
struct Tell<'a> {
    columns: [&'a mut [f32]; 3],
    starts: [&'a [f32]; 3],
    ends: [&'a [f32]; 3],
    before: [&'a [f32]; 3],
    after: [&'a [f32]; 3],
    step: f32,
    bound: f32,
}

impl WithSimd for Tell<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { columns: [x, y, z], starts, ends, before, after, step, bound } = self;
        let count = x.len();
        let (y, z) = (&mut y[..count], &mut z[..count]);
        let [starts, ends, before, after] = [starts, ends, before, after].map(|all| all.map(|column| &column[..count]));
        for index in 0..count {
            let mean: [f32; 3] = std::array::from_fn(|axis| (ends[axis][index] - starts[axis][index]) / step);
            let gain: [f32; 3] = std::array::from_fn(|axis| (after[axis][index] - before[axis][index]) * 0.5);
            let [of_mean, of_gain] = [mean, gain].map(|[x, y, z]| x * x + y * y + z * z);
            let most = bound * bound * of_mean;
            let part = if of_gain > most { (most / of_gain).sqrt() } else { 1.0 };
            (x[index], y[index], z[index]) = (mean[0] + part * gain[0], mean[1] + part * gain[1], mean[2] + part * gain[2]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The velocity that is told of a particle that goes so far along x in a step of 1/64 s, V being this before and after.
    fn told(way: f32, before: f32, after: f32, bound: f32) -> f32 {
        let (starts, ends, before, after) = ([0.0], [way], [before], [after]);
        let (mut x, mut y, mut z) = ([9.0], [9.0], [9.0]);
        let still: &[f32] = &[0.0];
        arch().dispatch(Tell {
            columns: [&mut x, &mut y, &mut z],
            starts: [&starts, still, still],
            ends: [&ends, still, still],
            before: [&before, still, still],
            after: [&after, still, still],
            step: 1.0 / 64.0,
            bound,
        });
        assert_eq!([y, z], [[0.0]; 2]);
        x[0]
    }

    #[test]
    fn what_stands_still_has_no_velocity_however_v_turns_round() {
        assert_eq!(told(0.0, 8.0, -8.0, LARGEST_GAIN), 0.0);
        assert_eq!(told(0.0, 8.0, -8.0, f32::INFINITY), -8.0);
        assert!((told(1e-3, 8.0, -8.0, LARGEST_GAIN)).abs() < 1e-3);
    }

    #[test]
    fn what_is_accelerated_steadily_has_the_velocity_of_the_end_of_the_step() {
        let (acceleration, step) = (-9.81, 1.0 / 64.0);
        for start in [0.0, 1.0, -3.0] {
            let end = start + acceleration * step;
            let told = told((start + end) / 2.0 * step, start, end, LARGEST_GAIN);
            assert!((told - end).abs() < 1e-6, "{told} instead of {end}");
        }
    }
}
