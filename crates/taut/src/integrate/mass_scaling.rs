//! Selective mass scaling: a grid takes springs and dampers in fewer parts than its fastest vibrations need.
//!
//! Velocities gain S F h instead of F h / M, with the sum over grids of stride 1, 2, 4 ..
//!
//! ```text
//! S = sum_l a_l P_l M_l^-1 P_l^T
//! ```
//!
//! P_l interpolates, M_l = P_l^T M are the masses that a coarse particle carries, and the a_l add up to one: what a coarse grid
//! can show is accelerated as always, finer vibrations less, by 1/4 from grid to grid (the sum of Bramble, Pasciak & Xu 1990
//! [BPX90], as the inverse of a mass matrix in the sense of Olovsson, Simonsson & Unosson 2005 [Olovsson05]). S is symmetric
//! and positive, so nothing is damped, and where forces balance they still do; it keeps momentum where nothing is held
//! (docs/equations.md, "Scaled masses").

use pulp::{Arch, Simd, WithSimd};

use crate::geometry::{Pool, Vectors, VectorsChunk};
use crate::model::{ClothRange, Lattice, Model};

/// Fine rows that one call works on.
const BAND: usize = 16;

/// The coarse grids of a lattice.
pub(super) struct MassScaling {
    first: usize,
    /// Masses of its particles [kg]; zero for what is held.
    masses: Vec<f32>,
    columns: usize,
    rows: usize,
    coarse: Vec<Grid>,
    /// A row for each band that is worked on, and one more.
    scratch: Vec<Vec<f32>>,
}

/// A grid with every second column and row of the one before it.
struct Grid {
    columns: usize,
    rows: usize,
    /// 1 / M_l [1/kg]; zero for what is held, or carries what is held: it would tear at it.
    weights: Vec<f32>,
    /// P_l^T M V on the way up, velocities on the way down.
    field: Vectors,
}

/// How much of its acceleration each grid gives, the lattice itself first: a_l.
#[derive(Debug)]
pub(super) struct Shares(Vec<f32>);

impl Shares {
    /// With this much left of the finest vibrations [1].
    pub fn new(finest: f64) -> Self {
        let mut shares = vec![finest];
        let mut sum = finest;
        while sum < 1.0 {
            let next = (4.0 * sum).min(1.0);
            shares.push(next - sum);
            sum = next;
        }
        Self(shares.into_iter().map(|share| share as f32).collect())
    }
}

impl MassScaling {
    /// Grids for a lattice, as many as the shares ask for.
    pub fn new(model: &Model, cloth: &ClothRange, lattice: &Lattice, shares: [&Shares; 2]) -> Self {
        let weights = &model.particles.inverse_mass[cloth.particles()];
        let masses: Vec<f64> = weights.iter().map(|&w| if w > 0.0 { 1.0 / f64::from(w) } else { 0.0 }).collect();
        let most = shares.map(|shares| shares.0.len()).into_iter().max().unwrap_or(1);
        let mut coarse: Vec<Grid> = Vec::new();
        let (mut columns, mut rows, mut carried) = (lattice.columns, lattice.rows, masses.clone());
        while coarse.len() + 1 < most && columns.max(rows) > 2 {
            carried = carry(&carried, columns, rows);
            (columns, rows) = (coarsened(columns), coarsened(rows));
            let weights = carried.iter().map(|&mass| if mass > 0.0 { (1.0 / mass) as f32 } else { 0.0 });
            coarse.push(Grid { columns, rows, weights: weights.collect(), field: Vectors::zeros(columns * rows) });
        }
        Self {
            first: lattice.first,
            masses: masses.into_iter().map(|mass| mass as f32).collect(),
            columns: lattice.columns,
            rows: lattice.rows,
            coarse,
            scratch: vec![vec![0.0; lattice.columns + 1]; lattice.rows.div_ceil(BAND)],
        }
    }

