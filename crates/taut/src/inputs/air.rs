//! The moving air, ready for evaluation.

use glam::{DVec3, Vec3};

use super::Flows;
use crate::geometry::{exp2, power};
use crate::scene::{FlowElement, Wind, WindLaw, WindModel};

/// One travelling sine wave of the gusts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// Velocity amplitude [m/s].
    pub amplitude: Vec3,
    /// Turns per metre along each axis [1/m].
    pub turns_per_metre: Vec3,
    /// Turns per second [1/s].
    pub turns_per_second: f64,
    /// Turns at the origin at the start [1].
    pub phase: f64,
}

/// Octaves of gusts; each has half the period of the one before.
pub const OCTAVES: usize = 4;

/// The moving air.
#[derive(Debug, Clone, PartialEq)]
pub struct Air {
    /// Mean velocity [m/s].
    pub velocity: Vec3,
    /// Gusts on top of it.
    pub waves: Vec<Wave>,
    /// Vortices, sources and sinks.
    pub flows: Flows,
    /// Where the force is evaluated.
    pub model: WindModel,
    /// How it follows from the relative wind.
    pub law: WindLaw,
    /// rho [kg/m^3].
    pub density: f32,
    /// The air is nowhere and never faster than this [m/s].
    pub greatest_speed: f64,
}

impl Air {
    /// Prepares a wind.
    #[must_use]
    pub fn new(wind: &Wind) -> Self {
        let (flows, uniform, fastest) = Flows::new(wind.elements.iter().filter_map(FlowElement::flow));
        let velocity = DVec3::from_array(wind.velocity) + uniform;
        let waves = wind.gust.as_ref().map_or_else(Vec::new, |gust| waves(velocity, gust.strength, gust.period, gust.seed));
        let gusts: f64 = waves.iter().map(|wave| f64::from(wave.amplitude.length())).sum();
        Self {
            velocity: velocity.as_vec3(),
            waves,
            flows,
            model: wind.model,
            law: wind.law,
            density: wind.density as f32,
            greatest_speed: velocity.length() + gusts + fastest,
        }
    }
}

/// Waves carried along by the mean wind (Taylor's frozen turbulence: a gust of period T is |W| T long), their
/// amplitudes falling as k^(-1/3) (Kolmogorov's spectrum), directions and phases drawn from the seed.
fn waves(mean: DVec3, strength: f64, period: f64, seed: u64) -> Vec<Wave> {
    let speed = mean.length();
    if speed == 0.0 || strength == 0.0 {
        return Vec::new();
    }
    let along = mean / speed;
    let share = |octave: usize| exp2(-(octave as f64) / 3.0);
    // Root mean square of a unit sine is 1/sqrt(2); independent waves add in squares.
    let square: f64 = (0..OCTAVES).map(|octave| 0.5 * power(share(octave), 2)).sum();
    let mut random = SplitMix(seed);
    (0..OCTAVES)
        .map(|octave| {
            let period = period / exp2(octave as f64) * (0.9 + 0.2 * random.unit());
            let travel = (along + 0.4 * random.direction()).normalize();
            let swing = (along + 0.8 * random.direction()).normalize();
            Wave {
                amplitude: (swing * (speed * strength * share(octave) / square.sqrt())).as_vec3(),
                turns_per_metre: (travel / (speed * period)).as_vec3(),
                turns_per_second: 1.0 / period,
                phase: random.unit(),
            }
        })
        .collect()
}

/// Steele, Lea & Flood 2014: a seeded sequence that is the same everywhere.
struct SplitMix(u64);

impl SplitMix {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    /// In [0, 1).
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A unit vector (Marsaglia's rejection from the cube).
    fn direction(&mut self) -> DVec3 {
        loop {
            let point = DVec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - DVec3::ONE;
            if (1e-3..=1.0).contains(&point.length_squared()) {
                return point.normalize();
            }
        }
    }
}
