//! A regular grid: levels of stride 1, 2, 4 ..

use pulp::{Simd, WithSimd};

use super::{Acting, MassLevels};
use crate::geometry::{Pool, Vectors, VectorsChunk, arch};
use crate::model::coarse_grid::{carry, coarsened, parents};
use crate::model::{ClothRange, Lattice, LevelRate, Model, shares};

/// Fine rows that one call works on.
const BAND: usize = 16;

/// The coarse grids of a lattice.
pub(super) struct LatticeMassLevels {
    first: usize,
    /// Masses of its particles [kg]; zero for what is held.
    masses: Vec<f32>,
    columns: usize,
    rows: usize,
    coarse: Vec<Grid>,
    /// How much of its acceleration each level gives, the finest first, with springs and with dampers: a_l.
    shares: [Vec<f32>; 2],
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

impl LatticeMassLevels {
    /// So many grids for a lattice.
    pub fn new(model: &Model, cloth: &ClothRange, lattice: &Lattice, levels: usize) -> Self {
        let masses = model.particles.free_masses(cloth);
        let mut coarse: Vec<Grid> = Vec::new();
        let (mut columns, mut rows, mut carried) = (lattice.columns, lattice.rows, masses.clone());
        while coarse.len() + 1 < levels && columns.max(rows) > 2 {
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
            shares: Default::default(),
            scratch: vec![vec![0.0; lattice.columns + 1]; lattice.rows.div_ceil(BAND)],
        }
    }
}

impl MassLevels for LatticeMassLevels {
    fn share_out(&mut self, _model: &Model, cloth: &ClothRange, acting: Acting, borne: f64) {
        let rate = |rate: &LevelRate| match acting {
            Acting::Springs => rate.frequency_squared,
            Acting::Dampers => rate.damping,
        };
        self.shares[acting as usize] =
            shares(borne, cloth.rates.iter().map(rate)).into_iter().map(|share| share as f32).collect();
    }

    fn add(&mut self, acting: Acting, gains: &Vectors, velocities: &mut Vectors, pool: &Pool) {
        let Self { first, masses, columns, rows, coarse, shares, scratch } = self;
        let shares = &shares[acting as usize];
        let particles = *first..*first + *columns * *rows;
        let levels = shares.len() - 1;
        for index in 0..levels {
            let (before, grids) = coarse.split_at_mut(index);
            let fine = match before.last() {
                Some(grid) => Fine { columns: grid.columns, rows: grid.rows, first: 0, field: &grid.field, masses: None },
                None => Fine { columns: *columns, rows: *rows, first: *first, field: gains, masses: Some(masses) },
            };
            let Grid { columns, rows, field, .. } = &mut grids[0];
            let columns = *columns;
            field.for_each_band(0..columns * *rows, BAND * columns, scratch, pool, |out, row| {
                arch().dispatch(Restrict { fine: &fine, out, columns, row });
            });
        }
        for index in (0..levels).rev() {
            let (grids, coarser) = coarse.split_at_mut(index + 1);
            let coarser = coarser.first().filter(|_| index + 1 < levels);
            let Grid { columns, rows, weights, field } = &mut grids[index];
            let (columns, rows, share) = (*columns, *rows, shares[index + 1]);
            let weights = &*weights;
            field.for_each_chunk(pool, |VectorsChunk { first, x, y, z }| {
                let weights = &weights[first..first + x.len()];
                for column in [x, y, z] {
                    arch().dispatch(Weigh { column, share, weights });
                }
            });
            if let Some(coarser) = coarser {
                field.for_each_band(0..columns * rows, BAND * columns, scratch, pool, |out, row| {
                    arch().dispatch(Prolong { out, first: 0, columns, rows, coarser, row });
                });
            }
        }
        velocities.add_scaled(particles.clone(), gains, shares[0], pool);
        if let Some(coarser) = coarse.first().filter(|_| levels > 0) {
            let (first, columns, rows) = (*first, *columns, *rows);
            velocities.for_each_band(particles, BAND * columns, scratch, pool, |out, row| {
                arch().dispatch(Prolong { out, first, columns, rows, coarser, row });
            });
        }
    }
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

/// Multiplies sums of M V by what a level adds of them: its share, by its masses.
struct Weigh<'a> {
    column: &'a mut [f32],
    share: f32,
    weights: &'a [f32],
}

impl WithSimd for Weigh<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.column.iter_mut().zip(self.weights).for_each(|(value, weight)| *value *= self.share * weight);
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
