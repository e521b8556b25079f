//! The levels of a cloth, laid out in memory.

use super::level::{Level, Spring};
use crate::geometry::Vectors;
use crate::model::{Adjacency, ClothRange, Hierarchy};

/// Levels, the finest first, and the particle at each place of the finest one.
pub(super) fn levels(hierarchy: &Hierarchy, cloth: &ClothRange, stretch: f32) -> (Vec<Level>, Vec<u32>) {
    let finest = &hierarchy.levels[0].nodes;
    let mut place = vec![0; cloth.count];
    (0..).zip(finest).for_each(|(index, &node)| place[node as usize] = index);
    let mut levels: Vec<Level> = Vec::new();
    for level in &hierarchy.levels {
        if let Some(fine) = levels.last_mut() {
            let moving = (0_u32..).zip(&fine.p).filter(|(_, quad)| quad[3] > 0.0);
            let follow =
                moving.flat_map(|(place, _)| level.parents.of(place as usize).iter().map(move |&follow| (place, follow)));
            fine.parents = Adjacency::new(fine.p.len(), follow);
        }
        let weight = |&mass: &f64| if mass > 0.0 { (1.0 / mass) as f32 } else { 0.0 };
        let spring = |&(ends, length): &([u32; 2], f32)| Spring { ends, limit: stretch * length, now: stretch * length };
        levels.push(Level {
            p: level.masses.iter().map(|mass| [0.0, 0.0, 0.0, weight(mass)]).collect(),
            d: Vectors::zeros(level.nodes.len()),
            springs: level.springs.iter().map(spring).collect(),
            finest: level.nodes.iter().map(|&node| place[node as usize]).collect(),
            parents: Adjacency::default(),
        });
    }
    (levels, finest.iter().map(|node| cloth.first as u32 + node).collect())
}
