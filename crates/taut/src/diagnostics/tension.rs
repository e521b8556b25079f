//! What springs carry. No filter tells that: a strain limit moves particles, on coarse levels too, and has no force for each spring. But
//! what a step did to momentum is known, and what forces alone would have done; the rest is the springs'.

use glam::DVec3;

use crate::model::Model;
use crate::state::State;

/// The solution ends where what is left has become smaller by this factor ..
const ENOUGH: f64 = 1e-6;
/// .. or after so many passes over all springs: the load of a chain goes from link to link, in as many as it has.
const MOST_PASSES: usize = 10_000;

/// Tension of each spring [N]. It is that of Hooke's law, or of its curve, and the least change of it, in the sum of squares, that gives
/// each particle the force `wanted` besides [N]. No change does so where cloth would have to bear loads across itself. There it is the
/// one that leaves the least of that force, in the sum of squares over masses. Type 2 springs keep what they have. Conjugate gradients
/// [HestenesStiefel52] from zero lead to that one of all solutions.
#[must_use]
pub fn tensions(model: &Model, state: &State, wanted: &[DVec3]) -> Vec<f64> {
    let springs = Springs::new(model, state);
    let weights: Vec<f64> = model.particles.inverse_mass.iter().map(|&weight| f64::from(weight)).collect();
    let mut field: Vec<DVec3> = wanted.iter().zip(&weights).map(|(force, weight)| *force * *weight).collect();
    let mut found = vec![0.0; springs.list.len()];
    let mut left = vec![0.0; found.len()];
    springs.along(&field, &mut left);
    let (mut way, mut image) = (left.clone(), left.clone());
    let first = dot(&left, &left);
    let mut square = first;
    for _ in 0..MOST_PASSES {
        if square <= ENOUGH * ENOUGH * first {
            break;
        }
        springs.accelerate(&way, &weights, &mut field);
        springs.along(&field, &mut image);
        let length = square / dot(&way, &image);
        if !length.is_finite() {
            break;
        }
        for (found, way) in found.iter_mut().zip(&way) {
            *found += length * way;
        }
        for (left, image) in left.iter_mut().zip(&image) {
            *left -= length * image;
        }
        let next = dot(&left, &left);
        for (way, left) in way.iter_mut().zip(&left) {
            *way = left + next / square * *way;
        }
        square = next;
    }
    found.iter().zip(&springs.list).map(|(found, spring)| found + spring.by_law).collect()
}

/// A spring where it is.
struct Spring {
    ends: [usize; 2],
    /// From the first end to the second, of length 1; zero where it takes no further tension.
    way: DVec3,
    /// Its pull by its law [N].
    by_law: f64,
}

struct Springs {
    list: Vec<Spring>,
}

impl Springs {
    fn new(model: &Model, state: &State) -> Self {
        let all = &model.springs;
        let spring = |spring: usize| {
            let ends = all.ends[spring].map(|end| end as usize);
            let [from, to] = ends.map(|end| state.positions.get(end).as_dvec3());
            let length = (to - from).length();
            let way = if all.kind[spring].is_type1() { (to - from).normalize_or_zero() } else { DVec3::ZERO };
            let curves = if model.curved.links.is_empty() { &[] } else { model.curved.links.of(ends[0]) };
            let curve = curves.iter().find(|link| link.other as usize == ends[1]);
            let by_law = match curve {
                Some(link) => f64::from(model.curved.pull(link, length as f32)),
                None => f64::from(all.force_stiffness[spring]) * (length - f64::from(all.rest[spring])),
            };
            Spring { ends, way, by_law }
        };
        Self { list: (0..all.len()).map(spring).collect() }
    }

    /// What tensions accelerate: `field = W J' tensions`.
    fn accelerate(&self, tensions: &[f64], weights: &[f64], field: &mut [DVec3]) {
        field.fill(DVec3::ZERO);
        for (Spring { ends: [from, to], way, .. }, tension) in self.list.iter().zip(tensions) {
            let pull = *way * *tension;
            field[*from] += pull;
            field[*to] -= pull;
        }
        for (acceleration, weight) in field.iter_mut().zip(weights) {
            *acceleration *= *weight;
        }
    }

    /// How fast springs shorten under a field: `J field`.
    fn along(&self, field: &[DVec3], speeds: &mut [f64]) {
        for (Spring { ends: [from, to], way, .. }, speed) in self.list.iter().zip(speeds) {
            *speed = (field[*from] - field[*to]).dot(*way);
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
