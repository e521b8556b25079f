//! What is held, where it is asked to go further apart than the cloth between it reaches.
//!
//! No step within the limit takes pins there. What the certificate would leave of such a step is next to nothing: not of the way of these
//! pins alone, but of the whole cloth. So first of all what is held goes to the places nearest to those it is asked for, in the sum of
//! squares, that are no further apart than springs reach from one to the other. What is to go far gives way more than what is to go a
//! little, and what is to stay stays. The cloth follows as it always does.
//!
//! The cloth reaches from each particle that is held to those next to it, over the particles that are nearer to these two than to any other.
//! From a few of them, far from each other, it is known how far it reaches to all. What is within these reaches may still ask for too much,
//! as three pins around one point may, or cloth that goes round a body: then it is for the certificate.
//!
//! Where so many pairs are to be kept that a direct solution takes too long, all go with the mean, and such a part of the way from there that
//! none is too far apart.

use glam::{DVec3, Vec3};

use super::certificate::largest;
use super::interior::{Interior, Link, Task};
use crate::geometry::{Pool, Vectors};
use crate::model::{Adjacency, ClothRange, Model, Reach};
use crate::schedule::Stride;
use crate::state::{State, measure};

/// What is held stays so much nearer than the cloth reaches [1]: places are rounded.
const ROUNDING: f64 = 1e-5;
/// What is found is exact to such a part of reaches, and of the squares of what is changed [1].
const EXACT: f64 = 1e-6;
const NEARLY: f64 = 1e-8;
/// What is to stay gives way by this part of what gives way that is to go furthest [1].
const STAYS: f64 = 1e-6;
/// From so many of them it is known how far the cloth reaches to all.
const FAR: usize = 32;
/// So many pairs are solved directly at most.
const DIRECTLY: usize = 800;
/// So often the worst of what these find is taken along.
const ROUNDS: usize = 6;
/// Ways that differ by no more than this part of coordinates are alike [1]: places are rounded one by one.
const ALIKE: f32 = 1e-6;

/// What is held of a cloth.
pub(super) struct Apart {
    cloth: ClothRange,
    held: Vec<usize>,
    /// Where several springs lead from one of those to another, they reach so much less far than their limits [1]: cycles pull them to that.
    slack: f64,
    /// How far these may be from each other: known once their ways differ.
    reaches: Option<Reaches>,
}

/// How far particles that are held may be from each other.
struct Reaches {
    /// Between neighbours, by their numbers among what is held: what the cloth reaches [m], and whether that is a single spring.
    near: Vec<([u32; 2], f64, bool)>,
    /// From some of them to all of them [m].
    far: Vec<(u32, Vec<f64>)>,
    /// Those that are to be kept in a step, and those that the last one kept with what solves that; none if there is no direct solution.
    links: Vec<Link>,
    solved: Vec<Link>,
    interior: Option<Interior>,
    /// How much each of them gives way, beside the one that does most [1].
    weights: Vec<f64>,
    movable: Vec<usize>,
    /// X and displacements [m].
    start: Vec<DVec3>,
    proposed: Vec<DVec3>,
    found: Vec<DVec3>,
    tried: Vec<DVec3>,
}

impl Apart {
    /// Of a cloth whose springs are pulled to so much below their limits [1]; none if less than two of its particles are held.
    pub fn new(model: &Model, cloth: &ClothRange, slack: f32) -> Option<Self> {
        let held: Vec<usize> = model.particles.held(cloth.particles()).collect();
        (held.len() > 1).then(|| Self { cloth: cloth.clone(), held, slack: slack.into(), reaches: None })
    }

    /// Keeps what is held together, if it has to, and gives it the velocities with which it goes there. Returns whether it had to. Cloth
    /// that is nowhere over its limit as it is proposed is pulled by no cycles, and needs no slack.
    pub fn keep(&mut self, Stride { model, plan, .. }: Stride<'_>, state: &mut State, ends: &mut Vectors, pool: &Pool) -> bool {
        let Self { cloth, held, slack, reaches } = self;
        if way_of_held(held, &state.positions, ends).is_some() {
            return false;
        }
        let reaches = reaches.get_or_insert_with(|| Reaches::new(model, cloth, held));
        let is_slack = || measure(model, cloth, ends, pool).worst <= 1.0;
        if !reaches.find(held, *slack, &state.positions, ends) || is_slack() && !reaches.find(held, 0.0, &state.positions, ends) {
            return false;
        }
        for (&particle, way) in held.iter().zip(&reaches.found) {
            ends.set(particle, state.positions.get(particle) + way.as_vec3());
            state.velocities.set(particle, (way / plan.length).as_vec3());
        }
        true
    }
}

