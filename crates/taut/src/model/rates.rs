//! How fast a model can vibrate and how fast the air slows it.
//!
//! Vibrations x'' = -w^2 x - g x' are bounded by Gershgorin's theorem on the spring matrix, in every configuration the cloth
//! can take: w^2 and g are at most the largest d_u/m_u + d_v/m_v over the springs uv, d being the sum of the constants at a
//! particle (docs/equations.md, "Step").

use super::{Bending, Particles, Springs};

/// The fastest rates in a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates {
    /// w^2 of the springs that act as forces, and of bending [1/s^2].
    pub frequency_squared: f64,
    /// w^2 of all springs, those that are left to the filter as well [1/s^2].
    pub resolved: f64,
    /// w^2 of bending alone [1/s^2].
    pub bending: f64,
    /// g of dampers [1/s].
    pub damping: f64,
    /// g of air at rest [1/s] ..
    pub still_air: f64,
    /// .. and what wind adds to it for each kg/m^3 of its density and m/s of its speed [m^2/kg]: without lift, and with it.
    pub wind: [f64; 2],
    /// Every vibration has at least this g / w^2 from dampers [s] ..
    pub least_damping: f64,
    /// .. and this g from the air [1/s].
    pub least_drag: f64,
}

impl Rates {
    /// Of springs, bending and dampers; see the fields for `still_air` and `wind`.
    pub(super) fn new(particles: &Particles, springs: &Springs, bending: &Bending, still_air: f64, wind: [f64; 2]) -> Self {
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
            still_air,
            wind,
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
