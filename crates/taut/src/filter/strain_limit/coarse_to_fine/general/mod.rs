//! Any mesh or network: levels of particles chosen from its own, joined by springs as long as the cloth between them.
//!
//! Coarse limits are guides: they are what a cloth of the same shape could reach that gives way by lambda in *every*
//! direction, while springs along crooked edges reach somewhat further. Where the cloth is over such a limit at the
//! start of a step, it only may not go further. So the start of a step is admissible on every level, and the
//! certificate asks the springs of the cloth alone.

mod build;
mod forest;
mod level;
mod obstacles;
mod tiles;

use glam::{Vec3, Vec4, Vec4Swizzles};

use super::{Cycle, FINEST, Levels, MOMENTUM, Measure, Motion, coarse_sweeps, cycles_to_come};
use crate::contact::Obstacle;
use crate::geometry::{CHUNK, Pool, Vectors, VectorsChunk, for_each_chunk, for_each_two_chunks, roots};
use crate::model::{ClothRange, Hierarchy};
use forest::Forest;
use level::{GeneralLevel, GeneralPull, LANES};
use obstacles::Obstacles;
use tiles::GeneralTiles;

/// After a cycle, the few places that are still over their limit are swept alone: so many times, so many rounds.
const LOCAL_SWEEPS: usize = 2;
const LOCAL_ROUNDS: usize = 2;

/// Part of the last cycle's way that a cycle starts with, at most, where there have been no more than a few. What is slack again by then
/// goes too far by several times its way: where pins or bodies lead cloth, wrinkles went to and fro from step to step. Later ways are
/// shorter. By so much more each of those goes on, up to what those of grids do.
const MOMENTUM_OF_FEW: f32 = 0.7;
const FEW_CYCLES: u8 = 8;
const MORE_MOMENTUM: f32 = 0.03;

/// The place of a particle that no spring is tied to.
const NOWHERE: u32 = u32::MAX;

/// The levels of one cloth, finest first.
pub(super) struct GeneralLevels {
    levels: Vec<GeneralLevel>,
    /// The particle at each place of the finest level, and the place of each particle of the cloth: nowhere if nothing is tied to it.
    particles: Vec<u32>,
    places: Vec<u32>,
    /// The first particle of the cloth.
    first: usize,
    /// Inverse masses on the finest level.
    weights: Vec<f32>,
    /// Where the step begins [m].
    x: Vec<Vec4>,
    /// Displacements one cycle ago [m].
    previous: Vec<Vec4>,
    /// Displacements as they come out [m].
    corrected: Vectors,
    /// Where the finest level is over its limit.
    tiles: GeneralTiles,
    /// What can be solved exactly, and whether it has been in this step.
    forest: Option<Forest>,
    solved: bool,
    /// How far below R springs of the finest level and of coarse ones are aimed, as parts of R.
    deltas: [f32; 2],
    backwards: bool,
    /// So many cycles to come are sure not to be the last.
    unmeasured: u32,
    /// What coarse levels may not do.
    obstacles: Obstacles,
    /// Places on the finest level that are held in this step, and how far they go [m]; and places on each level with their inverse masses.
    held: Vec<(u32, Vec4)>,
    weights_of_held: Vec<(u32, u32, f32)>,
}

/// Part of the last cycle's way that the next one starts with, so many cycles after the last start without it.
pub(super) fn momentum(cycles: u8, is_calm: bool) -> f32 {
    let most = MOMENTUM_OF_FEW + MORE_MOMENTUM * f32::from(cycles.saturating_sub(FEW_CYCLES));
    super::momentum(cycles, is_calm, most.min(MOMENTUM))
}

impl GeneralLevels {
    /// The levels of a cloth with the limit `strain_limit`, aiming about `delta` of R below it.
    pub fn new(hierarchy: &Hierarchy, cloth: &ClothRange, strain_limit: f32, delta: f32) -> Self {
        let stretch = 1.0 + strain_limit;
        let (levels, tiles, particles) = build::levels(hierarchy, cloth, stretch);
        let count = particles.len();
        let weights: Vec<f32> = levels[0].d.iter().map(|quad| quad.w).collect();
        let springs = hierarchy.levels[0].springs.iter().map(|&(ends, length)| (ends, stretch * length));
        let mut places = vec![NOWHERE; cloth.count];
        (0..).zip(&particles).for_each(|(place, &particle)| places[particle as usize - cloth.first] = place);
        Self {
            forest: Forest::new(springs, &weights),
            solved: false,
            weights,
            x: vec![Vec4::ZERO; count],
            previous: levels[0].d.clone(),
            corrected: Vectors::zeros(count),
            tiles,
            obstacles: Obstacles::new(levels.len()),
            held: Vec::new(),
            weights_of_held: Vec::new(),
            levels,
            particles,
            places,
            first: cloth.first,
            deltas: [FINEST * delta, delta],
            backwards: false,
            unmeasured: 0,
        }
    }