/// How far all of them go [m], if they go alike; there must be some.
pub(super) fn way_of_held(held: &[usize], positions: &Vectors, ends: &Vectors) -> Option<Vec3> {
    let way = |particle: usize| ends.get(particle) - positions.get(particle);
    let first = way(held[0]);
    let alike = held.iter().all(|&particle| {
        let extent = positions.get(particle).abs().max_element() + first.abs().max_element();
        (way(particle) - first).abs().max_element() <= ALIKE * extent
    });
    alike.then_some(first)
}

impl Reaches {
    fn new(model: &Model, cloth: &ClothRange, held: &[usize]) -> Self {
        let springs = &model.springs;
        let first = cloth.first as u32;
        let local = |spring: usize| springs.ends[spring].map(|end| end - first);
        let all = cloth.springs.clone().map(|spring| (local(spring), springs.greatest_length(spring)));
        let is_held = |end: u32| model.particles.inverse_mass[cloth.first + end as usize] == 0.0;
        let both = springs.ways(cloth.springs.clone()).map(|(a, (b, length))| (a - first, (b - first, length)));
        let of_held = both.clone().filter(|(a, (b, _))| is_held(*a) && is_held(*b));
        let [graph, of_held] = [Adjacency::new(cloth.count, both), Adjacency::new(cloth.count, of_held)];
        let sources: Vec<u32> = held.iter().map(|particle| (particle - cloth.first) as u32).collect();
        let reach = Reach::new(&graph, cloth.count, &sources);
        let mut near: Vec<([u32; 2], f64, bool)> = all
            .filter_map(|(ends, length)| {
                let [a, b] = ends.map(|end| reach.from[end as usize]);
                let ways = ends.map(|end| reach.lengths[end as usize]);
                let whole = ways[0] + f64::from(length) + ways[1];
                (a != b && whole.is_finite()).then_some(([a.min(b), a.max(b)], whole, ways == [0.0; 2]))
            })
            .collect();
        near.sort_by(|one, other| one.0.cmp(&other.0).then(one.1.total_cmp(&other.1)));
        near.dedup_by_key(|(pair, ..)| *pair);
        Self {
            near,
            far: far(&graph, &of_held, cloth.count, &sources),
            links: Vec::new(),
            solved: Vec::new(),
            interior: None,
            weights: vec![1.0; held.len()],
            movable: (0..held.len()).collect(),
            start: vec![DVec3::ZERO; held.len()],
            proposed: vec![DVec3::ZERO; held.len()],
            found: vec![DVec3::ZERO; held.len()],
            tried: vec![DVec3::ZERO; held.len()],
        }
    }

    /// Finds where what is held goes. Returns whether that is elsewhere than where it is asked to go.
    fn find(&mut self, held: &[usize], slack: f64, positions: &Vectors, ends: &Vectors) -> bool {
        for ((start, proposed), &particle) in self.start.iter_mut().zip(&mut self.proposed).zip(held) {
            *start = positions.get(particle).as_dvec3();
            *proposed = ends.get(particle).as_dvec3() - *start;
        }
        self.found.copy_from_slice(&self.proposed);
        let most = self.proposed.iter().map(|way| way.length()).fold(f64::MIN_POSITIVE, f64::max);
        self.weights.iter_mut().zip(&self.proposed).for_each(|(weight, way)| *weight = (way.length() / most).max(STAYS));
        let mut links = std::mem::take(&mut self.links);
        links.clear();
        let slack_of = |is_single: bool| if is_single { 0.0 } else { slack };
        links.extend(self.near.iter().map(|&(ends, length, is_single)| self.link(ends, length, slack_of(is_single))));
        let mut is_over = links.iter().any(|link| link.way(&self.found).length() > link.aim);
        let (mut is_changed, mut is_solved) = (false, true);
        for _ in 0..ROUNDS {
            if !is_over {
                let before = links.len();
                links.extend(self.far.iter().filter_map(|from| self.worst(from, slack)));
                is_over = links.len() > before;
            }
            is_solved = !is_over || self.solve(&links);
            if !is_over || !is_solved {
                break;
            }
            self.found.copy_from_slice(&self.tried);
            (is_changed, is_over) = (true, false);
        }
        if !is_solved {
            self.go_in_part(&links, slack);
        }
        self.links = links;
        is_changed || !is_solved
    }

