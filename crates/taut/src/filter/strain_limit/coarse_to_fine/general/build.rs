//! The levels of a cloth, laid out in memory.

use glam::Vec4;

use super::level::{Bundle, GeneralLevel};
use super::tiles::{GeneralTiles, TILE, tile_of};
use crate::model::{ClothRange, Hierarchy};

/// Blocks of fewer particles are not worth handing to another thread.
const LEAST_BLOCK: usize = 256;

/// Levels, the finest first, the tiles of that, and the particle at each of its places.
pub(super) fn levels(hierarchy: &Hierarchy, cloth: &ClothRange, stretch: f32) -> (Vec<GeneralLevel>, GeneralTiles, Vec<u32>) {
    let finest = &hierarchy.levels[0];
    let mut place = vec![0; cloth.count];
    (0..).zip(&finest.nodes).for_each(|(index, &node)| place[node as usize] = index);
    let limited = |&(ends, length): &([u32; 2], f32)| (ends, stretch * length);
    let mut levels: Vec<GeneralLevel> = Vec::new();
    for level in &hierarchy.levels {
        if let Some(fine) = levels.last_mut() {
            fine.parents.clone_from(&level.parents);
        }
        let weight = |&mass: &f64| if mass > 0.0 { (1.0 / mass) as f32 } else { 0.0 };
        let d: Vec<Vec4> = level.masses.iter().map(|mass| Vec4::new(0.0, 0.0, 0.0, weight(mass))).collect();
        let (mut bundles, mut starts, mut rest) = (Vec::new(), vec![0], &level.springs[..]);
        for tile in 0..level.nodes.len().div_ceil(TILE as usize) as u32 {
            let (own, others) = rest.split_at(rest.partition_point(|spring| tile_of(spring.0) <= tile));
            rest = others;
            bundles.extend(Bundle::pack(own.iter().map(limited)));
            starts.push(bundles.len());
        }
        let span = |bundles: &[Bundle]| {
            let ends = bundles.iter().flat_map(|bundle| bundle.ends.into_iter().flatten());
            ends.fold([u32::MAX, 0], |[least, most], end| [least.min(end), most.max(end)])
        };
        // Numbers of neighbours are near one another: a block is as long as the longest spring, in numbers.
        let longest = level.springs.iter().map(|spring| spring.0[1] - spring.0[0]).max().unwrap_or_default();
        levels.push(GeneralLevel {
            before: d.clone(),
            d,
            limits: bundles.iter().map(|bundle| bundle.limit).collect(),
            moved: vec![false; starts.len() - 1],
            block: (longest as usize).max(LEAST_BLOCK).next_multiple_of(TILE as usize),
            spans: starts.windows(2).map(|tile| span(&bundles[tile[0]..tile[1]])).collect(),
            bundles,
            starts,
            finest: level.nodes.iter().map(|&node| place[node as usize]).collect(),
            parents: Vec::new(),
        });
    }
    let tiles = GeneralTiles::new(&levels[0], finest.springs.iter().map(|spring| spring.0));
    (levels, tiles, finest.nodes.iter().map(|node| cloth.first as u32 + node).collect())
}
