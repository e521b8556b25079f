//! How long a step is, and in how many parts springs and dampers take it.

use super::stability::{self, GROWTH_TIME, Rates, of_euler};
use super::{ClothRange, LevelRate, ScaledTiming, Timing, shares};
use crate::geometry::{cbrt, power};
use crate::scene::{FilterKind, IntegratorKind, Scene, SceneError, Substeps};

/// Part of the bound that `"auto"` uses: compression turns springs soft, impulses of a filter do not count.
const SAFETY: f64 = 0.9;
/// Longest step that "auto" takes where stability does not bound it [s], for the sake of the motion.
const LONGEST: f64 = 1.0 / 60.0;
/// Under limits tighter than this [1] it shrinks with their cube root.
const ROOMY: f64 = 0.05;
/// Where a particle has a part s of the mass of a cloth, "auto" takes 1 + 28 s times as many steps: it throws the cloth about, and
/// single steps leave the motion. Measured (docs/decisions/coarse-to-fine.md).
const HURRY: f64 = 28.0;
/// The longest part of a step that springs with scaled masses take [s]: vibrations that are slower than this are as they should be.
const SCALED_PART: f64 = 1.0 / 180.0;
/// How much larger the largest eigenvalue of springs with scaled masses may be than that of each level, with its share.
const OVERLAP: f64 = 1.25;

/// The least part of its acceleration that an even load gives a cloth with scaled masses on the whole [1].
const SETS_OUT: f64 = 0.9;

/// Masses are not scaled unless that saves so many times the parts.
const WORTH: f64 = 2.0;

/// What does not scale masses, networks, has a longest step of ..
const LONGEST_UNSCALED: f64 = 1.0 / 120.0;
/// .. if the limit is at least this [1]. Under tighter limits vibrations of the springs reach the limit within a step, and a
/// filter that looks at the whole step only cannot stop them: one that takes back what many of them did leaves the cloth
/// pressed together. So the step shrinks with the root of the limit, ..
const ROOMY_UNSCALED: f64 = 0.1;
/// .. and has no more than so many parts of the springs [1], if the limit ..
const PARTS: f64 = 11.0;
/// .. is at most this [1]; the wider it is, the more the springs bear themselves.
const TIGHT: f64 = 0.05;

/// h g of the fastest mode, at least, where a filter looks at several parts of a step together [1]. It takes the displacement D
/// of a step back and D / h from the velocity. A vibration of frequency w leaves the step with V cos(w h) and D = V sin(w h) / w,
/// so that it is multiplied by cos(w h) - sin(w h) / (w h), which is up to 1.063: undamped, it would grow.
const CALM: f64 = 1.2;

/// More steps a frame than this are a mistake in the scene.
const MOST_STEPS: f64 = 100_000.0;

/// The step: chosen, or checked against its bound.
///
/// Most filters look at every step of the springs. The coarse-to-fine filter takes longer steps of the Euler method, within
/// which springs and dampers go their own, shorter ones; only the air bounds it.
pub(super) fn timing(scene: &Scene, rates: &Rates, cloths: &[ClothRange]) -> Result<Timing, SceneError> {
    let divided = is_divided(scene);
    let bound = if divided { of_euler(0.0, rates.drag) } else { stability::bound(&scene.solver, rates) };
    let frame = 1.0 / scene.fps;
    let longest = if divided { longest_divided(scene, rates, cloths, bound) } else { longest_whole(scene, rates, bound) };
    // A frame that is a whole number of longest steps but for rounding needs no further one.
    let steps = |longest: f64| (frame / longest * (1.0 - 1e-9)).ceil().max(1.0);
    let unhurried = if divided { frame / steps(longest) } else { longest_scaled(scene) };
    let enough = steps(if divided { longest / hurry(cloths) } else { longest });
    let substeps = match scene.solver.substeps {
        Substeps::Auto if enough > MOST_STEPS => {
            let problem = format!(
                "\"auto\" would need {enough} steps a frame (stable step {bound:.3e} s); lower stiffness, bending or damping{}",
                remedy(scene)
            );
            return Err(SceneError::at("solver.substeps", problem));
        }
        Substeps::Auto => enough as u32,
        Substeps::Count(count) => {
            let step = frame / f64::from(count);
            if step > bound && !scene.solver.force_step {
                let problem = format!(
                    "the step of {:.4} ms is over the stability bound of {:.4} ms (springs, bending, damping, drag and wind); \
                     use at least {enough}, or \"auto\", or set solver.force_step = true{}",
                    step * 1e3,
                    bound * 1e3,
                    remedy(scene)
                );
                return Err(SceneError::with_value("solver.substeps", count, problem));
            }
            count
        }
    };
    let step_length = frame / f64::from(substeps);
    if divided {
        return divide(Timing { substeps, step_length, unhurried, bound, ..Timing::default() }, rates, cloths);
    }
    let damping_stages = u32::from(rates.damping > 0.0);
    Ok(Timing { substeps, step_length, spring_steps: 1, damping_stages, unhurried, bound, ..Timing::default() })
}

