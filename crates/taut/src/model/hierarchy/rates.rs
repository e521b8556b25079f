//! How fast the levels of a cloth can vibrate.
//!
//! A displacement q of the particles of a level moves those of the cloth by P q. The row r of a spring is the difference of two rows of
//! P. So springs of stiffness k store `sum k |r q|^2 / 2` at most, in whatever configuration. With the masses M that the level
//! carries, no vibration has a larger w^2 than the largest sum of a row of `M^-1 sum k |r| |r|^T` (Gershgorin).

use super::coarse_grid::{carry, coarsened};
use super::{Hierarchy, HierarchyLevel};
use crate::model::{ClothRange, LevelRate, Springs};

/// Smaller parts of a row are left out; they are rounding [1].
const NOTHING: f64 = 1e-6;

/// A spring as a level sees it: stiffness [N/m], damping [kg/s] and its row.
struct Row {
    stiffness: f64,
    damping: f64,
    /// Places in the level.
    parts: Vec<(u32, f64)>,
}

/// How much of its acceleration each level gives, the finest first, if no more than `borne` of any level's rate is borne. Each gives as
/// much as that is, and the last one what is left.
#[must_use]
pub fn shares(borne: f64, rates: impl ExactSizeIterator<Item = f64>) -> Vec<f64> {
    let (mut shares, mut sum, count) = (Vec::new(), 0.0, rates.len());
    for (level, rate) in rates.enumerate() {
        let up_to_here = if level + 1 == count { 1.0 } else { (borne / rate).min(1.0).max(sum) };
        shares.push(up_to_here - sum);
        sum = up_to_here;
        if sum == 1.0 {
            break;
        }
    }
    shares
}

/// How fast a particle of a level can vibrate at most: its row of the bound.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct NodeRate {
    /// w^2 of springs and bending [1/s^2].
    pub frequency_squared: f64,
    /// g of dampers [1/s].
    pub damping: f64,
}

/// `shares`, particle by particle: where a mesh is coarse its particles keep their own acceleration, however fine it is elsewhere.
///
/// The part of a particle's acceleration that a level and its finer ones leave to coarser ones is interpolated between particles of
/// the next level. There it is the most that any of those that follow wants to leave, so that none bears more than it may. All
/// parts add up to one at each particle of the cloth. Levels to which nothing is left are left out.
#[must_use]
pub fn shares_of_nodes(borne: f64, levels: &[HierarchyLevel], rate: impl Fn(&NodeRate) -> f64) -> Vec<Vec<f64>> {
    let Some(finest) = levels.first() else { return Vec::new() };
    let mut left = vec![vec![1.0; finest.nodes.len()]];
    for (fine, coarse) in levels.iter().zip(&levels[1..]) {
        let mut most = vec![0.0_f64; coarse.nodes.len()];
        for (fastest, parents) in fine.rates.iter().zip(&coarse.parents) {
            let leaves = 1.0 - (borne / rate(fastest)).min(1.0);
            parents.iter().for_each(|(place, _)| most[place as usize] = most[place as usize].max(leaves));
        }
        if most.iter().all(|&most| most == 0.0) {
            break;
        }
        left.push(most);
    }
    // The coarsest takes all that is left to it, a finer one what coarser ones do not take.
    let mut taken: Vec<f64> = Vec::new();
    for (index, shares) in left.iter_mut().enumerate().rev() {
        let beyond = |place: usize| {
            let parents = levels.get(index + 1).map(|level| level.parents[place]).unwrap_or_default();
            parents.iter().map(|(above, part)| taken.get(above as usize).map_or(0.0, |taken| f64::from(part) * taken)).sum()
        };
        let both: Vec<[f64; 2]> = (0..shares.len()).map(|place| [shares[place], beyond(place)]).collect();
        taken = both.iter().map(|[left, beyond]| left.max(*beyond)).collect();
        *shares = both.iter().map(|[left, beyond]| (left - beyond).max(0.0)).collect();
    }
    left
}

