//! How far the levels of a mesh add up: the largest eigenvalue of its springs and its bending with scaled masses.

use super::{HierarchyLevel, shares_of_nodes};
use crate::model::{Bending, ClothRange, Springs};

/// Steps of the method of Lanczos. They find the largest eigenvalue to within some percent, from below.
const STEPS: usize = 16;

/// What resists displacements of the particles of a cloth's finest level, where that is stiffest: pairs of them, with their pulls [N/m]. No
/// configuration of the cloth resists more.
#[derive(Debug)]
pub(super) struct Stiffness {
    pairs: Vec<([u32; 2], f64)>,
}

impl Stiffness {
    pub fn new(cloth: &ClothRange, finest: &HierarchyLevel, springs: &Springs, bending: &Bending) -> Self {
        let mut place = vec![None; cloth.count];
        (0..).zip(&finest.nodes).for_each(|(index, &node)| place[node as usize] = Some(index));
        let own = cloth.particles();
        let type2 = (springs.type1..springs.len()).filter(|&spring| own.contains(&(springs.ends[spring][0] as usize)));
        let acting = cloth.springs.clone().chain(type2);
        let sprung =
            acting.map(|spring| (springs.ends[spring], f64::from(springs.force_stiffness[spring] + springs.steepest[spring])));
        let bent = own.clone().flat_map(|particle| bending.pairs_of(particle));
        let placed = |(ends, pull): ([u32; 2], f64)| {
            let [a, b] = ends.map(|end| place[end as usize - cloth.first]);
            Some(([a?, b?], pull)).filter(|_| pull != 0.0)
        };
        Self { pairs: sprung.chain(bent).filter_map(placed).collect() }
    }

    /// `K x`, zero for what is held.
    fn times(&self, x: &[f64], masses: &[f64], into: &mut [f64]) {
        into.fill(0.0);
        for &([a, b], pull) in &self.pairs {
            let (a, b) = (a as usize, b as usize);
            let pull = pull * (x[a] - x[b]);
            into[a] += pull;
            into[b] -= pull;
        }
        into.iter_mut().zip(masses).filter(|(_, mass)| **mass == 0.0).for_each(|(value, _)| *value = 0.0);
    }
}

/// The largest eigenvalue of `S K` [1/s^2], S being the scaled inverse masses that bear a w^2 of `borne` on each level.
///
/// `S K` is symmetric in the product `x^T K y`, in which the method of Lanczos [Lanczos50] makes it tridiagonal.
pub(super) fn largest(stiffness: &Stiffness, levels: &[HierarchyLevel], borne: f64) -> f64 {
    let shares = shares_of_nodes(borne, levels, |rate| rate.frequency_squared);
    let (masses, count) = (&levels[0].masses, levels[0].nodes.len());
    let mut scaled = Scaled::new(levels, &shares);
    // No direction is missing from it.
    let mut now: Vec<f64> = (0..count).map(|place| (place as f64 * 0.618_033_988_7).fract() - 0.5).collect();
    now.iter_mut().zip(masses).filter(|(_, mass)| **mass == 0.0).for_each(|(value, _)| *value = 0.0);
    let (mut before, mut next, mut pulls) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
    stiffness.times(&now, masses, &mut pulls);
    let (mut diagonal, mut beside): (Vec<f64>, Vec<f64>) = Default::default();
    let mut size = dot(&now, &pulls).max(0.0).sqrt();
    while size > 0.0 && diagonal.len() < STEPS {
        now.iter_mut().chain(&mut pulls).for_each(|value| *value /= size);
        scaled.times(&pulls, &mut next);
        let along = dot(&next, &pulls);
        let back = if diagonal.is_empty() { 0.0 } else { size };
        for ((next, now), before) in next.iter_mut().zip(&now).zip(&before) {
            *next -= along * now + back * before;
        }
        diagonal.push(along);
        beside.push(size);
        std::mem::swap(&mut before, &mut now);
        std::mem::swap(&mut now, &mut next);
        stiffness.times(&now, masses, &mut pulls);
        size = dot(&now, &pulls).max(0.0).sqrt();
        if size <= 1e-4 * along.abs() {
            break;
        }
    }
    largest_of_tridiagonal(&diagonal, beside.get(1..).unwrap_or_default())
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// By bisection: a value is over all eigenvalues where all pivots of the matrix `value I - T` are positive (Sturm).
fn largest_of_tridiagonal(diagonal: &[f64], beside: &[f64]) -> f64 {
    let off = |index: usize| beside.get(index).copied().unwrap_or_default();
    let row = |index: usize| diagonal[index] + off(index) + if index > 0 { off(index - 1) } else { 0.0 };
    let mut above = (0..diagonal.len()).map(row).fold(0.0, f64::max);
    let mut below = diagonal.iter().copied().fold(0.0, f64::max);
    while above > 1.001 * below {
        let middle = 0.5 * (below + above);
        let mut pivot = 1.0;
        let mut is_above = true;
        for (index, value) in diagonal.iter().enumerate() {
            let square = if index > 0 { off(index - 1) * off(index - 1) } else { 0.0 };
            pivot = middle - value - square / pivot;
            is_above &= pivot > 0.0;
        }
        *(if is_above { &mut above } else { &mut below }) = middle;
    }
    above
}

/// Scaled inverse masses: `sum_l P_l diag(a_l) M_l^-1 P_l^T`.
struct Scaled<'a> {
    levels: &'a [HierarchyLevel],
    /// a_l / M_l [1/kg]; zero for what is held.
    shares: Vec<Vec<f64>>,
    fields: Vec<Vec<f64>>,
}

