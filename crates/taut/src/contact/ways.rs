//! The ways of all vertices in single precision, for a first look at pairs: most of them are far enough from each other.

use glam::{Mat4, Vec3A, Vec4};

use super::Places;
use super::detect::Pair;
use super::proximity::Kind;
use super::tree::Bounds;
use crate::geometry::{Pool, for_each_two_chunks};

/// Boxes are wider by this part of the largest coordinate: places are rounded to single precision.
const ROUNDING: f32 = 2.0 * f32::EPSILON;
/// A gap is less by these parts of the largest coordinate, and of the largest one as seen from the first corner, than it is found to be:
/// places are rounded, and so are their differences, the axis (twice, as it is normalized) and products with it.
const OF_PLACES: f32 = 4.0 * f32::EPSILON;
const OF_DIFFERENCES: f32 = 24.0 * f32::EPSILON;

/// Where vertices start and end [m].
#[derive(Debug, Default)]
pub(crate) struct Ways {
    list: Vec<[Vec3A; 2]>,
}

impl Ways {
    pub fn new(vertices: usize) -> Self {
        Self { list: vec![[Vec3A::ZERO; 2]; vertices] }
    }

    /// Takes them, and boxes of vertices that are wider by what `half` says of each [m] on all sides.
    pub fn take(&mut self, places: &Places, half: impl Fn(usize) -> f32 + Sync, bounds: &mut [Bounds], pool: &Pool) {
        for_each_two_chunks(&mut self.list, bounds, pool, |first, ways, bounds| {
            let ends = places.x[first..].iter().zip(&places.ends[first..]);
            for (((way, bounds), (x, end)), vertex) in ways.iter_mut().zip(bounds).zip(ends).zip(first..) {
                let half = half(vertex);
                *way = [x.as_vec3a(), end.as_vec3a()];
                *bounds = Bounds::around(*way, way.map(|place| half + ROUNDING * place.abs().max_element()));
            }
        });
    }

    /// How far two features are apart, at least, at the start and at the end of the step along the line between their middles at the
    /// start [m]; below zero where that says nothing. If it is above zero they are as far apart on all of the way.
    pub fn gap(&self, Pair { kind, corners }: Pair) -> f32 {
        let ways = corners.map(|corner| self.list[corner as usize]);
        let of = |at: usize| ways.map(|way| way[at]);
        let [starts, ends] = [of(0), of(1)];
        let largest = starts.iter().chain(&ends).fold(Vec3A::ZERO, |largest, place| largest.max(place.abs())).max_element();
        // The corners in lanes, from the first one.
        let [from, to] = [starts, ends].map(|places| {
            let columns = places.map(|place| (place - places[0]).extend(0.0));
            let rows = Mat4::from_cols(columns[0], columns[1], columns[2], columns[3]).transpose();
            [rows.x_axis, rows.y_axis, rows.z_axis]
        });
        let weights = match kind {
            Kind::PointTriangle => Vec4::new(1.0, -1.0 / 3.0, -1.0 / 3.0, -1.0 / 3.0),
            Kind::EdgeEdge => Vec4::new(0.5, 0.5, -0.5, -0.5),
        };
        let between = from.map(|row| sum(row * weights));
        let length = (between[0] * between[0] + between[1] * between[1] + between[2] * between[2]).sqrt();
        if length == 0.0 {
            return -1.0;
        }
        let axis = between.map(|part| part / length);
        let along = |rows: [Vec4; 3]| rows[0] * axis[0] + rows[1] * axis[1] + rows[2] * axis[2];
        let [start, end] = [from, to].map(|rows| {
            let [a, b, c, d] = along(rows).to_array();
            match kind {
                Kind::PointTriangle => a - b.max(c).max(d),
                Kind::EdgeEdge => a.min(b) - c.max(d),
            }
        });
        let furthest = from.iter().chain(&to).fold(Vec4::ZERO, |furthest, row| furthest.max(row.abs())).max_element();
        start.min(end) - OF_PLACES * largest - OF_DIFFERENCES * furthest
    }
}

/// The sum of all lanes, in their order on every machine.
fn sum(lanes: Vec4) -> f32 {
    let [a, b, c, d] = lanes.to_array();
    a + b + c + d
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use proptest::prelude::*;

    use super::super::crossing::Motion;
    use super::*;
    use crate::contact::proximity::Closest;

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
            let mut list = Ways::new(4);
            list.take(&places, |_| 0.0, &mut [Bounds::NOTHING; 4], &Pool::new(1));
            let pair = Pair { kind, corners: [0, 1, 2, 3] };
            let gap = f64::from(list.gap(pair));
            let motion = Motion::of(&places, pair);
            for part in 0..=20 {
                let at = [0, 1, 2, 3].map(|corner| motion.x[corner] + motion.d[corner] * (f64::from(part) / 20.0));
                let distance = Closest::new(kind, &at).way.length();
                prop_assert!(gap <= distance, "{gap} at a distance of {distance}");
            }
            // It says nearly all that there is to say along this line, which is rounded itself: the more, the closer its ends.
            let middle = |of: &[DVec3]| of.iter().sum::<DVec3>() / of.len() as f64;
            let (one, other) = motion.x.split_at(kind.split());
            let between = middle(one) - middle(other);
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
    }
}
