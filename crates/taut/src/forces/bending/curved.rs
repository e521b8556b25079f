//! Bending along a measured curve: first what each row of second derivatives pulls with, then what each particle feels of it.

use glam::Vec3;

use crate::geometry::{CHUNK, Pool, Vectors};
use crate::model::{ClothRange, Curvatures, Share};

/// `M(k) / k y` of each row of a cloth [N m].
pub(super) fn pulls(curvatures: &Curvatures, cloth: &ClothRange, positions: &Vectors, pulls: &mut Vectors, pool: &Pool) {
    let rows = cloth.curvatures.clone();
    if rows.is_empty() {
        return;
    }
    // Rows that make one curvature stay in one part.
    let together = curvatures.together[rows.start].len();
    pulls.for_each_part(rows, CHUNK - CHUNK % together, pool, |mut part| {
        let end = part.first + part.x.len();
        for first in (part.first..end).step_by(together) {
            let rows = first..first + together;
            let mut square = 0.0;
            for row in rows.clone() {
                let sum = second_derivative(curvatures, row, positions);
                square += sum.length_squared();
                part.set(row, sum);
            }
            let curve = &curvatures.curves[curvatures.curve[first] as usize];
            let secant = curve.secant((square * curvatures.per_area[first]).sqrt());
            rows.for_each(|row| part.set(row, part.get(row) * secant));
        }
    });
}

/// y: a second derivative times the root of its area [1].
#[inline]
fn second_derivative(curvatures: &Curvatures, row: usize, positions: &Vectors) -> Vec3 {
    let shares = curvatures.particles.of(row);
    // The weights add up to zero; distances are more exact than places. A triangle without neighbours has none.
    let origin = shares.first().map_or(Vec3::ZERO, |share| positions.get(share.index as usize));
    shares.iter().fold(Vec3::ZERO, |sum, share| sum + (positions.get(share.index as usize) - origin) * share.weight)
}

/// On a particle, from its rows and what they pull with [N].
#[inline]
pub(super) fn force(rows: &[Share], pulls: &Vectors) -> Vec3 {
    rows.iter().fold(Vec3::ZERO, |sum, share| sum - pulls.get(share.index as usize) * share.weight)
}

/// A particle's share of the energy of its rows [J]: rows that make one curvature share evenly, and so do their particles.
pub(super) fn energy(curvatures: &Curvatures, positions: &Vectors, particle: usize) -> f64 {
    let of_row = |share: &Share| {
        let row = share.index as usize;
        let together = curvatures.together[row].clone();
        let rows = together.len() * curvatures.particles.of(row).len();
        let square: f32 = together.map(|row| second_derivative(curvatures, row, positions).length_squared()).sum();
        let per_area = curvatures.per_area[row];
        let whole = curvatures.curves[curvatures.curve[row] as usize].integral((square * per_area).sqrt()) / f64::from(per_area);
        whole / rows as f64
    };
    curvatures.rows.of(particle).iter().map(of_row).sum()
}
