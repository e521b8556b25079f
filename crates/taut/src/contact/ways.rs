//! The ways of all vertices in single precision, for a first look at pairs: most of them are far enough from each other.

use glam::{BVec4A, Vec4};

use super::Places;
use super::bounds::Bounds;
use super::proximity::Kind;
use crate::geometry::{Pool, by_axis, for_each_two_chunks, roots};

/// Boxes are wider by this part of the largest coordinate: places are rounded to single precision.
const ROUNDING: f32 = 2.0 * f32::EPSILON;
/// A gap is less by these parts of the largest coordinate, and of the largest one as seen from the first corner, than it is found to be:
/// places are rounded, and so are their differences, the axis (twice, as it is normalized) and products with it.
const OF_PLACES: f32 = 4.0 * f32::EPSILON;
const OF_DIFFERENCES: f32 = 24.0 * f32::EPSILON;
/// Lines that are no longer than this say nothing: their squares are too small for numbers [m].
const SHORTEST: f32 = 1e-18;
/// So many pairs fit into the registers of a look.
pub(super) const LANES: usize = 4;

/// Where vertices start and end [m].
#[derive(Debug, Default)]
pub(crate) struct Ways {
    list: Vec<[Vec4; 2]>,
}

/// What pairs ask of rows: how far apart they ask for none any more [m], and whether their edges are all sides of triangles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Asks {
    pub within: f32,
    pub are_sides: bool,
}

/// The corners of four pairs as seen from the first one of each, at the start and at the end of the step: each coordinate of all four [m].
pub(crate) struct Seen {
    from: [[Vec4; 3]; 4],
    to: [[Vec4; 3]; 4],
    /// The largest coordinates of their places, and of these differences.
    largest: Vec4,
    furthest: Vec4,
}

impl Ways {
    pub fn new(vertices: usize) -> Self {
        Self { list: vec![[Vec4::ZERO; 2]; vertices] }
    }

    /// Takes them, and boxes of vertices that are wider by what `half` says of each [m] on all sides.
    pub fn take(&mut self, places: &Places, half: impl Fn(usize) -> f32 + Sync, bounds: &mut [Bounds], pool: &Pool) {
        for_each_two_chunks(&mut self.list, bounds, pool, |first, ways, bounds| {
            let ends = places.x[first..].iter().zip(&places.ends[first..]);
            for (((way, bounds), (x, end)), vertex) in ways.iter_mut().zip(bounds).zip(ends).zip(first..) {
                let half = half(vertex);
                let places = [x.as_vec3a(), end.as_vec3a()];
                *way = places.map(|place| place.extend(0.0));
                *bounds = Bounds::around(places, places.map(|place| half + ROUNDING * place.abs().max_element()));
            }
        });
    }

    /// Whether some places are surely no further from each other than that at the start [m].
    pub fn are_within(&self, corners: &[u32], longest: f32) -> bool {
        let places = || corners.iter().map(|&corner| self.list[corner as usize][0]);
        let largest = places().fold(Vec4::ZERO, |largest, place| largest.max(place.abs())).max_element();
        let longest = longest * (1.0 - OF_DIFFERENCES) - OF_PLACES * largest;
        longest > 0.0 && places().all(|a| places().all(|b| (a - b).length_squared() <= longest * longest))
    }

    #[inline(always)]
    pub fn see(&self, corners: &[[u32; 4]; LANES]) -> Seen {
        let [p, q, r, s] = corners;
        let at = |corner: usize, time: usize| {
            let place = |corners: &[u32; 4]| self.list[corners[corner] as usize][time];
            by_axis([place(p), place(q), place(r), place(s)])
        };
        let [first, then] = [at(0, 0), at(0, 1)];
        let mut seen = Seen { from: [[Vec4::ZERO; 3]; 4], to: [[Vec4::ZERO; 3]; 4], largest: Vec4::ZERO, furthest: Vec4::ZERO };
        for axis in 0..3 {
            seen.largest = seen.largest.max(first[axis].abs()).max(then[axis].abs());
        }
        for corner in 1..4 {
            let [start, end] = [at(corner, 0), at(corner, 1)];
            for axis in 0..3 {
                let [start, end] = [start[axis] - first[axis], end[axis] - then[axis]];
                (seen.from[corner][axis], seen.to[corner][axis]) = (start, end);
                seen.furthest = seen.furthest.max(start.abs()).max(end.abs());
            }
        }
        seen.largest += seen.furthest;
        seen
    }
}