    /// Goes with the mean, and as far from there as no pair is too far apart.
    fn go_in_part(&mut self, links: &[Link], slack: f64) {
        let far = self.far.iter().flat_map(|from| self.links_from(from, slack)).map(|(_, link)| link);
        let part_of = |link: Link| largest(link.start, link.way(&self.proposed) - link.start, link.aim);
        let part = links.iter().copied().chain(far).map(part_of).fold(1.0, f64::min);
        let mean = self.mean();
        self.found.iter_mut().zip(&self.proposed).for_each(|(found, way)| *found = mean + (*way - mean) * part);
    }

    /// How all of them are asked to go on the mean, what stays counting most [m].
    fn mean(&self) -> DVec3 {
        let all: f64 = self.weights.iter().map(|weight| 1.0 / weight).sum();
        self.proposed.iter().zip(&self.weights).map(|(way, weight)| *way / *weight).sum::<DVec3>() / all
    }

    /// What keeps two of them together, so much closer than the cloth reaches [1].
    fn link(&self, ends: [u32; 2], length: f64, slack: f64) -> Link {
        let [u, v] = ends.map(|end| self.start[end as usize]);
        // What is as far apart already may stay so.
        let (apart, most) = (u.distance(v), length * (1.0 - ROUNDING));
        let aim = if apart > length { apart } else { apart.clamp(most.min(length * (1.0 - slack)), most) };
        Link { ends, start: v - u, aim }
    }

    /// What keeps the others within reach of one of them, and how far that is [m].
    fn links_from<'a>(&'a self, (from, lengths): &'a (u32, Vec<f64>), slack: f64) -> impl Iterator<Item = (f64, Link)> + 'a {
        let others = (0..).zip(lengths).filter(move |(to, length)| to != from && length.is_finite());
        others.map(move |(to, &length)| (length, self.link([*from, to], length, slack)))
    }

    /// What is furthest beyond reach of one of them, if anything is.
    fn worst(&self, from: &(u32, Vec<f64>), slack: f64) -> Option<Link> {
        let over = self.links_from(from, slack).filter_map(|(length, link)| {
            let over = link.way(&self.found).length() - link.aim;
            (over > EXACT * length).then_some((over, link))
        });
        over.reduce(|worst, other| if other.0 > worst.0 { other } else { worst }).map(|(_, link)| link)
    }

    /// Tries the places nearest to the proposed ones that links allow. Returns whether these were found.
    fn solve(&mut self, links: &[Link]) -> bool {
        if links.len() > DIRECTLY {
            return false;
        }
        let mean = self.mean();
        let Self { solved, interior, weights, movable, proposed, tried, .. } = self;
        if interior.is_none() || !solved.iter().map(|link| link.ends).eq(links.iter().map(|link| link.ends)) {
            *interior = Interior::new(links.iter().map(|link| link.ends), weights, movable);
            solved.clear();
            solved.extend_from_slice(links);
        }
        let Some(interior) = interior else { return false };
        tried.fill(mean);
        let spread = links.iter().map(|link| (link.way(proposed) - link.start).length_squared() / (link.aim * link.aim));
        let task = Task {
            spread: (spread.sum::<f64>() / links.len() as f64).sqrt(),
            energy: proposed.iter().zip(&*weights).map(|(way, weight)| (*way - mean).length_squared() / weight).sum(),
            links,
            weights,
            proposed,
            exact: EXACT,
            nearly: NEARLY,
        };
        interior.run(task, tried)
    }
}