    /// Sweeps a coarse level. Coarse limits have their back-off in them.
    fn sweep(&mut self, index: usize, pool: &Pool) {
        self.levels[index].sweep(GeneralPull { aim: 1.0, at_start: true }, self.backwards, None, pool);
        self.backwards = !self.backwards;
    }

    /// Sweeps the finest level, or where it is over its limit and around that.
    fn sweep_finest(&mut self, everywhere: bool, pool: &Pool) {
        let pull = GeneralPull { aim: 1.0 - self.deltas[0], at_start: false };
        let only = (!everywhere).then(|| self.tiles.wide());
        self.levels[0].sweep(pull, self.backwards, only, pool);
        self.backwards = !self.backwards;
    }

    /// What is left where sweeps moved something since `moved` was cleared.
    fn measure(&mut self, enough: f32, pool: &Pool) -> Measure {
        self.tiles.measure(&self.levels[0], enough, pool)
    }

    /// Whether the next cycle tells what is left.
    fn is_measured(&self, is_sure: bool, is_last: bool) -> bool {
        is_last || !is_sure && self.unmeasured == 0
    }

    /// Goes on with `momentum`.
    fn go_on(&mut self, momentum: f32, pool: &Pool) {
        for_each_two_chunks(&mut self.levels[0].d, &mut self.previous, pool, |_, d, previous| {
            for (d, previous) in d.iter_mut().zip(previous) {
                // Inverse masses are the same in both.
                let now = *d;
                *d = now + (now - *previous) * momentum;
                *previous = now;
            }
        });
    }

    /// Hands the displacements of the finest level out.
    fn hand_out(&mut self, pool: &Pool) {
        let finest = &self.levels[0].d;
        self.corrected.for_each_chunk(pool, |VectorsChunk { first, x, y, z }| {
            for (d, ((x, y), z)) in finest[first..].iter().zip(x.iter_mut().zip(y).zip(z)) {
                (*x, *y, *z) = (d.x, d.y, d.z);
            }
        });
    }
}

impl Levels for GeneralLevels {
    fn load(&mut self, positions: &Vectors, ends: &Vectors, room: f32, pool: &Pool) {
        let particles = &self.particles;
        for_each_two_chunks(&mut self.x, &mut self.levels[0].d, pool, |first, x, d| {
            for (particle, (x, d)) in particles[first..].iter().zip(x.iter_mut().zip(d)) {
                let (start, end) = (positions.get(*particle as usize), ends.get(*particle as usize));
                *x = start.extend(0.0);
                *d = (end - start).extend(d.w);
            }
        });
        self.hand_out(pool);
        let (finest, coarse) = self.levels.split_at_mut(1);
        let x = &self.x;
        let GeneralLevel { bundles, finest: places, .. } = &mut finest[0];
        for_each_chunk(bundles, pool, |_, bundles| bundles.iter_mut().for_each(|bundle| bundle.begin(x, places)));
        for level in coarse {
            let GeneralLevel { bundles, limits, finest, .. } = level;
            let back_off = self.deltas[1] * room;
            for_each_chunk(bundles, pool, |first, bundles| {
                for (bundle, limit) in bundles.iter_mut().zip(&limits[first..]) {
                    bundle.begin(x, finest);
                    let length = roots(bundle.squares_at_start());
                    // Where the cloth is further than that it may stay so, less the back-off.
                    bundle.limit = (*limit).max(length) - *limit * back_off;
                }
            });
        }
        self.backwards = false;
        self.unmeasured = 0;
        self.solved = false;
        self.obstacles.clear();
    }

