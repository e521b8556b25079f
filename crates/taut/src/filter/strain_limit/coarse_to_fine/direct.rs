//! What cycles cannot solve, solved directly: the place within all limits that is nearest to the proposed one.
//!
//! Cycles go from spring to spring. Where a point bears thousands of times the mass of its neighbours, or cells are many times longer
//! than wide, they take more than there are, or pull further than the step moves. Nearest in the metric of masses is P - W J^T m with a
//! multiplier m >= 0 for each spring: that of fast projection (Goldenthal et al. 2007), but for limits that need not be reached. Springs
//! are held to their aims along the directions that cycles found, which is a convex problem, solved by projected Newton steps in the
//! multipliers (Bertsekas, SIAM J. Control Optim. 20(2), 1982): those that would push are zero, the others are solved for at once. Where springs
//! have turned on the way, directions are taken anew and what was found is projected once more: no longer quite the nearest place. X is
//! within the aims, so each projection brings the cloth nearer to X, and kinetic energy does not rise. A light point between two
//! heavy ones may turn its springs again and again; then nothing is found, and the certificate shortens the step.
//!
//! Small cloths alone have one: the time of a factorisation grows faster than the number of springs.

use glam::DVec3;

use super::super::multipliers::System;
use super::Levels;
use crate::geometry::Vectors;
use crate::model::{ClothRange, Model};

/// Cloths with more springs have none.
const MOST_SPRINGS: usize = 6000;
/// Directions are taken so many times at most, with so many Newton steps each, each of them halved so many times.
const TURNS: usize = 6;
const ROUNDS: usize = 15;
const HALVINGS: usize = 20;
/// What a spring may be too long along its direction after that, as a part of R [1].
const EXACT: f64 = 2e-6;
/// Aims are below the limit by at least so many times what is not worth further work: the solution is no more exact.
const TIGHTER: f64 = 3.0;

/// The limited springs of a cloth and their linear system.
pub(super) struct Direct {
    first: usize,
    springs: Vec<Spring>,
    /// Particles that a spring may move: levels know no others.
    movable: Vec<usize>,
    /// W of the cloth's particles [1/kg].
    weights: Vec<f64>,
    system: System,
    /// X_uv of each spring, and a, what it may reach in this step [m].
    starts: Vec<DVec3>,
    aims: Vec<f64>,
    /// Half of its direction: C = |P_uv| - a.
    slopes: Vec<DVec3>,
    /// Which are solved for, m and its Newton step.
    taut: Vec<bool>,
    multipliers: Vec<f64>,
    step: Vec<f64>,
    /// The proposed displacements, and those that are found [m].
    proposed: Vec<DVec3>,
    found: Vec<DVec3>,
}

struct Spring {
    /// Particles, from the cloth's first.
    ends: [u32; 2],
    /// R [m].
    limit: f64,
}

impl Direct {
    /// Of a cloth; none if it is too large.
    pub fn new(model: &Model, cloth: &ClothRange) -> Option<Self> {
        if cloth.springs.len() > MOST_SPRINGS {
            return None;
        }
        let weights: Vec<f64> = cloth.particles().map(|particle| f64::from(model.particles.inverse_mass[particle])).collect();
        let local = |spring: usize| model.springs.ends[spring].map(|end| end - cloth.first as u32);
        let moves = |spring: &usize| local(*spring).iter().any(|&end| weights[end as usize] > 0.0);
        let springs: Vec<Spring> = cloth
            .springs
            .clone()
            .filter(moves)
            .map(|spring| Spring { ends: local(spring), limit: f64::from(model.springs.greatest_length(spring)) })
            .collect();
        let mut movable = vec![false; cloth.count];
        springs.iter().flat_map(|spring| spring.ends).for_each(|end| movable[end as usize] = weights[end as usize] > 0.0);
        Some(Self {
            movable: (0..cloth.count).filter(|&particle| movable[particle]).collect(),
            first: cloth.first,
            system: System::new(springs.iter().map(|spring| spring.ends), &weights)?,
            aims: vec![0.0; springs.len()],
            slopes: vec![DVec3::ZERO; springs.len()],
            taut: vec![false; springs.len()],
            multipliers: vec![0.0; springs.len()],
            step: vec![0.0; springs.len()],
            starts: vec![DVec3::ZERO; springs.len()],
            proposed: vec![DVec3::ZERO; weights.len()],
            found: vec![DVec3::ZERO; weights.len()],
            springs,
            weights,
        })
    }

