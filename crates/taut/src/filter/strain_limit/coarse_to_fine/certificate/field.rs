//! How far each particle may go: a factor t_i in [0, 1] for everyone, P_i = Y_i + t_i (P_i - Y_i).
//!
//! The pairs (t_u, t_v) that a spring bears are a convex set. It holds the diagonal up to the pair's own largest common t, since Y
//! is admissible. So a particle with a small factor asks its neighbour for at most something between its own factor and 1,
//! and particles visited by growing factors are visited once. No factor is below the one that would do for the whole cloth.

use std::ops::Range;

use glam::DVec3;

use super::super::queue::Queue;
use crate::geometry::{Vectors, power};
use crate::model::{Adjacency, ClothRange, Model, Springs};
use crate::state::measure_squares;

/// A spring over this part of R counts as over: the measure in single precision is no finer.
const OVER: f64 = 1.0 - 1e-6;
/// The margin below R: so many times what rounding leaves of the largest coordinate of an end ..
const ROUNDINGS: f64 = 4.0 * f32::EPSILON as f64;
/// .. and each further round wants so many times the margin.
const WIDER: f64 = 8.0;
/// Where a spring is over its limit it is shortened by at least this much.
const LEAST: f32 = 1e-6;
/// So many springs are looked at together.
const RUN: usize = 256;

/// A step that is to be shortened.
pub(super) struct Proposal<'a> {
    pub springs: &'a Springs,
    pub inverse_mass: &'a [f32],
    /// X and P [m].
    pub positions: &'a Vectors,
    pub ends: &'a Vectors,
    /// From X to Y [m].
    pub frame: DVec3,
    /// Whether what is held goes to its end whatever the others do.
    pub pins_first: bool,
    /// Whether everything will be shifted, and rounded, once more.
    pub shifted: bool,
    /// How often this step was shortened already.
    pub round: usize,
}

/// The factors of a cloth's particles, with the workspace to find them.
pub(super) struct Field {
    first: usize,
    /// The cloth's springs, and those of each particle.
    springs: Range<usize>,
    around: Adjacency<u32>,
    /// Of each particle; 1 but for those in `cut`.
    factors: Vec<f32>,
    cut: Vec<u32>,
    queue: Queue,
}

/// Y, D = P - Y, and the end in single precision of a particle [m].
#[derive(Clone, Copy)]
struct Way {
    y: DVec3,
    d: DVec3,
    extent: f64,
    fixed: bool,
}

impl Proposal<'_> {
    fn way(&self, particle: usize) -> Way {
        let (start, end) = (self.positions.get(particle), self.ends.get(particle));
        let extent = f64::from(start.abs().max(end.abs()).max_element());
        if self.pins_first && self.inverse_mass[particle] == 0.0 {
            return Way { y: end.as_dvec3(), d: DVec3::ZERO, extent, fixed: true };
        }
        let y = start.as_dvec3() + self.frame;
        Way { y, d: end.as_dvec3() - y, extent, fixed: false }
    }

    /// What a spring may reach [m]; one that is over its limit at Y already may not grow.
    fn reach(&self, spring: usize, [u, v]: [&Way; 2]) -> f64 {
        let limit = f64::from(self.springs.greatest_length(spring));
        (limit * OVER - self.margin([u, v])).max(u.y.distance(v.y))
    }

    fn margin(&self, ways: [&Way; 2]) -> f64 {
        ROUNDINGS * power(WIDER, self.round as u32) * ways[0].extent.max(ways[1].extent)
    }
}

impl Field {
    /// The field of a cloth.
    pub fn new(model: &Model, cloth: &ClothRange) -> Self {
        let (first, springs) = (cloth.first as u32, cloth.springs.clone());
        let all = model.springs.ends[springs.clone()].iter().zip(springs.start as u32..);
        let pairs = all.flat_map(|(ends, spring)| ends.map(|end| (end - first, spring)));
        Self {
            first: cloth.first,
            springs,
            around: Adjacency::new(cloth.count, pairs),
            factors: vec![1.0; cloth.count],
            cut: Vec::with_capacity(cloth.count),
            queue: Queue::new(cloth.count),
        }
    }

    /// Finds the factors for a step.
    pub fn find(&mut self, proposal: &Proposal<'_>, model: &Model) {
        self.clear();
        let mut squares = [0.0; RUN];
        for start in self.springs.clone().step_by(RUN) {
            let run = start..self.springs.end.min(start + RUN);
            let squares = &mut squares[..run.len()];
            measure_squares(model, run.clone(), proposal.ends, squares);
            for (spring, square) in run.zip(squares) {
                // A first look in single precision; a cloth that will be shifted wants a closer one.
                let limit = proposal.springs.greatest_length(spring);
                let near = if proposal.shifted { 0.99 } else { 1.0 - 2e-6 };
                if *square > limit * limit * near {
                    self.begin(proposal, spring);
                }
            }
        }
        while let Some(particle) = self.queue.take() {
            self.visit(proposal, particle);
        }
    }

