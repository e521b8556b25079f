//! How long a step is, and in how many parts springs and dampers take it.
//!
//! The bound on the step of the velocity-first Euler method holds in every configuration the cloth can take.
//!
//! A mode x'' = -w^2 x - g x' stays bounded if and only if h^2 w^2 + 2 h g < 4, that is
//! h < 4 / (g + sqrt(g^2 + 4 w^2)). Gershgorin's theorem on the spring matrix bounds w^2 and g by the largest
//! d_u/m_u + d_v/m_v over the springs uv, d being the sum of the constants at a particle (docs/equations.md, "Step").

use super::{Bending, Particles, Springs, Timing};
use crate::scene::{FilterKind, Scene, SceneError, Substeps};

/// Part of the bound that `"auto"` uses: compression turns springs soft, impulses of a filter do not count.
const SAFETY: f64 = 0.9;
/// Longest step that "auto" takes with the coarse-to-fine filter [s], for the sake of the motion ..
const LONGEST: f64 = 1.0 / 120.0;
/// .. if its limit is at least this [1]. Under tighter limits vibrations of the springs reach the limit within a step, and a
/// filter that looks at the whole step only cannot stop them; the step is shorter ..
const ROOMY: f64 = 0.1;
/// .. by this power of the limit. One that takes back what a step of springs did leaves the cloth pressed together.
const ROOM_POWER: f64 = 0.75;
/// For the same reason it looks after so many parts of the springs at least [1], if the limit ..
const PARTS: f64 = 11.0;
/// .. is at most this [1]; the wider it is, the more the springs bear themselves.
const TIGHT: f64 = 0.05;

/// h g of the fastest mode, at least, where a filter looks at several parts of a step together [1]. It takes the displacement D
/// of a step back and D / h from the velocity. A vibration of frequency w leaves the step with V cos(w h) and D = V sin(w h) / w,
/// so that it is multiplied by cos(w h) - sin(w h) / (w h), which is up to 1.063: undamped, it would grow.
const CALM: f64 = 1.2;

/// The fastest rates in a model.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rates {
    /// w^2 of the springs that act as forces, and of bending [1/s^2].
    frequency_squared: f64,
    /// w^2 of all springs, those that are left to the filter as well [1/s^2].
    resolved: f64,
    /// g of dampers [1/s].
    damping: f64,
    /// g of the air [1/s].
    drag: f64,
}

impl Rates {
    /// Of springs, bending and dampers; `drag` is the largest rate at which the air slows a particle [1/s].
    pub fn new(particles: &Particles, springs: &Springs, bending: &Bending, drag: f64) -> Self {
        let largest = |constants: &[f32]| largest_rate(particles, springs, constants);
        // A spring with a curve has a steepest slope and no k_s.
        let with_curves =
            |constants: &[f32]| constants.iter().zip(&springs.steepest).map(|(k, slope)| k + slope).collect::<Vec<f32>>();
        // The largest eigenvalue of a sum is at most the sum of the largest ones.
        let bending = bending.largest_rate(particles);
        Self {
            frequency_squared: largest(&with_curves(&springs.force_stiffness)) + bending,
            resolved: largest(&with_curves(&springs.stiffness)) + bending,
            damping: largest(&springs.damping),
            drag,
        }
    }
}

/// The largest stable step [s] of modes with w^2 and g; infinite if nothing acts.
fn bound(frequency_squared: f64, rate: f64) -> f64 {
    4.0 / (rate + (rate * rate + 4.0 * frequency_squared).sqrt())
}

/// The step: chosen, or checked against its bound.
///
/// Most filters look at every step of the springs. The coarse-to-fine filter takes longer steps, within which
/// springs and dampers go their own, shorter ones; only the air bounds it.
pub(super) fn timing(scene: &Scene, rates: Rates) -> Result<Timing, SceneError> {
    let Rates { frequency_squared, resolved, damping, drag } = rates;
    let divided = scene.solver.filter == FilterKind::CoarseToFine;
    let bound = if divided { self::bound(0.0, drag) } else { self::bound(frequency_squared, damping + drag) };
    let frame = 1.0 / scene.fps;
    let longest = if divided {
        let spring_step = SAFETY * self::bound(frequency_squared, 0.0);
        let limit = scene.cloth.iter().map(|cloth| cloth.material().strain_limit).fold(ROOMY, f64::min);
        let parts = PARTS * (limit / TIGHT).max(1.0).powi(2);
        let by_limit = (LONGEST * (limit / ROOMY).powf(ROOM_POWER)).min(parts * spring_step);
        LONGEST.min(by_limit.max(spring_step)).min(SAFETY * bound)
    } else {
        let by_constraints = matches!(scene.solver.filter, FilterKind::Rods | FilterKind::FastProjection | FilterKind::Xpbd);
        let longest = if by_constraints { LONGEST } else { f64::INFINITY };
        // One pass of "xpbd" carries a load one spring further, as a step of explicit springs does.
        longest.min(SAFETY * self::bound(resolved, damping + drag))
    };
    // A frame that is a whole number of longest steps but for rounding needs no further one.
    let enough = (frame / longest * (1.0 - 1e-9)).ceil().max(1.0);
    let substeps = match scene.solver.substeps {
        Substeps::Auto if enough > MOST_STEPS => {
            let problem = format!(
                "\"auto\" would need {enough} steps a frame (stable step {bound:.3e} s); lower stiffness, bending or damping"
            );
            return Err(SceneError::at("solver.substeps", problem));
        }
        Substeps::Auto => enough as u32,
        Substeps::Count(count) => {
            let step = frame / f64::from(count);
            if step > bound && !scene.solver.force_step {
                let problem = format!(
                    "the step of {:.4} ms is over the stability bound of {:.4} ms (springs, bending, damping, drag and wind); \
                     use at least {enough}, or \"auto\", or set solver.force_step = true",
                    step * 1e3,
                    bound * 1e3
                );
                return Err(SceneError::with_value("solver.substeps", count, problem));
            }
            count
        }
    };
    let step_length = frame / f64::from(substeps);
    if !divided {
        return Ok(Timing {
            substeps,
            step_length,
            spring_steps: 1,
            springs_ahead: 0.0,
            damping_stages: u32::from(damping > 0.0),
            bound,
        });
    }
    let undivided = step_length <= SAFETY * self::bound(frequency_squared, 0.0);
    let ahead = if undivided || damping * step_length >= CALM { 0.0 } else { CALM / step_length };
    let spring_steps = (step_length / (SAFETY * self::bound(frequency_squared, ahead))).ceil().max(1.0);
    if spring_steps * f64::from(substeps) > MOST_STEPS {
        let problem = format!("springs would need {spring_steps} parts of each step; lower stiffness or bending");
        return Err(SceneError::at("solver.substeps", problem));
    }
    let rate = step_length * damping / SAFETY;
    // s stages are stable up to h g = s^2 + s.
    let damping_stages = ((rate + 0.25).sqrt() - 0.5).ceil().max(0.0) as u32;
    let springs_ahead = if ahead > 0.0 { ahead / frequency_squared } else { 0.0 };
    Ok(Timing { substeps, step_length, spring_steps: spring_steps as u32, springs_ahead, damping_stages, bound })
}

/// More steps a frame than this are a mistake in the scene.
const MOST_STEPS: f64 = 100_000.0;

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
