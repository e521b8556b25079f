//! The largest stable step of the velocity-first Euler method, in every configuration the cloth can take.
//!
//! A mode x'' = -w^2 x - g x' stays bounded if and only if h^2 w^2 + 2 h g < 4, that is
//! h < 4 / (g + sqrt(g^2 + 4 w^2)). Gershgorin's theorem on the spring matrix bounds w^2 and g by the largest
//! d_u/m_u + d_v/m_v over the springs uv, d being the sum of the constants at a particle (docs/equations.md, "Step").

use super::{Particles, Springs};

/// Part of the bound that `"auto"` uses: compression turns springs soft, impulses of a filter do not count.
pub(super) const SAFETY: f64 = 0.9;

/// The bound [s]; infinite if nothing acts. `drag` is the largest further damping rate of a particle [1/s].
pub(super) fn bound(particles: &Particles, springs: &Springs, drag: f64) -> f64 {
    let frequency_squared = largest_rate(particles, springs, &springs.stiffness);
    let rate = largest_rate(particles, springs, &springs.damping) + drag;
    4.0 / (rate + (rate * rate + 4.0 * frequency_squared).sqrt())
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
