//! What intersects at the start is found, counted and told.

use crate::common::oracle::pierces;
use crate::common::{self, Built, crooked, mesh_scene, model};
use glam::DVec3;
use proptest::prelude::*;
use serde_json::{Value, json};
use taut::contact::{Fault, Intersections, Other};
use taut::geometry::Vectors;
use taut::model::MeshData;

fn found(model: &Built) -> Intersections {
    Intersections::at_start(model)
}

/// A sheet of 1 m, at a height, with one thickness for all.
fn flat(height: f64, cells: u32) -> Value {
    json!({ "grid": { "size": [1, 1], "cells": [cells, cells], "axes": ["x", "y"], "origin": [0, 0, height] }, "thickness": 0.004 })
}

fn with(cloth: Value, body: Value) -> Built {
    model(&json!({ "cloth": [cloth], "body": [body], "contact": { "self": false } }))
}

/// The warnings of a start.
fn told(model: &Built) -> Vec<&String> {
    model.model.warnings.iter().filter(|text| text.contains(" at the start: ")).collect()
}

/// A sheet of two triangles and an upright one that passes through it along a line of half its length.
fn crossing() -> [Value; 2] {
    let upright = json!({ "size": [0.5, 1], "cells": [1, 1], "axes": ["x", "z"], "origin": [0.25, 0.4, -0.5] });
    [flat(0.0, 1), json!({ "name": "upright", "grid": upright })]
}

#[test]
fn two_squares_that_cross_do_so_at_four_places() {
    let scene = |alone: bool| json!({ "cloth": crossing(), "contact": { "self": alone } });
    let built = model(&scene(true));
    let found = found(&built);
    // Both sides and the diagonal of the upright one, and the diagonal of the flat one.
    assert_eq!((found.count, found.places.len(), found.pairs.len()), (4, 4, 1));
    for place in &found.places {
        assert_eq!((place.cloth, place.other, place.fault, place.depth), (0, Other::Cloth(1), Fault::Crosses, None));
        assert!(place.place.z.abs() < 1e-6 && (place.place.y - 0.4).abs() < 1e-6, "{place:?}");
        assert!((0.25..=0.75).contains(&(place.place.x as f32)), "{place:?}");
    }
    let told = told(&built);
    let parts =
        ["scene.cloth[0] (cloth0) intersects cloth[1] (upright) at the start: 4 places, the first at [", "move one of them"];
    assert!(told.len() == 1 && parts.iter().all(|part| told[0].contains(part)), "{told:?}");
    assert_eq!(Intersections::at_start(&model(&scene(false))), Intersections::default(), "they do not touch each other");
}

#[test]
fn a_cloth_that_crosses_itself_is_found() {
    let squares = |y: f64| {
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let upright = [[0.25, y, -0.5], [0.75, y, -0.5], [0.75, y, 0.5], [0.25, y, 0.5]];
        MeshData { vertices: [square, upright].concat(), corners: (0..8).collect(), counts: vec![4, 4] }
    };
    let built = mesh_scene(json!({}), json!({ "thickness": 0.004 }), squares(0.4));
    assert_eq!(found(&built).count, 4);
    let told = told(&built);
    assert!(told.len() == 1 && told[0].contains("(cloth0) intersects itself at the start: 4 places"), "{told:?}");
    assert!(told[0].contains("mend its mesh, or set contact.self = false"), "{told:?}");
    let built = mesh_scene(json!({}), json!({ "thickness": 0.004 }), squares(1.1));
    assert!(found(&built).count == 0 && built.model.warnings.is_empty(), "{:?}", built.model.warnings);
}