/// Rates of a grid of so many columns and rows with these masses [kg], nothing for what is held. The finest level has `finest`. From one
/// to the next they fall to a quarter.
pub(in crate::model) fn of_grid([mut columns, mut rows]: [usize; 2], mut masses: Vec<f64>, finest: LevelRate) -> Vec<LevelRate> {
    let (mut rates, mut rate, all) = (vec![finest], finest, masses.iter().sum::<f64>());
    while columns.max(rows) > 2 {
        masses = carry(&masses, columns, rows);
        (columns, rows) = (coarsened(columns), coarsened(rows));
        let moving = masses.iter().sum::<f64>() / all;
        rate = LevelRate { frequency_squared: rate.frequency_squared / 4.0, damping: rate.damping / 4.0, moving };
        rates.push(rate);
    }
    rates
}

/// Rates of the levels of a mesh, and of their particles. `bending` is the w^2 of its bending [1/s^2],
/// which falls from level to level, and towards longer springs, at least as that of springs does.
pub(in crate::model) fn of_hierarchy(
    hierarchy: &mut Hierarchy,
    cloth: &ClothRange,
    springs: &Springs,
    bending: f64,
) -> Vec<LevelRate> {
    let mut rows = rows(&hierarchy.levels[0], cloth, springs);
    let mut rates: Vec<LevelRate> = Vec::new();
    let (mut finest, all) = (0.0, hierarchy.levels[0].masses.iter().sum::<f64>());
    for index in 0..hierarchy.levels.len() {
        let (finer, level) = hierarchy.levels.split_at_mut(index);
        let (finer, level) = (finer.last(), &mut level[0]);
        if finer.is_some() {
            rows.iter_mut().for_each(|row| row.parts = carried(&row.parts, level));
        }
        let mut sums = vec![[0.0; 2]; level.nodes.len()];
        for row in &rows {
            let size: f64 = row.parts.iter().map(|(_, part)| part.abs()).sum();
            for &(place, part) in &row.parts {
                sums[place as usize][0] += row.stiffness * size * part.abs();
                sums[place as usize][1] += row.damping * size * part.abs();
            }
        }
        let over = |sum: f64, mass: f64| if mass > 0.0 { sum / mass } else { 0.0 };
        if finer.is_none() {
            finest = sums.iter().zip(&level.masses).map(|(sums, &mass)| over(sums[0], mass)).fold(0.0, f64::max);
        }
        let rate = |(&[stiffness, damping], &mass): (&[f64; 2], &f64)| {
            let springs = over(stiffness, mass);
            let bends = if finest > 0.0 { bending * (springs / finest).min(1.0) } else { bending };
            NodeRate { frequency_squared: if mass > 0.0 { springs + bends } else { 0.0 }, damping: over(damping, mass) }
        };
        level.rates = sums.iter().zip(&level.masses).map(rate).collect();
        if let Some(finer) = finer {
            slower_than(finer, level);
        }
        let fastest = |of: fn(&NodeRate) -> f64| level.rates.iter().map(of).fold(0.0, f64::max);
        let moving = level.masses.iter().sum::<f64>() / all;
        let (frequency_squared, damping) = (fastest(|rate| rate.frequency_squared), fastest(|rate| rate.damping));
        rates.push(LevelRate { frequency_squared, damping, moving });
    }
    rates
}

/// No particle of a level is faster than the fastest of those that follow it, whatever its row says: what the level can show, they can.
fn slower_than(finer: &HierarchyLevel, level: &mut HierarchyLevel) {
    let mut most = vec![NodeRate::default(); level.rates.len()];
    for (rate, parents) in finer.rates.iter().zip(&level.parents) {
        for (above, _) in parents.iter() {
            let most = &mut most[above as usize];
            most.frequency_squared = most.frequency_squared.max(rate.frequency_squared);
            most.damping = most.damping.max(rate.damping);
        }
    }
    for (rate, most) in level.rates.iter_mut().zip(most) {
        rate.frequency_squared = rate.frequency_squared.min(most.frequency_squared);
        rate.damping = rate.damping.min(most.damping);
    }
}

/// The springs that act as forces; what is held has no part in them.
fn rows(finest: &HierarchyLevel, cloth: &ClothRange, springs: &Springs) -> Vec<Row> {
    let mut place = vec![None; cloth.count];
    (0..).zip(&finest.nodes).for_each(|(index, &node)| place[node as usize] = Some(index));
    let row = |spring: usize| {
        let part = |end: u32, sign: f64| {
            let place = place[end as usize - cloth.first]?;
            (finest.masses[place as usize] > 0.0).then_some((place, sign))
        };
        let [u, v] = springs.ends[spring];
        Row {
            stiffness: f64::from(springs.force_stiffness[spring] + springs.steepest[spring]),
            damping: f64::from(springs.damping[spring]),
            parts: [part(u, 1.0), part(v, -1.0)].into_iter().flatten().collect(),
        }
    };
    let own = cloth.particles();
    let type2 = (springs.type1..springs.len()).filter(|&spring| own.contains(&(springs.ends[spring][0] as usize)));
    cloth.springs.clone().chain(type2).map(row).collect()
}

