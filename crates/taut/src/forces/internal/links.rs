//! Springs outside of lattices, chunk by chunk of particles, four at a time.
//!
//! A spring within a chunk is looked at once. One that leads to another chunk is looked at in both of them, so that no chunk waits for
//! another and no sum depends on the number of threads.

use std::ops::Range;

use glam::{Vec4, Vec4Swizzles};
use pulp::{Simd, WithSimd};

use super::Impulse;
use super::law::Law;
use crate::geometry::{CHUNK, Pool, arch, by_vector, differences, fill_quads};
use crate::model::{ClothRange, Link, Model, SpringRun};

/// Forces on a particle are added one after the other, so springs of the same particle should not come in a row: within so many.
const SHUFFLED: usize = 128;

/// Workspace of a cloth and a law.
#[derive(Debug)]
pub(super) struct Workspace {
    /// What the law draws forces from, particle by particle.
    field: Vec<Vec4>,
    chunks: Vec<Chunk>,
}

/// The springs around [`CHUNK`] particles.
#[derive(Debug)]
struct Chunk {
    fours: Vec<Four>,
    /// Of the particles, and of all others together.
    sums: Vec<Vec4>,
}

/// Four springs.
#[derive(Debug)]
struct Four {
    /// Their particles, counted from the cloth's first.
    ends: [[u32; 4]; 2],
    /// The sums that these add to.
    sums: [[u16; 4]; 2],
    /// Those of the law.
    constants: [Vec4; 2],
}

impl Workspace {
    pub fn new<L: Law>(law: L, model: &Model, cloth: &ClothRange) -> Self {
        let chunks = (0..cloth.count).step_by(CHUNK).map(|first| Chunk::new(law, model, cloth, first));
        Self { field: vec![Vec4::ZERO; cloth.count], chunks: chunks.collect() }
    }
}

impl Chunk {
    fn new<L: Law>(law: L, model: &Model, cloth: &ClothRange, first: usize) -> Self {
        let own = first..cloth.count.min(first + CHUNK);
        let mut springs: Vec<(usize, usize, &Link)> = Vec::new();
        for particle in own.clone() {
            let links = model.links.of(cloth.first + particle);
            let others = links.iter().map(|link| (particle, link.other as usize - cloth.first, link));
            springs.extend(others.filter(|(_, other, _)| *other > particle || !own.contains(other)));
        }
        for run in springs.chunks_mut(SHUFFLED) {
            let turn = |index: usize| run[..index].iter().filter(|other| other.0 == run[index].0).count();
            let mut shuffled: Vec<_> = (0..run.len()).map(|index| (turn(index), run[index])).collect();
            shuffled.sort_by_key(|(turn, _)| *turn);
            run.iter_mut().zip(shuffled).for_each(|(place, (_, spring))| *place = spring);
        }
        let four = |springs: &[(usize, usize, &Link)]| Four::new(law, springs, &own);
        Self { fours: springs.chunks(4).map(four).collect(), sums: vec![Vec4::ZERO; own.len() + 1] }
    }
}

impl Four {
    /// At most four springs; the lanes that are left have one of no strength from a particle to itself.
    fn new<L: Law>(law: L, springs: &[(usize, usize, &Link)], own: &Range<usize>) -> Self {
        let mut run = SpringRun::default();
        let mut ends = [[springs[0].0 as u32; 4]; 2];
        for (lane, &(one, other, link)) in springs.iter().enumerate() {
            (ends[0][lane], ends[1][lane]) = (one as u32, other as u32);
            run.push(link.stiffness, link.rest, link.damping);
        }
        let mut constants = [[0.0; 4]; 2];
        constants.iter_mut().zip(law.constants(&run)).for_each(|(to, from)| to[..from.len()].copy_from_slice(from));
        // What pulls at particles of other chunks goes to the last sum.
        let sum = |end: u32| (end as usize).wrapping_sub(own.start).min(own.len()) as u16;
        Self { ends, sums: ends.map(|ends| ends.map(sum)), constants: constants.map(Vec4::from_array) }
    }
}

/// Writes `out` for the particles of a cloth.
pub(super) fn apply<L: Law>(law: L, impulse: Impulse<'_>, model: &Model, cloth: &ClothRange, work: &mut Workspace, pool: &Pool) {
    let Impulse { field: from, other, out, keep, add, scale } = impulse;
    let Workspace { field, chunks } = work;
    fill_quads(field, from, cloth.first, pool);
    out.for_each_band(cloth.particles(), CHUNK, chunks, pool, |out, Chunk { fours, sums }| {
        let first = out.first;
        arch().dispatch(AddUp { law, field, fours, sums });
        out.map(|particle, value| {
            let force = sums[particle - first].xyz();
            value * keep + other.get(particle) * add + force * (scale * model.particles.inverse_mass[particle])
        });
    });
}

/// Adds up the forces on the particles of a chunk.
struct AddUp<'a, L> {
    law: L,
    field: &'a [Vec4],
    fours: &'a [Four],
    sums: &'a mut [Vec4],
}

impl<L: Law> WithSimd for AddUp<'_, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { law, field, fours, sums } = self;
        sums.fill(Vec4::ZERO);
        for Four { ends, sums: [to_a, to_b], constants } in fours {
            let [x, y, z] = differences(field, ends);
            let factor = law.factor_of_four([x, y, z], *constants);
            let forces = by_vector([x * factor, y * factor, z * factor]);
            for ((a, b), force) in to_a.iter().zip(to_b).zip(forces) {
                sums[*a as usize] += force;
                sums[*b as usize] -= force;
            }
        }
    }
}
