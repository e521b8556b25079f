//! The moving air, ready for evaluation.

use glam::{DVec3, Vec3};

use super::{Flows, Track};
use crate::geometry::{exp2, power};
use crate::scene::{FlowElement, Keyframe, Wind, WindLaw, WindModel};

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

/// Slower wind [m/s] has no gusts: nobody could see them, and waves that travel so slowly are shorter than any cloth.
const SLOWEST: f64 = 1e-6;

/// The moving air.
#[derive(Debug, Clone, PartialEq)]
pub struct Air {
    /// Mean velocity [m/s].
    velocity: Track,
    /// That with which the gusts have their full strength [m/s], if the mean changes.
    reference: Option<f64>,
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
        let keyframes =
            wind.keyframes.iter().map(|&Keyframe(time, value)| Keyframe(time, (DVec3::from_array(value) + uniform).into()));
        let keyframes: Vec<Keyframe> = keyframes.collect();
        let all = keyframes.iter().map(|key| DVec3::from_array(key.1));
        // Straight lines are nowhere longer than at their ends.
        let strongest = all.fold(velocity, |one, other| if other.length() > one.length() { other } else { one });
        let waves = wind.gust.as_ref().map_or_else(Vec::new, |gust| waves(strongest, gust.strength, gust.period, gust.seed));
        let gusts: f64 = waves.iter().map(|wave| f64::from(wave.amplitude.length())).sum();
        Self {
            reference: (!keyframes.is_empty()).then_some(strongest.length()),
            velocity: Track::new(velocity, &keyframes),
            waves,
            flows,
            model: wind.model,
            law: wind.law,
            density: wind.density as f32,
            greatest_speed: strongest.length() + gusts + fastest,
        }
    }

    /// Mean velocity at `time` [m/s].
    #[must_use]
    pub fn velocity(&self, time: f64) -> Vec3 {
        self.velocity.at(time).as_vec3()
    }

    /// The part of their full strength that gusts have at `time` [1].
    #[must_use]
    pub fn gusts(&self, time: f64) -> f32 {
        match self.reference {
            Some(reference) if reference > 0.0 => (self.velocity.at(time).length() / reference) as f32,
            _ => 1.0,
        }
    }
}

/// Waves carried along by the mean wind (Taylor's frozen turbulence: a gust of period T is |W| T long). Their amplitudes fall as
/// k^(-1/3) (Kolmogorov's spectrum). Their directions and phases are drawn from the seed.
fn waves(mean: DVec3, strength: f64, period: f64, seed: u64) -> Vec<Wave> {
    let speed = mean.length();
    if speed < SLOWEST || strength == 0.0 {
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
