//! A regular grid: levels of stride 2, all of it in vector registers.

mod exchange;
mod guides;
mod kernels;
mod level;
mod tiles;
mod transfer;

use glam::Vec3;
use pulp::{Simd, WithSimd};

use super::{Cycle, FINEST, Levels, MOMENTUM, Measure, Motion, coarse_sweeps, cycles_to_come, momentum};
use crate::contact::Obstacle;
use crate::geometry::{Pool, Vectors, arch, cbrt, hypot, power};
use crate::model::{Lattice, Model};
use exchange::{load, store};
use guides::Guide;
use kernels::LatticePull;
use level::LatticeLevel;
use tiles::LatticeTiles;
use transfer::{Ahead, Beside, coarsened, prolong, sample_ends, sample_start};

/// Pulls along the end of a step damp a swing, pulls along its start do not. Short springs turn too much in a step for
/// that; from this level on they turn little.
const STEADY: usize = 2;
/// Coarse levels aim below their limit by a part of a spring's length, up to this part of the cloth's size [1]: a part of a long spring
/// is a long way, and taking it back within a step would throw the cloth. What counts is that a level has more room than the finer
/// one, and less than gravity takes in an automatic step (2.7 times as much). Under limits ..
const FURTHEST: f64 = 1e-3;
/// .. tighter than this [1] all springs are taut, and levels get more room, as steps get shorter: with the cube root.
const ROOMY: f32 = 0.05;
/// After a cycle, the places that are still over their limit, if they are no larger a part of the cloth than this [1], are swept
/// alone: so many times, so many rounds.
const LOCAL: f32 = 0.125;
const LOCAL_SWEEPS: usize = 2;
const LOCAL_ROUNDS: usize = 2;

/// Diagonals of coarse cells are guides where the way along springs is longer than a straight line by more than this part [1]. Where it is
/// less, they may contradict cloth that folds, but by little, and runs are swept faster (docs/decisions/coarse-to-fine.md).
const STRAIGHT: f64 = 0.02;

/// A grid's levels, finest first.
pub(super) struct LatticeLevels {
    first: usize,
    levels: Vec<LatticeLevel>,
    /// The particle that places are relative to.
    middle: usize,
    /// Where each coarse level's ends were sampled, columns in order [m].
    sampled: Vec<Vectors>,
    /// Displacements of the finest level: as they were proposed, and corrected in the end [m]. They are small, and places
    /// in single precision would round slow motion away.
    d: Vectors,
    /// Ends of the finest level one cycle ago.
    previous: Vectors,
    /// What ties particles of each level to held ones of the finest level, which it does not have.
    anchors: Vec<Vec<Guide>>,
    /// Where the finest level is still over its limit.
    tiles: LatticeTiles,
    backwards: bool,
    /// So many cycles to come are sure not to be the last.
    unmeasured: u32,
    /// How far below R each level aims at most, as a part of R, and where that is now, as another.
    deltas: Vec<f32>,
    aims: Vec<f32>,
}

/// A grid at rest. Places along its sides are counted in its cells.
struct Grid {
    columns: Side,
    rows: Side,
}

/// Where the columns (or rows) of a grid are, from the first [m].
struct Side(Vec<f64>);

impl Side {
    /// Those of a level with so many cells, all alike, as places.
    fn of_level(&self, cells: usize) -> Vec<f64> {
        (0..=cells).map(|place| (place * (self.0.len() - 1)) as f64 / cells as f64).collect()
    }

    /// From one place to another [m].
    fn apart(&self, [one, other]: [f64; 2]) -> f64 {
        let at = |place: f64| {
            let before = self.0[place as usize];
            self.0.get(place as usize + 1).map_or(before, |next| before + place.fract() * (next - before))
        };
        (at(one) - at(other)).abs()
    }
}

impl Grid {
    /// One of square cells [m].
    #[cfg(test)]
    fn of_squares(counts: [usize; 2], side: f64) -> Self {
        let [columns, rows] = counts.map(|count| Side((0..count).map(|place| side * place as f64).collect()));
        Self { columns, rows }
    }

