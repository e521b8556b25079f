//! Cloths that hang on rows with something heavy, solved together with these.
//!
//! Cycles and sweeps in turn find places within all limits, but on them pushes are what is left of many small corrections. Where a weight of
//! many times the mass of its cloth hangs on a rod, they are a tenth of what they ought to be after all rounds, and friction, which rests on
//! them, with them. Here limits and rows are one problem, with friction (balance.rs), whose multipliers are the pushes.

use glam::DVec3;

use super::balance::{Balance, NONE, Task};
use super::blocks::Blocks;
use super::descent::Descent;
use super::interior::Link;
use super::unit::Unit;
use crate::contact::{Places, Rows, Support};
use crate::geometry::Vectors;
use crate::model::Model;
use crate::state::State;

/// Cloths that touch each other are solved together if they have at most so many springs: more take seconds a step.
const MOST: usize = 2000;
/// A particle of so many times the mass of half of its cloth's others is heavy: what hangs on a rod may be most of all mass, so that the
/// mean tells little.
const HEAVY: f64 = 16.0;
/// Aims are below the limit by at least so many times what rounding may add, and kept to within this part of it.
const MARGIN: f64 = 1.25;
const DOUBT: f64 = 0.1;
/// What of the energy of the proposed motion may be in doubt.
const NEARLY: f64 = 1e-6;
/// A row that bears all of the proposed motion gives way by this part of what it may lack.
const GIVES: f64 = 0.01;

/// Cloths of a model, and how those are solved that hang on rows.
pub(super) struct Joint {
    /// The unit of each particle that a spring may move; none of others.
    units: Vec<u32>,
    is_heavy: Vec<bool>,
    springs: Vec<usize>,
    /// Units that are solved together, rows of theirs, and where these are among all.
    is_in: Vec<bool>,
    all: Vec<Support>,
    supports: Vec<Support>,
    places: Vec<u32>,
    system: Option<System>,
    balance: Balance,
    /// Displacements of all particles [m].
    proposed: Vec<DVec3>,
    found: Vec<DVec3>,
}

/// What is solved as long as the same units are, and rows join the same particles.
struct System {
    is_in: Vec<bool>,
    links: Vec<Link>,
    /// The limit of each [m], and its unit.
    limits: Vec<(f64, u32)>,
    number: Vec<u32>,
    movable: Vec<u32>,
    masses: Vec<f64>,
    blocks: Blocks,
}

impl Joint {
    /// Of a model's units.
    pub fn new(model: &Model, all: &[Unit]) -> Self {
        let mut units = vec![NONE; model.particle_count()];
        for (index, unit) in (0..).zip(all) {
            let moves = |particle: &usize| model.particles.inverse_mass[*particle] > 0.0;
            for particle in unit.cloth().particles().filter(moves) {
                if unit.levels().knows(particle - unit.cloth().first) {
                    units[particle] = index;
                }
            }
        }
        let is_heavy = |unit: &Unit| {
            let mut masses = model.particles.free_masses(unit.cloth());
            masses.sort_unstable_by(f64::total_cmp);
            masses.last().is_some_and(|heaviest| *heaviest > HEAVY * masses[masses.len() / 2])
        };
        Self {
            units,
            is_heavy: all.iter().map(is_heavy).collect(),
            springs: all.iter().map(|unit| unit.cloth().springs.len()).collect(),
            is_in: vec![false; all.len()],
            all: Vec::new(),
            supports: Vec::new(),
            places: Vec::new(),
            system: None,
            balance: Balance::default(),
            proposed: vec![DVec3::ZERO; model.particle_count()],
            found: vec![DVec3::ZERO; model.particle_count()],
        }
    }

    /// Takes the rows of those that bear something heavy, and of what touches them. Returns whether there are any that are not too large.
    pub fn gather(&mut self, rows: &Rows, at: &Places) -> bool {
        let largest = |(is_heavy, springs): (&bool, &usize)| *is_heavy && *springs <= MOST;
        if !self.is_heavy.iter().zip(&self.springs).any(largest) {
            return false;
        }
        let Self { units, is_heavy, is_in, all, supports, places, .. } = self;
        rows.supports(at, all, |particle| units[particle] != NONE);
        let of = |support: &Support| {
            support.nodes.into_iter().filter(|(_, part)| *part != 0.0).map(|(node, _)| units[node as usize] as usize)
        };
        is_in.fill(false);
        for unit in all.iter().flat_map(of).filter(|&unit| is_heavy[unit]) {
            is_in[unit] = true;
        }
        // What touches one of them is one of them.
        let mut grows = true;
        while std::mem::take(&mut grows) {
            for support in all.iter() {
                if of(support).any(|unit| is_in[unit]) {
                    of(support).for_each(|unit| grows |= !std::mem::replace(&mut is_in[unit], true));
                }
            }
        }
        supports.clear();
        places.clear();
        for (place, support) in (0..).zip(all.iter()).filter(|(_, support)| of(support).any(|unit| is_in[unit])) {
            supports.push(*support);
            places.push(place);
        }
        let springs: usize = self.springs.iter().zip(is_in).filter(|(_, is_in)| **is_in).map(|(springs, _)| springs).sum();
        (1..=MOST).contains(&springs)
    }

    /// Whether a unit bears something heavy.
    pub fn is_heavy(&self, unit: usize) -> bool {
        self.is_heavy[unit]
    }

    /// Whether all units are among those.
    pub fn has_all(&self) -> bool {
        !self.is_in.contains(&false)
    }