    /// `velocities += S M gains`; gains of what is held are zero.
    pub fn add(&mut self, Shares(shares): &Shares, gains: &Vectors, velocities: &mut Vectors, pool: &Pool) {
        let Self { first, masses, columns, rows, coarse, scratch } = self;
        let particles = *first..*first + *columns * *rows;
        let levels = coarse.len().min(shares.len() - 1);
        for index in 0..levels {
            let (before, grids) = coarse.split_at_mut(index);
            let fine = match before.last() {
                Some(grid) => Fine { columns: grid.columns, rows: grid.rows, first: 0, field: &grid.field, masses: None },
                None => Fine { columns: *columns, rows: *rows, first: *first, field: gains, masses: Some(masses) },
            };
            let Grid { columns, rows, field, .. } = &mut grids[0];
            let columns = *columns;
            field.for_each_band(0..columns * *rows, BAND * columns, scratch, pool, |out, row| {
                Arch::new().dispatch(Restrict { fine: &fine, out, columns, row });
            });
        }
        // Where the lattice is too small for all grids, the coarsest has the share of those that are missing.
        let share = |level: usize| if level == levels { shares[level..].iter().sum() } else { shares[level] };
        for index in (0..levels).rev() {
            let (grids, coarser) = coarse.split_at_mut(index + 1);
            let coarser = coarser.first().filter(|_| index + 1 < levels);
            let Grid { columns, rows, weights, field } = &mut grids[index];
            let (columns, rows, share) = (*columns, *rows, share(index + 1));
            for column in [&mut field.x, &mut field.y, &mut field.z] {
                column.iter_mut().zip(&*weights).for_each(|(value, weight)| *value *= share * weight);
            }
            if let Some(coarser) = coarser {
                field.for_each_band(0..columns * rows, BAND * columns, scratch, pool, |out, row| {
                    Arch::new().dispatch(Prolong { out, first: 0, columns, rows, coarser, row });
                });
            }
        }
        velocities.add_scaled(particles.clone(), gains, share(0), pool);
        if let Some(coarser) = coarse.first().filter(|_| levels > 0) {
            let (first, columns, rows) = (*first, *columns, *rows);
            velocities.for_each_band(particles, BAND * columns, scratch, pool, |out, row| {
                Arch::new().dispatch(Prolong { out, first, columns, rows, coarser, row });
            });
        }
    }
}

/// How many coarse columns (or rows) `count` fine ones have.
fn coarsened(count: usize) -> usize {
    count.div_ceil(2)
}

/// The two coarse neighbours of a fine column (or row), each with weight 1/2; the same twice where it is sampled itself, and
/// beyond the last coarse one: a coarse cell that is narrower than the others would be stiffer than its level bears.
fn parents(fine: usize, count: usize) -> [usize; 2] {
    if fine.is_multiple_of(2) || fine + 1 == count { [fine / 2; 2] } else { [fine / 2, fine / 2 + 1] }
}

/// P^T M one grid up; nothing where that would carry what is held.
fn carry(masses: &[f64], columns: usize, rows: usize) -> Vec<f64> {
    let coarse_columns = coarsened(columns);
    let mut carried = vec![0.0; coarse_columns * coarsened(rows)];
    let mut held = vec![false; carried.len()];
    for (index, &mass) in masses.iter().enumerate() {
        for j in parents(index / columns, rows) {
            for i in parents(index % columns, columns) {
                carried[j * coarse_columns + i] += 0.25 * mass;
                held[j * coarse_columns + i] |= mass == 0.0;
            }
        }
    }
    carried.iter().zip(held).map(|(&mass, held)| if held { 0.0 } else { mass }).collect()
}

/// Where P^T takes from: velocities with their masses, or what has masses in it already.
struct Fine<'a> {
    columns: usize,
    rows: usize,
    first: usize,
    field: &'a Vectors,
    masses: Option<&'a [f32]>,
}

/// Some rows of P^T.
struct Restrict<'a> {
    fine: &'a Fine<'a>,
    out: VectorsChunk<'a>,
    columns: usize,
    row: &'a mut [f32],
}

impl WithSimd for Restrict<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { fine, out, columns, row } = self;
        let first = out.first / columns;
        for (out, field) in [(out.x, &fine.field.x), (out.y, &fine.field.y), (out.z, &fine.field.z)] {
            for (index, out) in out.chunks_exact_mut(columns).enumerate() {
                let row = &mut row[..fine.columns];
                row.fill(0.0);
                let coarse = first + index;
                for (there, part) in children(coarse, fine.rows) {
                    let start = there * fine.columns;
                    let from = &field[fine.first + start..][..fine.columns];
                    match fine.masses {
                        Some(masses) => {
                            let terms = from.iter().zip(&masses[start..][..fine.columns]);
                            row.iter_mut().zip(terms).for_each(|(sum, (value, mass))| *sum += part * mass * value);
                        }
                        None => row.iter_mut().zip(from).for_each(|(sum, value)| *sum += part * value),
                    }
                }
                gather(row, out);
            }
        }
    }
}

