//! From a level to the next coarser one.
//!
//! Some particles are chosen so that none is near another and none is far from all. Coarse springs join those around
//! each other: many directions, so that a sheet that hangs between two of them cannot get much longer than they allow.

use std::collections::VecDeque;

use super::interpolation::weights;
use super::{Bond, HierarchyLevel, Parents};
use crate::model::surface::{Search, Surface};

/// A chosen particle stands for those nearer than this, in mean distances of neighbours.
const REACH: f32 = 1.5;
/// .. and in a held row for free ones and for held ones nearer than these. What is beside a held particle cannot go far. Levels that
/// miss that particle would move it each time to where the finer ones cannot follow.
const REACH_OF_HELD_ROWS: [f32; 2] = [1.25, 0.5];
/// A particle whose nearest neighbour is farther than so many times the median of the level stands for itself alone: the finest places are
/// thinned out first. Else a mesh that is fine in places has no particles left where it is coarse before it is coarse everywhere.
pub(super) const EVEN: f32 = 2.5;
/// Coarse springs are at most so many times longer than a chosen particle reaches.
const LONGEST: f32 = 2.6;
/// Coarse springs that begin at a particle, the shortest first.
const MOST_SPRINGS: usize = 18;
/// A spring is left out if two others in a row are not longer than it by more than this part.
const DETOUR: f32 = 0.005;
/// Neighbours of which the mean distance is taken.
const NEIGHBOURS: usize = 6;
/// A search visits at most this many particles of its level; on a flat cloth it meets about 100.
const MOST_REACHED: usize = 400;

/// Places in a level with their distances.
type Near = Vec<(u32, f32)>;

const NONE: u32 = u32::MAX;

/// What the choice of particles depends on.
pub(super) struct Choosing<'a> {
    pub surface: &'a Surface,
    /// Which particles are held.
    pub held: &'a [bool],
    /// Those of higher rank are chosen first: what is held, corners, borders.
    pub rank: &'a [u8],
}

impl Choosing<'_> {
    /// Whether the particle at a place of a level is held.
    fn is_held(&self, level: &HierarchyLevel, place: usize) -> bool {
        self.held[level.nodes[place] as usize]
    }
}

/// The next level, thinned out where it is fine: see [`EVEN`]. Its springs are few or none where there is nothing left to join.
pub(super) fn coarser(fine: &HierarchyLevel, cloth: &Choosing<'_>, even: f32, search: &mut Search) -> HierarchyLevel {
    let choice = Choice::new(fine, cloth, even, search);
    let mut coarse_of = vec![NONE; fine.nodes.len()];
    for (coarse, &place) in (0..).zip(&choice.chosen) {
        coarse_of[place as usize] = coarse;
    }
    let (around, near) = choice.neighbours(&coarse_of);
    let between = |a: u32, b: u32| around[a as usize].iter().find(|entry| entry.0 == b).map(|entry| entry.1);
    let follow = |(place, (&own, near)): (usize, (&u32, &Near))| match own {
        NONE if cloth.is_held(fine, place) => Parents::default(),
        NONE => Parents::new(&weights(near, between)),
        _ => Parents::new(&[(own, 1.0)]),
    };
    let parents: Vec<Parents> = coarse_of.iter().zip(&near).enumerate().map(follow).collect();
    let nodes: Vec<u32> = choice.chosen.iter().map(|&place| fine.nodes[place as usize]).collect();
    let held = |coarse: u32| cloth.held[nodes[coarse as usize] as usize];
    let mut masses = vec![0.0; nodes.len()];
    for (&mass, list) in fine.masses.iter().zip(&parents) {
        for (coarse, part) in list.iter() {
            masses[coarse as usize] += if held(coarse) { 0.0 } else { f64::from(part) * mass };
        }
    }
    HierarchyLevel { springs: springs(&around, between, held), parents, masses, nodes, rates: Vec::new() }
}

/// The particles chosen from a level.
struct Choice {
    /// Places in the finer level, in rising order.
    chosen: Vec<u32>,
    /// For each of them the places around it, the nearest first.
    reached: Vec<Near>,
}

