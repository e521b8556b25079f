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

/// Rates of the levels of a mesh. `bending` is the w^2 of its bending [1/s^2],
/// which falls from level to level at least as that of springs does.
pub(in crate::model) fn of_hierarchy(
    hierarchy: &Hierarchy,
    cloth: &ClothRange,
    springs: &Springs,
    bending: f64,
) -> Vec<LevelRate> {
    let mut rows = rows(&hierarchy.levels[0], cloth, springs);
    let mut rates: Vec<LevelRate> = Vec::new();
    let (mut finest, all) = (0.0, hierarchy.levels[0].masses.iter().sum::<f64>());
    for level in &hierarchy.levels {
        if !rates.is_empty() {
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
        let fastest = |which: usize| {
            let moving = sums.iter().zip(&level.masses).filter(|(_, mass)| **mass > 0.0);
            moving.map(|(sum, mass)| sum[which] / mass).fold(0.0, f64::max)
        };
        let springs = fastest(0);
        if rates.is_empty() {
            finest = springs;
        }
        let bends = if finest > 0.0 { bending * (springs / finest).min(1.0) } else { bending };
        let moving = level.masses.iter().sum::<f64>() / all;
        rates.push(LevelRate { frequency_squared: springs + bends, damping: fastest(1), moving });
    }
    rates
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
