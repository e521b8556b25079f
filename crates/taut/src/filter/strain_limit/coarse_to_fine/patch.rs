//! A stubborn place, solved directly.
//!
//! Some springs stay over their limit however many cycles there are: along a border that is taut between two pins, say, which coarse levels
//! hardly see. Around them springs are shorter than they may be by the back-off. So the particles around are taken, as many rings as
//! it needs, those further out held where they are, and the place nearest to the present one is found by an interior-point method.
//! What is held there drops reactions, as the finish does.

use glam::DVec3;

use super::Levels;
use super::interior::{Interior, Link, Task};
use crate::model::Adjacency;

/// Particles of a patch, about: four times as many where few have no solution.
const SIZES: [usize; 2] = [300, 1200];
/// What springs may be over their aims, and how far these are below what is enough, as parts of the length.
const EXACT: f64 = 1e-6;
/// What of the energy of the correction may be in doubt.
const NEARLY: f64 = 0.01;

/// Workspace of a cloth.
pub(super) struct Patch {
    /// Numbers of particles in the patch; `OUTSIDE` of others.
    number: Vec<u32>,
    /// Particles of the patch: those that move first.
    particles: Vec<u32>,
}

const OUTSIDE: u32 = u32::MAX;

impl Patch {
    /// Of a cloth with so many particles.
    pub fn new(count: usize) -> Self {
        Self { number: vec![OUTSIDE; count], particles: Vec::new() }
    }

    /// Makes all springs at most `enough` of their limit long. `around` has neighbours and the greatest lengths of the springs to them [m],
    /// `weights` W [1/kg]. Returns whether that was done; otherwise nothing has changed.
    pub fn run(&mut self, levels: &mut dyn Levels, around: &Adjacency<(u32, f32)>, weights: &[f32], enough: f32) -> bool {
        let mut seeds = Vec::new();
        levels.over(enough, &mut |ends| seeds.extend(ends));
        SIZES.iter().any(|&size| {
            let movable = self.gather(&seeds, size, around, weights);
            let is_solved = self.solve(levels, around, weights, enough, movable);
            self.particles.drain(..).for_each(|particle| self.number[particle as usize] = OUTSIDE);
            is_solved
        })
    }

    /// Takes rings around the `seeds` until there are `size` particles, and those that hold them. Returns how many may move.
    fn gather(&mut self, seeds: &[usize], size: usize, around: &Adjacency<(u32, f32)>, weights: &[f32]) -> usize {
        for &seed in seeds {
            self.take(seed, weights);
        }
        let (mut next, mut ring) = (0, self.particles.len());
        while next < ring && self.particles.len() < size {
            for index in next..ring {
                for &(other, _) in around.of(self.particles[index] as usize) {
                    self.take(other as usize, weights);
                }
            }
            (next, ring) = (ring, self.particles.len());
        }
        let movable = self.particles.len();
        for index in 0..movable {
            for &(other, _) in around.of(self.particles[index] as usize) {
                if self.number[other as usize] == OUTSIDE {
                    self.number[other as usize] = self.particles.len() as u32;
                    self.particles.push(other);
                }
            }
        }
        movable
    }

    /// Takes a particle that may move.
    fn take(&mut self, particle: usize, weights: &[f32]) {
        if weights[particle] > 0.0 && self.number[particle] == OUTSIDE {
            self.number[particle] = self.particles.len() as u32;
            self.particles.push(particle as u32);
        }
    }