    /// Makes all springs at most `enough` of their limit long, wherever `levels` have brought them. Returns whether that was done;
    /// otherwise nothing has changed.
    pub fn run(&mut self, levels: &mut dyn Levels, positions: &Vectors, ends: &Vectors, enough: f32) -> bool {
        let (enough, back_off) = (f64::from(enough), f64::from(levels.back_off()));
        for (place, (proposed, found)) in self.proposed.iter_mut().zip(&mut self.found).enumerate() {
            let (start, end) = (positions.get(self.first + place), ends.get(self.first + place));
            *proposed = end.as_dvec3() - start.as_dvec3();
            *found = levels.displacement(place).as_dvec3();
        }
        // As long as it was, but not so short that cycles would have nothing to do, nor so long that the next step finds no room.
        let most = 1.0 - TIGHTER * (1.0 - enough);
        for (index, spring) in self.springs.iter().enumerate() {
            let [u, v] = spring.ends.map(|end| positions.get(self.first + end as usize).as_dvec3());
            self.starts[index] = v - u;
            self.aims[index] = u.distance(v).clamp(spring.limit * (1.0 - back_off).min(most), spring.limit * most);
        }
        for _ in 0..TURNS {
            self.project();
            if self.is_within(enough) {
                for &particle in &self.movable {
                    levels.shift(particle, self.found[particle].as_vec3() - levels.displacement(particle));
                }
                return true;
            }
            self.proposed.copy_from_slice(&self.found);
        }
        false
    }

    fn is_within(&self, enough: f64) -> bool {
        self.springs
            .iter()
            .zip(&self.starts)
            .all(|(spring, start)| spring.way(*start, &self.found).length() <= enough * spring.limit)
    }

    /// Finds the place nearest to the proposed one where no spring is too long along the direction that it has now.
    fn project(&mut self) {
        for (spring, (slope, start)) in self.springs.iter().zip(self.slopes.iter_mut().zip(&self.starts)) {
            let way = spring.way(*start, &self.found);
            *slope = 0.5 * way / way.length().max(f64::MIN_POSITIVE);
        }
        self.multipliers.fill(0.0);
        self.step.fill(0.0);
        let mut dual = self.go(0.0);
        for _ in 0..ROUNDS {
            let mut worst = 0.0_f64;
            for (index, spring) in self.springs.iter().enumerate() {
                let over = 2.0 * self.slopes[index].dot(spring.way(self.starts[index], &self.found)) - self.aims[index];
                self.taut[index] = self.multipliers[index] > 0.0 || over > 0.0;
                self.step[index] = if self.taut[index] { over } else { 0.0 };
                worst = worst.max(over / spring.limit);
            }
            if worst <= EXACT || !self.system.solve(&self.slopes, Some(&self.taut), &mut self.step) {
                return;
            }
            let (before, mut part) = (dual, 1.0);
            for _ in 0..HALVINGS {
                dual = self.go(part);
                if dual < before {
                    break;
                }
                part *= 0.5;
            }
            for (multiplier, step) in self.multipliers.iter_mut().zip(&self.step) {
                *multiplier = (*multiplier + part * step).max(0.0);
            }
            if dual >= before {
                return;
            }
        }
    }

    /// Goes `part` of the step and finds the displacements there. Returns what is to become as small as possible: the dual of the energy.
    fn go(&mut self, part: f64) -> f64 {
        self.found.fill(DVec3::ZERO);
        let mut dual = 0.0;
        for (index, spring) in self.springs.iter().enumerate() {
            let multiplier = (self.multipliers[index] + part * self.step[index]).max(0.0);
            if multiplier > 0.0 {
                let [u, v] = spring.ends.map(|end| end as usize);
                let pull = self.slopes[index] * (2.0 * multiplier);
                self.found[u] += pull;
                self.found[v] -= pull;
                dual -= pull.dot(spring.way(self.starts[index], &self.proposed)) - multiplier * self.aims[index];
            }
        }
        for ((found, proposed), weight) in self.found.iter_mut().zip(&self.proposed).zip(&self.weights) {
            dual += 0.5 * weight * found.length_squared();
            *found = *proposed + *found * *weight;
        }
        dual
    }
}

