//! One level: its particles, and its springs four at a time.

use std::collections::BTreeSet;
use std::ops::Range;

use glam::{Vec4, Vec4Swizzles};
use pulp::{Simd, WithSimd};

use super::super::Measure;
use super::tiles::TILE;
use crate::geometry::{
    Pool, arch, by_axis, by_vector, chunks, differences, for_each_chunk, for_each_piece, for_each_two_chunks, roots,
};
use crate::model::Parents;

/// How many springs are looked at together.
pub(super) const LANES: usize = 4;
/// A spring goes into one of so many bundles that are not yet full.
const OPEN: usize = 16;
/// A limit that no distance reaches, for lanes without a spring; its square is still a number.
const NO_LIMIT: f32 = 1e18;

/// Springs whose |D|^2 is a larger part of |X + D|^2 than this are pulled along X + D in any case: they turn so far that their
/// direction at the start says little [1].
const TURNED: f32 = 0.01;

/// One level of a cloth.
pub(super) struct GeneralLevel {
    /// Displacements so far [m], and inverse masses: 16 bytes that are loaded at once.
    pub d: Vec<Vec4>,
    /// Displacements before the sweeps of a cycle; what was gained by them after that.
    pub before: Vec<Vec4>,
    /// The springs; those that begin in a tile together, in the order of the tiles.
    pub bundles: Vec<Bundle>,
    /// Bundles of tile t: `bundles[starts[t]..starts[t + 1]]`.
    pub starts: Vec<usize>,
    /// The lowest and the highest place at which they end.
    pub spans: Vec<[u32; 2]>,
    /// Particles in a block, a whole number of tiles: springs that begin in a block end in it or in the next one. So every second block
    /// may be swept at the same time, with the same result.
    pub block: usize,
    /// The tiles of which sweeps pulled a spring since this was cleared.
    pub moved: Vec<bool>,
    /// Greatest lengths of the springs of each bundle of a coarse level [m].
    pub limits: Vec<Vec4>,
    /// Where the finest level keeps each particle.
    pub finest: Vec<u32>,
    /// What each particle follows on the next coarser level; nothing if it is held.
    pub parents: Vec<Parents>,
}

/// Four springs that share no particle, if there were enough.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bundle {
    /// Places of their particles.
    pub ends: [[u32; LANES]; 2],
    /// X_uv at the start of the step [m], each coordinate of all four.
    pub start: [Vec4; 3],
    /// Greatest lengths, on coarse levels those in this step [m].
    pub limit: Vec4,
}

/// Springs in an order of matchings: springs one after the other that share no particle. So the processor need not wait for what it
/// has just written.
fn in_matchings(mut left: Vec<([u32; 2], f32)>) -> Vec<([u32; 2], f32)> {
    let mut ordered = Vec::with_capacity(left.len());
    while !left.is_empty() {
        let mut met = BTreeSet::new();
        left.retain(|&(ends, limit)| {
            let shares = ends.iter().any(|end| met.contains(end));
            if !shares {
                met.extend(ends);
                ordered.push((ends, limit));
            }
            shares
        });
    }
    ordered
}

/// How far a spring is pulled together.
#[derive(Clone, Copy)]
pub(super) struct GeneralPull {
    /// Springs longer than this part of their greatest length are pulled to it ..
    pub aim: f32,
    /// .. along X, their direction at the start of the step, instead of X + D: only if D, what the step has turned and
    /// stretched them by, is short against them.
    pub at_start: bool,
}

impl GeneralLevel {
    /// Projects all springs, or those of the tiles in `only`: every second block, then the others.
    pub fn sweep(&mut self, pull: GeneralPull, backwards: bool, only: Option<&[bool]>, pool: &Pool) {
        let in_parallel = pool.pays_for(self.d.len());
        let Self { d, bundles, starts, spans, block, moved, .. } = self;
        let (bundles, starts, spans, block) = (&*bundles, &*starts, &*spans, *block);
        let tiles = block / TILE as usize;
        for phase in if backwards { [1, 0] } else { [0, 1] } {
            let (d, moved) = (d.get_mut(phase * block..).unwrap_or_default(), moved.get_mut(phase * tiles..).unwrap_or_default());
            let both = (chunks(d, 2 * block), chunks(moved, 2 * tiles));
            for_each_piece(both, in_parallel, |index, (d, moved)| {
                let first = (2 * index + phase) * tiles;
                let tiles = first..(first + tiles).min(starts.len() - 1);
                arch().dispatch(Sweep { d, moved, first, tiles, bundles, starts, spans, pull, backwards, only });
            });
        }
    }

