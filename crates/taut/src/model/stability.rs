//! The longest stable step of each integrator (docs/methods/integrators.md, "Step").
//!
//! Vibrations x'' = -w^2 x - g x' are bounded by Gershgorin's theorem on the spring matrix, in every configuration the cloth
//! can take: w^2 and g are at most the largest d_u/m_u + d_v/m_v over the springs uv, d being the sum of the constants at a
//! particle (docs/equations.md, "Step").

use super::{Bending, Particles, Springs};
use crate::geometry::cbrt;
use crate::scene::{FilterKind, IntegratorKind, Solver};

/// Where a method lets undamped vibrations grow however short the step is, they may grow by a factor e in this time [s].
pub(super) const GROWTH_TIME: f64 = 10.0;

/// The fastest rates in a model.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rates {
    /// w^2 of the springs that act as forces, and of bending [1/s^2].
    pub frequency_squared: f64,
    /// w^2 of all springs, those that are left to the filter as well [1/s^2].
    pub resolved: f64,
    /// w^2 of bending alone [1/s^2].
    pub bending: f64,
    /// g of dampers [1/s].
    pub damping: f64,
    /// g of the air [1/s].
    pub drag: f64,
    /// Every vibration has at least this g / w^2 from dampers [s] ..
    pub least_damping: f64,
    /// .. and this g from the air [1/s].
    pub least_drag: f64,
}

impl Rates {
    /// Of springs, bending and dampers; `drag` is the largest rate at which the air slows a particle [1/s].
    pub fn new(particles: &Particles, springs: &Springs, bending: &Bending, drag: f64) -> Self {
        let largest = |constants: &[f32]| largest_rate(particles, springs, constants);
        // A spring with a curve has a steepest slope and no k_s.
        let with_curves =
            |constants: &[f32]| constants.iter().zip(&springs.steepest).map(|(k, slope)| k + slope).collect::<Vec<f32>>();
        let forces = with_curves(&springs.force_stiffness);
        let acting = forces.iter().zip(&springs.damping).filter(|(stiffness, _)| **stiffness > 0.0);
        let ratios = acting.map(|(&stiffness, &damping)| f64::from(damping) / f64::from(stiffness));
        let free = particles.air_drag.iter().zip(&particles.inverse_mass).filter(|(_, weight)| **weight > 0.0);
        // The largest eigenvalue of a sum is at most the sum of the largest ones.
        let bends = bending.largest_rate(particles);
        Self {
            frequency_squared: largest(&forces) + bends,
            resolved: largest(&with_curves(&springs.stiffness)) + bends,
            bending: bends,
            damping: largest(&springs.damping),
            drag,
            least_damping: if bending.is_empty() { finite_least(ratios) } else { 0.0 },
            least_drag: finite_least(free.map(|(&drag, _)| f64::from(drag))),
        }
    }
}

/// The least number; 0 if there is none.
fn finite_least(numbers: impl Iterator<Item = f64>) -> f64 {
    let least = numbers.fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

/// The largest stable step [s] of the velocity-first Euler method for modes with w^2 and g; infinite if nothing acts.
///
/// It stays bounded if and only if h^2 w^2 + 2 h g < 4, that is h < 4 / (g + sqrt(g^2 + 4 w^2)).
pub(super) fn of_euler(frequency_squared: f64, rate: f64) -> f64 {
    4.0 / (rate + (rate * rate + 4.0 * frequency_squared).sqrt())
}

/// The largest stable step [s] of the solver's integrator, all forces being taken at every step.
pub(super) fn bound(solver: &Solver, rates: &Rates) -> f64 {
    let (square, rate) = (rates.frequency_squared, rates.damping + rates.drag);
    let frequency = square.sqrt();
    match solver.integrator {
        IntegratorKind::Euler => of_euler(square, rate),
        // |1 + z| <= exp(h / T) for both z of a mode if h w^2 <= g + 2 / T and h g <= 2.
        IntegratorKind::ForwardEuler => {
            let least = rates.least_drag + 2.0 / GROWTH_TIME;
            (rates.least_damping + least / square).min(2.0 / rate)
        }
        // |1 + z + z^2 / 2| <= exp(h / T) if h^3 w^4 <= 4 g + 8 / T, h g <= 2 and h w <= 1.4.
        IntegratorKind::Midpoint => {
            let least = rates.least_damping * square + rates.least_drag;
            cbrt((4.0 * least + 8.0 / GROWTH_TIME) / (square * square)).min(2.0 / rate).min(1.4 / frequency)
        }
        // The region of stability holds the left half of a disc of radius 2.61, and 2.82 of the imaginary axis.
        IntegratorKind::Rk4 => {
            if rate > 0.0 {
                2.61 / frequency.max(rate)
            } else {
                2.82 / frequency
            }
        }
        IntegratorKind::Verlet if solver.filter == FilterKind::None => of_euler(square, rate),
        // What a filter takes back in every step is multiplied by -h^2 w^2 / 2: bounded for h^2 w^2 + h g < 2.
        IntegratorKind::Verlet => 4.0 / (rate + (rate * rate + 8.0 * square).sqrt()),
        // Only the air is explicit.
        IntegratorKind::ImplicitEuler => 2.0 / rates.drag,
        // And extrapolated: 3/2 + 2 + 1/2 = 3 h g at z = -1.
        IntegratorKind::Bdf2 => 4.0 / (3.0 * rates.drag),
    }
}

fn largest_rate(particles: &Particles, springs: &Springs, constants: &[f32]) -> f64 {
    let mut sums = vec![0.0_f64; particles.mass.len()];
    for (ends, &constant) in springs.ends.iter().zip(constants) {
        for &end in ends {
            sums[end as usize] += f64::from(constant);
        }
    }
    let rate = |end: u32| sums[end as usize] * f64::from(particles.inverse_mass[end as usize]);
    springs
        .ends
        .iter()
        .zip(constants)
        .filter(|(_, constant)| **constant > 0.0)
        .map(|(&[u, v], _)| rate(u) + rate(v))
        .fold(0.0, f64::max)
}
