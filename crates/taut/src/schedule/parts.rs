//! A step of some length, planned: parts of the springs, stages of the dampers.

use super::pace;
use super::stability::of_euler;
use crate::geometry::power;
use crate::model::{Borne, ClothRange, LevelRate, Model};
use crate::scene::{FilterKind, IntegratorKind, Solver};

/// Part of the bound that plans use: compression turns springs soft, impulses of a filter do not count.
pub(super) const SAFETY: f64 = 0.9;
/// The longest part of a step that springs with scaled masses take, as a part of the time in which the cloth moves by its size [1].
/// Vibrations that are slower than this are as they should be. It is 1/180 s for a cloth of 1 m.
const SCALED_PART: f64 = 0.0174;
/// How much larger the largest eigenvalue of dampers with scaled masses may be than that of each level, with its share.
const OVERLAP_OF_DAMPERS: f64 = 1.25;

/// With scaled masses a step has at least so many parts, in which springs look ahead. The filter takes energy by the masses as they are, and
/// may so add to that by scaled ones. In a single part, where springs do not look ahead, nothing takes that back: heavy weights bounced for ever.
const LEAST_SCALED: f64 = 2.0;
/// Masses are not scaled unless that takes so many times fewer parts, of a grid and of a mesh, where a part with scaled masses costs 1.7
/// plain ones.
const WORTH: f64 = 2.0;
const WORTH_ON_MESHES: f64 = 2.5;

/// h g of the fastest mode, at least, where a filter looks at several parts of a step together [1]. The filter takes back the
/// displacement D of a step, and D / h from the velocity. A vibration of frequency w leaves the step with V cos(w h) and
/// D = V sin(w h) / w. So it is multiplied by cos(w h) - sin(w h) / (w h), which is up to 1.063: undamped, it would grow.
const LEAST_DECAY: f64 = 1.2;
/// .. and how far springs look ahead, at least, as a part of the step [1]. Where the fastest mode is much faster than the step, those with
/// `w h` of 2 to 5 would lose too little. Then springs take more parts, up to so many times as many.
const LEAST_AHEAD: f64 = 0.0546;
const MORE_PARTS: f64 = 4.0;

/// A step of some length.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Plan {
    /// h [s].
    pub length: f64,
    /// How each cloth takes it.
    pub cloths: Vec<ClothPlan>,
}

/// How a cloth takes a step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ClothPlan {
    /// The step as a part of the one that "auto" would take for this cloth alone if it were not weighted at a point [1].
    pub relative: f64,
    /// Equal parts of the step in which springs are followed before the filter looks at where they lead.
    pub spring_steps: u32,
    /// How far ahead of each part its springs look [s]: at X + V t instead of X, which damps what is faster than the step.
    pub springs_ahead: f64,
    /// Stages of the damping of the step.
    pub damping_stages: u32,
    /// How it takes the step, if with scaled masses.
    pub scaled: Option<ScaledTiming>,
}

/// A step of springs and dampers with selectively scaled masses: in fewer parts than the fastest vibration needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScaledTiming {
    /// Equal parts of the step.
    pub parts: u32,
    /// How far ahead of each part its springs look [s].
    pub springs_ahead: f64,
    /// The w^2 that a part bears from each level [1/s^2].
    pub frequency_squared: f64,
    /// The g that a step bears from each level [1/s]; none where dampers take it in stages, with the masses as they are.
    pub damping: Option<f64>,
}

impl Plan {
    /// A step of `length` seconds. Most filters look at every step of the springs. The coarse-to-fine filter takes longer steps of
    /// the Euler method, within which springs and dampers go their own, shorter ones.
    pub(super) fn new(model: &Model, length: f64, unhurried: &[f64], pace: &[f64]) -> Self {
        let divided = is_divided(&model.solver);
        let of_cloth = |(cloth, unhurried): (&ClothRange, &f64)| {
            let relative = length / unhurried;
            if divided {
                ClothPlan { relative, ..ClothPlan::divided(cloth, length, pace[cloth.index]) }
            } else {
                let damping_stages = u32::from(model.rates.damping > 0.0);
                ClothPlan { relative, spring_steps: 1, damping_stages, ..ClothPlan::default() }
            }
        };
        Self { length, cloths: model.cloths.iter().zip(unhurried).map(of_cloth).collect() }
    }

    /// How a cloth takes the step.
    #[must_use]
    pub fn of(&self, cloth: &ClothRange) -> &ClothPlan {
        &self.cloths[cloth.index]
    }

    /// The step as a part of the automatic one of a cloth, at most 1 [1]; 1 where nothing vibrates.
    pub(crate) fn part_of_automatic(&self, cloth: &ClothRange) -> f64 {
        if cloth.rates.is_empty() { 1.0 } else { self.of(cloth).relative.min(1.0) }
    }
}