/// How far the cloth reaches from some of what is held, over what is not: each as far as can be from those before it.
fn far(graph: &Adjacency<(u32, f32)>, of_held: &Adjacency<(u32, f32)>, particles: usize, held: &[u32]) -> Vec<(u32, Vec<f64>)> {
    let (mut nearest, mut next) = (vec![f64::INFINITY; held.len()], 0_usize);
    (0..FAR.min(held.len()))
        .map(|_| {
            let from = next;
            let [lengths, along] = [graph, of_held].map(|graph| Reach::new(graph, particles, &[held[from]]).lengths);
            let lengths: Vec<[f64; 2]> = held.iter().map(|&other| [&lengths, &along].map(|of| of[other as usize])).collect();
            nearest.iter_mut().zip(&lengths).for_each(|(nearest, [length, _])| *nearest = nearest.min(*length));
            next = (0..held.len()).fold(0, |best, other| if nearest[other] > nearest[best] { other } else { best });
            // Where springs between neighbours that are held are the shortest way, these say it all.
            let beyond = lengths.iter().map(|[length, along]| if along <= length { f64::INFINITY } else { *length });
            (from as u32, beyond.collect())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde_json::json;

    use super::*;
    use crate::scene::Scene;

    const LIMIT: f64 = 0.05;
    const SLACK: f64 = 0.01;

    /// A chain of five links of 0.1 m, some of its points held.
    fn chain(held: &[u32]) -> Model {
        let points: Vec<[f64; 3]> = (0..6).map(|point| [0.1 * f64::from(point), 0.0, 0.0]).collect();
        let links: Vec<[u32; 2]> = (0..5).map(|link| [link, link + 1]).collect();
        let net = json!({ "points": points, "links": links, "mass": 0.01 });
        let cloth = json!({ "network": net, "strain_limit": LIMIT, "pins": [{ "vertices": held }] });
        let scene = Scene::from_json(&json!({ "cloth": [cloth] }).to_string()).expect("a valid scene");
        Model::build(&scene, &BTreeMap::new()).expect("a model")
    }

    /// Where what is held goes that is asked to go such ways, in the order of places; and whether that is elsewhere.
    fn found(model: &Model, ways: &[Vec3]) -> (Vec<Vec3>, bool) {
        let cloth = &model.cloths[0];
        let mut held: Vec<usize> = cloth.particles().filter(|&particle| model.particles.inverse_mass[particle] == 0.0).collect();
        held.sort_by(|a, b| model.particles.rest.x[*a].total_cmp(&model.particles.rest.x[*b]));
        let mut ends = model.particles.rest.clone();
        held.iter().zip(ways).for_each(|(&particle, way)| ends.set(particle, ends.get(particle) + *way));
        let mut reaches = Reaches::new(model, cloth, &held);
        let is_changed = reaches.find(&held, SLACK, &model.particles.rest, &ends);
        (reaches.found.iter().map(|way| way.as_vec3()).collect(), is_changed)
    }

    #[test]
    fn what_is_within_reach_goes_where_it_is_asked_to() {
        let ways = [Vec3::new(-0.01, 0.2, 0.0), Vec3::new(0.003, 0.2, 0.05)];
        let (found, is_changed) = found(&chain(&[0, 5]), &ways);
        assert!(!is_changed && found.iter().zip(ways).all(|(found, way)| found.abs_diff_eq(way, 1e-6)), "{found:?}");
    }

    #[test]
    fn ends_that_are_pulled_apart_go_as_far_as_the_chain_reaches_and_no_further() {
        // Both are 0.3 m too far apart, and go 1 m along.
        let along = Vec3::Y;
        let (ways, is_changed) = found(&chain(&[0, 5]), &[along - 0.2 * Vec3::X, along + 0.2 * Vec3::X]);
        assert!(is_changed);
        let each = (0.5 * (1.0 + LIMIT) * (1.0 - SLACK) - 0.5) as f32 / 2.0;
        assert!(ways[0].abs_diff_eq(along - each * Vec3::X, 1e-5), "{ways:?}");
        assert!(ways[1].abs_diff_eq(along + each * Vec3::X, 1e-5), "{ways:?}");
    }

    #[test]
    fn what_is_to_stay_stays() {
        let (ways, is_changed) = found(&chain(&[0, 5]), &[Vec3::ZERO, Vec3::X]);
        assert!(is_changed && ways[0].length() < 1e-5, "{ways:?}");
        assert!(ways[1].abs_diff_eq((0.5 * (1.0 + LIMIT) * (1.0 - SLACK) - 0.5) as f32 * Vec3::X, 1e-5), "{ways:?}");
    }

    #[test]
    fn neighbours_that_are_held_use_their_spring_up() {
        let (ways, is_changed) = found(&chain(&[0, 1, 2]), &[-0.05 * Vec3::X, Vec3::ZERO, 0.05 * Vec3::X]);
        assert!(is_changed);
        let each = 0.1 * LIMIT as f32;
        assert!(ways[0].abs_diff_eq(-each * Vec3::X, 1e-5) && ways[2].abs_diff_eq(each * Vec3::X, 1e-5), "{ways:?}");
        assert!(ways[1].length() < 1e-5, "{ways:?}");
    }
}