    /// What the springs of a tile are against `enough` of their limits.
    pub fn measure(&self, tile: usize, enough: f32) -> Measure {
        arch().dispatch(Measured { d: &self.d, bundles: self.bundles_of(tile), enough })
    }

    /// The springs that begin in a tile.
    pub fn bundles_of(&self, tile: usize) -> &[Bundle] {
        &self.bundles[self.starts[tile]..self.starts[tile + 1]]
    }

    /// Takes the displacements of the finest level.
    pub fn sample(&mut self, finest: &GeneralLevel, pool: &Pool) {
        let places = &self.finest;
        for_each_two_chunks(&mut self.d, &mut self.before, pool, |first, d, before| {
            for ((d, before), &place) in d.iter_mut().zip(before).zip(&places[first..]) {
                *d = finest.d[place as usize].xyz().extend(d.w);
                *before = *d;
            }
        });
    }

    /// Adds what the coarser level gained.
    pub fn follow(&mut self, coarse: &mut GeneralLevel, pool: &Pool) {
        let d = &coarse.d;
        for_each_chunk(&mut coarse.before, pool, |first, gains| {
            for (gain, d) in gains.iter_mut().zip(&d[first..]) {
                *gain = *d - *gain;
            }
        });
        let (parents, gains) = (&self.parents, &coarse.before);
        for_each_chunk(&mut self.d, pool, |start, d| {
            arch().dispatch(Follow { parents: &parents[start..start + d.len()], d, gains });
        });
    }
}

/// The springs of a block.
struct Sweep<'a> {
    /// The particles of the block and the next one, and whether springs of their tiles were pulled.
    d: &'a mut [Vec4],
    moved: &'a mut [bool],
    /// The first tile of the block, and all of them.
    first: usize,
    tiles: Range<usize>,
    bundles: &'a [Bundle],
    starts: &'a [usize],
    spans: &'a [[u32; 2]],
    pull: GeneralPull,
    backwards: bool,
    only: Option<&'a [bool]>,
}

impl WithSimd for Sweep<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { d, moved, first, tiles, bundles, starts, spans, pull, backwards, only } = self;
        let first = first * TILE as usize;
        for step in 0..tiles.len() {
            let tile = if backwards { tiles.end - 1 - step } else { tiles.start + step };
            if only.is_some_and(|only| !only[tile]) {
                continue;
            }
            let bundles = &bundles[starts[tile]..starts[tile + 1]];
            let [lowest, highest] = spans[tile].map(|place| place as usize);
            // One check a tile: one of each end of each spring would take as long as the rest.
            assert!(
                bundles.is_empty() || lowest >= first && highest - first < d.len(),
                "springs of a tile end in its block or in the next one"
            );
            // SAFETY: all ends of the bundles are in the span, and places of the level from `first` on are in `d`.
            let any = unsafe {
                let d = d.as_mut_ptr().wrapping_sub(first);
                if backwards {
                    bundles.iter().rev().fold(false, |any, bundle| bundle.project(d, pull) | any)
                } else {
                    bundles.iter().fold(false, |any, bundle| bundle.project(d, pull) | any)
                }
            };
            moved[tile - tiles.start] |= any;
        }
    }
}

struct Measured<'a> {
    d: &'a [Vec4],
    bundles: &'a [Bundle],
    enough: f32,
}

impl WithSimd for Measured<'_> {
    type Output = Measure;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Measure {
        let (mut worst, mut over) = (Vec4::ZERO, 0);
        for bundle in self.bundles {
            let ratio = bundle.squares(self.d) / (bundle.limit * bundle.limit);
            worst = worst.max(ratio);
            over += ratio.cmpgt(Vec4::splat(self.enough * self.enough)).bitmask().count_ones();
        }
        Measure { worst: worst.max_element().sqrt(), over: over as usize }
    }
}

struct Follow<'a> {
    d: &'a mut [Vec4],
    parents: &'a [Parents],
    gains: &'a [Vec4],
}

impl WithSimd for Follow<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (d, Parents { places, parts }) in self.d.iter_mut().zip(self.parents) {
            let [a, b, c] = places;
            let gains = &self.gains;
            *d += gains[*a as usize] * parts[0] + gains[*b as usize] * parts[1] + gains[*c as usize] * parts[2];
        }
    }
}