    /// Each particle that goes less than all of its way, and what part of it.
    pub fn cut(&self) -> impl Iterator<Item = (usize, f32)> {
        self.cut.iter().map(|&particle| (self.first + particle as usize, self.factors[particle as usize]))
    }

    fn clear(&mut self) {
        for particle in self.cut.drain(..) {
            self.factors[particle as usize] = 1.0;
        }
    }

    /// Gives both ends of a spring that is over its limit their largest common factor.
    fn begin(&mut self, proposal: &Proposal<'_>, spring: usize) {
        let ends = proposal.springs.ends[spring].map(|end| end as usize);
        let [u, v] = ends.map(|end| proposal.way(end));
        let length = (v.y + v.d).distance(u.y + u.d);
        let limit = f64::from(proposal.springs.greatest_length(spring)) * OVER;
        let (over, reach) = (length > limit, proposal.reach(spring, [&u, &v]));
        let rounded_over = proposal.shifted && length > limit - 0.5 * proposal.margin([&u, &v]);
        if !(over || rounded_over) {
            return;
        }
        let factor = match largest(v.y - u.y, v.d - u.d, reach) {
            part if part < 1.0 => (part as f32).min(1.0 - LEAST),
            // It was over already, and does not grow.
            _ if over && u.y.distance(v.y) > limit => return,
            // It does not grow on its way, and is over by rounding alone: where it was, it was not.
            _ if over && proposal.round > 0 => 0.0,
            _ if over => 1.0 - LEAST,
            _ => return,
        };
        for (end, way) in ends.into_iter().zip([u, v]) {
            self.lower(end, &way, factor);
        }
    }

    /// Asks the neighbours of a particle, whose own factor is settled.
    fn visit(&mut self, proposal: &Proposal<'_>, particle: usize) {
        let factor = self.factors[particle];
        let u = proposal.way(self.first + particle);
        for index in 0..self.around.of(particle).len() {
            let spring = self.around.of(particle)[index] as usize;
            let [a, b] = proposal.springs.ends[spring].map(|end| end as usize);
            let other = if a == self.first + particle { b } else { a };
            let now = self.factors[other - self.first];
            if now <= factor {
                continue;
            }
            let v = proposal.way(other);
            let from = v.y - u.y - u.d * f64::from(factor);
            let reach = proposal.reach(spring, [&u, &v]);
            if (from + v.d * f64::from(now)).length_squared() > reach * reach {
                let part = largest(from, v.d, reach) as f32;
                self.lower(other, &v, part.min(now).max(factor));
            }
        }
    }

    fn lower(&mut self, particle: usize, way: &Way, factor: f32) {
        let place = particle - self.first;
        if way.fixed || factor >= self.factors[place] {
            return;
        }
        if self.factors[place] == 1.0 {
            self.cut.push(place as u32);
        }
        self.factors[place] = factor;
        self.queue.put(place, factor);
    }
}