impl ClothPlan {
    fn divided(cloth: &ClothRange, length: f64, pace: f64) -> Self {
        let steps = spring_steps(length, &cloth.fastest);
        let LevelRate { frequency_squared, damping, .. } = cloth.fastest;
        // What has no loops is solved exactly, velocities as well.
        let has_loops = cloth.springs.len() >= cloth.count;
        let (spring_steps, springs_ahead) = if has_loops { calmed(length, steps, frequency_squared, damping) } else { steps };
        let rate = length * cloth.fastest.damping / SAFETY;
        // s stages are stable up to h g = s^2 + s.
        let damping_stages = ((rate + 0.25).sqrt() - 0.5).ceil().max(0.0) as u32;
        let scaled = scaled(length, steps.0, cloth, pace);
        Self { relative: 1.0, spring_steps: spring_steps as u32, springs_ahead, damping_stages, scaled }
    }

    /// The parts in which springs take the cloth through the step.
    #[must_use]
    pub fn parts(&self) -> u32 {
        self.scaled.map_or(self.spring_steps, |scaled| scaled.parts)
    }
}

/// Whether springs and dampers take the filter's step in parts.
pub(super) fn is_divided(solver: &Solver) -> bool {
    solver.filter == FilterKind::CoarseToFine && solver.integrator == IntegratorKind::Euler
}

/// How many parts of a step springs take as they are, and how far ahead they look [s].
pub(super) fn spring_steps(step_length: f64, rates: &LevelRate) -> (f64, f64) {
    let square = rates.frequency_squared;
    let undivided = step_length <= SAFETY * of_euler(square, 0.0);
    let ahead = if undivided || rates.damping * step_length >= LEAST_DECAY { 0.0 } else { LEAST_DECAY / step_length };
    let parts = (step_length / (SAFETY * of_euler(square, ahead))).ceil().max(1.0);
    (parts, if ahead > 0.0 { ahead / square } else { 0.0 })
}

/// Parts of the springs with scaled masses (docs/equations.md, "Scaled masses"). They are as few as three things allow: vibrations that
/// must be seen, those of the coarsest levels, whose masses are never scaled, and what is held. None if that is not much fewer than
/// `unscaled`. The cloth moves by its size in `pace` seconds.
pub(super) fn scaled(step_length: f64, unscaled: f64, cloth: &ClothRange, pace: f64) -> Option<ScaledTiming> {
    let (Borne { least, overlap, .. }, damping) = (cloth.borne, cloth.rates.last()?.damping);
    let mut parts = pace::parts(step_length, SCALED_PART * pace).max(LEAST_SCALED);
    if bears(step_length, parts) < overlap * least {
        // bears() solved for the parts.
        let (a, b, c) = (power(2.0 * SAFETY, 2), 2.0 * LEAST_DECAY, overlap * least * power(step_length, 2));
        parts = ((b + (b * b + 4.0 * a * c).sqrt()) / (2.0 * a)).ceil().max(LEAST_SCALED);
    }
    let frequency_squared = bears(step_length, parts);
    let worth = if cloth.lattice_of_levels().is_some() { WORTH } else { WORTH_ON_MESHES };
    (worth * parts <= unscaled).then(|| {
        let ahead = LEAST_DECAY / (step_length * frequency_squared);
        let (parts, springs_ahead) = calmed(step_length, (parts, ahead), frequency_squared, 0.0);
        ScaledTiming {
            parts: parts as u32,
            springs_ahead,
            frequency_squared: cloth.borne.of_each_level(frequency_squared),
            damping: Some(1.0 / (OVERLAP_OF_DAMPERS * step_length)).filter(|bears| damping <= *bears),
        }
    })
}

/// The parts of a step, and how far ahead springs look [s], that calm what is a little faster than the step as well; the fastest mode has
/// such a w^2 [1/s^2], and dampers take such a rate from it [1/s].
fn calmed(step_length: f64, (parts, ahead): (f64, f64), frequency_squared: f64, damping: f64) -> (f64, f64) {
    let least = LEAST_AHEAD * step_length;
    if parts == 1.0 || ahead.max(damping / frequency_squared) >= least {
        return (parts, ahead);
    }
    // h^2 w^2 + 2 h w^2 t < 4 with h = H / n.
    let (a, b, c) = (power(2.0 * SAFETY, 2), step_length * least * frequency_squared, power(step_length, 2) * frequency_squared);
    let more = ((b + (b * b + a * c).sqrt()) / a).ceil().min(MORE_PARTS * parts);
    let part = step_length / more;
    (more, least.min((a / frequency_squared - part * part) / (2.0 * part)))
}

/// The largest w^2 that so many parts of a step bear [1/s^2]: h^2 w^2 + 2 h g < 4 with g = 1.2 / H.
fn bears(step_length: f64, parts: f64) -> f64 {
    let part = step_length / parts;
    (power(2.0 * SAFETY, 2) - 2.0 * LEAST_DECAY / parts) / power(part, 2)
}