    /// A straight line between two columns and two rows [m].
    fn line(&self, columns: [f64; 2], rows: [f64; 2]) -> f64 {
        hypot(self.columns.apart(columns), self.rows.apart(rows))
    }

    /// Whether the way along springs over a cell of such a size, diagonals first and then straight on, is so much longer than a straight
    /// line that its diagonals are guides.
    fn is_guided(&self, [width, height]: [f64; 2]) -> bool {
        let turn = width.min(height);
        let way = self.line([0.0, turn], [0.0, turn]) + self.line([turn, width], [turn, height]);
        way > (1.0 + STRAIGHT) * self.line([0.0, width], [0.0, height])
    }
}

impl LatticeLevels {
    /// The levels of a lattice with the limit `strain_limit`, aiming `delta` of R below it, but no more than [`FURTHEST`] of
    /// the cloth's size times `shrunk`.
    pub fn new(model: &Model, lattice: &Lattice, strain_limit: f32, delta: f32, shrunk: f32) -> Self {
        let size = model.cloths[model.cloth_of(lattice.first)].size;
        let furthest = f64::from(shrunk) * FURTHEST * size / cbrt(f64::from(strain_limit / ROOMY)).min(1.0);
        let at = |i: usize, j: usize| model.particles.rest.get(lattice.first + j * lattice.columns + i).as_dvec3();
        let grid = Grid {
            columns: Side((0..lattice.columns).map(|i| at(0, 0).distance(at(i, 0))).collect()),
            rows: Side((0..lattice.rows).map(|j| at(0, 0).distance(at(0, j))).collect()),
        };
        let mut cells = [lattice.columns - 1, lattice.rows - 1];
        let weight = |index: usize| f64::from(model.particles.inverse_mass[index]);
        let mut weights: Vec<f64> = (lattice.first..lattice.first + lattice.columns * lattice.rows).map(weight).collect();
        let held: Vec<(usize, usize)> =
            (0..weights.len()).filter(|&p| weights[p] == 0.0).map(|p| (p % lattice.columns, p / lattice.columns)).collect();
        let stretch = 1.0 + f64::from(strain_limit);
        let mut levels: Vec<LatticeLevel> = Vec::new();
        let mut anchors = Vec::new();
        loop {
            let mut level = LatticeLevel::new(&grid, cells, stretch);
            for (index, &weight) in weights.iter().enumerate() {
                let place = level.place(index % level.columns, index / level.columns);
                level.w[place] = weight as f32;
                if weight == 0.0 {
                    level.held.push((place, Vec3::ZERO));
                }
            }
            let finest = levels.first().unwrap_or(&level);
            anchors.push(guides::anchors(&level, finest, &held, &grid, cells, stretch));
            weights = coarse_weights(&weights, &level);
            levels.push(level);
            if cells.iter().all(|&cells| cells < 2) {
                break;
            }
            cells = cells.map(coarsened);
        }
        let spacing = grid.columns.0[1].max(grid.rows.0[1]);
        let of_level = |level: u32| f64::from(delta).min(furthest / (spacing * power(2.0, level))) as f32;
        let mut deltas: Vec<f32> = (0..levels.len() as u32).map(of_level).collect();
        deltas[0] *= FINEST;
        Self {
            first: lattice.first,
            middle: lattice.first + lattice.rows / 2 * lattice.columns + lattice.columns / 2,
            sampled: levels.iter().map(|level| Vectors::zeros(level.p.len())).collect(),
            previous: levels[0].p.clone(),
            d: levels[0].p.clone(),
            tiles: LatticeTiles::new(&levels[0]),
            levels,
            anchors,
            backwards: false,
            unmeasured: 0,
            aims: vec![1.0; deltas.len()],
            deltas,
        }
    }

    fn sweep(&mut self, index: usize, pool: &Pool) {
        let aim = self.aims[index];
        self.levels[index].sweep(LatticePull { aim, at_start: index >= STEADY }, self.backwards, None, pool);
        self.backwards = !self.backwards;
        let (finest, coarse) = self.levels.split_at_mut(1);
        if let Some(level) = index.checked_sub(1).map(|index| &mut coarse[index]) {
            for anchor in &self.anchors[index] {
                let way = finest[0].p.get(anchor.b) - level.p.get(anchor.a);
                let excess = anchor.excess(way.length(), aim);
                if excess > 0.0 {
                    level.p.set(anchor.a, level.p.get(anchor.a) + way * excess);
                }
            }
        }
    }
}

