//! The levels of a cloth, laid out in memory.

use glam::Vec3;

use super::coarsen::{Cloth, Draft, coarser};
use super::level::{Level, Spring};
use crate::filter::strain_limit::surface::{Search, Surface};
use crate::geometry::Vectors;
use crate::model::{Adjacency, ClothRange, Model};

/// A level of so few particles needs no coarser one.
const FEW: usize = 4;
/// Nor does one of which the next level would keep more than this part: it has fallen into pieces.
const SHRINKS: f64 = 0.8;

/// Levels, the finest first, and the particle at each place of the finest one.
pub(super) fn levels(model: &Model, cloth: &ClothRange, stretch: f32) -> (Vec<Level>, Vec<u32>) {
    let drafts = drafts(model, cloth);
    let orders = orders(&drafts);
    let place = |level: usize, index: u32| orders[level][index as usize];
    let mut finest = vec![0; cloth.count];
    for (index, &node) in (0..).zip(&drafts[0].nodes) {
        finest[node as usize] = place(0, index);
    }
    let weight = |node: u32| f64::from(model.particles.inverse_mass[cloth.first + node as usize]);
    let mut masses: Vec<f64> = drafts[0].nodes.iter().map(|&node| 1.0 / weight(node)).collect();
    let mut levels = Vec::new();
    for (index, draft) in drafts.iter().enumerate() {
        if index > 0 {
            masses = coarse_masses(&masses, draft, |node| weight(node) == 0.0);
        }
        let count = draft.nodes.len();
        let mut level = Level {
            p: vec![[0.0; 4]; count],
            d: Vectors::zeros(count),
            springs: springs(draft, stretch, |end| place(index, end)),
            finest: vec![0; count],
            parents: Adjacency::default(),
        };
        for (old, &node) in (0..).zip(&draft.nodes) {
            let new = place(index, old) as usize;
            level.p[new][3] = (1.0 / masses[old as usize]) as f32;
            level.finest[new] = finest[node as usize];
        }
        let followers = drafts.get(index + 1).map_or(&[][..], |coarse| &coarse.weights);
        let moving = (0_u32..).zip(followers).filter(|(old, _)| masses[*old as usize].is_finite());
        let parents = moving.flat_map(|(old, list)| {
            let new = place(index, old);
            list.iter().map(move |&(coarse, part)| (new, (place(index + 1, coarse), part)))
        });
        level.parents = Adjacency::new(count, parents);
        levels.push(level);
    }
    let mut particles = vec![0; drafts[0].nodes.len()];
    for (index, &node) in (0..).zip(&drafts[0].nodes) {
        particles[place(0, index) as usize] = cloth.first as u32 + node;
    }
    (levels, particles)
}

/// Level 0 is the cloth, without the particles that nothing is tied to.
fn drafts(model: &Model, cloth: &ClothRange) -> Vec<Draft> {
    let surface = Surface::new(model, cloth);
    let held: Vec<bool> = cloth.particles().map(|particle| model.particles.inverse_mass[particle] == 0.0).collect();
    let rank = ranks(model, cloth, &surface, &held);
    let nodes: Vec<u32> = (0..cloth.count as u32).filter(|&node| !surface.links(node).is_empty()).collect();
    let mut place = vec![0; cloth.count];
    (0..).zip(&nodes).for_each(|(index, &node)| place[node as usize] = index);
    let movable = cloth.springs.clone().filter(|&spring| {
        let [u, v] = model.springs.ends[spring].map(|end| held[end as usize - cloth.first]);
        !(u && v)
    });
    let bond =
        |spring: usize| (model.springs.ends[spring].map(|end| place[end as usize - cloth.first]), model.springs.rest[spring]);
    let springs = movable.map(bond).collect();
    let mut drafts = vec![Draft { nodes, springs, weights: Vec::new() }];
    let mut search = Search::new(cloth.count);
    let on = Cloth { surface: &surface, held: &held, rank: &rank };
    while let Some(fine) = drafts.last().filter(|level| level.nodes.len() > FEW) {
        let coarse = coarser(fine, &on, &mut search);
        if coarse.springs.is_empty() || coarse.nodes.len() as f64 > SHRINKS * fine.nodes.len() as f64 {
            break;
        }
        drafts.push(coarse);
    }
    drafts
}

/// Held particles come first, then corners, then borders: levels keep the outline of the cloth.
fn ranks(model: &Model, cloth: &ClothRange, surface: &Surface, held: &[bool]) -> Vec<u8> {
    /// How far the mean direction to the neighbours is from zero.
    const CORNER: f32 = 0.6;
    const BORDER: f32 = 0.3;
    let at = |node: u32| model.particles.rest.get(cloth.first + node as usize);
    let rank = |(node, &held): (u32, &bool)| {
        let links = surface.links(node);
        let sum: Vec3 = links.iter().map(|&(other, _)| (at(other) - at(node)).normalize_or_zero()).sum();
        let lopsided = sum.length() / links.len().max(1) as f32;
        if held {
            3
        } else if lopsided > CORNER {
            2
        } else {
            u8::from(lopsided > BORDER)
        }
    };
    (0..).zip(held).map(rank).collect()
}

/// For each level the place in memory of each of its particles: those that follow the same coarse one stand together.
fn orders(drafts: &[Draft]) -> Vec<Vec<u32>> {
    let mut orders: Vec<Vec<u32>> = Vec::new();
    for (index, draft) in drafts.iter().enumerate().rev() {
        let mut sorted: Vec<u32> = (0..draft.nodes.len() as u32).collect();
        if let (Some(above), Some(coarse)) = (orders.last(), drafts.get(index + 1)) {
            let leader = |node: u32| {
                let list = &coarse.weights[node as usize];
                list.iter()
                    .reduce(|best, next| if next.1 > best.1 { next } else { best })
                    .map_or(u32::MAX, |best| above[best.0 as usize])
            };
            sorted.sort_by_cached_key(|&node| (leader(node), node));
        }
        let mut order = vec![0; sorted.len()];
        (0..).zip(&sorted).for_each(|(new, &old)| order[old as usize] = new);
        orders.push(order);
    }
    orders.reverse();
    orders
}

/// A coarse particle has the mass that it carries when its displacement is interpolated, so that a pull conserves
/// momentum on the finest level too. Held stays held: infinite.
fn coarse_masses(fine: &[f64], coarse: &Draft, held: impl Fn(u32) -> bool) -> Vec<f64> {
    let mut masses: Vec<f64> = coarse.nodes.iter().map(|&node| if held(node) { f64::INFINITY } else { 0.0 }).collect();
    for (&mass, list) in fine.iter().zip(&coarse.weights).filter(|(mass, _)| mass.is_finite()) {
        list.iter().for_each(|&(parent, part)| masses[parent as usize] += f64::from(part) * mass);
    }
    masses
}

fn springs(draft: &Draft, stretch: f32, place: impl Fn(u32) -> u32) -> Vec<Spring> {
    let spring = |&(ends, length): &([u32; 2], f32)| {
        let [a, b] = ends.map(&place);
        let limit = stretch * length;
        Spring { ends: [a.min(b), a.max(b)], limit, now: limit }
    };
    let mut springs: Vec<Spring> = draft.springs.iter().map(spring).collect();
    springs.sort_by_key(|spring| spring.ends);
    springs
}