    fn solve(
        &self,
        levels: &mut dyn Levels,
        around: &Adjacency<(u32, f32)>,
        weights: &[f32],
        enough: f32,
        movable: usize,
    ) -> bool {
        let mut links = Vec::new();
        let (mut energy, mut spread) = (0.0, 0.0_f64);
        let places: Vec<usize> = self.particles.iter().map(|particle| *particle as usize).collect();
        let inverse_masses: Vec<f64> = places.iter().map(|&particle| f64::from(weights[particle])).collect();
        let start: Vec<DVec3> = places.iter().map(|&particle| levels.displacement(particle).as_dvec3()).collect();
        for (index, &particle) in places[..movable].iter().enumerate() {
            for &(other, limit) in around.of(particle) {
                let number = self.number[other as usize];
                if (number as usize) < index {
                    continue;
                }
                let way = levels.between(particle, other as usize).as_dvec3();
                let aim = f64::from(enough * limit) * (1.0 - 2.0 * EXACT);
                let over = way.length() / aim - 1.0;
                if over > 0.0 {
                    spread = spread.max(over);
                    energy += (over * aim) * (over * aim) / (inverse_masses[index] + inverse_masses[number as usize]);
                }
                let rest = way - (start[number as usize] - start[index]);
                links.push(Link { ends: [index as u32, number], start: rest, aim });
            }
        }
        let movable: Vec<usize> = (0..movable).collect();
        let Some(mut interior) = Interior::new(links.iter().map(|link| link.ends), &inverse_masses, &movable) else {
            return false;
        };
        let mut found = start.clone();
        let task =
            Task { links: &links, weights: &inverse_masses, proposed: &start, energy, spread, exact: EXACT, nearly: NEARLY };
        let is_solved = energy > 0.0 && interior.run(task, &mut found);
        if is_solved {
            for &index in &movable {
                levels.shift(places[index], (found[index] - start[index]).as_vec3());
            }
        }
        is_solved
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use glam::Vec3;
    use serde_json::json;

    use super::super::Cycle;
    use super::super::finish::Finish;
    use super::super::general::GeneralLevels;
    use super::*;
    use crate::geometry::Pool;
    use crate::model::Model;
    use crate::scene::Scene;

    /// Points of a ladder that hangs along z, two to a rung.
    const POINTS: usize = 2000;
    const ENOUGH: f32 = 1.0 - 2e-5;

    /// A ladder whose point in the middle is moved by `way`, after one cycle: whether a patch puts that right, which points it moves, and the
    /// longest spring before and after it, as a part of its limit.
    fn pulled(way: Vec3, held: &[usize]) -> (bool, Vec<usize>, [f32; 2]) {
        let points: Vec<[f64; 3]> =
            (0..POINTS).map(|point| [0.01 * (point % 2) as f64, 0.0, -0.01 * (point / 2) as f64]).collect();
        let rungs = (0..POINTS / 2).map(|rung| [2 * rung, 2 * rung + 1]);
        let rails = (2..POINTS).map(|point| [point - 2, point]);
        let ladder = json!({ "points": points, "links": rungs.chain(rails).collect::<Vec<_>>(), "mass": 1e-3 });
        let cloth = json!({ "network": ladder, "strain_limit": 0.01, "pins": [{ "vertices": held }] });
        let scene = Scene::from_json(&json!({ "cloth": [cloth] }).to_string()).expect("a valid scene");
        let model = Model::build(&scene, &BTreeMap::new()).expect("a model");
        let cloth = &model.cloths[0];
        let start = &model.particles.rest;
        let middle = model.numbering.particle(POINTS as u32 / 2) as usize;
        let mut ends = start.clone();
        ends.set(middle, ends.get(middle) + way);
        let mut levels = GeneralLevels::new(&model.hierarchies[cloth.hierarchy.expect("a network has one")], cloth, 0.01, 0.005);
        levels.load(start, &ends, 1.0, &Pool::new(1));
        levels.cycle(Cycle { since_restart: 0, enough: ENOUGH, is_sure: false, is_last: true, is_calm: false }, &Pool::new(1));
        let worst = |levels: &GeneralLevels| {
            let lengths = model.springs.ends.iter().enumerate().map(|(spring, ends)| {
                let [u, v] = ends.map(|end| end as usize);
                levels.between(u, v).length() / model.springs.greatest_length(spring)
            });
            lengths.fold(0.0, f32::max)
        };
        let finish = Finish::new(&model, cloth);
        let (before, worst_before) =
            ((0..POINTS).map(|particle| levels.displacement(particle)).collect::<Vec<_>>(), worst(&levels));
        let weights = &model.particles.inverse_mass[cloth.particles()];
        let is_solved = Patch::new(POINTS).run(&mut levels, finish.around(), weights, ENOUGH);
        let moved = (0..POINTS).filter(|&particle| levels.displacement(particle) != before[particle]).collect();
        (is_solved, moved, [worst_before, worst(&levels)])
    }

    #[test]
    fn a_place_is_put_right_and_what_lies_further_out_stays() {
        let (is_solved, moved, [before, after]) = pulled(Vec3::new(0.0, 0.02, 0.0), &[0, 1]);
        assert!(is_solved && before > 1.0 && after <= ENOUGH, "{before}, {after}");
        assert!(!moved.is_empty() && moved.len() <= SIZES[0] + 4, "{} points moved", moved.len());
    }

    #[test]
    fn where_nothing_fits_nothing_moves() {
        let (is_solved, moved, _) = pulled(Vec3::new(0.0, 30.0, 0.0), &[0, 1, POINTS / 2]);
        assert!(
            !is_solved && moved.is_empty(),
            "a ladder of ten metres does not reach thirty metres aside: {} moved",
            moved.len()
        );
    }
}