impl Levels for LatticeLevels {
    fn load(&mut self, positions: &Vectors, ends: &Vectors, room: f32, pool: &Pool) {
        for (index, (aim, delta)) in self.aims.iter_mut().zip(&self.deltas).enumerate() {
            *aim = 1.0 - delta * if index == 0 { 1.0 } else { room };
        }
        load(&mut self.levels[0], &mut self.d, self.first, self.middle, [positions, ends], pool);
        for index in 1..self.levels.len() {
            let (fine, coarse) = self.levels.split_at_mut(index);
            sample_start(&fine[index - 1], &mut coarse[0], &mut self.sampled[index], pool);
            coarse[0].begin_guides();
            for anchor in &mut self.anchors[index] {
                anchor.begin(coarse[0].x.get(anchor.a).distance(fine[0].x.get(anchor.b)));
            }
        }
        self.backwards = false;
        self.unmeasured = 0;
    }

    fn hold(&mut self, _: usize, _: Vec3) {
        unreachable!("cloth that can touch has no lattice")
    }

    fn release(&mut self) {
        unreachable!("cloth that can touch has no lattice")
    }

    fn obstruct(&mut self, _: &[Obstacle], _: bool, _: &Pool) {
        unreachable!("cloth that can touch has no lattice")
    }

    fn resisted(&mut self, _: &mut dyn FnMut(u32, f32)) {
        unreachable!("cloth that can touch has no lattice")
    }

    fn smooth(&mut self, _: Cycle, _: &Pool) -> Option<Measure> {
        unreachable!("cloth that can touch has no lattice")
    }

    fn cycle(&mut self, Cycle { since_restart, enough, is_sure, is_last, is_calm }: Cycle, pool: &Pool) -> Option<Measure> {
        // Only the finest level goes on: coarser ones begin where it is.
        let momentum = momentum(since_restart, is_calm, MOMENTUM);
        for index in 1..self.levels.len() {
            let (fine, coarse) = self.levels.split_at_mut(index);
            let ahead = (index == 1).then_some(Ahead { previous: &mut self.previous, momentum });
            sample_ends(&fine[index - 1], ahead, &mut coarse[0], &mut self.sampled[index], pool);
        }
        for index in (1..self.levels.len()).rev() {
            for _ in 0..coarse_sweeps(self.levels[index].size()) {
                self.sweep(index, pool);
            }
            let (fine, coarse) = self.levels.split_at_mut(index);
            let ahead = (index == 1).then_some(Ahead { previous: &mut self.previous, momentum });
            prolong(&mut fine[index - 1], ahead, &coarse[0], &mut self.sampled[index], pool);
        }
        self.sweep(0, pool);
        if !is_last && (is_sure || self.unmeasured > 0) {
            self.unmeasured = self.unmeasured.saturating_sub(1);
            return None;
        }
        let mut left = self.levels[0].measure(enough, &mut self.tiles, true, pool);
        self.unmeasured = cycles_to_come(self.tiles.share());
        for _ in 0..LOCAL_ROUNDS {
            if left.over == 0 || self.tiles.share() > LOCAL {
                break;
            }
            self.tiles.take_neighbours();
            let pull = LatticePull { aim: self.aims[0], at_start: false };
            for _ in 0..LOCAL_SWEEPS {
                self.levels[0].sweep(pull, self.backwards, Some(&self.tiles), pool);
                self.backwards = !self.backwards;
            }
            left = self.levels[0].measure(enough, &mut self.tiles, false, pool);
        }
        Some(left)
    }

    fn back_off(&self) -> f32 {
        self.deltas[0]
    }

    fn over(&self, enough: f32, visit: &mut dyn FnMut([usize; 2])) {
        self.levels[0].over(enough, &self.tiles, visit);
    }

    fn between(&self, from: usize, to: usize) -> Vec3 {
        let finest = &self.levels[0];
        finest.p.get(finest.place_of(to)) - finest.p.get(finest.place_of(from))
    }

