//! How fast a model can vibrate and how fast the air slows it.
//!
//! Gershgorin's theorem on the spring matrix bounds vibrations x'' = -w^2 x - g x', in every configuration the cloth can take. w^2
//! and g are at most the largest d_u/m_u + d_v/m_v over the springs uv, d being the sum of the constants at a particle
//! (docs/equations.md, "Step").

use super::{Bending, ClothRange, LevelRate, Particles, Springs};

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
        let largest = |constants: &[f32]| largest_rates(particles, springs, constants).map(|(_, rate)| rate).fold(0.0, f64::max);
        let forces = with_curves(springs, &springs.force_stiffness);
        let acting = forces.iter().zip(&springs.damping).filter(|(stiffness, _)| **stiffness > 0.0);
        let ratios = acting.map(|(&stiffness, &damping)| f64::from(damping) / f64::from(stiffness));
        let free = particles.air_drag.iter().zip(&particles.inverse_mass).filter(|(_, weight)| **weight > 0.0);
        // The largest eigenvalue of a sum is at most the sum of the largest ones.
        let bends = bending.largest_rate(particles, 0..particles.mass.len()) + bending.curved.largest_rate();
        Self {
            frequency_squared: largest(&forces) + bends,
            resolved: largest(&with_curves(springs, &springs.stiffness)) + bends,
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

/// How fast each cloth can vibrate, and the w^2 of its bending alone [1/s^2].
pub(super) fn of_cloths(
    cloths: &[ClothRange],
    particles: &Particles,
    springs: &Springs,
    bending: &Bending,
) -> Vec<(LevelRate, f64)> {
    let largest = |constants: &[f32]| {
        let mut rates = vec![0.0_f64; cloths.len()];
        for (particle, rate) in largest_rates(particles, springs, constants) {
            let cloth = cloths.partition_point(|cloth| cloth.particles().end <= particle as usize);
            rates[cloth] = rates[cloth].max(rate);
        }
        rates
    };
    let (forces, dampers) = (largest(&with_curves(springs, &springs.force_stiffness)), largest(&springs.damping));
    let of_cloth = |(cloth, (frequency_squared, damping)): (&ClothRange, (f64, f64))| {
        let curved = if cloth.curvatures.is_empty() { 0.0 } else { bending.curved.largest_rate() };
        let bends = bending.largest_rate(particles, cloth.particles()) + curved;
        (LevelRate { frequency_squared: frequency_squared + bends, damping, moving: 1.0 }, bends)
    };
    cloths.iter().zip(forces.into_iter().zip(dampers)).map(of_cloth).collect()
}

/// A spring with a curve has a steepest slope and no k_s.
fn with_curves(springs: &Springs, constants: &[f32]) -> Vec<f32> {
    constants.iter().zip(&springs.steepest).map(|(k, slope)| k + slope).collect()
}

/// An end of each spring and its rate.
fn largest_rates<'a>(
    particles: &'a Particles,
    springs: &'a Springs,
    constants: &'a [f32],
) -> impl Iterator<Item = (u32, f64)> + use<'a> {
    let mut sums = vec![0.0_f64; particles.mass.len()];
    for (ends, &constant) in springs.ends.iter().zip(constants) {
        for &end in ends {
            sums[end as usize] += f64::from(constant);
        }
    }
    let rate = move |end: u32| sums[end as usize] * f64::from(particles.inverse_mass[end as usize]);
    let acting = springs.ends.iter().zip(constants).filter(|(_, constant)| **constant > 0.0);
    acting.map(move |(&[u, v], _)| (u, rate(u) + rate(v)))
}