/// A row on the next coarser level.
fn carried(parts: &[(u32, f64)], coarse: &HierarchyLevel) -> Vec<(u32, f64)> {
    let mut carried: Vec<(u32, f64)> = Vec::new();
    for &(place, part) in parts {
        for (above, share) in coarse.parents[place as usize].iter() {
            if coarse.masses[above as usize] == 0.0 {
                continue;
            }
            match carried.iter_mut().find(|entry| entry.0 == above) {
                Some(entry) => entry.1 += part * f64::from(share),
                None => carried.push((above, part * f64::from(share))),
            }
        }
    }
    carried.retain(|(_, part)| part.abs() > NOTHING);
    carried
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Parents;

    #[test]
    fn shares_are_what_levels_bear_and_add_up_to_one() {
        let shares = |borne: f64, rates: &[f64]| shares(borne, rates.iter().copied());
        assert_eq!(shares(1.0, &[8.0, 2.0, 0.5, 0.1]), [0.125, 0.375, 0.5]);
        assert_eq!(shares(1.0, &[8.0, 2.0]), [0.125, 0.875], "the last one has what is left");
        assert_eq!(shares(1.0, &[2.0, 4.0, 1.0]), [0.5, 0.0, 0.5], "never less than nothing");
        assert_eq!(shares(1.0, &[0.0]), [1.0]);
    }

    /// Three chains, each level every second one of the finer one.
    fn chains(rates: [&[f64]; 3]) -> Vec<HierarchyLevel> {
        let level = |(index, rates): (usize, &[f64])| {
            let parents = |place: u32| match place % 2 {
                0 => Parents::new(&[(place / 2, 1.0)]),
                _ => Parents::new(&[(place / 2, 0.5), (place / 2 + 1, 0.5)]),
            };
            let finer = if index == 0 { 0 } else { 2 * rates.len() as u32 - 1 };
            HierarchyLevel {
                nodes: (0..rates.len() as u32).collect(),
                parents: (0..finer).map(parents).collect(),
                rates: rates.iter().map(|&rate| NodeRate { frequency_squared: rate, damping: 0.0 }).collect(),
                ..HierarchyLevel::default()
            }
        };
        rates.into_iter().enumerate().map(level).collect()
    }

    #[test]
    fn nodes_of_even_levels_have_the_shares_of_their_level() {
        let found = shares_of_nodes(1.0, &chains([&[8.0; 9], &[2.0; 5], &[0.5; 3]]), |rate| rate.frequency_squared);
        assert_eq!(found, [vec![0.125; 9], vec![0.375; 5], vec![0.5; 3]]);
    }

    #[test]
    fn only_nodes_that_are_too_fast_leave_something_to_coarser_ones() {
        let (mut fine, mut coarse) = ([0.5; 17], [0.5; 9]);
        (fine[0], fine[1]) = (16.0, 8.0);
        (coarse[0], coarse[1]) = (4.0, 2.0);
        let levels = chains([&fine, &coarse, &[0.5; 5]]);
        let found = shares_of_nodes(1.0, &levels, |rate| rate.frequency_squared);
        let above = |level: usize, place: usize| -> f64 {
            let parents = levels[level + 1].parents[place].iter();
            parents.map(|(above, part)| f64::from(part) * found[level + 1][above as usize]).sum()
        };
        for place in 0..17 {
            let passed: f64 = levels[1].parents[place].iter().map(|(node, part)| f64::from(part) * above(1, node as usize)).sum();
            let all = found[0][place] + above(0, place) + passed;
            assert!((all - 1.0).abs() < 1e-12, "{place}: {all}");
            assert!(
                found[0][place] * levels[0].rates[place].frequency_squared <= 1.0 + 1e-12,
                "{place} bears too much: {found:?}"
            );
        }
        assert_eq!(found[0][8..], [1.0; 9], "two coarse springs away: {found:?}");
        assert!(found.iter().flatten().all(|share| (0.0..=1.0).contains(share)), "{found:?}");
    }
}
