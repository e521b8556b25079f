//! A regular grid: levels of stride 2, all of it in vector registers.

mod exchange;
mod kernels;
mod level;
mod tiles;
mod transfer;

use pulp::{Arch, Simd, WithSimd};

use super::Hierarchy;
use crate::geometry::Vectors;
use crate::model::{Lattice, Model};
use crate::state::State;
use exchange::{Load, Store};
use kernels::Pull;
use level::Level;
use tiles::Tiles;
use transfer::{coarsened, parents, prolong, sample, sampled};

/// Levels with at most this many particles are swept [`COARSEST_SWEEPS`] times: they cost nothing and carry the loads.
const COARSEST: usize = 81;
const COARSEST_SWEEPS: usize = 3;
/// Part of the way that coarse springs are pulled; the finer levels do the rest.
const COARSE_PART: f32 = 0.8;
/// After a cycle, the few places that are still over their limit are swept alone: so many times, so many rounds.
const LOCAL_SWEEPS: usize = 4;
const LOCAL_ROUNDS: usize = 2;

/// A grid's levels, finest first.
pub(super) struct LatticeLevels {
    first: usize,
    levels: Vec<Level>,
    /// Displacements of each coarse level before it was swept.
    before: Vec<Vectors>,
    /// Displacements of the finest level one cycle ago.
    previous: Vectors,
    anchors: Vec<Vec<Anchor>>,
    /// Where the finest level is still over its limit.
    tiles: Tiles,
    /// A row of gains on the way from a coarse level to a finer one.
    gained: Vec<f32>,
    backwards: bool,
    delta: f32,
}

/// A coarse particle that may not go further from a held one, which its level does not have.
struct Anchor {
    coarse: usize,
    /// Where the finest level keeps the held particle.
    held: usize,
    /// [m]
    limit: f32,
}

impl LatticeLevels {
    /// The levels of a lattice with the limit `strain_limit`, aiming `delta` of R below it.
    pub fn new(model: &Model, lattice: &Lattice, strain_limit: f32, delta: f32) -> Self {
        let at = |i: usize, j: usize| model.particles.rest.get(lattice.first + j * lattice.columns + i).as_dvec3();
        let mut columns: Vec<f64> = (0..lattice.columns).map(|i| at(0, 0).distance(at(i, 0))).collect();
        let mut rows: Vec<f64> = (0..lattice.rows).map(|j| at(0, 0).distance(at(0, j))).collect();
        let weight = |index: usize| f64::from(model.particles.inverse_mass[index]);
        let mut weights: Vec<f64> = (lattice.first..lattice.first + columns.len() * rows.len()).map(weight).collect();
        let held: Vec<(usize, usize)> =
            (0..weights.len()).filter(|&p| weights[p] == 0.0).map(|p| (p % columns.len(), p / columns.len())).collect();
        let stretch = 1.0 + f64::from(strain_limit);
        let (finest_columns, finest_rows) = (columns.clone(), rows.clone());
        let mut levels: Vec<Level> = Vec::new();
        let mut anchors = Vec::new();
        loop {
            let mut level = Level::new(&columns, &rows, stretch);
            for (index, &weight) in weights.iter().enumerate() {
                let place = level.place(index % columns.len(), index / columns.len());
                level.w[place] = weight as f32;
            }
            let finest = levels.first().unwrap_or(&level);
            anchors.push(anchors_of(&level, finest, &held, [&columns, &rows], [&finest_columns, &finest_rows], stretch));
            let enough = columns.len().max(rows.len()) < 3;
            levels.push(level);
            if enough {
                break;
            }
            weights = coarse_weights(&weights, columns.len(), rows.len());
            columns = (0..coarsened(columns.len())).map(|i| columns[sampled(i, columns.len())]).collect();
            rows = (0..coarsened(rows.len())).map(|j| rows[sampled(j, rows.len())]).collect();
        }
        Self {
            first: lattice.first,
            before: levels.iter().map(|level| Vectors::zeros(level.d.len())).collect(),
            previous: levels[0].d.clone(),
            gained: vec![0.0; levels[0].columns + 2],
            tiles: Tiles::new(&levels[0]),
            levels,
            anchors,
            backwards: false,
            delta,
        }
    }

    /// Not every spring that is a little over its aim is worth a pull: only those more than half the way to the limit.
    fn finest_pull(&self) -> Pull {
        Pull { trigger: 1.0 - 0.5 * self.delta, aim: 1.0 - self.delta, part: 1.0 }
    }

    #[inline(always)]
    fn sweep<S: Simd>(&mut self, simd: S, index: usize) {
        let aim = 1.0 - self.delta;
        let pull = if index == 0 { self.finest_pull() } else { Pull { trigger: aim, aim, part: COARSE_PART } };
        self.levels[index].sweep(simd, pull, self.backwards);
        self.backwards = !self.backwards;
        let (finest, coarse) = self.levels.split_at_mut(1);
        if let Some(level) = index.checked_sub(1).map(|index| &mut coarse[index]) {
            for anchor in &self.anchors[index] {
                let end = |level: &Level, place: usize| level.x.get(place) + level.d.get(place);
                let away = end(level, anchor.coarse) - end(&finest[0], anchor.held);
                let (length, reach) = (away.length(), anchor.limit * aim);
                if length > reach {
                    level.d.set(anchor.coarse, level.d.get(anchor.coarse) - away * (1.0 - reach / length));
                }
            }
        }
    }
}

