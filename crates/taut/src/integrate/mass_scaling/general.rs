//! Meshes: the levels of their hierarchy.

use glam::{Vec3, Vec3A};

use super::{Levels, Shares};
use crate::geometry::{Pool, Vectors, for_each_chunk};
use crate::model::{Adjacency, ClothRange, Hierarchy, Model};

/// The levels of a cloth above the cloth itself.
pub(super) struct GeneralLevels {
    cloth: ClothRange,
    coarse: Vec<Level>,
}

/// Some particles, and how they are tied to the next finer level.
struct Level {
    /// 1 / M_l [1/kg]; zero for what is fixed.
    weights: Vec<f32>,
    /// P_l^T M V on the way up, velocities on the way down.
    field: Vec<Vec3A>,
    /// For each particle of the finer level those that it follows, and by which part: P.
    parents: Adjacency<(u32, f32)>,
    /// The same as seen from here: P^T.
    children: Adjacency<(u32, f32)>,
}

impl GeneralLevels {
    /// So many levels of a cloth.
    pub fn new(cloth: &ClothRange, hierarchy: &Hierarchy, levels: usize) -> Self {
        let nodes = &hierarchy.levels[0].nodes;
        let coarse = hierarchy.levels[..levels].iter().enumerate().skip(1).map(|(index, level)| {
            // The cloth's own particles are all there, even those that nothing is tied to.
            let (count, places) =
                if index == 1 { (cloth.count, nodes.len()) } else { (0, hierarchy.levels[index - 1].nodes.len()) };
            let finer = |place: usize| if index == 1 { nodes[place] } else { place as u32 };
            let follow = (0..places)
                .flat_map(|place| level.parents.of(place).iter().map(move |&(above, part)| (finer(place), above, part)));
            let weight = |(&mass, &fixed): (&f64, &bool)| if fixed { 0.0 } else { (1.0 / mass) as f32 };
            Level {
                weights: level.masses.iter().zip(&level.fixed).map(weight).collect(),
                field: vec![Vec3A::ZERO; level.nodes.len()],
                parents: Adjacency::new(count.max(places), follow.clone().map(|(place, above, part)| (place, (above, part)))),
                children: Adjacency::new(level.nodes.len(), follow.map(|(place, above, part)| (above, (place, part)))),
            }
        });
        Self { cloth: cloth.clone(), coarse: coarse.collect() }
    }
}

impl Levels for GeneralLevels {
    fn add(&mut self, model: &Model, Shares(shares): &Shares, gains: &Vectors, velocities: &mut Vectors, pool: &Pool) {
        let Self { cloth, coarse } = self;
        let (first, masses) = (cloth.first, &model.particles.mass);
        let coarse = &mut coarse[..shares.len() - 1];
        for index in 0..coarse.len() {
            let (finer, here) = coarse.split_at_mut(index);
            let Level { field, children, .. } = &mut here[0];
            let finer = finer.last().map(|level| &level.field);
            for_each_chunk(field, pool, |start, chunk| {
                for (place, value) in (start..).zip(chunk) {
                    let children = children.of(place).iter().map(|&(child, part)| (child as usize, part));
                    *value = match finer {
                        Some(finer) => children.map(|(child, part)| finer[child] * part).sum(),
                        None => children.map(|(child, part)| at(gains, first + child) * (part * masses[first + child])).sum(),
                    };
                }
            });
        }
        for index in (0..coarse.len()).rev() {
            let (here, coarser) = coarse.split_at_mut(index + 1);
            let Level { field, weights, .. } = &mut here[index];
            let share = shares[index + 1];
            for_each_chunk(field, pool, |start, chunk| {
                for (place, value) in (start..).zip(chunk) {
                    *value =
                        *value * (share * weights[place]) + coarser.first().map_or(Vec3A::ZERO, |level| level.prolonged(place));
                }
            });
        }
        velocities.for_each_chunk_of(cloth.particles(), pool, |chunk| {
            chunk.map(|particle, velocity| {
                let gain = at(gains, particle) * shares[0];
                let gain = gain + coarse.first().map_or(Vec3A::ZERO, |level| level.prolonged(particle - first));
                velocity + Vec3::from(gain)
            });
        });
    }
}

impl Level {
    /// P at a particle of the finer level. What is fixed gets nothing: all that it follows is fixed as well.
    #[inline(always)]
    fn prolonged(&self, place: usize) -> Vec3A {
        self.parents.of(place).iter().map(|&(above, part)| self.field[above as usize] * part).sum()
    }
}

#[inline(always)]
fn at(vectors: &Vectors, index: usize) -> Vec3A {
    Vec3A::new(vectors.x[index], vectors.y[index], vectors.z[index])
}
