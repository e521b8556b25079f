//! Boxes around ways: one at the start of a step and one at its end.

use glam::{BVec4A, Vec3A, Vec4};

use crate::geometry::by_axis;

/// A box at the start of a step and one at its end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    pub low: [Vec3A; 2],
    pub high: [Vec3A; 2],
}

impl Bounds {
    pub const NOTHING: Self = Self { low: [Vec3A::INFINITY; 2], high: [Vec3A::NEG_INFINITY; 2] };

    /// Cubes around places at the start and at the end [m]; `half` is half of their sides.
    pub fn around(places: [Vec3A; 2], half: [f32; 2]) -> Self {
        let half = half.map(Vec3A::splat);
        Self { low: [places[0] - half[0], places[1] - half[1]], high: [places[0] + half[0], places[1] + half[1]] }
    }

    pub fn and(self, other: Self) -> Self {
        Self {
            low: [self.low[0].min(other.low[0]), self.low[1].min(other.low[1])],
            high: [self.high[0].max(other.high[0]), self.high[1].max(other.high[1])],
        }
    }

    /// Wider by so much on all sides [m].
    pub fn grown(self, by: f32) -> Self {
        let by = Vec3A::splat(by);
        Self { low: self.low.map(|low| low - by), high: self.high.map(|high| high + by) }
    }

    /// Whether what is in one may meet what is in the other on straight ways. Places that are apart along an axis, the same one before
    /// the other at the start and at the end, are so on all of the way.
    #[inline]
    pub fn meets(&self, other: &Self) -> bool {
        let before = |one: &Self, other: &Self| one.high[0].cmplt(other.low[0]) & one.high[1].cmplt(other.low[1]);
        !(before(self, other) | before(other, self)).any()
    }
}

/// Four boxes, or the same one four times: each number of all of them at both times, axis by axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Four {
    low: [[Vec4; 3]; 2],
    high: [[Vec4; 3]; 2],
}

/// Boxes in fours.
pub(super) const LANES: usize = 4;

impl Four {
    pub const NOTHING: Self = Self { low: [[Vec4::INFINITY; 3]; 2], high: [[Vec4::NEG_INFINITY; 3]; 2] };

    /// Up to four boxes. Those that are missing meet nothing.
    pub fn new(boxes: impl Iterator<Item = Bounds>) -> Self {
        let mut all = [Bounds::NOTHING; LANES];
        all.iter_mut().zip(boxes).for_each(|(place, bounds)| *place = bounds);
        let of = |side: fn(&Bounds) -> &[Vec3A; 2]| [0, 1].map(|time| by_axis(all.map(|bounds| side(&bounds)[time].extend(0.0))));
        Self { low: of(|bounds| &bounds.low), high: of(|bounds| &bounds.high) }
    }

    /// One box, to be compared with four.
    #[inline(always)]
    pub fn same(bounds: &Bounds) -> Self {
        let of = |side: [Vec3A; 2]| side.map(|place| place.to_array().map(Vec4::splat));
        Self { low: of(bounds.low), high: of(bounds.high) }
    }

    /// Which of four may meet another one, as [`Bounds::meets`] says: a bit for each.
    #[inline(always)]
    fn meets(&self, other: &Self) -> u32 {
        let before = |one: &Self, other: &Self, axis: usize| -> BVec4A {
            one.high[0][axis].cmplt(other.low[0][axis]) & one.high[1][axis].cmplt(other.low[1][axis])
        };
        let apart = |axis: usize| before(self, other, axis) | before(other, self, axis);
        !(apart(0) | apart(1) | apart(2)).bitmask() & 0b1111
    }
}

/// Which of some boxes meet another one: a bit for each, of those of `among` alone.
#[inline(always)]
pub(super) fn meeting(fours: &[Four], other: &Four, among: u32) -> u32 {
    let bits = |(first, four): (usize, &Four)| if among >> first & 0b1111 == 0 { 0 } else { four.meets(other) << first };
    (0..).step_by(LANES).zip(fours).map(bits).fold(0, |all, bits| all | bits) & among
}

/// The numbers of the bits that are set.
#[inline(always)]
pub(super) fn numbers(mut bits: u32) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let first = bits.trailing_zeros();
        bits &= bits.wrapping_sub(1);
        (first < u32::BITS).then_some(first)
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    prop_compose! {
        fn bounds()(place in prop::array::uniform12(-1.0_f32..1.0), lost in 0..40_u8) -> Bounds {
            let [low, high] = [0, 6].map(|side| {
                [0, 3].map(|time| Vec3A::from_slice(&place[side + time..]) + if side == 0 { -0.3 } else { 0.3 })
            });
            // What is no number is never apart from anything.
            Bounds { low: if lost == 0 { [Vec3A::NAN; 2] } else { low }, high }
        }
    }

    proptest! {
        /// Boxes in fours meet what each of them does; those that are missing meet nothing.
        #[test]
        fn fours_meet_what_each_of_them_does(all in prop::collection::vec(bounds(), 1..24), other in bounds(), among: u32) {
            let fours: Vec<Four> = all.chunks(LANES).map(|four| Four::new(four.iter().copied())).collect();
            let met = meeting(&fours, &Four::same(&other), among);
            let each: Vec<u32> = (0..).zip(&all).filter(|(number, one)| among >> number & 1 == 1 && one.meets(&other)).map(|(number, _)| number).collect();
            prop_assert_eq!(numbers(met).collect::<Vec<_>>(), each);
        }
    }
}