impl<'a> Scaled<'a> {
    fn new(levels: &'a [HierarchyLevel], shares: &[Vec<f64>]) -> Self {
        let over = |(share, mass): (&f64, &f64)| if *mass > 0.0 { share / mass } else { 0.0 };
        let of_level = |(shares, level): (&Vec<f64>, &HierarchyLevel)| shares.iter().zip(&level.masses).map(over).collect();
        let shares: Vec<Vec<f64>> = shares.iter().zip(levels).map(of_level).collect();
        let fields = shares.iter().map(|shares| vec![0.0; shares.len()]).collect();
        Self { levels, shares, fields }
    }

    fn times(&mut self, x: &[f64], into: &mut [f64]) {
        let Self { levels, shares, fields } = self;
        fields[0].copy_from_slice(x);
        for index in 1..fields.len() {
            let (finer, here) = fields.split_at_mut(index);
            here[0].fill(0.0);
            for (value, parents) in finer[index - 1].iter().zip(&levels[index].parents) {
                parents.iter().for_each(|(above, part)| here[0][above as usize] += f64::from(part) * value);
            }
        }
        for index in (0..fields.len()).rev() {
            let (here, coarser) = fields[index..].split_at_mut(1);
            here[0].iter_mut().zip(&shares[index]).for_each(|(value, share)| *value *= share);
            let Some(coarser) = coarser.first() else { continue };
            for (value, parents) in here[0].iter_mut().zip(&levels[index + 1].parents) {
                *value += parents.iter().map(|(above, part)| f64::from(part) * coarser[above as usize]).sum::<f64>();
            }
        }
        into.copy_from_slice(&fields[0]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::NodeRate;
    use super::*;

    #[test]
    fn the_largest_eigenvalue_of_a_tridiagonal_matrix() {
        // Of a chain of n springs and points between walls: 2 - 2 cos(n pi / (n + 1)).
        for n in [1_usize, 2, 5, 40] {
            let expected = 2.0 - 2.0 * (std::f64::consts::PI * n as f64 / (n as f64 + 1.0)).cos();
            let found = largest_of_tridiagonal(&vec![2.0; n], &vec![1.0; n - 1]);
            assert!((found / expected - 1.0).abs() < 2e-3, "{n}: {found} instead of {expected}");
        }
    }

    #[test]
    fn without_levels_it_is_the_fastest_vibration_of_a_chain() {
        // n points of 1 kg on springs of 1 N/m between two that are held.
        for n in [3_usize, 10, 60] {
            let masses = (0..n + 2).map(|place| f64::from(u8::from((1..=n).contains(&place)))).collect();
            let level = HierarchyLevel { nodes: (0..n as u32 + 2).collect(), masses, ..HierarchyLevel::default() };
            let level = HierarchyLevel { rates: vec![NodeRate { frequency_squared: 4.0, damping: 0.0 }; n + 2], ..level };
            let stiffness = Stiffness { pairs: (0..=n as u32).map(|place| ([place, place + 1], 1.0)).collect() };
            let expected = 2.0 - 2.0 * (std::f64::consts::PI * n as f64 / (n as f64 + 1.0)).cos();
            let found = largest(&stiffness, &[level], 4.0);
            assert!(found < 1.002 * expected && found > 0.97 * expected, "{n}: {found} instead of {expected}");
        }
    }
}
