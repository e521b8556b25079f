//! Any mesh or network: levels of particles chosen from its own, joined by springs as long as the cloth between them.
//!
//! Coarse limits are guides: they are what a cloth of the same shape could reach that gives way by lambda in *every*
//! direction, while springs along crooked edges reach somewhat further. Where the cloth is over such a limit at the
//! start of a step, it only may not go further. So the start of a step is admissible on every level, and the
//! certificate asks the springs of the cloth alone.

mod build;
mod forest;
mod level;
mod tiles;

use glam::{Vec3, Vec4, Vec4Swizzles};

use super::{Levels, Motion, coarse_sweeps, cycles_to_come, momentum};
use crate::geometry::{Pool, Vectors};
use crate::model::{ClothRange, Hierarchy};
use forest::Forest;
use level::{LANES, Level, Pull};
use tiles::Tiles;

/// After a cycle, the few places that are still over their limit are swept alone: so many times, so many rounds.
const LOCAL_SWEEPS: usize = 4;
const LOCAL_ROUNDS: usize = 3;

/// The finest level aims below its limit by this part of the back-off, coarse ones by the other: what they have put right, the
/// finest does not find wrong again.
const FINEST: f32 = 0.5;
const COARSE: f32 = 2.0;
/// Cycle k starts k / (k + this) of the last one's way further.
const LAG: f32 = 2.0;

/// The levels of one cloth, finest first.
pub(super) struct GeneralLevels {
    levels: Vec<Level>,
    /// The particle at each place of the finest level.
    particles: Vec<u32>,
    /// Inverse masses on the finest level.
    weights: Vec<f32>,
    /// Where the step begins [m].
    x: Vec<Vec4>,
    /// Displacements one cycle ago [m].
    previous: Vec<Vec4>,
    /// Displacements as they were proposed, and as they come out [m].
    proposed: Vec<Vec4>,
    corrected: Vectors,
    /// How far each particle may go with all its springs within their limits [m].
    room: Vec<f32>,
    /// Where the finest level is over its limit.
    tiles: Tiles,
    /// What can be solved exactly, and whether it has been in this step.
    forest: Option<Forest>,
    solved: bool,
    /// How far below R springs of the finest level and of coarse ones are aimed, as parts of R.
    deltas: [f32; 2],
    backwards: bool,
    /// So many cycles to come are sure not to be the last.
    unmeasured: u32,
}

impl GeneralLevels {
    /// The levels of a cloth with the limit `strain_limit`, aiming about `delta` of R below it.
    pub fn new(hierarchy: &Hierarchy, cloth: &ClothRange, strain_limit: f32, delta: f32) -> Self {
        let stretch = 1.0 + strain_limit;
        let (levels, tiles, particles) = build::levels(hierarchy, cloth, stretch);
        let count = particles.len();
        let weights: Vec<f32> = levels[0].d.iter().map(|quad| quad.w).collect();
        let springs = hierarchy.levels[0].springs.iter().map(|&(ends, length)| (ends, stretch * length));
        Self {
            forest: Forest::new(springs, &weights),
            solved: false,
            weights,
            x: vec![Vec4::ZERO; count],
            previous: levels[0].d.clone(),
            proposed: levels[0].d.clone(),
            corrected: Vectors::zeros(count),
            room: vec![0.0; count],
            tiles,
            levels,
            particles,
            deltas: [FINEST * delta, COARSE * delta],
            backwards: false,
            unmeasured: 0,
        }
    }

    /// Not every spring that is a little over its aim is worth a pull: only those more than half the way to the limit.
    fn finest_pull(&self) -> Pull {
        let [delta, _] = self.deltas;
        Pull { trigger: 1.0 - 0.5 * delta, aim: 1.0 - delta, at_start: false }
    }

    /// Sweeps a coarse level.
    fn sweep(&mut self, index: usize) {
        let level = &mut self.levels[index];
        level.sweep(0..level.bundles.len(), Pull { trigger: 1.0, aim: 1.0, at_start: true }, self.backwards, |_| ());
        self.backwards = !self.backwards;
    }

    /// Sweeps the finest level, everywhere or where it is marked and around that.
    fn sweep_finest(&mut self, everywhere: bool) {
        let pull = self.finest_pull();
        let Self { levels, tiles, .. } = self;
        let count = tiles.count();
        for tile in 0..count {
            let tile = if self.backwards { count - 1 - tile } else { tile };
            if everywhere || tiles.is_wide(tile) {
                levels[0].sweep(tiles.bundles(tile), pull, self.backwards, |ends| tiles.moves(ends));
            }
        }
        self.backwards = !self.backwards;
    }