impl Choice {
    fn new(fine: &HierarchyLevel, cloth: &Choosing<'_>, even: f32, search: &mut Search) -> Self {
        let mut place = vec![NONE; cloth.held.len()];
        for (index, &node) in fine.nodes.iter().enumerate() {
            place[node as usize] = index as u32;
        }
        let most = MOST_REACHED * cloth.held.len() / fine.nodes.len();
        let spacing = spacing(fine);
        let is_thinned = thinned(fine, even);
        let mut covered = vec![false; fine.nodes.len()];
        let mut choice = Self { chosen: Vec::new(), reached: Vec::new() };
        let mut front = VecDeque::new();
        let held = |place: u32| cloth.is_held(fine, place as usize);
        let mut consider = |index: u32, front: &mut VecDeque<u32>| {
            if covered[index as usize] {
                return;
            }
            // Of itself, too, where it reaches nothing: among held particles, which no spring of the level joins.
            covered[index as usize] = true;
            let farthest = LONGEST * REACH * spacing[index as usize];
            search.run(cloth.surface, fine.nodes[index as usize], farthest, most);
            let on_level = search.reached.iter().filter(|&&node| place[node as usize] != NONE);
            let mut list: Near = on_level.map(|&node| (place[node as usize], search.distance(node))).collect();
            list.sort_by(by_distance);
            let in_row = held(index)
                && cloth.surface.links(fine.nodes[index as usize]).iter().any(|&(other, _)| cloth.held[other as usize]);
            for &(other, distance) in &list {
                let stands_for = if in_row { REACH_OF_HELD_ROWS[usize::from(held(other))] } else { REACH };
                if distance < stands_for * spacing[index as usize] && is_thinned[index as usize] {
                    covered[other as usize] = true;
                } else if other != index {
                    front.push_back(other);
                }
            }
            choice.chosen.push(index);
            choice.reached.push(list);
        };
        let highest = cloth.rank.iter().copied().max().unwrap_or(0);
        let all = 0..fine.nodes.len() as u32;
        for rank in (1..=highest).rev() {
            let ranked = all.clone().filter(|&index| cloth.rank[fine.nodes[index as usize] as usize] == rank);
            ranked.for_each(|index| consider(index, &mut front));
        }
        // The others as a front that spreads from those, so that they stand close.
        for start in all {
            front.push_back(start);
            while let Some(index) = front.pop_front() {
                consider(index, &mut front);
            }
        }
        let mut pairs: Vec<(u32, Near)> = choice.chosen.into_iter().zip(choice.reached).collect();
        pairs.sort_by_key(|pair| pair.0);
        let (chosen, reached) = pairs.into_iter().unzip();
        Self { chosen, reached }
    }

    /// The chosen ones around each chosen one, and around each particle of the finer level; the nearest first.
    fn neighbours(&self, coarse_of: &[u32]) -> (Vec<Near>, Vec<Near>) {
        let mut around = vec![Near::new(); self.chosen.len()];
        let mut near = vec![Near::new(); coarse_of.len()];
        for (coarse, list) in (0_u32..).zip(&self.reached) {
            for &(place, distance) in list {
                near[place as usize].push((coarse, distance));
                let other = coarse_of[place as usize];
                if other != NONE && other != coarse {
                    around[coarse as usize].push((other, distance));
                    around[other as usize].push((coarse, distance));
                }
            }
        }
        for list in &mut around {
            list.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
            list.dedup_by_key(|entry| entry.0);
        }
        around.iter_mut().chain(&mut near).for_each(|list| list.sort_by(by_distance));
        (around, near)
    }
}

fn by_distance(a: &(u32, f32), b: &(u32, f32)) -> std::cmp::Ordering {
    a.1.total_cmp(&b.1).then(a.0.cmp(&b.0))
}

/// The mean distance of each particle's nearest neighbours [m].
fn spacing(level: &HierarchyLevel) -> Vec<f32> {
    let mut lengths: Vec<Vec<f32>> = vec![Vec::new(); level.nodes.len()];
    for &(ends, length) in &level.springs {
        ends.iter().for_each(|&end| lengths[end as usize].push(length));
    }
    let mean = |list: &mut Vec<f32>| {
        list.sort_by(f32::total_cmp);
        list.truncate(NEIGHBOURS);
        list.iter().sum::<f32>() / list.len().max(1) as f32
    };
    lengths.iter_mut().map(mean).collect()
}

/// Which particles of a level may stand for others: those whose nearest neighbour is at most `even` times as far as the median.
fn thinned(level: &HierarchyLevel, even: f32) -> Vec<bool> {
    let mut nearest = vec![f32::INFINITY; level.nodes.len()];
    for &(ends, length) in &level.springs {
        ends.iter().for_each(|&end| nearest[end as usize] = nearest[end as usize].min(length));
    }
    let mut sorted = nearest.clone();
    sorted.sort_by(f32::total_cmp);
    let most = even * sorted[sorted.len() / 2];
    nearest.iter().map(|&nearest| nearest <= most).collect()
}

/// Joins each chosen particle to those around it, except where a way over another is as short.
fn springs(around: &[Near], between: impl Fn(u32, u32) -> Option<f32>, held: impl Fn(u32) -> bool) -> Vec<Bond> {
    let mut springs = Vec::new();
    for (a, list) in (0_u32..).zip(around) {
        let mut kept = Near::new();
        for &(b, distance) in list {
            let is_detour = |&(c, to): &(u32, f32)| between(c, b).is_some_and(|from| to + from <= (1.0 + DETOUR) * distance);
            if kept.len() < MOST_SPRINGS && !kept.iter().any(is_detour) {
                kept.push((b, distance));
            }
        }
        springs.extend(kept.into_iter().map(|(b, distance)| ([a.min(b), a.max(b)], distance)));
    }
    springs.retain(|&([a, b], distance)| distance > 0.0 && !(held(a) && held(b)));
    springs.sort_by_key(|spring| spring.0);
    springs.dedup_by_key(|spring| spring.0);
    springs
}
