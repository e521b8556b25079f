//! Meshes: the levels of their hierarchy.

use glam::{Vec4, Vec4Swizzles};
use pulp::{Simd, WithSimd};

use super::{Acting, MassLevels};
use crate::geometry::{Pool, Vectors, VectorsChunk, arch, fill_quads, for_each_chunk};
use crate::model::{Adjacency, ClothRange, Hierarchy, Model, NodeRate, Parents, shares_of_nodes};

/// The levels of a cloth above the cloth itself.
pub(super) struct GeneralMassLevels {
    cloth: ClothRange,
    /// What the cloth's own particles would gain [m/s].
    own: Vec<Vec4>,
    coarse: Vec<MassLevel>,
    /// With springs and with dampers.
    shares: [NodeShares; 2],
}

/// How much of its acceleration each particle of each level gives, as far as levels give anything.
#[derive(Default)]
struct NodeShares {
    /// a_0 of the cloth's own particles [1].
    own: Vec<f32>,
    /// a_l / M_l of the coarse ones [1/kg]; zero for what is held.
    coarse: Vec<Vec<f32>>,
}

/// Some particles, and how they are tied to the next finer level.
struct MassLevel {
    /// P_l^T M V on the way up, velocities on the way down.
    field: Vec<Vec4>,
    /// What each particle of the finer level follows: P.
    parents: Vec<Parents>,
    /// The same as seen from here: P^T, or P^T M above the cloth itself.
    children: Adjacency<(u32, f32)>,
}

impl GeneralMassLevels {
    pub fn new(cloth: &ClothRange, hierarchy: &Hierarchy) -> Self {
        let nodes = &hierarchy.levels[0].nodes;
        let coarse = hierarchy.levels.iter().enumerate().skip(1).map(|(index, level)| {
            let finer = &hierarchy.levels[index - 1];
            // The cloth's own particles are all there, even those that nothing is tied to.
            let own = |place: usize| if index == 1 { nodes[place] } else { place as u32 };
            let mut parents = vec![Parents::default(); if index == 1 { cloth.count } else { finer.nodes.len() }];
            level.parents.iter().enumerate().for_each(|(place, &list)| parents[own(place) as usize] = list);
            let mass = |place: usize| if index == 1 { finer.masses[place] as f32 } else { 1.0 };
            let followed = level.parents.iter().enumerate().flat_map(|(place, list)| {
                let child = move |(above, part)| (above, (own(place), part * mass(place)));
                list.iter().map(child)
            });
            MassLevel {
                field: vec![Vec4::ZERO; level.nodes.len()],
                children: Adjacency::new(level.nodes.len(), followed),
                parents,
            }
        });
        Self { cloth: cloth.clone(), own: vec![Vec4::ZERO; cloth.count], coarse: coarse.collect(), shares: Default::default() }
    }
}

impl MassLevels for GeneralMassLevels {
    fn share_out(&mut self, model: &Model, cloth: &ClothRange, acting: Acting, borne: f64) {
        let Some(hierarchy) = cloth.hierarchy else { return };
        let levels = &model.hierarchies[hierarchy].levels;
        let rate = |rate: &NodeRate| match acting {
            Acting::Springs => rate.frequency_squared,
            Acting::Dampers => rate.damping,
        };
        let shares = shares_of_nodes(borne, levels, rate);
        // Particles that nothing is tied to are on no level and go their own way.
        let mut own = vec![1.0; cloth.count];
        for (&node, share) in levels[0].nodes.iter().zip(&shares[0]) {
            own[node as usize] = *share as f32;
        }
        let weighed = |(share, &mass): (&f64, &f64)| if mass > 0.0 { (share / mass) as f32 } else { 0.0 };
        let coarse = shares.iter().zip(levels).skip(1);
        let coarse = coarse.map(|(shares, level)| shares.iter().zip(&level.masses).map(weighed).collect()).collect();
        self.shares[acting as usize] = NodeShares { own, coarse };
    }

    fn add(&mut self, acting: Acting, gains: &Vectors, velocities: &mut Vectors, pool: &Pool) {
        let Self { cloth, own, coarse, shares } = self;
        let (first, shares) = (cloth.first, &shares[acting as usize]);
        fill_quads(own, gains, first, pool);
        let coarse = &mut coarse[..shares.coarse.len()];
        for index in 0..coarse.len() {
            let (finer, here) = coarse.split_at_mut(index);
            let MassLevel { field, children, .. } = &mut here[0];
            let finer = finer.last().map_or(&*own, |level| &level.field);
            for_each_chunk(field, pool, |first, sums| arch().dispatch(Restrict { sums, first, children, finer }));
        }
        for index in (0..coarse.len()).rev() {
            let (here, coarser) = coarse.split_at_mut(index + 1);
            let (MassLevel { field, .. }, shares) = (&mut here[index], &shares.coarse[index]);
            for_each_chunk(field, pool, |start, chunk| {
                for (place, value) in (start..).zip(chunk) {
                    *value = *value * shares[place] + coarser.first().map_or(Vec4::ZERO, |level| level.prolonged(place));
                }
            });
        }
        velocities.for_each_chunk_of(cloth.particles(), pool, |velocities| {
            arch().dispatch(Add { velocities, first, own, shares: &shares.own, coarse: coarse.first() });
        });
    }
}

/// P^T of a field, from the particle `first` of a level on.
struct Restrict<'a> {
    sums: &'a mut [Vec4],
    first: usize,
    children: &'a Adjacency<(u32, f32)>,
    finer: &'a [Vec4],
}

impl WithSimd for Restrict<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (place, sum) in (self.first..).zip(self.sums) {
            *sum = self.children.of(place).iter().map(|&(child, part)| self.finer[child as usize] * part).sum();
        }
    }
}

/// What velocities gain from their own level and from the coarse ones.
struct Add<'a> {
    velocities: VectorsChunk<'a>,
    /// The cloth's first particle.
    first: usize,
    own: &'a [Vec4],
    shares: &'a [f32],
    coarse: Option<&'a MassLevel>,
}

impl WithSimd for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { velocities, first, own, shares, coarse } = self;
        velocities.map(
            #[inline(always)]
            |particle, velocity| {
                let place = particle - first;
                let gain = own[place] * shares[place] + coarse.map_or(Vec4::ZERO, |level| level.prolonged(place));
                velocity + gain.xyz()
            },
        );
    }
}

impl MassLevel {
    /// P at a particle of the finer level. What is held gets nothing: all that it follows is held as well.
    #[inline(always)]
    fn prolonged(&self, place: usize) -> Vec4 {
        let Parents { places, parts } = &self.parents[place];
        let ([a, b, c], field) = (places, &self.field);
        field[*a as usize] * parts[0] + field[*b as usize] * parts[1] + field[*c as usize] * parts[2]
    }
}