    fn knows(&self, _: usize) -> bool {
        true
    }

    fn displacement(&self, particle: usize) -> Vec3 {
        let LatticeLevel { x, p, .. } = &self.levels[0];
        let place = self.levels[0].place_of(particle);
        p.get(place) - x.get(place)
    }

    fn shift(&mut self, particle: usize, way: Vec3) {
        let finest = &mut self.levels[0];
        let place = finest.place_of(particle);
        finest.p.set(place, finest.p.get(place) + way);
    }

    fn settle(&mut self, pool: &Pool) {
        let LatticeLevel { x, p, .. } = &self.levels[0];
        self.d.for_each_chunk(pool, |d| {
            let run = d.first..d.first + d.x.len();
            for (d, x, p) in [(d.x, &x.x, &p.x), (d.y, &x.y, &p.y), (d.z, &x.z, &p.z)] {
                arch().dispatch(Settle { d, x: &x[run.clone()], p: &p[run.clone()] });
            }
        });
    }

    fn motion(&mut self) -> Motion<'_> {
        Motion { d: &mut self.d, weights: &self.levels[0].w }
    }

    fn store(&self, positions: &Vectors, ends: &mut Vectors, corrections: &mut Vectors, pool: &Pool) {
        store(&self.levels[0], &self.d, self.first, positions, [ends, corrections], pool);
    }
}

/// Adds what was corrected to D: where P is still X + D, D stays what it is to the last bit.
struct Settle<'a> {
    d: &'a mut [f32],
    x: &'a [f32],
    p: &'a [f32],
}

impl WithSimd for Settle<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.d.iter_mut().zip(self.x.iter().zip(self.p)).for_each(|(d, (x, p))| *d += p - (x + *d));
    }
}

/// Inverse masses one level up: a coarse particle has the mass that it carries when its displacement is interpolated,
/// so that a pull conserves momentum on the finest level too. What samples nothing but what is held, stays held.
fn coarse_weights(weights: &[f64], fine: &LatticeLevel) -> Vec<f64> {
    let LatticeLevel { columns, beside: [across_beside, up_beside], .. } = fine;
    let [coarse_columns, coarse_rows] = [across_beside, up_beside].map(|beside| beside.before.len());
    let mut masses = vec![0.0; coarse_columns * coarse_rows];
    for (index, &weight) in weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
        for (j, up) in up_beside.parents(index / columns) {
            for (i, across) in across_beside.parents(index % columns) {
                masses[j * coarse_columns + i] += f64::from(up) * f64::from(across) / weight;
            }
        }
    }
    let held = |i: usize, j: usize| {
        let samples = |side: &Beside, at: usize| side.sampled(at).into_iter().filter(|(_, part)| *part > 0.0);
        samples(up_beside, j).all(|(row, _)| samples(across_beside, i).all(|(column, _)| weights[row * columns + column] == 0.0))
    };
    let weight = |index: usize| if held(index % coarse_columns, index / coarse_columns) { 0.0 } else { 1.0 / masses[index] };
    (0..masses.len()).map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_cells_of_a_level_are_alike() {
        let grid = Grid::of_squares([24, 8], 0.5);
        for (cells, width) in [(23, 0.5_f64), (12, 11.5 / 12.0), (1, 11.5)] {
            let places = grid.columns.of_level(cells);
            assert_eq!((places.len(), places[0], places[cells]), (cells + 1, 0.0, 23.0));
            for pair in places.windows(2) {
                let line = grid.line([pair[0], pair[1]], [0.0, 3.5]);
                assert!((line - width.hypot(1.75)).abs() < 1e-12, "{line}");
            }
        }
    }

    #[test]
    fn diagonals_of_cells_of_quite_another_shape_are_guides() {
        let grid = Grid { columns: Side((0..30).map(|i| 0.2 * f64::from(i)).collect()), ..Grid::of_squares([2, 30], 0.3) };
        for (cell, is_guided) in
            [([1.0, 1.0], false), ([8.0, 8.0], false), ([8.0, 7.6], false), ([8.0, 6.5], true), ([1.0, 2.0], true)]
        {
            assert_eq!(grid.is_guided(cell), is_guided, "{cell:?}");
        }
    }
}
