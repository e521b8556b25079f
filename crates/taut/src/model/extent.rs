//! How large a cloth is.

use std::ops::Range;

use glam::DVec3;

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

#[cfg(test)]
mod tests {
    use serde_json::json;

    use crate::model::Model;
    use crate::scene::Scene;

    fn size(shape: &serde_json::Value) -> f64 {
        let scene = Scene::from_json(&json!({ "cloth": [shape] }).to_string()).expect("a valid scene");
        Model::build(&scene, &std::collections::BTreeMap::new()).expect("a model").cloths[0].size
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
}