    /// Solves those, from where the step starts and where `ends` propose it to end. Returns whether that was done; otherwise nothing has changed.
    pub fn run(
        &mut self,
        units: &mut [Unit],
        descents: &mut [Descent],
        rows: &mut Rows,
        model: &Model,
        state: &State,
        ends: &Vectors,
    ) -> bool {
        if !self.prepare(model, units) {
            return false;
        }
        let Self { is_in, all, supports, places, system, balance, proposed, found, .. } = self;
        let Some(System { links, limits, number, movable, masses, blocks, .. }) = system else { return false };
        let mut exact = f64::INFINITY;
        for (unit, descent) in units.iter().zip(&*descents).zip(&*is_in).filter(|(_, is_in)| **is_in).map(|(both, _)| both) {
            exact = exact.min(DOUBT * f64::from(descent.rounding));
            for particle in unit.cloth().particles() {
                proposed[particle] = ends.get(particle).as_dvec3() - state.positions.get(particle).as_dvec3();
                let moves = number[particle] != NONE;
                found[particle] = if moves { descent.frame.unwrap_or_default().as_dvec3() } else { proposed[particle] };
            }
        }
        for (link, &(limit, unit)) in links.iter_mut().zip(&*limits) {
            let [u, v] = link.ends.map(|end| state.positions.get(end as usize).as_dvec3());
            let most = 1.0 - MARGIN * f64::from(descents[unit as usize].rounding);
            let back_off = f64::from(units[unit as usize].levels().back_off());
            link.start = v - u;
            link.aim = u.distance(v).clamp(limit * (1.0 - back_off).min(most), limit * most);
        }
        let (mut energy, mut motion) = (0.0, 0.0);
        for (&particle, mass) in movable.iter().zip(&*masses) {
            let way = proposed[particle as usize] - found[particle as usize];
            energy += mass * way.length_squared();
            motion += mass * way.length();
        }
        if energy.is_nan() || energy <= 0.0 {
            return false;
        }
        let moved = links.iter().map(|link| (link.way(proposed) - link.start).length_squared() / (link.aim * link.aim));
        let spread = (moved.sum::<f64>() / links.len() as f64).sqrt();
        let mut task = Task {
            links,
            number,
            movable,
            masses,
            proposed,
            supports,
            give: GIVES / motion,
            energy,
            spread,
            way: motion / masses.iter().sum::<f64>(),
            exact,
            nearly: NEARLY,
        };
        let is_found = balance.run(&mut task, blocks, found).is_some();
        if is_found {
            for (unit, descent) in units.iter_mut().zip(descents).zip(&*is_in).filter(|(_, is_in)| **is_in).map(|(both, _)| both)
            {
                let first = unit.cloth().first;
                for particle in unit.cloth().particles().filter(|&particle| number[particle] != NONE) {
                    let way = found[particle].as_vec3() - unit.levels().displacement(particle - first);
                    unit.levels_mut().shift(particle - first, way);
                }
                descent.is_done = true;
            }
            for (support, &place) in supports.iter().zip(&*places) {
                all[place as usize] = *support;
            }
            rows.take_supports(all);
        }
        is_found
    }

    /// Makes the system anew, if other units are solved than before, or rows join other particles. Returns whether there is one.
    fn prepare(&mut self, model: &Model, units: &[Unit]) -> bool {
        let couples = |system: &System| {
            let blocks = |pair: [(u32, f64); 2]| {
                let columns = pair.map(|(node, _)| system.number[node as usize]);
                pair.iter().any(|(_, part)| *part == 0.0) || system.blocks.place(columns).is_some()
            };
            self.supports.iter().all(|support| pairs(support).all(blocks))
        };
        if self.system.as_ref().is_some_and(|system| system.is_in == self.is_in && couples(system)) {
            return true;
        }
        let mut number = vec![NONE; self.units.len()];
        let moves = |particle: &usize| self.units[*particle] != NONE && self.is_in[self.units[*particle] as usize];
        let movable: Vec<u32> = (0..self.units.len()).filter(moves).map(|particle| particle as u32).collect();
        (0..).zip(&movable).for_each(|(column, &particle)| number[particle as usize] = column);
        let (mut links, mut limits) = (Vec::new(), Vec::new());
        for (index, unit) in (0..).zip(units).filter(|(index, _)| self.is_in[*index as usize]) {
            for spring in unit.cloth().springs.clone() {
                let ends = model.springs.ends[spring];
                if ends.iter().any(|&end| number[end as usize] != NONE) {
                    links.push(Link { ends, start: DVec3::ZERO, aim: 0.0 });
                    limits.push((f64::from(model.springs.greatest_length(spring)), index));
                }
            }
        }
        let of_rows = self.supports.iter().flat_map(pairs).filter(|pair| pair.iter().all(|(_, part)| *part != 0.0));
        let of_rows = of_rows.map(|pair| pair.map(|(node, _)| node));
        let columns = links.iter().map(|link| link.ends).chain(of_rows).map(|pair| pair.map(|end| number[end as usize]));
        let blocks = Blocks::new(movable.len(), columns.filter(|pair| !pair.contains(&NONE)));
        let masses = movable.iter().map(|&particle| f64::from(model.particles.inverse_mass[particle as usize]).recip()).collect();
        self.system = blocks.map(|blocks| System { is_in: self.is_in.clone(), links, limits, number, movable, masses, blocks });
        self.system.is_some()
    }
}

/// The pairs of nodes of a row.
fn pairs(support: &Support) -> impl Iterator<Item = [(u32, f64); 2]> + Clone + use<> {
    let nodes = support.nodes;
    (1..4).flat_map(move |b| (0..b).map(move |a| [nodes[a], nodes[b]]))
}
