//! What makes flat cloth buckle.
//!
//! Cloth that is flat, with gravity in its plane, stays in that plane for ever: no force has a part across it, and zeros stay zeros. It
//! crumples into folds without breadth, where real cloth buckles. So gravity leans a little, another way at each particle: an
//! imperfection, as programs for plates and shells have one (docs/equations.md, "Imperfection").

use glam::Vec3;
use pulp::{Simd, WithSimd};

use crate::geometry::{VectorsChunk, arch};
use crate::model::ClothRange;
use crate::schedule::Stride;

/// Cloth leans, and gravity does the rest, where more than this part of gravity is across it [1].
const LEANS: f32 = 1e-5;

/// Adds what acts across flat cloth [m/s^2].
pub(super) fn accelerate(stride: Stride<'_>, gravity: Vec3, chunk: &mut VectorsChunk<'_>) {
    let (first, end) = (chunk.first, chunk.first + chunk.x.len());
    for cloth in &stride.model.cloths {
        let particles = cloth.particles();
        let part = particles.start.max(first)..particles.end.min(end);
        if part.is_empty() {
            continue;
        }
        let weights = &stride.model.particles.inverse_mass[part.clone()];
        let number = (part.start - particles.start) as u32;
        for (salt, pull) in (0..).zip(across(cloth, gravity)) {
            for (column, pull) in [(&mut chunk.x, pull.x), (&mut chunk.y, pull.y), (&mut chunk.z, pull.z)] {
                let acceleration = &mut column[part.start - first..part.end - first];
                arch().dispatch(Lean { acceleration, weights, pull, number, salt });
            }
        }
    }
}

/// Directions in which neither the cloth extends nor gravity acts, at right angles, as long as the greatest pull along them [m/s^2];
/// zero where there is none.
fn across(cloth: &ClothRange, gravity: Vec3) -> [Vec3; 2] {
    let greatest = cloth.imperfection * gravity.length();
    let Some([one, other]) = cloth.extends.filter(|_| greatest > 0.0) else { return [Vec3::ZERO; 2] };
    let beside = gravity - one * gravity.dot(one) - other * gravity.dot(other);
    let leans = beside.length() > LEANS * gravity.length();
    if other != Vec3::ZERO {
        return [if leans { Vec3::ZERO } else { one.cross(other) * greatest }, Vec3::ZERO];
    }
    // All along a line, which has two such directions where gravity acts along it.
    let next = if leans { beside.normalize() } else { one.any_orthonormal_vector() };
    [one.cross(next) * greatest, if leans { Vec3::ZERO } else { next * greatest }]
}

/// One coordinate of some particles.
struct Lean<'a> {
    acceleration: &'a mut [f32],
    weights: &'a [f32],
    pull: f32,
    number: u32,
    salt: u32,
}

impl WithSimd for Lean<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        if self.pull == 0.0 {
            return;
        }
        for ((acceleration, w), number) in self.acceleration.iter_mut().zip(self.weights).zip(self.number..) {
            let more = self.pull * noise(2 * number + self.salt);
            *acceleration += if *w > 0.0 { more } else { 0.0 };
        }
    }
}

/// A number between -1 and 1 that looks drawn by chance, the same one at all times.
#[inline(always)]
fn noise(number: u32) -> f32 {
    // What MurmurHash3 ends with (Appleby).
    let mut hash = number.wrapping_add(1);
    hash = (hash ^ (hash >> 16)).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
    hash ^= hash >> 16;
    (hash >> 8) as i32 as f32 / 8_388_608.0 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What acts across a cloth with these directions.
    fn pulls(extends: Option<[Vec3; 2]>, gravity: Vec3) -> [Vec3; 2] {
        let json = serde_json::json!({ "cloth": [{ "name": "c", "grid": { "size": [1, 1], "cells": [1, 1] } }] });
        let scene = crate::scene::Scene::from_json(&json.to_string()).unwrap();
        let model = crate::model::Model::build(&scene, &std::collections::BTreeMap::new()).unwrap();
        across(&ClothRange { extends, ..model.cloths[0].clone() }, gravity)
    }

    #[test]
    fn it_acts_in_the_directions_that_nothing_else_acts_in() {
        let (x, y, z, none) = (Vec3::X, Vec3::Y, Vec3::Z, Vec3::ZERO);
        let down = -10.0 * z;
        let count = |extends, gravity| pulls(extends, gravity).map(|pull| (pull * 1e4).abs().round());
        assert_eq!(count(None, down), [none, none], "cloth that is not flat");
        assert_eq!(count(Some([x, y]), down), [none, none], "lying cloth");
        assert_eq!(count(Some([x, z]), down), [y, none], "hanging cloth");
        assert_eq!(count(Some([x, none]), down), [y, none], "a level line");
        assert_eq!(count(Some([z, none]), down).map(Vec3::length), [1.0, 1.0], "an upright line");
        assert_eq!(count(Some([x, z]), none), [none, none], "no gravity");
        assert_eq!(count(Some([x, z]), -10.0 * (z + 1e-3 * y)), [none, none], "leaning cloth");
    }

    #[test]
    fn the_numbers_are_evenly_spread() {
        let all: Vec<f64> = (0..10_000).map(|number| f64::from(noise(number))).collect();
        let mean = |of: &dyn Fn(usize) -> f64| (0..9_000).map(of).sum::<f64>() / 9_000.0;
        assert!(all.iter().all(|number| (-1.0..1.0).contains(number)));
        assert!(mean(&|at| all[at]).abs() < 0.02);
        assert!((mean(&|at| all[at] * all[at]) - 1.0 / 3.0).abs() < 0.01);
        for apart in [1, 2, 48, 49, 64] {
            assert!(mean(&|at| all[at] * all[at + apart]).abs() < 0.015, "{apart}");
        }
    }
}