    fn hold(&mut self, particle: usize, way: Vec3) {
        let place = self.places[particle];
        let d = way.extend(0.0);
        self.levels[0].d[place as usize] = d;
        self.previous[place as usize] = d;
        self.held.push((place, d));
        // On coarse levels what it follows most is held as well.
        let mut held = place;
        for (index, level) in (0..).zip(&mut self.levels) {
            let weight = std::mem::take(&mut level.d[held as usize].w);
            if weight > 0.0 {
                self.weights_of_held.push((index, held, weight));
            }
            let parents = level.parents.get(held as usize).into_iter().flat_map(|parents| parents.iter());
            let Some((parent, _)) = parents.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))) else { break };
            held = parent;
        }
    }

    fn release(&mut self) {
        self.held.clear();
        for (level, place, weight) in self.weights_of_held.drain(..).rev() {
            self.levels[level as usize].d[place as usize].w = weight;
        }
    }

    fn obstruct(&mut self, obstacles: &[Obstacle], anew: bool, pool: &Pool) {
        self.obstacles.set(obstacles, &self.levels, &self.places, !self.held.is_empty(), anew, pool);
        self.solved = true;
    }

    fn resisted(&mut self, tell: &mut dyn FnMut(u32, f32)) {
        self.obstacles.tell(tell);
    }

    fn cycle(&mut self, Cycle { since_restart, enough, is_sure, is_last, is_calm }: Cycle, pool: &Pool) -> Option<Measure> {
        if let (Some(forest), false) = (&mut self.forest, self.solved) {
            self.solved = true;
            forest.correct(&self.x, &mut self.corrected, enough);
            for (place, d) in self.levels[0].d.iter_mut().enumerate() {
                *d = self.corrected.get(place).extend(d.w);
            }
            self.go_on(0.0, pool);
            self.levels[0].moved.fill(true);
            return Some(self.measure(enough, pool));
        }
        self.go_on(momentum(since_restart, is_calm), pool);
        let (finest, coarse) = self.levels.split_at_mut(1);
        coarse.iter_mut().for_each(|level| level.sample(&finest[0], pool));
        for index in (1..self.levels.len()).rev() {
            for _ in 0..coarse_sweeps(self.levels[index].d.len()) {
                self.obstacles.resist(index, &mut self.levels[index]);
                self.sweep(index, pool);
            }
            let (fine, coarse) = self.levels.split_at_mut(index);
            fine[index - 1].follow(&mut coarse[0], pool);
        }
        // What is held does not follow.
        self.held.iter().for_each(|&(place, d)| self.levels[0].d[place as usize] = d);
        self.levels[0].moved.fill(false);
        self.sweep_finest(true, pool);
        if !self.is_measured(is_sure, is_last) {
            self.unmeasured = self.unmeasured.saturating_sub(1);
            return None;
        }
        let mut left = self.measure(enough, pool);
        self.unmeasured = cycles_to_come(self.tiles.share());
        for _ in 0..LOCAL_ROUNDS {
            if left.over == 0 || !self.tiles.widen() {
                break;
            }
            self.levels[0].moved.fill(false);
            (0..LOCAL_SWEEPS).for_each(|_| self.sweep_finest(false, pool));
            left = self.measure(enough, pool);
        }
        Some(left)
    }

    fn smooth(&mut self, Cycle { enough, is_sure, is_last, .. }: Cycle, pool: &Pool) -> Option<Measure> {
        self.levels[0].moved.fill(false);
        self.sweep_finest(true, pool);
        self.is_measured(is_sure, is_last).then(|| self.measure(enough, pool))
    }

    fn back_off(&self) -> f32 {
        self.deltas[0]
    }

    fn over(&self, enough: f32, visit: &mut dyn FnMut([usize; 2])) {
        let finest = &self.levels[0];
        for bundle in self.tiles.marked().flat_map(|tile| finest.bundles_of(tile)) {
            let over = bundle.squares(&finest.d).cmpgt(bundle.limit * bundle.limit * (enough * enough)).bitmask();
            for lane in (0..LANES).filter(|lane| over >> lane & 1 == 1) {
                visit(bundle.ends.map(|ends| self.particles[ends[lane] as usize] as usize - self.first));
            }
        }
    }

    fn between(&self, from: usize, to: usize) -> Vec3 {
        let ([from, to], d) = ([from, to].map(|particle| self.places[particle] as usize), &self.levels[0].d);
        ((self.x[to] - self.x[from]) + (d[to] - d[from])).xyz()
    }

    fn knows(&self, particle: usize) -> bool {
        self.places[particle] != NOWHERE
    }

    fn displacement(&self, particle: usize) -> Vec3 {
        self.levels[0].d[self.places[particle] as usize].xyz()
    }

    fn shift(&mut self, particle: usize, way: Vec3) {
        self.levels[0].d[self.places[particle] as usize] += way.extend(0.0);
    }

    fn settle(&mut self, pool: &Pool) {
        self.hand_out(pool);
    }

    fn motion(&mut self) -> Motion<'_> {
        Motion { d: &mut self.corrected, weights: &self.weights }
    }

    fn store(&self, positions: &Vectors, ends: &mut Vectors, corrections: &mut Vectors, pool: &Pool) {
        let all = self.first..self.first + self.places.len();
        ends.for_each_part_of_two(corrections, all, CHUNK, pool, |mut ends, mut corrections| {
            for particle in ends.first..ends.first + ends.x.len() {
                let place = self.places[particle - self.first];
                if place == NOWHERE {
                    corrections.set(particle, Vec3::ZERO);
                    continue;
                }
                let place = place as usize;
                let (start, after) = (positions.get(particle), self.corrected.get(place));
                let before = ends.get(particle) - start;
                let corrected = self.weights[place] > 0.0 && after != before;
                corrections.set(particle, if corrected { after - before } else { Vec3::ZERO });
                if corrected {
                    ends.set(particle, start + after);
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::*;
    use serde_json::json;

    use super::super::finish::Finish;
    use super::*;
    use crate::model::{MeshData, Model};
    use crate::scene::Scene;

    /// A sheet of so many cells along each side, 0.1 m each, cut into triangles.
    fn sheet(cells: u32) -> Model {
        held_sheet(cells, &[])
    }

    fn held_sheet(cells: u32, held: &[u32]) -> Model {
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
        let pins: Vec<_> = (!held.is_empty()).then(|| json!({ "vertices": held })).into_iter().collect();
        let document = json!({ "cloth": [{ "mesh": "sheet", "density": 0.2, "strain_limit": 0.01, "pins": pins }] });
        let scene = Scene::from_json(&document.to_string()).expect("a valid scene");
        Model::build(&scene, &BTreeMap::from([("sheet".to_owned(), mesh)])).expect("a valid model")
    }

    #[test]
    fn what_cannot_be_finished_is_put_back() {
        const ENOUGH: f32 = 0.9999;
        let (cells, pool) = (12, Pool::new(1));
        // Every other column is held. Where they are drawn apart, nothing between them has a place.
        let held: Vec<u32> = (0..(cells + 1) * (cells + 1)).filter(|vertex| vertex % (cells + 1) % 2 == 0).collect();
        let model = held_sheet(cells, &held);
        let start = &model.particles.rest;
        let mut ends = start.clone();
        (0..start.len()).for_each(|particle| ends.set(particle, start.get(particle) * Vec3::new(1.3, 1.0, 1.0)));
        let mut levels = GeneralLevels::new(&model.hierarchies[0], &model.cloths[0], 0.01, 0.005);
        levels.load(start, &ends, 1.0, &pool);
        levels.levels[0].moved.fill(true);
        assert!(levels.measure(ENOUGH, &pool).over > 0);
        assert!(!Finish::new(&model, &model.cloths[0]).run(&mut levels, ENOUGH));
        for particle in 1..start.len() {
            let off = levels.between(0, particle) - (ends.get(particle) - ends.get(0));
            assert!(off.length() < 1e-6, "{particle} is {off} from where it was");
        }
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
            levels.load(start, &ends, 1.0, &pool);
            levels.levels[0].moved.fill(true);
            let mut worst = levels.measure(ENOUGH, &pool);
            for _ in 0..6 {
                if worst.over == 0 {
                    break;
                }
                levels.tiles.widen();
                levels.levels[0].moved.fill(false);
                levels.sweep_finest(false, &pool);
                worst = levels.measure(ENOUGH, &pool);
                let marked = levels.tiles.share();
                levels.levels[0].moved.fill(true);
                let everywhere = levels.measure(ENOUGH, &pool);
                prop_assert_eq!(worst.over, everywhere.over);
                prop_assert!(worst == everywhere || everywhere.over == 0, "{:?} where it was swept, {:?} everywhere", worst, everywhere);
                prop_assert_eq!(marked, levels.tiles.share());
            }
        }
    }
}
