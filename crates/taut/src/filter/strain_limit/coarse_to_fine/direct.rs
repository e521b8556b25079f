//! What cycles cannot solve, solved directly: the place within all limits that is nearest to the proposed one.
//!
//! Cycles go from spring to spring. Where a point bears thousands of times the mass of its neighbours, or cells are many times longer
//! than wide, they take more than there are, or pull further than the step moves. What is to be found is a convex problem, solved by an
//! interior-point method. X is within the aims: the place nearest to the proposed one is nearer to X than that, and kinetic energy does
//! not rise.
//!
//! A factorisation takes longer than cycles, and its time grows faster than the number of springs: small cloths alone have one, and larger
//! ones that bear something heavy.

use glam::{DVec3, Vec3};

use super::Levels;
use super::interior::{Interior, Link, Task};
use crate::geometry::Vectors;
use crate::model::{ClothRange, Model};

/// Aims are below the limit by at least so many times what rounding may add, and kept to within this part of it.
const MARGIN: f64 = 1.25;
const DOUBT: f64 = 0.1;
/// What of the energy of the proposed motion may be in doubt.
const NEARLY: f64 = 1e-4;

/// The limited springs of a cloth.
pub(super) struct Direct {
    first: usize,
    /// Each with X_uv and what it may reach in this step, and its limit R [m].
    springs: Vec<Link>,
    limits: Vec<f64>,
    /// Particles that a spring may move: levels know no others.
    movable: Vec<usize>,
    /// W of the cloth's particles [1/kg].
    weights: Vec<f64>,
    interior: Interior,
    /// The proposed displacements, and those that are found [m].
    proposed: Vec<DVec3>,
    found: Vec<DVec3>,
}

impl Direct {
    /// Of a cloth; none if it is too large, or nothing in it moves.
    pub fn new(model: &Model, cloth: &ClothRange) -> Option<Self> {
        let weights: Vec<f64> = cloth.particles().map(|particle| f64::from(model.particles.inverse_mass[particle])).collect();
        let local = |spring: usize| model.springs.ends[spring].map(|end| end - cloth.first as u32);
        let moves = |spring: &usize| local(*spring).iter().any(|&end| weights[end as usize] > 0.0);
        let (springs, limits): (Vec<Link>, Vec<f64>) = cloth
            .springs
            .clone()
            .filter(moves)
            .map(|spring| {
                let link = Link { ends: local(spring), start: DVec3::ZERO, aim: 0.0 };
                (link, f64::from(model.springs.greatest_length(spring)))
            })
            .unzip();
        let mut movable = vec![false; cloth.count];
        springs.iter().flat_map(|spring| spring.ends).for_each(|end| movable[end as usize] = weights[end as usize] > 0.0);
        let movable: Vec<usize> = (0..cloth.count).filter(|&particle| movable[particle]).collect();
        Some(Self {
            first: cloth.first,
            interior: Interior::new(springs.iter().map(|spring| spring.ends), &weights, &movable)?,
            movable,
            proposed: vec![DVec3::ZERO; weights.len()],
            found: vec![DVec3::ZERO; weights.len()],
            springs,
            limits,
            weights,
        })
    }

    /// Makes all springs shorter than their limits by `rounding`, a part of these, wherever `levels` have brought them. Returns whether
    /// that was done; otherwise nothing has changed. What is held goes by `frame` [m].
    pub fn run(&mut self, levels: &mut dyn Levels, positions: &Vectors, ends: &Vectors, frame: Vec3, rounding: f32) -> bool {
        let (rounding, back_off) = (f64::from(rounding), f64::from(levels.back_off()));
        for (place, proposed) in (self.first..).zip(&mut self.proposed) {
            *proposed = ends.get(place).as_dvec3() - positions.get(place).as_dvec3();
        }
        // As long as it was, but not so short that cycles would have nothing to do, nor so long that the next step finds no room.
        let most = 1.0 - MARGIN * rounding;
        for (spring, limit) in self.springs.iter_mut().zip(&self.limits) {
            let [u, v] = spring.ends.map(|end| positions.get(self.first + end as usize).as_dvec3());
            spring.start = v - u;
            spring.aim = u.distance(v).clamp(limit * (1.0 - back_off).min(most), limit * most);
        }
        let (mut energy, frame) = (0.0, frame.as_dvec3());
        self.found.copy_from_slice(&self.proposed);
        for &particle in &self.movable {
            energy += (self.proposed[particle] - frame).length_squared() / self.weights[particle];
            self.found[particle] = frame;
        }
        if energy <= 0.0 {
            return false;
        }
        let moved = self.springs.iter().map(|spring| {
            let way = spring.way(&self.proposed) - spring.start;
            way.length_squared() / (spring.aim * spring.aim)
        });
        let task = Task {
            links: &self.springs,
            weights: &self.weights,
            proposed: &self.proposed,
            energy,
            spread: (moved.sum::<f64>() / self.springs.len() as f64).sqrt(),
            exact: DOUBT * rounding,
            nearly: NEARLY,
        };
        let is_found = self.interior.run(task, &mut self.found);
        if is_found {
            for &particle in &self.movable {
                levels.shift(particle, self.found[particle].as_vec3() - levels.displacement(particle));
            }
        }
        is_found
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
        const ROUNDING: f32 = 1e-6;
        const TRIALS: usize = 60;
        let pool = Pool::new(1);
        let mut dice =
            (1_u64..).map(|seed| (xxhash_rust::xxh3::xxh3_64(&seed.to_le_bytes()) >> 11) as f64 / (1_u64 << 53) as f64);
        let mut dice = || dice.next().expect("no end");
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
            assert!(direct.run(&mut levels, start, &ends, Vec3::ZERO, ROUNDING), "trial {trial} is not solved");
            let after: Vec<_> = (0..start.len()).map(|particle| levels.displacement(particle)).collect();
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
            let aims: Vec<f64> = direct.springs.iter().map(|spring| spring.aim).collect();
            let least = work(&nearest(&model, proposed.clone(), &aims), &proposed);
            let found = work(&found, &proposed);
            assert!(found <= least + 1e-4 * energy(&proposed), "trial {trial}: {found} where {least} is the least");
        }
    }
}
