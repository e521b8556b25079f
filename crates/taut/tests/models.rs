//! Grids, meshes and networks lead to the same cloth where they describe the same cloth.

use std::collections::BTreeMap;

use crate::common::{mesh_model, model, network};
use serde_json::json;
use taut::model::{MeshData, Model, SpringKind};

/// Springs by the vertices of their ends: kind, rest length, stiffness.
fn springs(model: &Model) -> BTreeMap<[u32; 2], (bool, f32, f32)> {
    let all = &model.springs;
    (0..all.len())
        .map(|index| {
            let [a, b] = all.ends[index].map(|end| model.numbering.vertex(end));
            ([a.min(b), a.max(b)], (all.kind[index] == SpringKind::Shear, all.rest[index], all.stiffness[index]))
        })
        .collect()
}

fn lattice(nx: i64, ny: i64, quads: bool) -> MeshData {
    let mut mesh = MeshData::default();
    for j in 0..=ny {
        for i in 0..=nx {
            mesh.vertices.push([0.1 * i as f64, 0.0, 0.1 * j as f64]);
        }
    }
    for j in 0..ny {
        for i in 0..nx {
            let a = j * (nx + 1) + i;
            let [b, c, d] = [a + 1, a + nx + 2, a + nx + 1];
            if quads {
                mesh.corners.extend([a, b, c, d]);
                mesh.counts.push(4);
            } else {
                mesh.corners.extend([a, b, d, b, c, d]);
                mesh.counts.extend([3, 3]);
            }
        }
    }
    mesh
}

#[test]
fn a_grid_that_comes_in_as_a_mesh_has_the_grids_springs() {
    let cloth = json!({ "stiffness": 30.0, "shear_stiffness": 12.0 });
    let mut grid = cloth.clone();
    grid["grid"] = json!({ "size": [0.7, 0.5], "cells": [7, 5] });
    let expected = springs(&model(&json!({ "cloth": [grid] })));
    assert_eq!(expected.len(), 7 * 6 + 8 * 5 + 2 * 35);
    for quads in [true, false] {
        let found = springs(&mesh_model(cloth.clone(), lattice(7, 5, quads)));
        assert_eq!(expected.keys().collect::<Vec<_>>(), found.keys().collect::<Vec<_>>(), "quads: {quads}");
        for (ends, (shear, rest, stiffness)) in &expected {
            let other = found[ends];
            assert_eq!(*shear, other.0, "{ends:?}");
            assert!((rest - other.1).abs() < 1e-6 && (stiffness - other.2).abs() < 1e-3, "{ends:?}: {stiffness} and {}", other.2);
        }
    }
}

#[test]
fn mass_is_density_times_area_whatever_the_resolution_and_the_transform() {
    for cells in [1, 3, 16] {
        let cloth = json!({
            "grid": { "size": [0.8, 0.5], "cells": [cells, cells] }, "density": 0.2,
            "scale": 2.0, "rotate": [30.0, 40.0, 50.0], "translate": [1.0, 2.0, 3.0],
        });
        let model = model(&json!({ "cloth": [cloth] }));
        let mass: f64 = model.particles.mass.iter().map(|&mass| f64::from(mass)).sum();
        assert!((mass / (0.2 * 0.8 * 0.5 * 4.0) - 1.0).abs() < 1e-5, "{mass} kg");
        let corner = f64::from(model.particles.mass[0]);
        assert!((corner * 4.0 * f64::from(cells * cells) / mass - 1.0).abs() < 1e-5, "a corner carries a quarter of a cell");
    }
}

#[test]
fn vertices_and_faces_keep_the_users_order_and_rotation_is_x_then_y_then_z() {
    let mesh = MeshData {
        vertices: vec![[0.0, 1.0, 0.0], [9.0, 9.0, 9.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
        corners: vec![2, 3, 0],
        counts: vec![3],
    };
    let model = mesh_model(json!({ "rotate": [90.0, 0.0, 90.0] }), mesh);
    assert_eq!(model.triangles[0].map(|corner| model.numbering.vertex(corner)), [2, 3, 0]);
    // About x: (0, 1, 0) -> (0, 0, 1), which z leaves alone; (1, 0, 0) stays, then turns to (0, 1, 0).
    let places = model.numbering.to_vertices(&model.particles.rest);
    let at = |vertex| places.get(vertex);
    assert_eq!(model.numbering.to_particles(&places), model.particles.rest);
    assert!((at(0) - glam::Vec3::Z).length() < 1e-6 && (at(3) - glam::Vec3::Y).length() < 1e-6, "{} {}", at(0), at(3));
    assert_eq!(model.particle_count(), 4);
    assert_eq!(model.particles.inverse_mass[model.numbering.particle(1) as usize], 0.0);
}

#[test]
fn corners_and_edges_are_named_as_seen_from_the_front() {
    let held = |pin: serde_json::Value| {
        let cloth = json!({ "grid": { "size": [3.0, 2.0], "cells": [3, 2] }, "pins": [pin] });
        model(&json!({ "cloth": [cloth] })).pins[0].particles.clone()
    };
    assert_eq!(held(json!({ "corner": "bottom-left" })), [0]);
    assert_eq!(held(json!({ "corner": "bottom-right" })), [3]);
    assert_eq!(held(json!({ "corner": "top-left" })), [8]);
    assert_eq!(held(json!({ "corner": "top-right" })), [11]);
    assert_eq!(held(json!({ "edge": "left" })), [0, 4, 8]);
    assert_eq!(held(json!({ "edge": "right" })), [3, 7, 11]);
    assert_eq!(held(json!({ "edge": "top" })), [8, 9, 10, 11]);
    assert_eq!(held(json!({ "edge": "bottom" })), [0, 1, 2, 3]);
    assert_eq!(held(json!({ "nearest": [2.1, 0.0, 1.2] })), [6]);
    assert_eq!(held(json!({ "box": [[-0.1, -0.1, 0.9], [1.1, 0.1, 2.1]] })), [4, 5, 8, 9]);
}

#[test]
fn several_cloths_stand_one_after_the_other_and_type_1_springs_come_first() {
    let mut rope = network(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], &[[0, 1], [1, 2]], 0.01);
    rope["flexion_stiffness"] = json!(3.0);
    rope["name"] = json!("rope");
    let sheet = json!({ "grid": { "cells": [2, 2] }, "flexion_stiffness": 1.0, "pins": [{ "corner": "top-right" }] });
    let model = model(&json!({ "cloth": [rope, sheet] }));
    assert_eq!(model.cloths[1].first, 3);
    assert_eq!(model.pins[0].particles, [3 + 8]);
    let springs = &model.springs;
    let kinds: Vec<bool> = springs.kind.iter().map(|kind| kind.is_type1()).collect();
    assert!(kinds.is_sorted_by(|a, b| a >= b));
    assert_eq!(springs.type1, 2 + 6 + 6 + 8);
    assert_eq!(springs.len() - springs.type1, 1 + 3 + 3);
    for spring in springs.type1..springs.len() {
        assert!(springs.strain_limit[spring].is_infinite() && springs.greatest_length(spring).is_infinite());
    }
    assert_eq!(springs.ends[springs.type1], [0, 2]);
}