impl Hierarchy for LatticeLevels {
    fn load(&mut self, model: &Model, state: &State) {
        let step = model.timing.step_length as f32;
        Arch::new().dispatch(Load { level: &mut self.levels[0], first: self.first, state, step });
        for index in 1..self.levels.len() {
            let (fine, coarse) = self.levels.split_at_mut(index);
            let mut x = std::mem::take(&mut coarse[0].x);
            sample(&fine[index - 1], &coarse[0], &fine[index - 1].x, &mut x);
            coarse[0].x = x;
        }
        self.backwards = false;
    }

    fn cycle(&mut self, _: &Model, momentum: f32, enough: f32) -> f32 {
        Arch::new().dispatch(Cycle { cloth: self, momentum, enough })
    }

    fn store(&self, model: &Model, state: &mut State) {
        let step = model.timing.step_length as f32;
        Arch::new().dispatch(Store { level: &self.levels[0], first: self.first, state, step });
    }
}

/// One cycle, compiled for the vector registers that are there.
struct Cycle<'a> {
    cloth: &'a mut LatticeLevels,
    momentum: f32,
    enough: f32,
}

impl WithSimd for Cycle<'_> {
    type Output = f32;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f32 {
        let cloth = self.cloth;
        extrapolate(&mut cloth.levels[0].d, &mut cloth.previous, self.momentum);
        for index in 1..cloth.levels.len() {
            let (fine, coarse) = cloth.levels.split_at_mut(index);
            let mut d = std::mem::take(&mut coarse[0].d);
            sample(&fine[index - 1], &coarse[0], &fine[index - 1].d, &mut d);
            cloth.before[index].copy_from(&d);
            coarse[0].d = d;
        }
        for index in (1..cloth.levels.len()).rev() {
            let particles = cloth.levels[index].columns * cloth.levels[index].rows;
            for _ in 0..if particles <= COARSEST { COARSEST_SWEEPS } else { 1 } {
                cloth.sweep(simd, index);
            }
            let (fine, coarse) = cloth.levels.split_at_mut(index);
            prolong(&mut fine[index - 1], &coarse[0], &cloth.before[index], &mut cloth.gained);
        }
        cloth.sweep(simd, 0);
        let mut worst = cloth.levels[0].measure(simd, self.enough, &mut cloth.tiles);
        for _ in 0..LOCAL_ROUNDS {
            if worst <= self.enough || !cloth.tiles.are_few() {
                break;
            }
            cloth.tiles.widen();
            let pull = cloth.finest_pull();
            for _ in 0..LOCAL_SWEEPS {
                cloth.levels[0].sweep_tiles(simd, pull, cloth.backwards, &cloth.tiles);
                cloth.backwards = !cloth.backwards;
            }
            worst = cloth.levels[0].measure(simd, self.enough, &mut cloth.tiles);
        }
        worst
    }
}

/// d += momentum (d - previous), and the old d becomes the previous one.
#[inline(always)]
fn extrapolate(d: &mut Vectors, previous: &mut Vectors, momentum: f32) {
    for (d, previous) in [(&mut d.x, &mut previous.x), (&mut d.y, &mut previous.y), (&mut d.z, &mut previous.z)] {
        for (d, previous) in d.iter_mut().zip(previous) {
            let now = *d;
            if momentum > 0.0 {
                *d += momentum * (now - *previous);
            }
            *previous = now;
        }
    }
}

/// Inverse masses one level up: a coarse particle has the mass that it carries when its displacement is interpolated,
/// so that a pull conserves momentum on the finest level too. Held stays held.
fn coarse_weights(weights: &[f64], columns: usize, rows: usize) -> Vec<f64> {
    let (coarse_columns, coarse_rows) = (coarsened(columns), coarsened(rows));
    let mut masses = vec![0.0; coarse_columns * coarse_rows];
    for (index, &weight) in weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
        for j in parents(index / columns, rows) {
            for i in parents(index % columns, columns) {
                masses[j * coarse_columns + i] += 0.25 / weight;
            }
        }
    }
    let held = |i: usize, j: usize| weights[sampled(j, rows) * columns + sampled(i, columns)] == 0.0;
    let weight = |index: usize| if held(index % coarse_columns, index / coarse_columns) { 0.0 } else { 1.0 / masses[index] };
    (0..masses.len()).map(weight).collect()
}

/// Ties the corners of a coarse cell to a held particle inside it, unless one of them is held itself.
fn anchors_of(
    level: &Level,
    finest: &Level,
    held: &[(usize, usize)],
    [columns, rows]: [&[f64]; 2],
    [all_columns, all_rows]: [&[f64]; 2],
    stretch: f64,
) -> Vec<Anchor> {
    let cell = |places: &[f64], at: f64| places.partition_point(|&place| place <= at).clamp(1, places.len() - 1);
    let mut anchors = Vec::new();
    for &(column, row) in held {
        let (x, y) = (all_columns[column], all_rows[row]);
        let (i, j) = (cell(columns, x), cell(rows, y));
        let corners = [(i - 1, j - 1), (i, j - 1), (i - 1, j), (i, j)];
        if corners.iter().any(|&(i, j)| level.w[level.place(i, j)] == 0.0) {
            continue;
        }
        anchors.extend(corners.map(|(i, j)| Anchor {
            coarse: level.place(i, j),
            held: finest.place(column, row),
            limit: (stretch * (columns[i] - x).hypot(rows[j] - y)) as f32,
        }));
    }
    anchors
}