impl Spring {
    /// From one end to the other [m], where it began and what its particles went.
    fn way(&self, start: DVec3, went: &[DVec3]) -> DVec3 {
        let [u, v] = self.ends.map(|end| went[end as usize]);
        start + (v - u)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::iter::zip;

    use serde_json::json;

    use super::super::general::GeneralLevels;
    use super::*;
    use crate::geometry::Pool;
    use crate::scene::Scene;

    const SIDE: usize = 4;

    /// A net of squares with both diagonals, its first point held, some of the others heavy.
    fn net(masses: &[f64]) -> Model {
        let points: Vec<[f64; 3]> =
            (0..SIDE * SIDE).map(|point| [0.1 * (point % SIDE) as f64, 0.1 * (point / SIDE) as f64, 0.0]).collect();
        let near = |a: usize, b: usize| (a % SIDE).abs_diff(b % SIDE) <= 1 && (a / SIDE).abs_diff(b / SIDE) <= 1;
        let links: Vec<[usize; 2]> =
            (0..points.len()).flat_map(|b| (0..b).map(move |a| [a, b])).filter(|&[a, b]| near(a, b)).collect();
        let net = json!({ "points": points, "links": links, "mass": masses });
        let cloth = json!({ "network": net, "strain_limit": 0.05, "pins": [{ "vertices": [0] }] });
        let scene = Scene::from_json(&json!({ "cloth": [cloth] }).to_string()).expect("a valid scene");
        Model::build(&scene, &BTreeMap::new()).expect("a model")
    }

    /// The nearest places within balls, by Dykstra's projections: one spring after the other, each taken back before it is put right again.
    fn nearest(model: &Model, mut places: Vec<DVec3>, aims: &[f64]) -> Vec<DVec3> {
        let mut pulls = vec![[DVec3::ZERO; 2]; aims.len()];
        for _ in 0..20_000 {
            for ((ends, &aim), pull) in model.springs.ends.iter().zip(aims).zip(&mut pulls) {
                let [u, v] = ends.map(|end| end as usize);
                let [a, b] = ends.map(|end| f64::from(model.particles.inverse_mass[end as usize]));
                (places[u], places[v]) = (places[u] - pull[0], places[v] - pull[1]);
                let way = places[v] - places[u];
                let over = (1.0 - aim / way.length()).max(0.0) / (a + b);
                *pull = [way * (over * a), way * (-over * b)];
                (places[u], places[v]) = (places[u] + pull[0], places[v] + pull[1]);
            }
        }
        places
    }

    #[test]
    fn what_is_found_is_the_nearest_place_within_the_limits() {
        const ENOUGH: f32 = 1.0 - 2e-5;
        const TRIALS: usize = 60;
        let pool = Pool::new(1);
        let mut dice =
            (1_u64..).map(|seed| (xxhash_rust::xxh3::xxh3_64(&seed.to_le_bytes()) >> 11) as f64 / (1_u64 << 53) as f64);
        let mut dice = || dice.next().expect("no end");
        let (mut solved, mut nearly_nearest) = (0, 0);
        for trial in 0..TRIALS {
            let heavy: Vec<f64> = (0..SIDE * SIDE).map(|_| if dice() < 0.25 { 0.3 * dice() } else { 1e-4 }).collect();
            let model = net(&heavy);
            let start = &model.particles.rest;
            let mut ends = start.clone();
            for particle in (0..start.len()).filter(|particle| model.particles.inverse_mass[*particle] > 0.0) {
                let way = DVec3::new(dice(), dice(), dice()) - 0.5;
                ends.set(particle, start.get(particle) + 0.02 * way.as_vec3());
            }
            let hierarchy = model.cloths[0].hierarchy.expect("a network has one");
            let mut levels = GeneralLevels::new(&model.hierarchies[hierarchy], &model.cloths[0], 0.05, 0.01);
            levels.load(start, &ends, 1.0, &pool);
            let mut direct = Direct::new(&model, &model.cloths[0]).expect("a small cloth");
            let before: Vec<_> = (0..start.len()).map(|particle| levels.displacement(particle)).collect();
            let is_solved = direct.run(&mut levels, start, &ends, ENOUGH);
            let after: Vec<_> = (0..start.len()).map(|particle| levels.displacement(particle)).collect();
            if !is_solved {
                assert_eq!(before, after, "trial {trial}: nothing has changed");
                continue;
            }
            solved += 1;
            let [proposed, found] = [&before, &after].map(|ways| -> Vec<DVec3> {
                start.iter().zip(ways).map(|(start, way)| start.as_dvec3() + way.as_dvec3()).collect()
            });
            let work = |places: &[DVec3], others: &[DVec3]| -> f64 {
                let moves = zip(zip(places, others), &model.particles.mass).filter(|(_, mass)| mass.is_finite());
                moves.map(|((place, other), mass)| f64::from(*mass) * place.distance_squared(*other)).sum()
            };
            let at_start: Vec<DVec3> = start.iter().map(|place| place.as_dvec3()).collect();
            for (spring, ends) in model.springs.ends.iter().enumerate() {
                let [u, v] = ends.map(|end| found[end as usize]);
                assert!(u.distance(v) <= f64::from(model.springs.greatest_length(spring)), "trial {trial}: spring {spring}");
            }
            let energy = |places: &[DVec3]| work(places, &at_start);
            assert!(energy(&found) <= energy(&proposed) * (1.0 + 1e-6), "trial {trial} gains energy");
            let least = work(&nearest(&model, proposed.clone(), &direct.aims), &proposed);
            nearly_nearest += usize::from(work(&found, &proposed) <= 1.01 * least + 1e-13);
        }
        assert!(10 * solved >= 9 * TRIALS, "{solved} of {TRIALS} were solved");
        assert!(10 * nearly_nearest >= 8 * solved, "{nearly_nearest} of {solved} were the nearest");
    }
}
