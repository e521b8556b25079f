//! The step that a scene asks for: chosen, or checked against its bound.

use super::pace::LONGEST;
use super::parts::{Plan, SAFETY, is_divided, scaled, spring_steps};
use super::stability::{self, GROWTH_TIME, of_euler};
use super::{blame, pace};
use crate::geometry::{cbrt, power};
use crate::inputs::Inputs;
use crate::model::{ClothRange, Model, Rates};
use crate::scene::{FilterKind, IntegratorKind, Scene, SceneError, Substeps};

/// Under limits tighter than this [1] it shrinks with their cube root.
pub(super) const ROOMY: f64 = 0.05;
/// Where a particle has a part s of the mass of a cloth, "auto" takes 1 + 28 s times as many steps. Such a particle throws the cloth
/// about, and single steps leave the motion. Measured (docs/decisions/coarse-to-fine.md).
const HURRY: f64 = 28.0;
/// What does not scale masses, networks, has a longest step of this part of that time [1] ..
const LONGEST_UNSCALED: f64 = 0.0261;
/// .. if the limit is at least this [1]. Under tighter limits vibrations of the springs reach the limit within a step. A filter that
/// looks at the whole step only cannot stop them. If it takes back what many of them did, it leaves the cloth pressed together. So the
/// step shrinks with the root of the limit, ..
const ROOMY_UNSCALED: f64 = 0.1;
/// .. and has no more than so many parts of the springs [1], if the limit ..
const PARTS: f64 = 11.0;
/// .. is at most this [1]; the wider it is, the more the springs bear themselves.
const TIGHT: f64 = 0.05;

/// So many times as many steps as without one of the cloths are worth a word [1].
const MUCH: f64 = 4.0;

/// More steps a frame than this are a mistake in the scene.
pub(super) const MOST_STEPS: f64 = 100_000.0;

/// Steps are at least this long [s]: single precision must hold what is divided by their squares.
const SHORTEST: f64 = 1e-12;

/// The steps of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    /// Steps per frame.
    pub substeps: u32,
    /// Length of each of them [s].
    pub step_length: f64,
    /// Largest stable step under what the scene begins with [s]; infinite if nothing acts.
    pub bound: f64,
    /// What "auto" would take for each cloth alone if springs took parts of it and it were not weighted at a point [s].
    unhurried: Vec<f64>,
    /// The time in which each cloth moves by its size [s].
    pace: Vec<f64>,
    /// What is to be said if one cloth makes the steps of all much shorter.
    culprit: Option<String>,
}