/// The largest t in [0, 1] with |x + t d| <= `reach`; 0 if there is none.
pub fn largest(x: DVec3, d: DVec3, reach: f64) -> f64 {
    let (a, b, c) = (d.length_squared(), x.dot(d), x.length_squared() - reach * reach);
    let root = (b * b - a * c).max(0.0).sqrt();
    // The one of two forms that does not cancel.
    let part = if b > 0.0 { -c / (b + root) } else { (root - b) / a };
    if part.is_nan() { 0.0 } else { part.clamp(0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use glam::Vec3;
    use proptest::prelude::*;
    use serde_json::json;

    use super::*;
    use crate::scene::Scene;

    type Points = Vec<[f64; 3]>;

    /// A network of points and links, some of the points held.
    fn network(points: &Points, links: &[[u32; 2]], held: &[usize]) -> Model {
        let pins: Vec<_> = held.iter().map(|vertex| json!({ "vertices": [vertex] })).collect();
        let net = json!({ "points": points, "links": links, "mass": 0.01 });
        let scene = Scene::from_json(&json!({ "cloth": [{ "network": net, "strain_limit": 0.05, "pins": pins }] }).to_string());
        Model::build(&scene.expect("a valid scene"), &BTreeMap::new()).expect("a model")
    }

    /// A chain through random points with further links, and where its points are to go.
    fn nets() -> impl Strategy<Value = (Points, Vec<[u32; 2]>, Vec<Vec3>)> {
        let point = || prop::array::uniform3(-1.0..1.0_f64);
        let way = prop::array::uniform3(-0.5..0.5_f32).prop_map(Vec3::from_array);
        (3_usize..14).prop_flat_map(move |count| {
            let links = prop::collection::vec((0..count, 1..count), 0..2 * count).prop_map(move |pairs| {
                let further = pairs.into_iter().map(|(a, step)| [a, (a + step) % count]);
                let mut links: Vec<[u32; 2]> =
                    (1..count).map(|b| [b - 1, b]).chain(further).map(|[a, b]| [a.min(b) as u32, a.max(b) as u32]).collect();
                links.sort_unstable();
                links.dedup();
                links
            });
            (prop::collection::vec(point(), count), links, prop::collection::vec(way.clone(), count))
        })
    }

    fn factors(field: &mut Field, proposal: &Proposal<'_>, model: &Model) -> Vec<f32> {
        field.find(proposal, model);
        let mut factors = vec![1.0; proposal.positions.len()];
        field.cut().for_each(|(particle, factor)| factors[particle] = factor);
        factors
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(500))]

        #[test]
        fn the_field_is_admissible_and_nowhere_below_the_global_factor(
            (points, links, ways) in nets(),
            size in 0.3_f32..1.04,
            part in 0.0_f32..1.0,
            moved in prop::array::uniform3(-0.1_f32..0.1),
            pinned: bool,
        ) {
            let distance = |[a, b]: [u32; 2]| DVec3::from_array(points[a as usize]).distance(points[b as usize].into());
            prop_assume!(links.iter().all(|&link| distance(link) > 0.05));
            let model = network(&points, &links, if pinned { &[0] } else { &[] });
            let (mut positions, mut ends) = (model.particles.rest.clone(), model.particles.rest.clone());
            let frame = Vec3::from_array(moved);
            for (particle, way) in ways.iter().enumerate() {
                let held = model.particles.inverse_mass[particle] == 0.0;
                positions.set(particle, positions.get(particle) * size);
                ends.set(particle, positions.get(particle) + frame + if held { Vec3::ZERO } else { *way * part });
            }
            let proposal = Proposal {
                springs: &model.springs,
                inverse_mass: &model.particles.inverse_mass,
                positions: &positions,
                ends: &ends,
                frame: frame.as_dvec3(),
                pins_first: pinned,
                shifted: false,
                round: 0,
            };
            let mut field = Field::new(&model, &model.cloths[0]);
            let found = factors(&mut field, &proposal, &model);
            let mut global = 1.0_f64;
            for (spring, ends) in model.springs.ends.iter().enumerate() {
                let [u, v] = ends.map(|end| end as usize);
                let (here, there) = (proposal.way(u), proposal.way(v));
                let gap = |parts: [f64; 2]| (there.y + there.d * parts[1]).distance(here.y + here.d * parts[0]);
                let reach = proposal.reach(spring, [&here, &there]);
                prop_assert!(gap([u, v].map(|end| f64::from(found[end]))) <= reach + 1e-7, "spring {} of {:?}", spring, found);
                global = global.min(largest(there.y - here.y, there.d - here.d, reach));
            }
            let least = found.iter().fold(1.0, |least: f32, factor| least.min(*factor));
            prop_assert!(f64::from(least) >= global - 2e-6, "{least} is less than {global}");
            prop_assert!(found.iter().zip(&model.particles.inverse_mass).all(|(factor, weight)| *weight > 0.0 || *factor == 1.0));
            // Another step leaves no trace.
            factors(&mut field, &Proposal { ends: &positions, frame: -3.0 * frame.as_dvec3(), ..proposal }, &model);
            prop_assert_eq!(&factors(&mut field, &proposal, &model), &found);
            prop_assert_eq!(&factors(&mut Field::new(&model, &model.cloths[0]), &proposal, &model), &found);
        }
    }

    #[test]
    fn what_no_spring_stops_goes_all_of_its_way() {
        // The last link of a chain is pulled to twice its length; the first ones do not notice.
        let points: Points = (0..6).map(|bead| [0.1 * f64::from(bead), 0.0, 0.0]).collect();
        let links: Vec<[u32; 2]> = (0..5).map(|link| [link, link + 1]).collect();
        let model = network(&points, &links, &[0]);
        let positions = &model.particles.rest;
        let mut ends = positions.clone();
        let tip = (0..6).max_by(|a, b| positions.x[*a].total_cmp(&positions.x[*b])).expect("six points");
        ends.set(tip, positions.get(tip) + Vec3::X * 0.1);
        let proposal = Proposal {
            springs: &model.springs,
            inverse_mass: &model.particles.inverse_mass,
            positions,
            ends: &ends,
            frame: DVec3::ZERO,
            pins_first: true,
            shifted: false,
            round: 0,
        };
        let found = factors(&mut Field::new(&model, &model.cloths[0]), &proposal, &model);
        let cut: Vec<usize> = (0..6).filter(|&particle| found[particle] < 1.0).collect();
        assert_eq!(cut.len(), 2, "{found:?}");
        assert!((found[tip] - 0.05).abs() < 1e-4, "{found:?}");
    }
}
