//! The backward differences of second order (Choi & Ko, *Stable but responsive cloth*, 2002, section 4), linearised.
//!
//! D and E are what the last step added to X and V, r is this step's length over the last one's. With a = r^2 / (1 + 2 r) and
//! b = (1 + r) / (1 + 2 r) h a step is `V' = V + a E + F(X', V') b / M`, `X' = X + a D + V' b`. Among equal steps a = 1/3 and
//! b = 2 h / 3. The method has order 2 and is stable for springs, bending and dampers at any step. It damps what is slower than the
//! step much less than backward Euler does.
//!
//! D and E are part of the state. Both are zero at the start, and where a state was set. Without them, and where steps grow too fast, a
//! step is one of backward Euler, `V' = V + F(X', V') h / M`, `X' = X + V' h`.
//!
//! *Where the forces are linear.* Springs, bending and dampers are linear around the beginning of the step, as in the paper. Order 2
//! needs exact derivatives there, and those of compressed springs are not exact. (Around what the last step points to, inexact ones
//! would do, but stiff cloth in long steps then gains energy.) What acts from outside is taken where the last step points to.
//!
//! *Filters.* E is what forces added. A plain V - V_before would carry a third of what a filter stops into the next step, as a
//! bounce.

use super::{LinearSystem, Method, Step};
use crate::forces::{self, Forces};
use crate::geometry::{Pool, Vectors};
use crate::model::Model;
use crate::state::{Moment, Past, State};

/// A linear system for each cloth.
pub(super) struct Bdf2 {
    systems: Vec<LinearSystem>,
    /// Where the last step points to [m].
    ahead: Vectors,
    /// With which velocities it does, and with which ones everything would go on [m/s].
    drift: Vectors,
}

/// Steps may not grow faster than this from one to the next, or the method starts anew: beyond 1 + sqrt(2) it is not stable [1].
const FASTEST_GROWTH: f64 = 2.0;

/// How much the last step counts, and b [s].
struct Weights {
    last: f32,
    reach: f64,
    /// The step as a part of the last one [1].
    ratio: f32,
}

impl Weights {
    /// For a step of `length` seconds after the last one.
    fn new(past: &Past, length: f64) -> Self {
        let ratio = length / past.length;
        if past.is_blank() || !(0.0..=FASTEST_GROWTH).contains(&ratio) {
            return Self { last: 0.0, reach: length, ratio: 1.0 };
        }
        let sum = 1.0 + 2.0 * ratio;
        Self { last: (ratio * ratio / sum) as f32, reach: (1.0 + ratio) / sum * length, ratio: ratio as f32 }
    }
}

impl Bdf2 {
    pub fn new(model: &Model) -> Self {
        let zeros = || Vectors::zeros(model.particle_count());
        let systems = model.cloths.iter().map(|cloth| LinearSystem::new(model, cloth)).collect();
        Self { systems, ahead: zeros(), drift: zeros() }
    }
}

impl Method for Bdf2 {
    fn propose(&mut self, step: Step<'_>, forces: &mut Forces, pool: &Pool) -> u32 {
        let Step { stride, state, ends } = step;
        let (all, length, start) = (0..stride.model.particle_count(), stride.plan.length, state.time());
        let weights = Weights::new(&state.past, length);
        let State { origins, positions, velocities, past: Past { displacements, gains, .. }, .. } = state;
        let Self { systems, ahead, drift } = self;
        // Where the last step points to.
        ahead.set_scaled(all.clone(), positions, velocities, length as f32, pool);
        drift.set_scaled(all.clone(), velocities, gains, weights.ratio, pool);
        let outside = Moment { origins, positions: ahead, velocities: drift, time: start + length };
        forces::inside_and_outside(stride, Moment { origins, positions, velocities, time: start }, outside, forces, pool);
        // (D a + V b) / b: how fast everything would go on.
        drift.set_scaled(all.clone(), velocities, displacements, weights.last / weights.reach as f32, pool);
        let mut passes = 1;
        for system in systems {
            system.look(positions, weights.reach, pool);
            let gain = f64::from(weights.last) / weights.reach;
            let right = |own: &LinearSystem, particle| {
                own.force(forces, particle) + own.momentum(gains, particle) * gain + own.pull_of(drift, particle)
            };
            passes += system.solve(right, pool);
            // The change itself: what single precision leaves of the sum would be remembered.
            system.write_changes(gains, pool);
        }
        velocities.add_scaled(all.clone(), gains, 1.0, pool);
        drift.add_scaled(all.clone(), gains, 1.0, pool);
        ends.set_scaled(all, positions, drift, weights.reach as f32, pool);
        passes
    }
}