#[test]
fn a_sheet_through_a_box_crosses_it_and_is_inside() {
    let block = json!({ "name": "block", "box": { "center": [0.52, 0.49, 0.013], "size": [0.3, 0.3, 0.3] } });
    let built = with(flat(0.0, 4), block);
    let found = found(&built);
    let inside: Vec<_> = found.places.iter().filter(|place| place.fault == Fault::Inside).collect();
    assert_eq!(inside.len(), 1);
    assert_eq!((inside[0].vertex, inside[0].place), (12, DVec3::new(0.5, 0.5, 0.0)));
    assert_eq!(found.count - 1, crossings(&built));
    let told = told(&built);
    assert!(told.len() == 1 && told[0].contains("(cloth0) intersects body[0] (block) at the start: "), "{told:?}");
    assert!(told[0].contains("or let the body come with `move`"), "{told:?}");
}

#[test]
fn cloth_inside_of_bodies_is_found_with_its_depth() {
    let all = |body: Value| found(&with(flat(0.0, 4), body));
    let ball = all(json!({ "sphere": { "center": [0.5, 0.5, 0.0], "radius": 2.0 } }));
    assert_eq!(ball.count, 32, "every triangle");
    let deepest = ball.places.iter().filter_map(|place| place.depth).fold(0.0, f64::max);
    assert!((deepest - 2.0).abs() < 1e-6, "{deepest}");
    let rod = all(json!({ "capsule": { "from": [-1, 0.5, 0], "to": [2, 0.5, 0], "radius": 0.2 } }));
    assert_eq!(rod.count, 16, "the triangles of two rows");
    assert!(rod.places.iter().all(|place| place.depth.is_some_and(|depth| (depth - 0.2).abs() < 1e-6)));
    let through = all(json!({ "capsule": { "from": [0.6, 0.55, -1], "to": [0.6, 0.55, 1], "radius": 0.01 } }));
    assert_eq!((through.count, through.places[0].depth), (1, Some(0.01)));
    let block = all(json!({ "box": { "center": [0.5, 0.5, 0.0], "size": [2, 2, 2], "rotate": [10, 20, 30] } }));
    assert_eq!((block.count, block.places[0].depth), (25, None));
    let plane = |height: f64| json!({ "plane": { "point": [0, 0, height], "normal": [0, 0, 1] } });
    assert_eq!(all(plane(0.0)).count, 0, "it lies on the plane");
    let behind = all(plane(0.1));
    assert!(behind.count == 25 && behind.places.iter().all(|place| (place.depth.unwrap_or(0.0) - 0.1).abs() < 1e-6));
    let built = with(flat(0.0, 4), plane(0.1));
    assert!(told(&built)[0].contains("is behind body[0] (body0) at the start: 25 places"), "{:?}", told(&built));
    assert!(told(&built)[0].contains("near vertex 0, 0.1 m deep"), "{:?}", told(&built));
}

#[test]
fn what_is_inside_of_a_mesh_does_not_depend_on_its_sides() {
    // Two boxes, one within the other: between them is inside, in the inner one is outside.
    let mut shells = MeshData::default();
    for (size, turned) in [(3.0, false), (2.4, true)] {
        let first = shells.vertices.len() as i64;
        let side = |bit: i64, number: i64| if number >> bit & 1 == 1 { 0.5 * size } else { -0.5 * size };
        shells.vertices.extend((0..8).map(|number| [side(0, number), side(1, number), side(2, number)]));
        for mut face in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
            if turned {
                face.reverse();
            }
            shells.corners.extend(face.map(|corner| corner + first));
            shells.counts.push(4);
        }
    }
    let count = |height: f64, mesh: &MeshData| {
        let scene = json!({ "cloth": [flat(height, 4)], "body": [{ "mesh": "shells" }], "contact": { "self": false } });
        let meshes = std::collections::BTreeMap::from([("shells".to_owned(), mesh.clone())]);
        found(&common::build(&common::scene(&scene), &meshes).expect("a model")).count
    };
    assert_eq!([0.0, 1.35, 1.75].map(|height| count(height, &shells)), [0, 25, 0]);
    shells.corners[..24].reverse();
    assert_eq!([0.0, 1.35, 1.75].map(|height| count(height, &shells)), [0, 25, 0]);
    // Without its lid it holds nothing.
    shells.corners.truncate(20);
    shells.counts.truncate(5);
    assert_eq!(count(0.0, &shells), 0);
}

