//! Springs outside of lattices, chunk by chunk of particles: a vector register holds one number of many springs.
//!
//! A spring within a chunk is looked at once; one that leads to another chunk in both of them, so that no chunk waits for
//! another and no sum depends on the number of threads.

use glam::{Mat4, Vec4, Vec4Swizzles};
use pulp::{Arch, Simd, WithSimd};

use super::Impulse;
use super::law::Law;
use crate::geometry::{CHUNK, LINE, Pool, for_each_chunk, register, set_registers};
use crate::model::{ClothRange, Link, Model, SpringRun};

/// Forces on a particle are added one after the other, so springs of the same particle should not come in a row: within so many.
const SHUFFLED: usize = 8 * LINE;

/// Workspace of a cloth and a law.
#[derive(Debug)]
pub(super) struct Workspace {
    /// What the law draws forces from, particle by particle: 16 bytes that are loaded at once.
    field: Vec<Vec4>,
    chunks: Vec<Chunk>,
}

/// The springs around [`CHUNK`] particles.
#[derive(Debug)]
struct Chunk {
    lines: Vec<Line>,
    /// Of the particles, and of all others together.
    sums: Vec<Vec4>,
}

/// As many springs as a cache line holds numbers.
#[derive(Debug)]
struct Line {
    /// Their particles, counted from the cloth's first.
    ends: [[u32; LINE]; 2],
    /// Those of the law.
    constants: [[f32; LINE]; 2],
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
        let line = |springs: &[(usize, usize, &Link)]| Line::new(law, springs);
        Self { lines: springs.chunks(LINE).map(line).collect(), sums: vec![Vec4::ZERO; own.len() + 1] }
    }
}

impl Line {
    /// At most [`LINE`] springs; the lanes that are left have one of no strength from a particle to itself.
    fn new<L: Law>(law: L, springs: &[(usize, usize, &Link)]) -> Self {
        let mut run = SpringRun::default();
        let mut ends = [[springs[0].0 as u32; LINE]; 2];
        for (lane, &(own, other, link)) in springs.iter().enumerate() {
            (ends[0][lane], ends[1][lane]) = (own as u32, other as u32);
            run.push(link.stiffness, link.rest, link.damping);
        }
        let mut constants = [[0.0; LINE]; 2];
        constants.iter_mut().zip(law.constants(&run)).for_each(|(to, from)| to[..from.len()].copy_from_slice(from));
        Self { ends, constants }
    }
}

/// Writes `out` for the particles of a cloth.
pub(super) fn apply<L: Law>(law: L, impulse: Impulse<'_>, model: &Model, cloth: &ClothRange, work: &mut Workspace, pool: &Pool) {
    let Impulse { field: from, other, out, keep, add, scale } = impulse;
    let Workspace { field, chunks } = work;
    for_each_chunk(field, pool, |start, chunk| {
        (cloth.first + start..).zip(chunk).for_each(|(particle, value)| *value = from.get(particle).extend(0.0));
    });
    out.for_each_band(cloth.particles(), CHUNK, chunks, pool, |out, Chunk { lines, sums }| {
        let first = out.first;
        Arch::new().dispatch(AddUp { law, field, lines, first: (first - cloth.first) as u32, sums });
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
    lines: &'a [Line],
    /// The chunk's first particle.
    first: u32,
    sums: &'a mut [Vec4],
}

impl<L: Law> WithSimd for AddUp<'_, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { law, field, lines, first, sums } = self;
        sums.fill(Vec4::ZERO);
        // What pulls at particles of other chunks goes to the last sum.
        let others = sums.len() as u32 - 1;
        for Line { ends: [a, b], constants } in lines {
            let mut forces = [[[0.0_f32; LINE]; 3]];
            for lane in (0..LINE).step_by(4) {
                let between = |lane: usize| field[b[lane] as usize] - field[a[lane] as usize];
                let by_axis = Mat4::from_cols(between(lane), between(lane + 1), between(lane + 2), between(lane + 3)).transpose();
                for (axis, numbers) in forces[0].iter_mut().enumerate() {
                    numbers[lane..lane + 4].copy_from_slice(&by_axis.col(axis).to_array());
                }
            }
            for i in 0..LINE / S::F32_LANES {
                let difference = [0, 1, 2].map(|axis| register::<S, 3>(&forces, axis, i));
                let constants = constants.each_ref().map(|column| S::as_simd_f32s(column).0[i]);
                let factor = law.exact_factor(simd, difference, constants);
                set_registers::<S, 3>(&mut forces, 0, i, difference.map(|component| simd.mul_f32s(component, factor)));
            }
            for lane in (0..LINE).step_by(4) {
                let along = |axis: usize| Vec4::from_slice(&forces[0][axis][lane..]);
                let by_spring = Mat4::from_cols(along(0), along(1), along(2), Vec4::ZERO).transpose();
                for offset in 0..4 {
                    let force = by_spring.col(offset);
                    sums[a[lane + offset].wrapping_sub(first).min(others) as usize] += force;
                    sums[b[lane + offset].wrapping_sub(first).min(others) as usize] -= force;
                }
            }
        }
    }
}