/// What is to be said about an integrator that lets vibrations grow; nothing about others.
pub(super) fn caution(scene: &Scene, timing: &Timing) -> Option<String> {
    let name = growing(scene.solver.integrator)?;
    Some(format!(
        "solver.integrator = \"{name}\" lets every undamped vibration grow, however short the step; at its bound of {:.4} ms \
         the fastest one by a factor e in {GROWTH_TIME} s; \"rk4\", \"verlet\" and \"euler\" do not",
        timing.bound * 1e3
    ))
}

fn growing(integrator: IntegratorKind) -> Option<&'static str> {
    match integrator {
        IntegratorKind::ForwardEuler => Some("forward_euler"),
        IntegratorKind::Midpoint => Some("midpoint"),
        _ => None,
    }
}

/// More to say where a step is refused.
fn remedy(scene: &Scene) -> String {
    growing(scene.solver.integrator).map_or_else(String::new, |name| {
        format!(
            "; {name:?} lets undamped vibrations grow at any step, and this bound keeps them to a factor e in {GROWTH_TIME} s: \
             \"rk4\", \"verlet\" or \"euler\" take longer steps"
        )
    })
}

/// Whether springs and dampers take the filter's step in parts.
fn is_divided(scene: &Scene) -> bool {
    scene.solver.filter == FilterKind::CoarseToFine && scene.solver.integrator == IntegratorKind::Euler
}

/// The tightest strain limit [1].
fn tightest(scene: &Scene) -> f64 {
    scene.cloth.iter().map(|cloth| cloth.material().strain_limit).fold(1.0, f64::min)
}

/// The longest step of "auto" where masses can be scaled and the air does not bound it [s].
fn longest_scaled(scene: &Scene) -> f64 {
    LONGEST * cbrt(tightest(scene) / ROOMY).min(1.0)
}

/// The longest step of "auto" where it is divided further [s].
fn longest_divided(scene: &Scene, rates: &Rates, cloths: &[ClothRange], bound: f64) -> f64 {
    let limit = tightest(scene);
    let scales = |step: f64| {
        let (unscaled, _) = spring_steps(step, rates);
        unscaled <= PARTS || scaled(step, unscaled, cloths).is_some()
    };
    let with_scaling = longest_scaled(scene).min(SAFETY * bound);
    let longest = if cloths.iter().all(|cloth| !cloth.rates.is_empty()) && scales(with_scaling) {
        with_scaling
    } else {
        let spring_step = SAFETY * of_euler(rates.frequency_squared, 0.0);
        let parts = PARTS * power((limit / TIGHT).max(1.0), 2);
        let by_limit = (LONGEST_UNSCALED * (limit / ROOMY_UNSCALED).sqrt()).min(parts * spring_step);
        LONGEST_UNSCALED.min(by_limit.max(spring_step))
    };
    longest.min(SAFETY * bound)
}

/// How many times as many steps cloths take that are weighted at a point.
fn hurry(cloths: &[ClothRange]) -> f64 {
    let scaled = cloths.iter().filter(|cloth| !cloth.rates.is_empty());
    (1.0 + HURRY * scaled.map(|cloth| cloth.heaviest).fold(0.0, f64::max)).round()
}

/// The longest step of "auto" that all forces take whole [s].
fn longest_whole(scene: &Scene, rates: &Rates, bound: f64) -> f64 {
    let by_constraints = matches!(scene.solver.filter, FilterKind::Rods | FilterKind::FastProjection | FilterKind::Xpbd);
    let for_motion = by_constraints || scene.solver.integrator.is_implicit();
    let longest = if for_motion { LONGEST_UNSCALED.min(SAFETY * bound) } else { SAFETY * bound };
    if rates.resolved == rates.frequency_squared {
        return longest;
    }
    // One pass of "xpbd" carries a load one spring further, as a step of explicit springs does.
    longest.min(SAFETY * of_euler(rates.resolved, rates.damping + rates.drag))
}