    /// Largest |P_uv| / R where sweeps moved something; elsewhere it is below their trigger, and that is below `enough`. Marks the
    /// tiles where it is over `enough`.
    fn measure(&mut self, enough: f32) -> f32 {
        let mut worst = Vec4::ZERO;
        for tile in 0..self.tiles.count() {
            let changed = self.tiles.has_changed(tile);
            let here = if changed { self.levels[0].worst(self.tiles.bundles(tile)) } else { Vec4::ZERO };
            self.tiles.mark(tile, here.max_element() > enough * enough);
            worst = worst.max(here);
        }
        worst.max_element().sqrt()
    }

    /// How far each particle may go, whatever its neighbours do, without a spring becoming longer than `aim` of R: half of what
    /// the tightest of its springs has left.
    fn measure_room(&mut self, aim: f32) {
        self.room.fill(f32::INFINITY);
        let Level { d, bundles, .. } = &self.levels[0];
        for bundle in bundles {
            let length = Vec4::from_array(bundle.squares(d).to_array().map(f32::sqrt));
            let left = (0.5 * (aim * bundle.limit - length)).max(Vec4::ZERO).to_array();
            for lane in 0..LANES {
                for end in bundle.ends.map(|ends| ends[lane] as usize) {
                    self.room[end] = self.room[end].min(left[lane]);
                }
            }
        }
    }

    /// Goes on with `momentum`.
    fn go_on(&mut self, momentum: f32) {
        for (d, previous) in self.levels[0].d.iter_mut().zip(&mut self.previous) {
            // Inverse masses are the same in both.
            let now = *d;
            *d = now + (now - *previous) * momentum;
            *previous = now;
        }
    }

    /// Hands the displacements of the finest level out.
    fn hand_out(&mut self) {
        let Vectors { x, y, z } = &mut self.corrected;
        for (d, ((x, y), z)) in self.levels[0].d.iter().zip(x.iter_mut().zip(y).zip(z)) {
            (*x, *y, *z) = (d.x, d.y, d.z);
        }
    }
}

impl Levels for GeneralLevels {
    fn load(&mut self, positions: &Vectors, ends: &Vectors, _: &Pool) {
        let (positions, ends) = (positions.columns(), ends.columns());
        let places = self.x.iter_mut().zip(&mut self.levels[0].d);
        for (particle, (x, d)) in self.particles.iter().zip(places) {
            let [start, end] = [positions, ends].map(|[x, y, z]| {
                let particle = *particle as usize;
                Vec3::new(x[particle], y[particle], z[particle])
            });
            *x = start.extend(0.0);
            *d = (end - start).extend(d.w);
        }
        self.proposed.copy_from_slice(&self.levels[0].d);
        self.hand_out();
        let (finest, coarse) = self.levels.split_at_mut(1);
        for bundle in &mut finest[0].bundles {
            bundle.begin(|end| self.x[end as usize]);
        }
        for level in coarse {
            let Level { bundles, limits, finest, .. } = level;
            for (bundle, limit) in bundles.iter_mut().zip(limits) {
                bundle.begin(|end| self.x[finest[end as usize] as usize]);
                let length = Vec4::from_array(bundle.squares_at_start().to_array().map(f32::sqrt));
                bundle.limit = (*limit * (1.0 - self.deltas[1])).max(length);
            }
        }
        self.backwards = false;
        self.unmeasured = 0;
        self.solved = false;
    }

    fn cycle(&mut self, cycles: u8, enough: f32, pool: &Pool) -> Option<f32> {
        if let (Some(forest), false) = (&mut self.forest, self.solved) {
            self.solved = true;
            forest.correct(&self.x, &mut self.corrected, enough);
            for (place, d) in self.levels[0].d.iter_mut().enumerate() {
                *d = self.corrected.get(place).extend(d.w);
            }
            self.go_on(0.0);
            self.tiles.moves_all();
            return Some(self.measure(enough));
        }
        self.go_on(momentum(cycles, LAG));
        let (finest, coarse) = self.levels.split_at_mut(1);
        coarse.iter_mut().for_each(|level| level.sample(&finest[0]));
        for index in (1..self.levels.len()).rev() {
            for _ in 0..coarse_sweeps(self.levels[index].d.len()) {
                self.sweep(index);
            }
            let (fine, coarse) = self.levels.split_at_mut(index);
            fine[index - 1].follow(&mut coarse[0], pool);
        }
        self.tiles.begin();
        self.sweep_finest(true);
        if self.unmeasured > 0 {
            self.unmeasured -= 1;
            return None;
        }
        let mut worst = self.measure(enough);
        self.unmeasured = cycles_to_come(self.tiles.share());
        for _ in 0..LOCAL_ROUNDS {
            if worst <= enough || !self.tiles.widen() {
                break;
            }
            self.tiles.begin();
            (0..LOCAL_SWEEPS).for_each(|_| self.sweep_finest(false));
            worst = self.measure(enough);
        }
        Some(worst)
    }