impl Schedule {
    /// The steps of a scene. Where springs and dampers take a step in parts, only the air bounds it.
    ///
    /// # Errors
    /// The step that the scene asks for is over its bound, or "auto" would need too many.
    pub fn new(scene: &Scene, model: &Model, inputs: &Inputs) -> Result<Self, SceneError> {
        let (rates, cloths) = (&model.rates, &model.cloths);
        let bound = bound(model, inputs);
        let divided = is_divided(&scene.solver);
        let frame = 1.0 / scene.fps;
        // A frame that is a whole number of longest steps but for rounding needs no further one.
        let steps = |longest: f64| (frame / longest * (1.0 - 1e-9)).ceil().max(1.0);
        let pace: Vec<f64> = cloths.iter().map(|cloth| pace::time(cloth, inputs, frame / LONGEST)).collect();
        let whole = Whole { frame, pace: &pace, bound };
        let [wanted, least] = wanted(cloths, whole);
        let unhurried = cloths.iter().map(|cloth| {
            if divided { frame / steps(longest_divided(cloth, PARTS, whole)) } else { longest_scaled(cloth, whole) }
        });
        let unhurried: Vec<f64> = unhurried.collect();
        let longest =
            if divided { wanted.iter().copied().fold(frame, f64::min) } else { longest_whole(scene, rates, inputs, whole) };
        let enough = steps(longest);
        let culprit = Some(()).filter(|()| divided && scene.solver.substeps == Substeps::Auto);
        let culprit = culprit.and_then(|()| culprit_of(cloths, &least, frame));
        let substeps = match scene.solver.substeps {
            Substeps::Auto if enough > MOST_STEPS => {
                return Err(blame::too_many(scene, model, inputs, &pace, enough));
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
            for (index, cloth) in cloths.iter().enumerate() {
                let (parts, _) = spring_steps(step_length, &cloth.fastest);
                if parts * f64::from(substeps) > MOST_STEPS {
                    return Err(blame::too_many_parts(scene, index, parts * f64::from(substeps)));
                }
            }
        }
        Ok(Self { substeps, step_length, bound, unhurried, pace, culprit })
    }

    /// Length of a frame [s].
    #[must_use]
    pub fn frame(&self) -> f64 {
        self.step_length * f64::from(self.substeps)
    }

    /// Plans a step of `length` seconds.
    #[must_use]
    pub fn plan(&self, model: &Model, length: f64) -> Plan {
        Plan::new(model, length, &self.unhurried, &self.pace)
    }

    /// Checks the length of a step that nobody chose for the scene. Springs and dampers bound it. The air does not: in a step that is
    /// too long for it, it only slows (docs/equations.md, "Steps that are too long for the air").
    ///
    /// # Errors
    /// Says how long a step may be.
    pub fn check(&self, model: &Model, length: f64) -> Result<(), BadLength> {
        // The scene's own step has been checked.
        if length == self.step_length {
            return Ok(());
        }
        let bound = if is_divided(&model.solver) {
            MOST_STEPS * SAFETY * of_euler(model.rates.frequency_squared, 0.0)
        } else if model.solver.force_step {
            f64::INFINITY
        } else {
            stability::bound(&model.solver, &model.rates, 0.0)
        };
        if length >= SHORTEST && length.is_finite() && length <= bound { Ok(()) } else { Err(BadLength { length, bound }) }
    }

    /// What is to be said: one cloth makes the steps of all much shorter; the integrator lets vibrations grow.
    pub fn cautions(&self, model: &Model) -> impl Iterator<Item = String> {
        self.culprit.clone().into_iter().chain(self.caution(model))
    }

    fn caution(&self, model: &Model) -> Option<String> {
        let name = growing(model.solver.integrator)?;
        Some(format!(
            "solver.integrator = \"{name}\" lets every undamped vibration grow, however short the step; at its bound of {:.4} ms \
             the fastest one by a factor e in {GROWTH_TIME} s; \"rk4\", \"verlet\" and \"euler\" do not",
            self.bound * 1e3
        ))
    }
}

/// A step that cannot be taken.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "dt = {length:?} s: must be {SHORTEST:e} s or more, for the sake of single precision, and at most {bound:.3e} s, the stability bound \
     of the springs; take other steps, or leave dt out"
)]
pub struct BadLength {
    /// What was asked for [s].
    pub length: f64,
    /// The longest one [s].
    pub bound: f64,
}

/// The largest stable step of a model under what acts on it [s]; infinite if nothing acts.
fn bound(model: &Model, inputs: &Inputs) -> f64 {
    let drag = inputs.drag(&model.rates);
    if is_divided(&model.solver) { of_euler(0.0, drag) } else { stability::bound(&model.solver, &model.rates, drag) }
}

fn growing(integrator: IntegratorKind) -> Option<&'static str> {
    match integrator {
        IntegratorKind::ForwardEuler => Some("forward_euler"),
        IntegratorKind::Midpoint => Some("midpoint"),
        _ => None,
    }
}

/// More to say where a step is refused.
pub(super) fn remedy(scene: &Scene) -> String {
    growing(scene.solver.integrator).map_or_else(String::new, |name| {
        format!(
            "; {name:?} lets undamped vibrations grow at any step, and this bound keeps them to a factor e in {GROWTH_TIME} s: \
             \"rk4\", \"verlet\" or \"euler\" take longer steps"
        )
    })
}

/// What steps are parts of.
#[derive(Clone, Copy)]
struct Whole<'a> {
    /// [s]
    frame: f64,
    /// The time in which each cloth moves by its size [s].
    pace: &'a [f64],
    /// The largest stable step [s].
    bound: f64,
}

/// The longest step of "auto" where masses can be scaled and the air does not bound it [s].
fn longest_scaled(cloth: &ClothRange, Whole { frame, pace, .. }: Whole<'_>) -> f64 {
    pace::part(frame, LONGEST * pace[cloth.index] * cbrt(cloth.strain_limit / ROOMY).min(1.0))
}