impl Bundle {
    /// Springs in bundles, each spring with its greatest length [m]; those of one matching come one after the other.
    pub fn pack(springs: impl Iterator<Item = ([u32; 2], f32)>) -> Vec<Self> {
        let mut packed = Vec::new();
        let mut open: Vec<Vec<([u32; 2], f32)>> = Vec::new();
        for (ends, limit) in in_matchings(springs.collect()) {
            let apart = |bundle: &Vec<([u32; 2], f32)>| bundle.iter().flat_map(|other| other.0).all(|end| !ends.contains(&end));
            match open.iter().position(apart) {
                Some(index) => {
                    open[index].push((ends, limit));
                    if open[index].len() == LANES {
                        packed.push(Self::of(&open.remove(index)));
                    }
                }
                None => {
                    if open.len() == OPEN {
                        packed.push(Self::of(&open.remove(0)));
                    }
                    open.push(vec![(ends, limit)]);
                }
            }
        }
        packed.extend(open.iter().map(|bundle| Self::of(bundle)));
        packed
    }

    /// At most four springs; the lanes that are left have one from a particle to itself.
    fn of(springs: &[([u32; 2], f32)]) -> Self {
        let mut ends = [[springs[0].0[0]; LANES]; 2];
        let mut limit = [NO_LIMIT; LANES];
        for (lane, &([a, b], length)) in springs.iter().enumerate() {
            (ends[0][lane], ends[1][lane], limit[lane]) = (a, b, length);
        }
        Self { ends, start: [Vec4::ZERO; 3], limit: Vec4::from_array(limit) }
    }

    /// Takes where the step begins: `x` by places of the finest level [m], which `finest` tells.
    pub fn begin(&mut self, x: &[Vec4], finest: &[u32]) {
        let [a, b] = &self.ends;
        let place = |end: u32| finest[end as usize];
        let ends = [[place(a[0]), place(a[1]), place(a[2]), place(a[3])], [place(b[0]), place(b[1]), place(b[2]), place(b[3])]];
        self.start = differences(x, &ends);
    }

    /// The squares of the lengths at the start of the step [m^2].
    pub fn squares_at_start(&self) -> Vec4 {
        let [x, y, z] = self.start;
        x * x + y * y + z * z
    }

    /// |X_uv + D_uv|^2 [m^2].
    #[inline(always)]
    pub fn squares(&self, d: &[Vec4]) -> Vec4 {
        let [u, v, w] = differences(d, &self.ends);
        let [x, y, z] = [self.start[0] + u, self.start[1] + v, self.start[2] + w];
        x * x + y * y + z * z
    }

    /// Pulls together the ends of each spring that is over its aim, each end by its share. Returns whether there was such a spring.
    ///
    /// # Safety
    /// `d`, where the first particle of the level would be, leads to all of the ends, and nobody else touches these meanwhile.
    #[inline(always)]
    unsafe fn project(&self, d: *mut Vec4, pull: GeneralPull) -> bool {
        let place = |end: u32| d.wrapping_add(end as usize);
        let [[a, b, c, e], [f, g, h, i]] = self.ends;
        let places = [[place(a), place(b), place(c), place(e)], [place(f), place(g), place(h), place(i)]];
        let [a, b] = &places;
        // SAFETY: as the caller promises.
        let (a, b) = unsafe { ([*a[0], *a[1], *a[2], *a[3]], [*b[0], *b[1], *b[2], *b[3]]) };
        let [u, v, w] = by_axis([b[0] - a[0], b[1] - a[1], b[2] - a[2], b[3] - a[3]]);
        let [x, y, z] = [self.start[0] + u, self.start[1] + v, self.start[2] + w];
        let square = x * x + y * y + z * z;
        let aim = self.limit * pull.aim;
        let over = square.cmpgt(aim * aim);
        if !over.any() {
            return false;
        }
        let length = roots(square);
        let (mut along, mut square_along) = ([x, y, z], square);
        if pull.at_start {
            let little = (u * u + v * v + w * w).cmplt(square * TURNED);
            along = [
                Vec4::select(little, self.start[0], x),
                Vec4::select(little, self.start[1], y),
                Vec4::select(little, self.start[2], z),
            ];
            // The length still shrinks by the same.
            square_along = x * along[0] + y * along[1] + z * along[2];
        }
        let of_a = Vec4::new(a[0].w, a[1].w, a[2].w, a[3].w);
        let of_b = Vec4::new(b[0].w, b[1].w, b[2].w, b[3].w);
        // The floor keeps two held ends from dividing by zero.
        let parts = square_along * (of_a + of_b).max(Vec4::splat(1e-30));
        let share = Vec4::select(over, (length - aim) * length / parts, Vec4::ZERO);
        for (places, share) in places.iter().zip([share * of_a, -share * of_b]) {
            let [p, q, r, s] = by_vector([along[0] * share, along[1] * share, along[2] * share]);
            // SAFETY: as the caller promises. Lanes without a spring add zero to a place that others may have written.
            unsafe {
                *places[0] += p;
                *places[1] += q;
                *places[2] += r;
                *places[3] += s;
            }
        }
        true
    }
}
