//! How large a cloth is.

use std::ops::Range;

use glam::{DVec3, Vec3};

use super::Springs;
use crate::geometry::Vectors;

/// The side of the square that is as widely spread as some springs at rest [m]: the root of six times the mean square distance of their
/// points from their middle. It is the same however a cloth is turned and divided.
pub(super) fn size(springs: &Springs, which: Range<usize>, rest: &Vectors) -> f64 {
    let (mut length, mut middle, mut square) = (0.0, DVec3::ZERO, 0.0);
    let from = springs.ends.get(which.start).map_or(DVec3::ZERO, |ends| rest.get(ends[0] as usize).as_dvec3());
    for spring in which {
        let [a, b] = springs.ends[spring].map(|end| rest.get(end as usize).as_dvec3() - from);
        let along = a.distance(b);
        length += along;
        middle += 0.5 * (a + b) * along;
        square += (a.length_squared() + a.dot(b) + b.length_squared()) / 3.0 * along;
    }
    if length > 0.0 { (6.0 * (square / length - (middle / length).length_squared()).max(0.0)).sqrt() } else { 0.0 }
}

/// Places less than this part of a cloth off its plane are in it: rounding leaves no more.
const FLAT: f64 = 1e-6;

/// Directions in which some points extend, of length one and at right angles, the second one zero if they are in a line; none if they
/// are not in a plane, or all in one place.
pub(super) fn flat(points: &Vectors, which: Range<usize>) -> Option<[Vec3; 2]> {
    let from = points.get(which.start).as_dvec3();
    let farthest = |axes: &[DVec3]| {
        let ways = which.clone().map(|point| {
            let way = points.get(point).as_dvec3() - from;
            axes.iter().fold(way, |way, axis| way - *axis * axis.dot(way))
        });
        ways.fold(DVec3::ZERO, |most, way| if way.length_squared() > most.length_squared() { way } else { most })
    };
    let long = farthest(&[]);
    let one = long.try_normalize()?;
    let seen = FLAT * long.length();
    let broad = farthest(&[one]);
    if broad.length() <= seen {
        return Some([one.as_vec3(), Vec3::ZERO]);
    }
    let other = broad.normalize();
    (farthest(&[one, other]).length() <= seen).then(|| [one.as_vec3(), other.as_vec3()])
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use glam::Vec3;

    use crate::model::{ClothRange, Model};
    use crate::scene::Scene;

    fn cloth(shape: &serde_json::Value) -> ClothRange {
        let scene = Scene::from_json(&json!({ "cloth": [shape] }).to_string()).expect("a valid scene");
        Model::build(&scene, &std::collections::BTreeMap::new()).expect("a model").cloths[0].clone()
    }

    fn size(shape: &serde_json::Value) -> f64 {
        cloth(shape).size
    }

    #[test]
    fn the_size_of_a_cloth_does_not_depend_on_how_it_is_divided_turned_and_put() {
        for cells in [4, 32, 100] {
            let sheet = json!({
                "grid": { "size": [2.0, 2.0], "cells": [cells, cells] }, "rotate": [30.0, 40.0, 50.0], "translate": [90.0, 0.0, 0.0],
            });
            assert!((size(&sheet) / 2.0 - 1.0).abs() < 0.5 / f64::from(cells), "{cells}: {}", size(&sheet));
        }
        for links in [1, 2, 30] {
            let points: Vec<[f64; 3]> = (0..=links).map(|point| [3.0 * f64::from(point) / f64::from(links), 1.0, 2.0]).collect();
            let chain =
                json!({ "network": { "points": points, "links": (0..links).map(|link| [link, link + 1]).collect::<Vec<_>>() } });
            assert!((size(&chain) - 3.0 * 0.5_f64.sqrt()).abs() < 1e-5, "{links}: {}", size(&chain));
        }
        let points = json!({ "network": { "points": [[0, 0, 0]], "links": [] } });
        assert_eq!(size(&points), 0.0);
    }

    #[test]
    fn a_cloth_is_flat_if_its_points_are_in_a_plane_or_in_a_line() {
        for turn in [0.0, 31.0, 90.0] {
            let sheet = json!({
                "grid": { "size": [2.0, 1.0], "cells": [40, 20] }, "rotate": [turn, 40.0, 50.0], "translate": [90.0, 3.0, 0.0],
            });
            let [one, other] = cloth(&sheet).extends.expect("a grid is flat");
            assert!((one.length() - 1.0).abs() < 1e-6 && (other.length() - 1.0).abs() < 1e-6 && one.dot(other).abs() < 1e-6);
        }
        let net = |last: f64| {
            let points = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [2.0, 2.0, 0.0], [3.0, 3.0, last]];
            cloth(&json!({ "network": { "points": points, "links": [[0, 1], [1, 2], [2, 3]] } })).extends
        };
        assert_eq!(net(0.0), Some([Vec3::new(1.0, 1.0, 0.0).normalize(), Vec3::ZERO]));
        assert!(net(0.1).is_some_and(|[_, other]| other.length() > 0.9));
        let points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
        assert_eq!(cloth(&json!({ "network": { "points": points, "links": [[0, 1], [0, 2], [0, 3]] } })).extends, None);
        assert_eq!(cloth(&json!({ "network": { "points": [[1, 2, 3]], "links": [] } })).extends, None);
    }
}
