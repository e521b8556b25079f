//! Tethers to the pins.
//!
//! T.-Y. Kim, N. Chentanez, M. Müller-Fischer, *Long range attachments - a method to simulate inextensible clothing in
//! computer games*, SCA 2012. However far a particle is from where the cloth is held, its distance from there cannot be
//! more than the way along the cloth: |P_v - P_pin| <= (1 + lambda) G, with G the geodesic distance at rest. A pin does
//! not give way, so v is simply put back on the sphere, and no load has to creep through the springs in between.
//!
//! Held particles that are neighbours are one place; a particle is tethered to the nearest particle of each of the
//! nearest places. With one tether the projection is exact; several are projected in turn, the nearest last,
//! `iterations` times. Springs stay springs, and nothing limits one between two particles that are both within reach of
//! the pins: the method keeps the cloth from sagging, not every spring from stretching.

use super::StrainLimit;
use crate::filter::Limited;
use crate::geometry::{Pool, Vectors};
use crate::model::{Adjacency, ClothRange, Model, Search, Surface};
use crate::schedule::Stride;
use crate::state::State;

/// Places that a particle is tethered to at most.
const MOST_PLACES: usize = 4;

/// A particle's tether.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Tether {
    pin: u32,
    /// (1 + lambda) G [m].
    limit: f32,
}

/// The tethers of each particle, the shortest last.
pub(in super::super) struct Tethers {
    tethers: Adjacency<Tether>,
}

impl Tethers {
    pub(in super::super) fn new(model: &Model) -> Self {
        let all: Vec<(u32, Tether)> = model.cloths.iter().flat_map(|cloth| of_cloth(model, cloth)).collect();
        Self { tethers: Adjacency::new(model.particle_count(), all.iter().copied()) }
    }
}

impl StrainLimit for Tethers {
    fn apply(&mut self, stride: Stride<'_>, state: &mut State, ends: &mut Vectors, _: &Pool) -> Limited {
        let (model, step) = (stride.model, stride.plan.length as f32);
        let mut limited = Limited::default();
        for particle in 0..ends.len() {
            let tethers = self.tethers.of(particle);
            let before = ends.get(particle);
            let (mut end, mut passes, mut over) = (before, 0, true);
            while over && passes < model.solver.iterations() {
                over = false;
                for &Tether { pin, limit } in tethers {
                    let from = ends.get(pin as usize);
                    let way = end - from;
                    let square = way.length_squared();
                    if square > limit * limit {
                        end = from + way * (limit / square.sqrt());
                        over = true;
                    }
                }
                passes += 1;
            }
            if end != before {
                ends.set(particle, end);
                state.velocities.set(particle, state.velocities.get(particle) + (end - before) / step);
                limited.springs += 1;
            }
            limited.sweeps = limited.sweeps.max(passes);
        }
        limited
    }
}

/// The tethers of a cloth's free particles.
fn of_cloth(model: &Model, cloth: &ClothRange) -> Vec<(u32, Tether)> {
    let Some(&strain_limit) = model.springs.strain_limit[cloth.springs.clone()].first() else { return Vec::new() };
    let surface = Surface::new(cloth, &model.particles.rest, &model.springs, &model.triangles);
    let held: Vec<bool> = cloth.particles().map(|particle| model.particles.inverse_mass[particle] == 0.0).collect();
    let mut search = Search::new(cloth.count);
    let mut nearest: Vec<Vec<(f32, u32)>> = vec![Vec::new(); cloth.count];
    for place in places(&surface, &held) {
        let ways = nearest_of(&place, &surface, &mut search, cloth.count);
        for (list, way) in nearest.iter_mut().zip(ways).filter(|(_, way)| way.0.is_finite()) {
            list.push(way);
        }
    }
    let mut tethers = Vec::new();
    for (particle, list) in (0_u32..).zip(&mut nearest).filter(|(particle, _)| !held[*particle as usize]) {
        list.sort_by(|a, b| a.0.total_cmp(&b.0));
        list.truncate(MOST_PLACES);
        let first = cloth.first as u32;
        let tether =
            |&(way, pin): &(f32, u32)| (first + particle, Tether { pin: first + pin, limit: way * (1.0 + strain_limit) });
        tethers.extend(list.iter().rev().map(tether));
    }
    tethers
}

/// Held particles, those that are neighbours together.
fn places(surface: &Surface, held: &[bool]) -> Vec<Vec<u32>> {
    let mut seen = vec![false; held.len()];
    let mut places = Vec::new();
    for start in (0..held.len()).filter(|&particle| held[particle]) {
        let mut place = Vec::new();
        let mut next = vec![start as u32];
        while let Some(particle) = next.pop() {
            if !std::mem::replace(&mut seen[particle as usize], true) {
                place.push(particle);
                next.extend(surface.links(particle).iter().map(|link| link.0).filter(|&other| held[other as usize]));
            }
        }
        if !place.is_empty() {
            place.sort_unstable();
            places.push(place);
        }
    }
    places
}

/// For each particle its distance along the cloth from the nearest particle of a place [m], and which that is.
fn nearest_of(place: &[u32], surface: &Surface, search: &mut Search, count: usize) -> Vec<(f32, u32)> {
    let mut nearest = vec![(f32::INFINITY, 0); count];
    // A way across a triangle needs both corners of its base: fronts run on into each other by an edge.
    let links = (0..count as u32).flat_map(|particle| surface.links(particle));
    let margin = links.fold(0.0_f32, |longest, link| longest.max(link.1));
    // Sources far apart first: each later one has to look only at what none of the earlier ones is nearer to.
    let mut gap = place.len().next_power_of_two();
    let mut first = 0;
    while gap > 0 {
        for &source in place.iter().skip(first).step_by(if first == 0 { place.len() } else { 2 * gap }) {
            search.run_while(surface, source, f32::INFINITY, usize::MAX, |particle, way| {
                way < nearest[particle as usize].0 + margin
            });
            for &particle in &search.reached {
                let way = search.distance(particle);
                if way < nearest[particle as usize].0 {
                    nearest[particle as usize] = (way, source);
                }
            }
        }
        gap /= 2;
        first = gap;
    }
    nearest
}