/// The steps that cloths want beside each other [s], and the steps that they could do with, however short the others want theirs. A cloth
/// whose springs are stiff takes more parts rather than have others take more steps. Nets that take hundreds of parts are as near the
/// converged motion as in the steps they want alone (docs/decisions/README.md).
fn wanted(cloths: &[ClothRange], whole: Whole<'_>) -> [Vec<f64>; 2] {
    let with = |parts: f64| move |cloth: &ClothRange| longest_divided(cloth, parts, whole) / hurry(cloth);
    let alone: Vec<f64> = cloths.iter().map(with(PARTS)).collect();
    let least: Vec<f64> = cloths.iter().map(with(f64::INFINITY)).collect();
    let beside = |index: usize| {
        let others = (0..cloths.len()).filter(|other| *other != index).map(|other| alone[other]);
        let shortest = others.fold(f64::INFINITY, f64::min);
        if shortest.is_finite() { alone[index].max(least[index].min(shortest)) } else { alone[index] }
    };
    [(0..cloths.len()).map(beside).collect(), least]
}

/// The longest step of "auto" for a cloth where it is divided further, into so many parts at most [s].
fn longest_divided(cloth: &ClothRange, parts: f64, whole: Whole<'_>) -> f64 {
    let (limit, pace) = (cloth.strain_limit, whole.pace[cloth.index]);
    let scales = |step: f64| {
        let (unscaled, _) = spring_steps(step, &cloth.fastest);
        unscaled <= parts || scaled(step, unscaled, cloth, pace).is_some()
    };
    let with_scaling = longest_scaled(cloth, whole).min(SAFETY * whole.bound);
    let longest = if !cloth.rates.is_empty() && scales(with_scaling) {
        with_scaling
    } else {
        let spring_step = SAFETY * of_euler(cloth.fastest.frequency_squared, 0.0);
        let parts = parts * power((limit / TIGHT).max(1.0), 2);
        let longest = |part: f64| pace::part(whole.frame, LONGEST_UNSCALED * pace * part);
        let by_limit = longest((limit / ROOMY_UNSCALED).sqrt()).min(parts * spring_step);
        longest(1.0).min(by_limit.max(spring_step))
    };
    longest.min(SAFETY * whole.bound)
}

/// How many times as many steps a cloth takes that is weighted at a point.
fn hurry(cloth: &ClothRange) -> f64 {
    if cloth.rates.is_empty() { 1.0 } else { (1.0 + HURRY * cloth.heaviest).round() }
}

/// What is to be said where the step of one cloth is much shorter than those that others want: all take it.
fn culprit_of(cloths: &[ClothRange], wanted: &[f64], frame: f64) -> Option<String> {
    let (index, shortest) = wanted.iter().copied().enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let others = wanted.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, step)| *step);
    let second = others.fold(f64::INFINITY, f64::min);
    let steps = |step: f64| (frame / step * (1.0 - 1e-9)).ceil().max(1.0);
    // Of a single cloth there are no others.
    (second.is_finite() && steps(shortest) > MUCH * steps(second)).then(|| {
        format!(
            "scene.cloth[{index}] ({}) needs {} steps a frame, the others {}, and all cloths take the same: widen its strain_limit, spread \
             its weights or simulate it apart",
            cloths[index].name,
            steps(shortest),
            steps(second)
        )
    })
}

/// The longest step of "auto" that all forces take whole [s].
fn longest_whole(scene: &Scene, rates: &Rates, inputs: &Inputs, Whole { frame, pace, bound }: Whole<'_>) -> f64 {
    let by_constraints = matches!(scene.solver.filter, FilterKind::Rods | FilterKind::FastProjection | FilterKind::Xpbd);
    let for_motion = by_constraints || scene.solver.integrator.is_implicit();
    let shortest = pace.iter().copied().fold(f64::INFINITY, f64::min);
    let motion = if for_motion { pace::part(frame, LONGEST_UNSCALED * shortest) } else { f64::INFINITY };
    let longest = motion.min(SAFETY * bound);
    if rates.resolved == rates.frequency_squared {
        return longest;
    }
    // One pass of "xpbd" carries a load one spring further, as a step of explicit springs does.
    longest.min(SAFETY * of_euler(rates.resolved, rates.damping + inputs.drag(rates)))
}