impl Seen {
    /// How far two features are apart, at least, at the start and at the end of the step along a line at the start [m]; below zero where
    /// that says nothing. If it is above zero they are as far apart on all of the way. The line is that from the middle of the second
    /// feature to the middle of a vertex, or to the nearest place of an edge: that of a capsule is long. Where it does not tell that all
    /// are as far apart as is `enough`, it may be the one across both as well, along which what lies on each other is apart.
    #[inline(always)]
    pub fn gaps(&self, kind: Kind, of_near_part: Option<f32>, enough: f32) -> Vec4 {
        let Self { from, largest, furthest, .. } = self;
        let wrong = OF_PLACES * *largest + OF_DIFFERENCES * *furthest;
        let part = match of_near_part {
            Some(least) if kind == Kind::EdgeEdge => self.near_part(Vec4::splat(least) + wrong),
            _ => [Vec4::ZERO, Vec4::ONE],
        };
        let sum = |a: [Vec4; 3], b: [Vec4; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        // How long it is does not count.
        let between = match kind {
            Kind::PointTriangle => sum(sum(from[1], from[2]), from[3]),
            Kind::EdgeEdge => {
                let (edge, twice) = (from[1], sum(from[2], from[3]));
                let square = dot(edge, edge).max(Vec4::splat(f32::MIN_POSITIVE));
                let along = (dot(twice, edge) / square).clamp(Vec4::ZERO, Vec4::splat(2.0));
                less(twice, edge.map(|part| part * along))
            }
        };
        let gaps = self.gaps_along(kind, between, part, wrong);
        if gaps.cmpge(Vec4::splat(enough)).all() {
            return gaps;
        }
        let (across, one) = match kind {
            Kind::PointTriangle => (cross(less(from[2], from[1]), less(from[3], from[1])), from[1]),
            Kind::EdgeEdge => (cross(from[1], less(from[3], from[2])), from[2]),
        };
        let sign = dot(across, one).signum();
        gaps.max(self.gaps_along(kind, across.map(|part| part * sign), part, wrong))
    }

    /// The same along a line to the second feature, where numbers are wrong by so much; of a first edge such a part counts.
    #[inline(always)]
    fn gaps_along(&self, kind: Kind, line: [Vec4; 3], [first, last]: [Vec4; 2], wrong: Vec4) -> Vec4 {
        let length = norm(line);
        let axis = line.map(|part| part / length);
        let [start, end] = [&self.from, &self.to].map(|corners| {
            let [a, b, c] = [dot(corners[1], axis), dot(corners[2], axis), dot(corners[3], axis)];
            match kind {
                Kind::PointTriangle => a.min(b).min(c),
                Kind::EdgeEdge => b.min(c) - (a * first).max(a * last),
            }
        });
        Vec4::select(length.cmpgt(Vec4::splat(SHORTEST)), start.min(end) - wrong, Vec4::NEG_ONE)
    }

    /// The part of the first edge, from its start [1], that can come within `least` of the other one [m] (crossing.rs).
    #[inline(always)]
    fn near_part(&self, least: Vec4) -> [Vec4; 2] {
        let along = self.from[1].map(|part| part / norm(self.from[1]));
        let [start, end] = [&self.from, &self.to].map(|corners| {
            let [length, one, other] = [1, 2, 3].map(|corner| dot(corners[corner], along));
            let (low, high) = ((one.min(other) - least) / length, (one.max(other) + least) / length);
            // Where it turns round, or is nothing, all of it counts.
            let goes_on = length.cmpgt(Vec4::ZERO);
            [Vec4::select(goes_on, low, Vec4::ZERO), Vec4::select(goes_on, high, Vec4::ONE)]
        });
        [start[0].min(end[0]), start[1].max(end[1])].map(|part| part.clamp(Vec4::ZERO, Vec4::ONE))
    }

    /// Whether pairs surely ask for no row, for all that single precision may be wrong: they are further apart than it takes, and stay so, or
    /// are two edges that are closest at the end of one of them (proximity.rs tells more).
    #[inline(always)]
    pub fn ask_for_none(&self, kind: Kind, Asks { within, are_sides }: Asks) -> BVec4A {
        let Self { from, to, largest, .. } = self;
        // What a difference of two places is wrong by, at most.
        let wrong = OF_PLACES * *largest;
        match kind {
            Kind::PointTriangle => {
                // What the distance has to be, as the vertex moves no further than that against any place of the triangle.
                let moved = [1, 2, 3].map(|corner| norm(less(to[corner], from[corner])));
                let needed = within + moved[0].max(moved[1]).max(moved[2]) + 4.0 * wrong;
                let (b, c) = (less(from[2], from[1]), less(from[3], from[1]));
                let normal = cross(b, c);
                let (height, area) = (dot(from[1], normal).abs(), norm(normal));
                let area_wrong = 2.0 * (norm(b) + norm(c)) * wrong;
                (height - 2.0 * (norm(from[1]) * area_wrong + area * wrong)).cmpgt(needed * (area + area_wrong))
            }
            Kind::EdgeEdge => {
                let (one, other, between) = (from[1], less(from[3], from[2]), from[2].map(|part| -part));
                let (a, b, e) = (dot(one, one), dot(one, other), dot(other, other));
                let (c, f) = (dot(one, between), dot(other, between));
                let across = a * e - b * b;
                // The lengths that these are products of, and so how wrong all of them and what is made of them may be, twice over.
                let (l, m, n) = (roots(a), roots(e), norm(between));
                let across_wrong = 8.0 * l * m * (l + m) * wrong;
                let s = ((b * f - c * e) / across).clamp(Vec4::ZERO, Vec4::ONE);
                let s_wrong = 2.0 * (4.0 * m * (l * m + 2.0 * l * n + m * n) * wrong + across_wrong) / across;
                let t = (b * s + f) / e;
                let t_wrong = 2.0 * ((l + 6.0 * m + n) * wrong + l * m * s_wrong) / e;
                let t_inside = t.clamp(Vec4::ZERO, Vec4::ONE);
                let s = (b * t_inside - c) / a;
                let s_wrong = 2.0 * ((6.0 * l + m + n) * wrong + l * m * t_wrong) / a;
                let s_inside = s.clamp(Vec4::ZERO, Vec4::ONE);
                let way = [0, 1, 2].map(|axis| between[axis] + one[axis] * s_inside - other[axis] * t_inside);
                // What the closest places gain along it in the step; and how wrong both are.
                let (one_gains, other_gains) = (less(to[1], one), less(less(to[3], to[2]), other));
                let gain = [0, 1, 2]
                    .map(|axis| one_gains[axis] * s_inside - other_gains[axis] * t_inside - (to[2][axis] - from[2][axis]));
                let way_wrong = l * s_wrong + m * t_wrong + 4.0 * wrong;
                let gain_wrong = norm(one_gains) * s_wrong + norm(other_gains) * t_wrong + 8.0 * wrong;
                let distance = norm(way);
                let spare = distance - way_wrong - within;
                // Along a direction that is wrong by twice the error of the way over its length.
                let gains = dot(way, gain) - 3.0 * way_wrong * norm(gain);
                let mut is_out = spare.cmpgt(Vec4::ZERO) & ((spare - gain_wrong) * distance + gains).cmpgt(Vec4::ZERO);
                if are_sides {
                    is_out |= (t - t_inside).abs().cmpgt(t_wrong) | (s - s_inside).abs().cmpgt(s_wrong);
                }
                is_out & across.cmpgt(2.0 * across_wrong)
            }
        }
    }
}

/// The products of four vectors with four others.
#[inline(always)]
fn dot(a: [Vec4; 3], b: [Vec4; 3]) -> Vec4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn norm(a: [Vec4; 3]) -> Vec4 {
    roots(dot(a, a))
}

#[inline(always)]
fn cross(a: [Vec4; 3], b: [Vec4; 3]) -> [Vec4; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn less(a: [Vec4; 3], b: [Vec4; 3]) -> [Vec4; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};
    use proptest::prelude::*;

    use super::super::batch::Batch;
    use super::super::crossing::Motion;
    use super::super::detect::Pair;
    use super::*;
    use crate::contact::proximity::Closest;

    /// What is told of the pair of all four places.
    fn looked_at<T>(kind: Kind, places: &Places, tell: impl FnOnce(&mut Batch, &Ways) -> T) -> T {
        let mut list = Ways::new(4);
        list.take(places, |_| 0.0, &mut [Bounds::NOTHING; 4], &Pool::new(1));
        let mut batch = Batch::new(kind);
        batch.put([0, 1, 2, 3]);
        tell(&mut batch, &list)
    }

    /// A first look at that pair.
    fn gap(kind: Kind, places: &Places, of_near_part: Option<f32>) -> (Pair, f32) {
        looked_at(kind, places, |batch, ways| {
            let mut found = batch.take(ways, of_near_part, f32::INFINITY);
            let first = found.next().expect("what was put");
            assert!(found.next().is_none(), "one was put");
            first
        })
    }

    /// How near features come at some times of their way [m].
    fn least(motion: &Motion) -> f64 {
        let at = |part: u8| [0, 1, 2, 3].map(|corner| motion.x[corner] + motion.d[corner] * (f64::from(part) / 20.0));
        (0..=20).map(|part| Closest::new(motion.kind, &at(part)).way.length()).fold(f64::INFINITY, f64::min)
    }

    proptest! {
        /// What is told is never more than the features are apart, at any time.
        #[test]
        fn gaps_are_no_wider_than_what_is_there(
            corners in prop::array::uniform4(prop::array::uniform3(-1.0_f64..1.0)),
            ways in prop::array::uniform4(prop::array::uniform3(-1.0_f64..1.0)),
            apart in 0.0_f64..3.0,
            size in -3_i32..2,
            far in 0.0_f64..1e3,
            is_triangle: bool,
        ) {
            let kind = if is_triangle { Kind::PointTriangle } else { Kind::EdgeEdge };
            let size = 10_f64.powi(size);
            let shift = |corner: usize| DVec3::splat(far) + DVec3::X * if corner < kind.split() { apart * size } else { 0.0 };
            let x: Vec<DVec3> = (0..4).map(|corner| DVec3::from(corners[corner]) * size + shift(corner)).collect();
            let ends = x.iter().zip(ways).map(|(x, way)| *x + DVec3::from(way) * 0.3 * size).collect();
            let places = Places { x, ends, ..Places::default() };
            let (pair, gap) = gap(kind, &places, None);
            let gap = f64::from(gap);
            let motion = Motion::of(&places, pair);
            let distance = least(&motion);
            prop_assert!(gap <= distance, "{gap} at a distance of {distance}");
            // It says nearly all that there is to say along this line, which is rounded itself: the more, the closer its ends.
            let middle = |of: &[DVec3]| of.iter().sum::<DVec3>() / of.len() as f64;
            let (one, other) = motion.x.split_at(kind.split());
            let from = match one {
                [p, q] => *p + (*q - *p) * ((middle(other) - *p).dot(*q - *p) / p.distance_squared(*q)).clamp(0.0, 1.0),
                _ => one[0],
            };
            let between = from - middle(other);
            let [start, end] = [0.0, 1.0].map(|time| {
                let along = [0, 1, 2, 3].map(|corner| between.normalize().dot(motion.x[corner] + motion.d[corner] * time));
                let (one, other) = along.split_at(kind.split());
                one.iter().copied().fold(f64::INFINITY, f64::min) - other.iter().copied().fold(f64::NEG_INFINITY, f64::max)
            });
            let extent = (3.0 + apart) * size;
            let rounding = 1e-5 * extent + 1e-6 * far;
            let of_axis = (rounding / between.length()) * extent;
            prop_assert!(gap >= start.min(end) - rounding - of_axis || between.length() < rounding, "{gap} of {}", start.min(end));
        }

        /// What is said to be near is, however far from the origin, and hardly anything that is goes unsaid.
        #[test]
        fn what_is_within_is_so(
            corners in prop::array::uniform4(prop::array::uniform3(-1.0_f64..1.0)),
            size in -3_i32..2,
            far in 0.0_f64..1e3,
            close in prop::sample::select(vec![0.9_f64, 0.999_999, 1.0, 1.000_001, 1.1]),
        ) {
            let x: Vec<DVec3> = corners.iter().map(|&corner| DVec3::from(corner) * 10_f64.powi(size) + DVec3::splat(far)).collect();
            let apart = x[1..].iter().flat_map(|a| x[1..].iter().map(|b| a.distance(*b))).fold(0.0, f64::max);
            let mut list = Ways::new(4);
            list.take(&Places { ends: x.clone(), x, ..Places::default() }, |_| 0.0, &mut [Bounds::NOTHING; 4], &Pool::new(1));
            let longest = (apart * close) as f32;
            let is_said = list.are_within(&[1, 2, 3], longest);
            prop_assert!(!is_said || apart <= f64::from(longest), "{apart} within {longest}");
            prop_assert!(is_said || f64::from(longest) < 1.000_01 * apart + 2e-6 * (1.0 + far), "{apart} not within {longest}");
        }

        /// Nor is that of a part of an edge, up to where it is cut off.
        #[test]
        fn gaps_of_near_parts_are_no_wider_than_what_is_there(
            corners in prop::array::uniform4(prop::array::uniform3(-1.0_f64..1.0)),
            ways in prop::array::uniform4(prop::array::uniform3(-1.0_f64..1.0)),
            long in 0.0_f64..20.0,
            size in -3_i32..2,
            far in 0.0_f64..1e3,
            fast in 0.0_f64..2.0,
            within in 0.01_f64..2.0,
        ) {
            let size = 10_f64.powi(size);
            let mut x = corners.map(|corner| DVec3::splat(far * size) + DVec3::from(corner) * size);
            x[1] = x[0] + (x[1] - x[0]) * long;
            let ends: Vec<DVec3> = x.iter().zip(ways).map(|(x, way)| *x + DVec3::from(way) * fast * size).collect();
            let places = Places { x: x.to_vec(), ends, ..Places::default() };
            let limit = (within * size) as f32;
            let (pair, gap) = gap(Kind::EdgeEdge, &places, Some(limit));
            let gap = f64::from(gap.min(limit));
            let motion = Motion::of(&places, pair);
            let distance = least(&motion);
            prop_assert!(gap <= distance, "{gap} at a distance of {distance}");
        }

        /// A rod of 1 m that swings about its middle keeps its distance from an edge of 1 cm that moves along with it.
        #[test]
        fn a_rod_that_swings_keeps_its_distance(angle in -0.02_f64..0.02, at in 0.3_f64..0.7, apart in 0.005_f64..0.02) {
            let turned = |place: DVec3| DVec3::new(0.5, 0.0, 0.0) + DQuat::from_rotation_y(angle) * (place - DVec3::new(0.5, 0.0, 0.0));
            let x = vec![DVec3::ZERO, DVec3::X, DVec3::new(at, -0.005, apart), DVec3::new(at, 0.005, apart)];
            let ends = x.iter().map(|place| turned(*place)).collect();
            let places = Places { x, ends, ..Places::default() };
            let of = |of_near_part: Option<f32>| gap(Kind::EdgeEdge, &places, of_near_part).1;
            let lost = (apart as f32 - of(Some(apart as f32))).max(0.0);
            // The part that is near swings by its length times the angle.
            prop_assert!(lost < 1e-4 + 2.0 * angle.abs() as f32 * apart as f32, "{lost}");
            prop_assert!(angle.abs() < 0.005 || of(None) < of(Some(apart as f32)));
        }

        /// What is told off asks for no row in double precision either: it is too far away and stays so, or an edge is closest at its end.
        #[test]
        fn what_is_told_off_asks_for_nothing(
            corners in prop::array::uniform4(prop::array::uniform3(-1.0_f64..1.0)),
            ways in prop::array::uniform4(prop::array::uniform3(-1.0_f64..1.0)),
            flat in 0.0_f64..1.0,
            fast in -8_i32..0,
            within in 0.0_f64..1.0,
            far in -3.0_f64..3.0,
            is_triangle: bool,
            are_sides: bool,
        ) {
            let kind = if is_triangle { Kind::PointTriangle } else { Kind::EdgeEdge };
            let flatten = DVec3::new(1.0, flat, flat * flat);
            let x: Vec<DVec3> = corners.iter().map(|&corner| DVec3::splat(10_f64.powf(far)) + DVec3::from(corner) * flatten).collect();
            let ends = x.iter().zip(ways).map(|(x, way)| *x + DVec3::from(way) * 10_f64.powi(fast)).collect();
            let places = Places { x, ends, ..Places::default() };
            let asks = Asks { within: within as f32, are_sides };
            let may_ask = looked_at(kind, &places, |four, ways| four.may_ask(ways, asks).eq([true]));
            let at = |places: &[DVec3]| [places[0], places[1], places[2], places[3]];
            let closest = Closest::new(kind, &at(&places.x));
            let distance = closest.way.length();
            let then: f64 = (0..4).map(|corner| places.ends[corner].dot(closest.way / distance) * closest.parts[corner]).sum();
            let is_far = distance > f64::from(asks.within) && then > f64::from(asks.within);
            let is_at_end = are_sides && !is_triangle && closest.parts.contains(&0.0);
            prop_assert!(may_ask || is_far || is_at_end, "at {distance}, then {then}: {closest:?}");
            // Nearly all is told off that lies still and is not nearly parallel.
            let [a, b] = [places.x[1] - places.x[0], places.x[3] - places.x[2]];
            let is_clear = flat > 0.3 && far < 0.0 && fast < -6 && a.cross(b).length() > 0.3 * a.length() * b.length();
            prop_assert!(!(may_ask && !is_triangle && is_clear && distance > 1.05 * within + 1e-3), "at {distance}, not {within}");
        }
    }
}
