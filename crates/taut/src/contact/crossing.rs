//! Whether two features keep their distance while all corners move along straight lines, conservatively.
//!
//! Distances along a fixed direction are linear in time, so that a direction along which two features are apart at the start and
//! at the end keeps them apart on all of the way. Where no such direction is at hand, time is advanced by what the distance
//! allows (additive continuous collision detection, Li, Kaufman & Jiang 2021 [Li21]).

use glam::DVec3;

use super::Places;
use super::detect::Pair;
use super::proximity::{Closest, Kind};

/// Time goes on while there is more left than this part of what there was above the floor, or of the floor where that is less [1].
const LEAST: f64 = 0.1;
/// So much of what the distance allows is taken at once [1].
const PART: f64 = 0.9;
/// An edge is cut off where the other one is so many times shorter [1].
const LONG: f64 = 4.0;
/// Features that slide along each other just above the floor are given up after so many advances.
const ADVANCES: usize = 2000;

/// Four corners and how far each goes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Motion {
    /// What they are corners of.
    pub kind: Kind,
    /// Where they start [m].
    pub x: [DVec3; 4],
    /// How far they go [m].
    pub d: [DVec3; 4],
}

impl Motion {
    /// That of a pair in a step.
    pub fn of(places: &Places, Pair { kind, corners }: Pair) -> Self {
        let corners = corners.map(|corner| corner as usize);
        let x = corners.map(|corner| places.x[corner]);
        Self { kind, x, d: [0, 1, 2, 3].map(|end| places.ends[corners[end]] - x[end]) }
    }

    /// Whether the features are at least `floor` apart along `axis`, a unit vector, at the start and at the end.
    pub fn is_apart_along(&self, axis: DVec3, floor: f64) -> bool {
        let at = |corner: usize| axis.dot(self.x[corner]);
        let to = |corner: usize| axis.dot(self.x[corner] + self.d[corner]);
        self.gap(at) >= floor && self.gap(to) >= floor
    }

    /// The same with the part alone of an edge, where the other one is much shorter, that can come within `least` of that: a capsule swings
    /// about places that are far from what it touches. Along the edge as it starts, the rest of it is further from the other one at the
    /// start and at the end, and so on all of the way.
    pub fn of_near_part(mut self, least: f64) -> Self {
        if self.kind == Kind::EdgeEdge {
            let [one, other] = [[0, 1], [2, 3]].map(|[from, to]| self.x[from].distance_squared(self.x[to]));
            if one > LONG * LONG * other {
                self.keep_near([0, 1], [2, 3], least);
            } else if other > LONG * LONG * one {
                self.keep_near([2, 3], [0, 1], least);
            }
        }
        self
    }

    fn keep_near(&mut self, [from, to]: [usize; 2], others: [usize; 2], least: f64) {
        let along = (self.x[to] - self.x[from]).normalize_or_zero();
        let (mut first, mut last) = (1.0_f64, 0.0_f64);
        for time in [0.0, 1.0] {
            let at = |corner: usize| along.dot(self.x[corner] + self.d[corner] * time);
            let length = at(to) - at(from);
            // It turns round, or is nothing.
            if length.is_nan() || length <= 0.0 {
                return;
            }
            for other in others.map(at) {
                first = first.min((other - at(from) - least) / length);
                last = last.max((other - at(from) + least) / length);
            }
        }
        let (first, last) = (first.clamp(0.0, 1.0), last.clamp(0.0, 1.0));
        for of in [&mut self.x, &mut self.d] {
            (of[from], of[to]) = (of[from].lerp(of[to], first), of[from].lerp(of[to], last));
        }
    }

    fn gap(&self, of: impl Fn(usize) -> f64) -> f64 {
        let split = self.kind.split();
        let least = (0..split).map(&of).fold(f64::INFINITY, f64::min);
        let most = (split..4).map(&of).fold(f64::NEG_INFINITY, f64::max);
        least - most
    }

    /// The part of their way that they may go before they are less than `floor` from each other, their radii left out: 1 if they never are.
    /// They start further apart than that; closest at the start are `start`.
    pub fn allowed(&self, start: &Closest, floor: f64, radius: f64) -> f64 {
        let (distance, least) = (start.way.length(), floor + radius);
        if self.is_apart_along(start.way / distance, least) {
            return 1.0;
        }
        let ends = Closest::new(self.kind, &[0, 1, 2, 3].map(|corner| self.x[corner] + self.d[corner]));
        if self.is_apart_along(ends.way.normalize_or_zero(), least) {
            return 1.0;
        }
        let left = distance - least;
        self.advance(left, least, LEAST * left.min(floor))
    }

