//! Pairs that are looked at together.

use pulp::{Simd, WithSimd};

use super::detect::Pair;
use super::proximity::Kind;
use super::ways::{Asks, LANES, Seen, Ways};
use crate::geometry::arch;

/// So many are looked at in a row: each look takes long to end, and several of them go on at once where nothing is decided in between.
pub(super) const BATCH: usize = 16 * LANES;

/// Pairs of a kind that wait to be looked at.
#[derive(Debug, Clone)]
pub(crate) struct Batch {
    kind: Kind,
    corners: [[u32; 4]; BATCH],
    count: usize,
}

impl Batch {
    pub fn new(kind: Kind) -> Self {
        Self { kind, corners: [[0; 4]; BATCH], count: 0 }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Takes one more. Returns whether no other one fits in.
    #[inline(always)]
    pub fn put(&mut self, corners: [u32; 4]) -> bool {
        self.corners[self.count] = corners;
        self.count += 1;
        self.count == BATCH
    }

    /// Gives them back and goes on with none. Tells of each how far its features are apart at least [m]; where only that much of a first edge
    /// counts, as a capsule is long, whether they come as near as `of_near_part`. What is `enough` need not be told better.
    pub fn take(&mut self, ways: &Ways, of_near_part: Option<f32>, enough: f32) -> impl Iterator<Item = (Pair, f32)> + use<'_> {
        let mut gaps = [0.0; BATCH];
        let kind = self.kind;
        self.look(
            ways,
            &mut gaps,
            #[inline(always)]
            |seen| seen.gaps(kind, of_near_part, enough).to_array(),
        );
        let corners = &self.corners[..std::mem::take(&mut self.count)];
        corners.iter().zip(gaps).map(move |(&corners, gap)| (Pair { kind, corners }, gap))
    }

    /// Goes on with none. Tells of each that there was whether it may ask for a row.
    pub fn may_ask(&mut self, ways: &Ways, asks: Asks) -> impl Iterator<Item = bool> + use<> {
        let mut may_ask = [false; BATCH];
        let kind = self.kind;
        self.look(
            ways,
            &mut may_ask,
            #[inline(always)]
            |seen| {
                let none = seen.ask_for_none(kind, asks).bitmask();
                [0, 1, 2, 3].map(|lane| none >> lane & 1 == 0)
            },
        );
        may_ask.into_iter().take(std::mem::take(&mut self.count))
    }

    /// Writes what `tell` says of each four pairs. The first pair is in the lanes that are left.
    #[inline(always)]
    fn look<T>(&mut self, ways: &Ways, told: &mut [T; BATCH], tell: impl Fn(&Seen) -> [T; LANES]) {
        let Self { corners, count, .. } = self;
        let fours = count.div_ceil(LANES);
        let first = corners[0];
        corners[*count..fours * LANES].fill(first);
        arch().dispatch(Looks { ways, fours: &corners.as_chunks().0[..fours], told: told.as_chunks_mut().0, tell });
    }
}

/// Looks at some pairs, four at a time.
struct Looks<'a, T, F> {
    ways: &'a Ways,
    fours: &'a [[[u32; 4]; LANES]],
    told: &'a mut [[T; LANES]],
    tell: F,
}

impl<T, F: Fn(&Seen) -> [T; LANES]> WithSimd for Looks<'_, T, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (corners, told) in self.fours.iter().zip(self.told) {
            *told = (self.tell)(&self.ways.see(corners));
        }
    }
}