#[test]
fn what_lies_exactly_on_a_surface_touches_it() {
    let block = |top: f64| json!({ "box": { "center": [0.5, 0.5, top - 0.5], "size": [1, 1, 1] } });
    assert!(found(&with(flat(0.0, 4), block(0.0))).count > 0);
    assert_eq!(found(&with(flat(0.0, 4), block(-1e-4))).count, 0);
}

#[test]
fn no_more_than_a_hundred_places_are_kept_and_all_are_counted() {
    let found = found(&with(flat(0.0, 20), json!({ "sphere": { "center": [0.5, 0.5, 0], "radius": 2 } })));
    assert_eq!((found.count, found.places.len(), found.pairs[0].count), (800, 100, 800));
}

#[test]
fn places_are_in_the_world_and_of_any_moment() {
    let far = |way: f64| {
        let mut cloth = flat(0.0, 4);
        cloth["translate"] = json!([way, 0.0, 0.0]);
        with(cloth, json!({ "sphere": { "center": [way + 0.3, 0.28, 0.0], "radius": 0.01 } }))
    };
    for way in [0.0, 5000.0] {
        let found = found(&far(way));
        assert!(found.count == 1 && (found.places[0].place.x - way - 0.3).abs() < 1e-3, "{found:?}");
    }
    let built = far(0.0);
    let raised: Vectors = built.particles.rest.iter().map(|place| place + glam::Vec3::Z).collect();
    let origins: Vec<DVec3> = built.origins.iter().map(|origin| origin.at).collect();
    assert_eq!(Intersections::find(&built, &origins, &raised, &built.bodies.rest).count, 0);
}

/// How many pairs of an edge and a triangle, one of the cloth and the other not, intersect.
fn crossings(built: &Built) -> usize {
    let of_cloth: Vec<DVec3> = built.particles.rest.iter().map(|place| place.as_dvec3() + built.origins[0].at).collect();
    let sides = |triangles: &[[u32; 3]]| {
        let mut sides: Vec<[u32; 2]> =
            triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).map(|[a, b]| [a.min(b), a.max(b)]).collect();
        sides.sort_unstable();
        sides.dedup();
        sides
    };
    let count = |x: &[DVec3], edges: &[[u32; 3]], y: &[DVec3], triangles: &[[u32; 3]]| {
        let pairs = sides(edges).into_iter().flat_map(|edge| triangles.iter().map(move |triangle| (edge, triangle)));
        pairs.filter(|(edge, corners)| pierces(edge.map(|end| x[end as usize]), corners.map(|corner| y[corner as usize]))).count()
    };
    let (x, y) = (&of_cloth, &built.bodies.rest);
    count(x, &built.triangles, y, &built.bodies.triangles) + count(y, &built.bodies.triangles, x, &built.triangles)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn crossings_are_those_of_other_arithmetic(
        at in prop::array::uniform3(-0.2_f64..1.2),
        size in prop::array::uniform3(0.05_f64..0.8),
        turn in prop::array::uniform3(0.0_f64..90.0),
    ) {
        let body = json!([{ "box": { "center": at, "size": size, "rotate": turn } }]);
        let built = mesh_scene(json!({ "body": body, "contact": { "self": false } }), json!({ "thickness": 0.004 }), crooked(7));
        let found = found(&built);
        // Inside, by the coordinates of the box.
        let turn = taut::geometry::turn(turn).inverse();
        let half = 0.5 * DVec3::from_array(size);
        let is_inside = |place: DVec3| ((turn * (place - DVec3::from_array(at))).abs().cmplt(half)).all();
        let expected = built.particles.rest.iter().filter(|place| is_inside(place.as_dvec3() + built.origins[0].at)).count();
        prop_assert_eq!(found.count, crossings(&built) + expected);
    }
}