    /// The same where so much is `left` at first; what is less than `enough` is as good as nothing.
    fn advance(&self, mut left: f64, least: f64, enough: f64) -> f64 {
        // What all do together brings nothing nearer.
        let mean = (self.d[0] + self.d[1] + self.d[2] + self.d[3]) * 0.25;
        let d = self.d.map(|d| d - mean);
        let split = self.kind.split();
        let most = |d: &[DVec3]| d.iter().map(|d| d.length()).fold(0.0, f64::max);
        let fastest = most(&d[..split]) + most(&d[split..]);
        let mut time = 0.0;
        for _ in 0..ADVANCES {
            // Not a number, or nothing to lose: no way at all.
            if left <= 0.0 || left.is_nan() {
                return time;
            }
            let further = PART * left / fastest;
            if time + further >= 1.0 {
                return 1.0;
            }
            let then = time + further;
            let now = Closest::new(self.kind, &[0, 1, 2, 3].map(|corner| self.x[corner] + d[corner] * then));
            left = now.way.length() - least;
            time = then;
            if left < enough {
                return time;
            }
        }
        time
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// How far its features are apart at some times of the way, at least [m].
    fn least(motion: &Motion, until: f64) -> f64 {
        let at = |time: f64| [0, 1, 2, 3].map(|corner| motion.x[corner] + motion.d[corner] * time);
        let apart = |time: f64| Closest::new(motion.kind, &at(time)).way.length();
        (0..=400).map(|step| apart(until * f64::from(step) / 400.0)).fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]
        /// What keeps clear of the floor may go all of its way, from however far it comes; and what may go keeps it.
        #[test]
        fn all_that_keeps_the_floor_may_go(
            x in prop::array::uniform4(prop::array::uniform3(-1.0_f64..1.0)),
            d in prop::array::uniform4(prop::array::uniform3(-1.0_f64..1.0)),
            floor in 0.02_f64..0.1,
            radius in 0.0_f64..0.1,
            is_triangle: bool,
        ) {
            let kind = if is_triangle { Kind::PointTriangle } else { Kind::EdgeEdge };
            let motion = Motion { kind, x: x.map(DVec3::from), d: d.map(DVec3::from) };
            let start = Closest::new(kind, &motion.x);
            prop_assume!(start.way.length() > floor + radius);
            let allowed = motion.allowed(&start, floor, radius);
            prop_assert!(least(&motion, allowed) >= floor + radius - 1e-12, "{allowed}");
            // Between the times that are looked at it may come a little nearer.
            let between = motion.d.map(DVec3::length).into_iter().fold(0.0, f64::max) / 400.0;
            prop_assert!(allowed == 1.0 || least(&motion, 1.0) < 1.1 * floor + radius + between, "{allowed}, {}", least(&motion, 1.0));
        }

        /// What an edge is cut off keeps its distance, and no more is cut off than that.
        #[test]
        fn only_what_is_far_is_cut_off(
            x in prop::array::uniform4(prop::array::uniform3(-1.0_f64..1.0)),
            d in prop::array::uniform4(prop::array::uniform3(-1.0_f64..1.0)),
            size in 0.0_f64..0.3,
            fast in 0.0_f64..1.0,
            limit in 0.01_f64..0.5,
            is_second: bool,
        ) {
            let [mut x, d] = [x, d].map(|of| of.map(DVec3::from));
            let short = if is_second { [2, 3] } else { [0, 1] };
            x[short[1]] = x[short[0]] + (x[short[1]] - x[short[0]]) * size;
            let whole = Motion { kind: Kind::EdgeEdge, x, d: d.map(|d| d * fast) };
            let part = whole.of_near_part(limit);
            for time in 0..=40 {
                let at = |motion: &Motion| [0, 1, 2, 3].map(|corner| motion.x[corner] + motion.d[corner] * (f64::from(time) / 40.0));
                let [all, own] = [&whole, &part].map(|motion| Closest::new(motion.kind, &at(motion)).way.length());
                prop_assert!(own >= all - 1e-12 && (own <= all + 1e-12 || all >= limit - 1e-12), "{own} of {all} at {time}");
            }
        }
    }
}