    fn back_off(&self) -> f32 {
        self.deltas[0]
    }

    fn release(&mut self, _: &Pool) {
        self.measure_room(1.0 - 0.5 * self.deltas[0]);
        for ((d, proposed), &room) in self.levels[0].d.iter_mut().zip(&self.proposed).zip(&self.room) {
            // Inverse masses are the same in both.
            let way = *proposed - *d;
            let length = way.xyz().length();
            let part = if length > room { room / length } else { 1.0 };
            *d += way * part;
        }
        self.hand_out();
    }

    fn motion(&mut self) -> Motion<'_> {
        Motion { d: &mut self.corrected, weights: &self.weights }
    }

    fn store(&self, positions: &Vectors, ends: &mut Vectors, corrections: &mut Vectors, _: &Pool) {
        for (place, &particle) in self.particles.iter().enumerate() {
            let particle = particle as usize;
            let (start, after) = (positions.get(particle), self.corrected.get(place));
            let before = ends.get(particle) - start;
            let corrected = self.weights[place] > 0.0 && after != before;
            corrections.set(particle, if corrected { after - before } else { Vec3::ZERO });
            if corrected {
                ends.set(particle, start + after);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::*;
    use serde_json::json;

    use super::*;
    use crate::model::{MeshData, Model};
    use crate::scene::Scene;

    /// A sheet of so many cells along each side, 0.1 m each, cut into triangles.
    fn sheet(cells: u32) -> Model {
        let mut mesh = MeshData::default();
        for vertex in 0..(cells + 1) * (cells + 1) {
            mesh.vertices.push([0.1 * f64::from(vertex % (cells + 1)), 0.1 * f64::from(vertex / (cells + 1)), 0.0]);
        }
        for cell in 0..cells * cells {
            let a = i64::from(cell / cells * (cells + 1) + cell % cells);
            let [b, c, d] = [a + 1, a + i64::from(cells) + 2, a + i64::from(cells) + 1];
            mesh.corners.extend(if cell % 2 == 0 { [a, b, c, a, c, d] } else { [a, b, d, b, c, d] });
            mesh.counts.extend([3, 3]);
        }
        let document = json!({ "cloth": [{ "mesh": "sheet", "density": 0.2 }] });
        let scene = Scene::from_json(&document.to_string()).expect("a valid scene");
        Model::build(&scene, &BTreeMap::from([("sheet".to_owned(), mesh)])).expect("a valid model")
    }

    proptest! {
        #[test]
        fn what_a_local_sweep_makes_longer_is_measured(
            cells in 3_u32..40,
            moved in prop::collection::vec((0_usize..1600, -0.03_f32..0.03, -0.03_f32..0.03), 1..4),
        ) {
            const ENOUGH: f32 = 0.9999;
            let (model, pool) = (sheet(cells), Pool::new(1));
            let mut levels = GeneralLevels::new(&model.hierarchies[0], &model.cloths[0], 0.01, 0.005);
            let start = &model.particles.rest;
            let mut ends = start.clone();
            for (particle, x, y) in moved {
                let particle = particle % ends.len();
                ends.set(particle, start.get(particle) + Vec3::new(x, y, 0.0));
            }
            levels.load(start, &ends, &pool);
            levels.tiles.moves_all();
            let mut worst = levels.measure(ENOUGH);
            for _ in 0..6 {
                if worst <= ENOUGH {
                    break;
                }
                levels.tiles.widen();
                levels.tiles.begin();
                levels.sweep_finest(false);
                worst = levels.measure(ENOUGH);
                let marked = levels.tiles.share();
                levels.tiles.moves_all();
                let everywhere = levels.measure(ENOUGH);
                prop_assert_eq!(worst > ENOUGH, everywhere > ENOUGH);
                prop_assert!(worst == everywhere || everywhere <= ENOUGH, "{} where it was swept, {} everywhere", worst, everywhere);
                prop_assert_eq!(marked, levels.tiles.share());
            }
        }
    }
}