/// The fine rows of a coarse one, and what it takes of them; of `count` rows.
#[inline(always)]
fn children(coarse: usize, count: usize) -> impl Iterator<Item = (usize, f32)> {
    let near = (2 * coarse).saturating_sub(1)..(2 * coarse + 2).min(count);
    near.filter_map(move |fine| {
        let [a, b] = parents(fine, count);
        let part = 0.5 * (f32::from(a == coarse) + f32::from(b == coarse));
        (part > 0.0).then_some((fine, part))
    })
}

/// P^T along a row.
#[inline(always)]
fn gather(fine: &[f32], coarse: &mut [f32]) {
    let (pairs, rest) = fine.as_chunks::<2>();
    for (out, pair) in coarse.iter_mut().zip(pairs) {
        *out = pair[0] + 0.5 * pair[1];
    }
    match (rest, pairs) {
        ([last], _) => coarse[pairs.len()] = *last,
        // The last one has no neighbour to share with.
        (_, [.., last]) => coarse[pairs.len() - 1] += 0.5 * last[1],
        _ => {}
    }
    for (out, pair) in coarse[1..].iter_mut().zip(pairs) {
        *out += 0.5 * pair[1];
    }
}

/// P of a coarse row between two rows, along a row; `mean` is workspace.
#[inline(always)]
fn interpolate(coarse: &[f32], columns: usize, rows: [usize; 2], mean: &mut [f32]) {
    let [a, b] = rows.map(|row| &coarse[row * columns..][..columns]);
    for (mean, (a, b)) in mean.iter_mut().zip(a.iter().zip(b)) {
        *mean = 0.5 * (a + b);
    }
}

/// Adds what P gives along a row.
#[inline(always)]
fn spread(fine: &mut [f32], mean: &[f32]) {
    let shared = (fine.len() - 1) / 2;
    let (pairs, rest) = fine.as_chunks_mut::<2>();
    let sides = mean.iter().zip(&mean[1..]);
    for (pair, (left, right)) in pairs[..shared].iter_mut().zip(sides) {
        pair[0] += left;
        pair[1] += 0.5 * (left + right);
    }
    pairs[shared..].as_flattened_mut().iter_mut().chain(rest).for_each(|value| *value += mean[shared]);
}

/// Adds P of a coarser grid to some rows. What is held gets nothing: all that it follows is held as well.
struct Prolong<'a> {
    out: VectorsChunk<'a>,
    first: usize,
    columns: usize,
    rows: usize,
    coarser: &'a Grid,
    row: &'a mut [f32],
}

