//! The longest stable step of each integrator (docs/methods/integrators.md, "Step"), for vibrations x'' = -w^2 x - g x'.

use crate::geometry::cbrt;
use crate::model::Rates;
use crate::scene::{FilterKind, IntegratorKind, Solver};

/// Where a method lets undamped vibrations grow however short the step is, they may grow by a factor e in this time [s]. It is how long
/// people look at a scene, whatever the size of the cloth.
pub(super) const GROWTH_TIME: f64 = 10.0;

/// The largest stable step [s] of the velocity-first Euler method for modes with w^2 and g; infinite if nothing acts.
///
/// It stays bounded if and only if h^2 w^2 + 2 h g < 4, that is h < 4 / (g + sqrt(g^2 + 4 w^2)).
pub(super) fn of_euler(frequency_squared: f64, rate: f64) -> f64 {
    4.0 / (rate + (rate * rate + 4.0 * frequency_squared).sqrt())
}

/// The largest stable step [s] of the solver's integrator, all forces being taken at every step; the air slows particles at rates up
/// to `drag` [1/s].
pub(super) fn bound(solver: &Solver, rates: &Rates, drag: f64) -> f64 {
    let (square, rate) = (rates.frequency_squared, rates.damping + drag);
    let frequency = square.sqrt();
    match solver.integrator {
        IntegratorKind::Euler => of_euler(square, rate),
        // |1 + z| <= exp(h / T) for both z of a mode if h w^2 <= g + 2 / T and h g <= 2. What a filter takes back in every step moves by
        // D = h V of the step before: V' = -h g V is left, bounded for h g <= 1.
        IntegratorKind::ForwardEuler => {
            let least = rates.least_drag + 2.0 / GROWTH_TIME;
            let damped = if solver.filter == FilterKind::None { 2.0 } else { 1.0 };
            (rates.least_damping + least / square).min(damped / rate)
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
        IntegratorKind::ImplicitEuler => 2.0 / drag,
        // And extrapolated: 3/2 + 2 + 1/2 = 3 h g at z = -1.
        IntegratorKind::Bdf2 => 4.0 / (3.0 * drag),
    }
}
