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

use glam::Vec3;

use super::{Levels, Motion};
use crate::geometry::{Pool, Vectors};
use crate::model::{ClothRange, Hierarchy};
use forest::Forest;
use level::{Level, Pull, square_distance};
use tiles::Tiles;

/// Levels with at most this many particles are swept [`COARSEST_SWEEPS`] times: they cost nothing and carry the loads.
const COARSEST: usize = 81;
const COARSEST_SWEEPS: usize = 3;
/// Part of the way that coarse springs are pulled; the finer levels do the rest.
const COARSE_PART: f32 = 0.8;
/// After a cycle, the few places that are still over their limit are swept alone: so many times, so many rounds.
const LOCAL_SWEEPS: usize = 4;
const LOCAL_ROUNDS: usize = 3;

/// The levels of one cloth, finest first.
pub(super) struct GeneralLevels {
    levels: Vec<Level>,
    /// The particle at each place of the finest level.
    particles: Vec<u32>,
    /// Inverse masses on the finest level.
    weights: Vec<f32>,
    /// Where the step begins [m].
    x: Vectors,
    /// Displacements one cycle ago [m].
    previous: Vectors,
    /// Where the finest level is over its limit.
    tiles: Tiles,
    /// What can be solved exactly, and whether it has been in this step.
    forest: Option<Forest>,
    solved: bool,
    delta: f32,
    backwards: bool,
}

impl GeneralLevels {
    /// The levels of a cloth with the limit `strain_limit`, aiming `delta` of R below it.
    pub fn new(hierarchy: &Hierarchy, cloth: &ClothRange, strain_limit: f32, delta: f32) -> Self {
        let (levels, particles) = build::levels(hierarchy, cloth, 1.0 + strain_limit);
        let count = particles.len();
        let weights: Vec<f32> = levels[0].p.iter().map(|quad| quad[3]).collect();
        Self {
            forest: Forest::new(&levels[0].springs, &weights),
            solved: false,
            weights,
            x: Vectors::zeros(count),
            previous: Vectors::zeros(count),
            tiles: Tiles::new(count, &levels[0].springs),
            levels,
            particles,
            delta,
            backwards: false,
        }
    }

    /// Not every spring that is a little over its aim is worth a pull: only those more than half the way to the limit.
    fn finest_pull(&self) -> Pull {
        Pull { trigger: 1.0 - 0.5 * self.delta, aim: 1.0 - self.delta, part: 1.0 }
    }

    fn sweep(&mut self, index: usize) {
        let pull = if index == 0 { self.finest_pull() } else { Pull { trigger: 1.0, aim: 1.0, part: COARSE_PART } };
        let level = &mut self.levels[index];
        level.sweep(0..level.springs.len(), pull, self.backwards);
        self.backwards = !self.backwards;
    }

    fn sweep_tiles(&mut self) {
        let pull = self.finest_pull();
        let count = self.tiles.count();
        for tile in 0..count {
            let tile = if self.backwards { count - 1 - tile } else { tile };
            self.levels[0].sweep(self.tiles.springs(tile), pull, self.backwards);
        }
        self.backwards = !self.backwards;
    }

    /// Largest |P_uv| / R; marks the tiles where it is over `enough`.
    fn measure(&mut self, enough: f32) -> f32 {
        self.tiles.clear();
        let Level { p, springs, .. } = &self.levels[0];
        let mut worst = 0.0_f32;
        for spring in springs {
            let [u, v] = spring.ends.map(|end| end as usize);
            let (square, limit) = (square_distance(p[u], p[v]), spring.limit * spring.limit);
            if square > worst * limit {
                worst = square / limit;
            }
            if square > enough * enough * limit {
                self.tiles.mark(spring);
            }
        }
        worst.sqrt()
    }

    /// Goes on with `momentum` and forms the ends of the step anew, so that their roundings do not add up.
    fn go_on(&mut self, momentum: f32) {
        let Level { p, d, .. } = &mut self.levels[0];
        for (place, p) in p.iter_mut().enumerate() {
            let now = d.get(place);
            let ahead = if momentum > 0.0 { now + (now - self.previous.get(place)) * momentum } else { now };
            self.previous.set(place, now);
            d.set(place, ahead);
            let end = self.x.get(place) + ahead;
            p[..3].copy_from_slice(&end.to_array());
        }
    }
}

impl Levels for GeneralLevels {
    fn load(&mut self, positions: &Vectors, ends: &Vectors) {
        for (place, &particle) in self.particles.iter().enumerate() {
            let start = positions.get(particle as usize);
            self.x.set(place, start);
            self.levels[0].d.set(place, ends.get(particle as usize) - start);
        }
        for level in &mut self.levels[1..] {
            for spring in &mut level.springs {
                let [u, v] = spring.ends.map(|end| self.x.get(level.finest[end as usize] as usize));
                spring.now = (spring.limit * (1.0 - self.delta)).max(u.distance(v));
            }
        }
        self.backwards = false;
        self.solved = false;
    }

    fn cycle(&mut self, momentum: f32, enough: f32, _: &Pool) -> f32 {
        if let (Some(forest), false) = (&mut self.forest, self.solved) {
            self.solved = true;
            forest.correct(&self.x, &mut self.levels[0].d, enough);
            self.go_on(0.0);
            return self.measure(enough);
        }
        self.go_on(momentum);
        let (finest, coarse) = self.levels.split_at_mut(1);
        for level in coarse {
            for (p, &place) in level.p.iter_mut().zip(&level.finest) {
                let [x, y, z, _] = finest[0].p[place as usize];
                p[..3].copy_from_slice(&[x, y, z]);
            }
            level.forget();
        }
        for index in (1..self.levels.len()).rev() {
            for _ in 0..if self.levels[index].p.len() <= COARSEST { COARSEST_SWEEPS } else { 1 } {
                self.sweep(index);
            }
            let (fine, coarse) = self.levels.split_at_mut(index);
            fine[index - 1].follow(&coarse[0]);
        }
        self.sweep(0);
        let mut worst = self.measure(enough);
        for _ in 0..LOCAL_ROUNDS {
            if worst <= enough || !self.tiles.widen() {
                break;
            }
            (0..LOCAL_SWEEPS).for_each(|_| self.sweep_tiles());
            worst = self.measure(enough);
        }
        worst
    }

    fn release(&mut self, _: &Pool) {}

    fn motion(&mut self) -> Motion<'_> {
        Motion { d: &mut self.levels[0].d, weights: &self.weights }
    }

    fn store(&self, positions: &Vectors, ends: &mut Vectors, corrections: &mut Vectors) {
        for (place, &particle) in self.particles.iter().enumerate() {
            let particle = particle as usize;
            let (start, after) = (positions.get(particle), self.levels[0].d.get(place));
            let before = ends.get(particle) - start;
            let corrected = self.weights[place] > 0.0 && after != before;
            corrections.set(particle, if corrected { after - before } else { Vec3::ZERO });
            if corrected {
                ends.set(particle, start + after);
            }
        }
    }
}