impl WithSimd for Prolong<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { out, first, columns, rows, coarser, row } = self;
        let start = (out.first - first) / columns;
        for (out, field) in [(out.x, &coarser.field.x), (out.y, &coarser.field.y), (out.z, &coarser.field.z)] {
            for (index, out) in out.chunks_exact_mut(columns).enumerate() {
                interpolate(field, coarser.columns, parents(start + index, rows), row);
                spread(out, &row[..coarser.columns]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use glam::{DVec3, Vec3};
    use serde_json::{Value, json};

    use super::*;
    use crate::forces::{Forces, gains};
    use crate::scene::Scene;

    fn model(cells: [u32; 2], pins: Value) -> Model {
        let grid = json!({ "size": [1.0, 0.8], "cells": cells, "axes": ["x", "y"] });
        let cloth = json!({ "grid": grid, "density": 0.2, "stiffness": 20.0, "damping": 0.0, "pins": pins });
        let document = json!({ "cloth": [cloth], "gravity": [0.0, 0.0, 0.0] });
        let scene = Scene::from_json(&document.to_string()).expect("a valid scene");
        Model::build(&scene, &BTreeMap::new()).expect("a valid model")
    }

    /// A grid of so many cells, its finest vibrations left with `share`.
    fn scaled(cells: [u32; 2], pins: Value, share: f64) -> (Model, MassScaling, Shares) {
        let (model, shares) = (model(cells, pins), Shares::new(share));
        let scaling = MassScaling::new(&model, &model.cloths[0], &model.lattices[0], [&shares, &shares]);
        (model, scaling, shares)
    }

    /// Some velocities that differ from particle to particle, those of held ones zero.
    fn velocities(model: &Model, seed: f32) -> Vectors {
        let value = |particle: usize| {
            let phase = seed + particle as f32;
            let free = f32::from(model.particles.inverse_mass[particle] > 0.0);
            Vec3::new((12.9 * phase).sin(), (78.2 * phase).sin(), (37.7 * phase).sin()) * free
        };
        (0..model.particle_count()).map(value).collect()
    }

    /// Sum of M a b.
    fn product(model: &Model, a: &Vectors, b: &Vectors) -> f64 {
        let terms = a.iter().zip(b.iter()).zip(&model.particles.mass);
        terms.map(|((a, b), mass)| f64::from(*mass) * a.as_dvec3().dot(b.as_dvec3())).sum()
    }

    fn apply(scaling: &mut MassScaling, shares: &Shares, field: &Vectors) -> Vectors {
        let mut result = Vectors::zeros(field.len());
        scaling.add(shares, field, &mut result, &Pool::new(1));
        result
    }

    const SIZES: [[u32; 2]; 6] = [[2, 2], [3, 2], [5, 9], [16, 16], [31, 12], [40, 33]];

    #[test]
    fn a_field_without_differences_passes_and_momentum_is_kept() {
        for cells in SIZES {
            for share in [1.0, 0.5, 0.1, 1e-3] {
                let (model, mut scaling, shares) = scaled(cells, json!([]), share);
                let even = (0..model.particle_count()).map(|_| Vec3::new(1.0, -2.0, 0.5)).collect();
                for value in apply(&mut scaling, &shares, &even).iter() {
                    assert!(value.abs_diff_eq(Vec3::new(1.0, -2.0, 0.5), 1e-5), "{cells:?}, {share}: {value}");
                }
                let momentum = |field: &Vectors| {
                    field.iter().zip(&model.particles.mass).map(|(v, mass)| v.as_dvec3() * f64::from(*mass)).sum::<DVec3>()
                };
                let field = velocities(&model, 0.3);
                let off = momentum(&apply(&mut scaling, &shares, &field)) - momentum(&field);
                assert!(off.length() < 1e-6, "{cells:?}, {share}: {off}");
            }
        }
    }

    #[test]
    fn it_is_symmetric_and_positive_and_moves_nothing_that_is_held() {
        for cells in SIZES {
            let (model, mut scaling, shares) =
                scaled(cells, json!([{ "corner": "top-left" }, { "nearest": [0.4, 0.3, 0.0] }]), 0.01);
            let (a, b) = (velocities(&model, 0.1), velocities(&model, 0.7));
            let (of_a, of_b) = (apply(&mut scaling, &shares, &a), apply(&mut scaling, &shares, &b));
            let (one, other) = (product(&model, &of_a, &b), product(&model, &a, &of_b));
            let size = product(&model, &a, &a);
            assert!((one - other).abs() < 1e-6 * size, "{cells:?}: {one} {other}");
            let kept = product(&model, &of_a, &a);
            assert!(kept > 0.0099 * size && kept < 1.001 * size, "{cells:?}: {kept} of {size}");
            for (value, weight) in of_a.iter().zip(&model.particles.inverse_mass) {
                assert!(*weight > 0.0 || value == Vec3::ZERO);
            }
        }
    }

    #[test]
    fn no_vibration_is_faster_than_the_step_bears() {
        for (cells, pins) in [
            ([20, 20], json!([])),
            ([33, 17], json!([{ "corner": "top-left" }])),
            ([62, 45], json!([{ "corner": "top-left" }, { "corner": "top-right" }])),
            ([130, 21], json!([])),
            ([98, 75], json!([{ "nearest": [0.31, 0.4, 0.0] }])),
            ([24, 40], json!([{ "edge": "left" }, { "nearest": [0.53, 0.41, 0.0] }])),
        ] {
            let timing = model(cells, pins.clone()).timing.scaled.expect("masses are scaled");
            let (model, mut scaling, shares) = scaled(cells, pins, timing.spring_share);
            // The largest eigenvalue by power iteration on small displacements.
            let (pool, mut forces, all) = (Pool::new(1), Forces::new(&model), 0..model.particle_count());
            let mut mode = velocities(&model, 0.2);
            let mut square = 0.0;
            for _ in 0..200 {
                let small = 1e-4 / product(&model, &mode, &mode).sqrt();
                let (mut moved, mut gained) = (model.particles.rest.clone(), Vectors::zeros(all.len()));
                moved.add_scaled(all.clone(), &mode, small as f32, &pool);
                gains(&model, &model.cloths[0], &moved, &mut gained, 1.0, &mut forces, &pool);
                mode = apply(&mut scaling, &shares, &gained);
                square = product(&model, &mode, &mode).sqrt() / 1e-4;
            }
            let part = model.timing.step_length / f64::from(timing.parts);
            let rate = square * timing.springs_ahead;
            assert!(part * part * square + 2.0 * part * rate < 4.0, "{cells:?}: {} {}", part * part * square, part * rate);
            assert!(part * part * square > 0.5, "{cells:?}: needlessly slow, {}", part * part * square);
        }
    }
}
