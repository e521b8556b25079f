//! One level: its particles, and its springs four at a time.

use std::ops::Range;

use glam::{Mat4, Vec4, Vec4Swizzles};

use crate::geometry::{Pool, for_each_chunk};
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
pub(super) struct Level {
    /// Displacements so far [m], and inverse masses: 16 bytes that are loaded at once.
    pub d: Vec<Vec4>,
    /// Displacements before the sweeps of a cycle; what was gained by them after that.
    pub before: Vec<Vec4>,
    /// The springs; those of a tile together, in its order.
    pub bundles: Vec<Bundle>,
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

/// When and how far a spring is pulled together, as parts of its greatest length.
#[derive(Clone, Copy)]
pub(super) struct Pull {
    /// Springs longer than this are pulled ..
    pub trigger: f32,
    /// .. to this length ..
    pub aim: f32,
    /// .. along X, their direction at the start of the step, instead of X + D: only if D, what the step has turned and
    /// stretched them by, is short against them.
    pub at_start: bool,
}

impl Level {
    /// Projects the springs of some bundles, one bundle after the other.
    pub fn sweep(&mut self, run: Range<usize>, pull: Pull, backwards: bool) {
        let Self { d, bundles, .. } = self;
        if backwards {
            bundles[run].iter().rev().for_each(|bundle| bundle.project(d, pull));
        } else {
            bundles[run].iter().for_each(|bundle| bundle.project(d, pull));
        }
    }

    /// Takes the displacements of the finest level.
    pub fn sample(&mut self, finest: &Level) {
        for ((d, before), &place) in self.d.iter_mut().zip(&mut self.before).zip(&self.finest) {
            *d = finest.d[place as usize].xyz().extend(d.w);
            *before = *d;
        }
    }

    /// Adds what the coarser level gained.
    pub fn follow(&mut self, coarse: &mut Level, pool: &Pool) {
        for (gain, d) in coarse.before.iter_mut().zip(&coarse.d) {
            *gain = *d - *gain;
        }
        let (parents, gains) = (&self.parents, &coarse.before);
        for_each_chunk(&mut self.d, pool, |start, chunk| {
            for (d, Parents { places, parts }) in chunk.iter_mut().zip(&parents[start..]) {
                let [a, b, c] = places.map(|place| gains[place as usize]);
                *d += a * parts[0] + b * parts[1] + c * parts[2];
            }
        });
    }
}

impl Bundle {
    /// Springs in bundles, each spring with its greatest length [m]; the order is kept as far as it can be.
    pub fn pack(springs: impl Iterator<Item = ([u32; 2], f32)>) -> Vec<Self> {
        let mut packed = Vec::new();
        let mut open: Vec<Vec<([u32; 2], f32)>> = Vec::new();
        for (ends, limit) in springs {
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

    /// Takes where the step begins: `x` at the ends [m].
    pub fn begin(&mut self, x: impl Fn(u32) -> Vec4) {
        let [a, b] = self.ends;
        let between = |lane: usize| x(b[lane]) - x(a[lane]);
        self.start = lanes(between(0), between(1), between(2), between(3));
    }

    /// The squares of the lengths at the start of the step [m^2].
    pub fn squares_at_start(&self) -> Vec4 {
        let [x, y, z] = self.start;
        x * x + y * y + z * z
    }

    /// D_uv [m].
    #[inline(always)]
    fn moved(&self, d: &[Vec4]) -> [Vec4; 3] {
        let [a, b] = self.ends;
        let between = |lane: usize| d[b[lane] as usize] - d[a[lane] as usize];
        lanes(between(0), between(1), between(2), between(3))
    }

    /// |X_uv + D_uv|^2 [m^2].
    #[inline(always)]
    pub fn squares(&self, d: &[Vec4]) -> Vec4 {
        let [u, v, w] = self.moved(d);
        let [x, y, z] = [self.start[0] + u, self.start[1] + v, self.start[2] + w];
        x * x + y * y + z * z
    }

    /// Pulls together the ends of each spring that is over its trigger, each end by its share.
    #[inline(always)]
    fn project(&self, d: &mut [Vec4], pull: Pull) {
        let moved = self.moved(d);
        let [x, y, z] = [0, 1, 2].map(|axis| self.start[axis] + moved[axis]);
        let square = x * x + y * y + z * z;
        let reach = self.limit * pull.trigger;
        let over = square.cmpgt(reach * reach);
        if !over.any() {
            return;
        }
        let length = Vec4::from_array(square.to_array().map(f32::sqrt));
        let mut excess = (length - self.limit * pull.aim) / length;
        let mut along = [x, y, z];
        if pull.at_start {
            let [u, v, w] = moved;
            let little = (u * u + v * v + w * w).cmplt(square * TURNED);
            along = [0, 1, 2].map(|axis| Vec4::select(little, self.start[axis], along[axis]));
            // The length still shrinks by the same.
            excess = excess * square / (x * along[0] + y * along[1] + z * along[2]);
        }
        let [a, b] = self.ends;
        let [of_a, of_b] = [a, b].map(|ends| Vec4::from_array(ends.map(|end| d[end as usize].w)));
        // The floor keeps two held ends from dividing by zero.
        let share = Vec4::select(over, excess / (of_a + of_b).max(Vec4::splat(1e-30)), Vec4::ZERO);
        for (ends, share) in [(a, share * of_a), (b, -share * of_b)] {
            let [x, y, z] = along.map(|along| along * share);
            let ways = Mat4::from_cols(x, y, z, Vec4::ZERO).transpose();
            for (lane, end) in ends.into_iter().enumerate() {
                d[end as usize] += ways.col(lane);
            }
        }
    }
}

/// The coordinates of four vectors, one by one.
#[inline(always)]
fn lanes(a: Vec4, b: Vec4, c: Vec4, d: Vec4) -> [Vec4; 3] {
    let by_axis = Mat4::from_cols(a, b, c, d).transpose();
    [by_axis.x_axis, by_axis.y_axis, by_axis.z_axis]
}