/// Parts of the springs, and stages of the dampers.
fn divide(step: Timing, rates: &Rates, cloths: &[ClothRange]) -> Result<Timing, SceneError> {
    let Timing { substeps, step_length, .. } = step;
    let (spring_steps, springs_ahead) = spring_steps(step_length, rates);
    if spring_steps * f64::from(substeps) > MOST_STEPS {
        let problem = format!("springs would need {spring_steps} parts of each step; lower stiffness or bending");
        return Err(SceneError::at("solver.substeps", problem));
    }
    let rate = step_length * rates.damping / SAFETY;
    // s stages are stable up to h g = s^2 + s.
    let damping_stages = ((rate + 0.25).sqrt() - 0.5).ceil().max(0.0) as u32;
    let scaled = scaled(step_length, spring_steps, cloths);
    Ok(Timing { spring_steps: spring_steps as u32, springs_ahead, damping_stages, scaled, ..step })
}

/// How many parts of a step springs take as they are, and how far ahead they look [s].
fn spring_steps(step_length: f64, rates: &Rates) -> (f64, f64) {
    let square = rates.frequency_squared;
    let undivided = step_length <= SAFETY * of_euler(square, 0.0);
    let ahead = if undivided || rates.damping * step_length >= CALM { 0.0 } else { CALM / step_length };
    let parts = (step_length / (SAFETY * of_euler(square, ahead))).ceil().max(1.0);
    (parts, if ahead > 0.0 { ahead / square } else { 0.0 })
}

/// Parts of the springs with scaled masses: as few as vibrations that must be seen allow, those of the coarsest levels, whose
/// masses are never scaled, and what is held; nothing if that is not much fewer than `unscaled` (docs/equations.md, "Scaled masses").
fn scaled(step_length: f64, unscaled: f64, cloths: &[ClothRange]) -> Option<ScaledTiming> {
    let coarsest = |of: fn(&LevelRate) -> f64| cloths.iter().filter_map(|cloth| cloth.rates.last()).map(of).fold(0.0, f64::max);
    let (slowest, damping) = (coarsest(|rate| rate.frequency_squared), coarsest(|rate| rate.damping));
    let mut parts = (step_length / SCALED_PART * (1.0 - 1e-9)).ceil().max(1.0);
    if bears(step_length, parts) < OVERLAP * slowest {
        // bears() solved for the parts.
        let (a, b, c) = (power(2.0 * SAFETY, 2), 2.0 * CALM, OVERLAP * slowest * power(step_length, 2));
        parts = ((b + (b * b + 4.0 * a * c).sqrt()) / (2.0 * a)).ceil().max(2.0);
    }
    while WORTH * parts <= unscaled
        && cloths.iter().any(|cloth| moved_by_even_load(cloth, bears(step_length, parts) / OVERLAP) < SETS_OUT)
    {
        parts = (1.25 * parts).ceil();
    }
    let frequency_squared = bears(step_length, parts);
    (WORTH * parts <= unscaled).then(|| ScaledTiming {
        parts: parts as u32,
        springs_ahead: calm(parts) / (step_length * frequency_squared),
        frequency_squared: frequency_squared / OVERLAP,
        damping: Some(1.0 / (OVERLAP * step_length)).filter(|bears| damping <= *bears),
    })
}

/// The part of its acceleration that an even load gives a cloth on the whole, if a w^2 of `borne` is borne [1]: levels whose
/// particles are tied to what is held give nothing there.
fn moved_by_even_load(cloth: &ClothRange, borne: f64) -> f64 {
    let shares = shares(borne, cloth.rates.iter().map(|rate| rate.frequency_squared));
    if shares.is_empty() { 1.0 } else { shares.iter().zip(&cloth.rates).map(|(share, rate)| share * rate.moving).sum() }
}

/// The largest w^2 that so many parts of a step bear [1/s^2]: h^2 w^2 + 2 h g < 4 with g = calm / H.
fn bears(step_length: f64, parts: f64) -> f64 {
    let part = step_length / parts;
    (power(2.0 * SAFETY, 2) - 2.0 * part * calm(parts) / step_length) / power(part, 2)
}

/// In a single part no vibration is faster than the step.
fn calm(parts: f64) -> f64 {
    if parts == 1.0 { 0.0 } else { CALM }
}

/// No level that is this slow needs its masses scaled, whatever the step.
pub(super) fn slow_enough(scene: &Scene) -> LevelRate {
    LevelRate { frequency_squared: bears(2.0 * SCALED_PART, 2.0) / OVERLAP, damping: scene.fps / OVERLAP, moving: 1.0 }
}
