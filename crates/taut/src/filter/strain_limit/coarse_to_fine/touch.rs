//! All cloths of a step together, where they touch bodies, each other or themselves.
//!
//! 1. One cycle without contact, so that the ends of the step are sensible; what comes near on the way there becomes rows.
//!    Bodies stop where they would go into what is held, and what is held where it would go into bodies.
//! 2. Cycles of each cloth and sweeps over all rows in turn, until springs are short enough and rows are kept; the last few of both are put
//!    right one by one (worklist.rs).
//!    Cloths that bear something heavy on their rows are solved with these as one problem instead (joint.rs).
//! 3. The certificate: each cloth keeps its limit, and nothing crosses anything on the way. Pairs that would cross become rows, with
//!    what is closest at the time of impact, and 2 goes on; where that does not help, the step is shortened there.

mod held;
mod shorten;

use std::ops::Range;

use glam::Vec3;

use super::brake::{Lying, left_under_load};
use super::descent::Descent;
use super::ease;
use super::gains::Gains;
use super::joint::Joint;
use super::led::Led;
use super::unit::Unit;
use super::where_is::{NONE, WhereIs};
use super::worklist::Worklist;
use crate::contact::{Carried, Contact, Obstacle};
use crate::filter::Limited;
use crate::geometry::{Pool, Vectors};
use crate::model::Model;
use crate::schedule::Stride;
use crate::state::{State, measure};

/// Cycles and sweeps in turn, at most; with rows that came late, so many more.
const ROUNDS: usize = 30;
/// .. where nothing is struck: a cloth that hangs on a corner takes them all. Where something moves, rows may contradict each other.
const ROUNDS_IF_CALM: usize = 90;
const ROUNDS_OF_REPAIR: usize = 6;
/// .. and at least, but after repairs: what lies still is pushed, and held, in every step.
const AT_LEAST: usize = 3;
/// Rows that are not kept by then share what room there is, and ask for no more than they must [rounds].
const GIVES_WAY: usize = 10;
const GIVES_IN: usize = 20;
/// Coarse levels learn so often how much room rows have, in rounds.
const RENEWED: usize = 6;
/// So often rows are made of what would cross; more often where nothing is struck: steps of other lengths would shake cloth that lies.
const REPAIRS: usize = 4;
const REPAIRS_IF_CALM: usize = 16;
/// .. and less often where bodies that can stay behind pinch it.
const REPAIRS_IF_PINCHED: usize = 2;

/// Contact, and what a step is gone through with.
pub(super) struct Touch {
    pub(super) contact: Contact,
    where_is: WhereIs,
    worklist: Worklist,
    /// The proposed ends and velocities.
    proposed: Vectors,
    velocities: Vectors,
    led: Led,
    obstacles: Vec<Vec<Obstacle>>,
    /// The momentum of the next cycle of each cloth, by its number.
    momenta: Vec<f32>,
    descents: Vec<Descent>,
    /// The rates with which velocities take corrections, what is left of kinetic energies where cloths touch something, and the
    /// particles that rows have pushed.
    rates: Vec<f32>,
    left_of_energy: Vec<f64>,
    pushed: Vec<u32>,
    is_pushed: Vec<bool>,
    /// What carries each cloth.
    carriers: Vec<Carried>,
    gains: Gains,
    stops: Vec<f64>,
    stopped: Vec<u32>,
    /// What carries each cloth along, by its number, where a step is shortened [m]; zero where nothing does.
    frames: Vec<Vec3>,
    /// The part of its motion that each cloth loses, by its number, where a step is cut [1].
    pub(super) lost: Vec<f64>,
    joint: Joint,
}

impl Touch {
    pub fn new(model: &Model, units: &[Unit], contact: Option<Contact>) -> Option<Self> {
        let contact = match contact {
            Some(contact) => contact.renewed(model),
            None => Contact::new(model)?,
        };
        let mut where_is = vec![(NONE, 0); model.particle_count()];
        for (index, unit) in (0..).zip(units) {
            let own = (0..).zip(&mut where_is[unit.cloth().particles()]);
            own.filter(|(own, _)| unit.levels().knows(*own as usize)).for_each(|(own, place)| *place = (index, own));
        }
        Some(Self {
            contact,
            where_is: WhereIs::new(where_is),
            worklist: Worklist::new(model.particle_count()),
            proposed: Vectors::default(),
            velocities: Vectors::default(),
            led: Led::new(model),
            obstacles: units.iter().map(|_| Vec::new()).collect(),
            momenta: vec![0.0; model.cloths.len()],
            descents: Vec::new(),
            rates: Vec::new(),
            left_of_energy: Vec::new(),
            pushed: Vec::new(),
            is_pushed: vec![false; model.particle_count()],
            carriers: Vec::new(),
            gains: Gains::default(),
            stops: vec![1.0; model.bodies.rest.len()],
            stopped: Vec::new(),
            frames: Vec::new(),
            lost: Vec::new(),
            joint: Joint::new(model, units),
        })
    }

    pub fn apply(
        &mut self,
        units: &mut [Unit],
        stride: Stride<'_>,
        state: &mut State,
        ends: &mut Vectors,
        corrections: &mut Vectors,
        pool: &Pool,
    ) -> Limited {
        let Stride { model, plan, .. } = stride;
        let part = model.cloths.iter().map(|cloth| plan.part_of_automatic(cloth)).fold(1.0, f64::min);
        self.led.aim(stride, part, state, &mut self.contact.places.turns);
        self.proposed.clone_from(ends);
        self.velocities.clone_from(&state.velocities);
        self.descents.clear();
        let mut limited = Limited::default();
        for unit in units.iter_mut() {
            let proposed = measure(model, unit.cloth(), ends, pool);
            limited.springs += proposed.over;
            if !proposed.worst.is_finite() {
                return limited;
            }
            let mut descent = unit.begin(proposed, state, ends, pool);
            descent.brake = left_under_load(descent.brake, stride, unit.index(), state, ends);
            descent.is_needed = proposed.worst > 1.0;
            if descent.is_needed {
                unit.descend(model, &mut descent, false, pool);
            }
            self.descents.push(descent);
        }
        self.where_is.load(&state.positions, ends); // 1
        let State { origins, positions, bodies, crept, .. } = &*state;
        self.contact.start(model, origins, positions, bodies, pool);
        self.contact.go_on(crept, part);
        limited.penetrations = self.contact.untangle(state.may_cross, stride.plan.length) as u32;
        state.may_cross = self.contact.may_cross();
        self.where_is.tell(&state.positions, units, ends, pool);
        self.contact.end(model, &state.origins, ends, &self.led.ends, pool);
        self.contact.find_rows(pool);
        if self.contact.rows.stop_bodies(&self.contact.places, &mut self.stops) {
            self.led.shorten(stride, state, &self.stops, &[]);
            self.contact.end(model, &state.origins, ends, &self.led.ends, pool);
            self.contact.rows.arrange(&self.contact.places, pool);
        }
        self.stop_held(units, stride, state);
        self.where_is.take(&self.contact.rows);
        limited.contacts = self.contact.rows.len() as u32;
        if !self.contact.rows.is_empty() {
            for (unit, descent) in units.iter().zip(&mut self.descents) {
                unit.stand(state, &self.proposed, &model.particles.inverse_mass, descent);
            }
        }
        self.find_frames(units, model, state);
        self.contact.rows.take_behind(self.led.behind(model, state));
        limited.pinched = self.contact.rows.share() as u32;
        self.grip(units);
        let mut rounds = AT_LEAST..ROUNDS_IF_CALM.min(model.solver.iterations() as usize);
        for attempt in 0.. {
            self.resolve(units, model, state, rounds.clone(), pool); // 2
            ends.clone_from(&self.proposed);
            state.velocities.clone_from(&self.velocities);
            let concluded = self.conclude(units, stride, state, ends, corrections, pool); // 3
            let Limited { cuts, lost_motion, held_back_pins, .. } = concluded;
            limited = Limited { cuts, lost_motion, held_back_pins, ..limited };
            self.contact.end(model, &state.origins, ends, &self.led.ends, pool);
            self.contact.certify(pool);
            if self.contact.cuts.list.is_empty() {
                break;
            }
            let is_pinched = limited.pinched > 0;
            let given_way = is_pinched && self.given_way(stride, state);
            let repairs = match none_is_struck(&self.left_of_energy) {
                _ if given_way || is_pinched && self.are_skins(stride, state) => REPAIRS_IF_PINCHED,
                true => REPAIRS_IF_CALM,
                false => REPAIRS,
            };
            if attempt < repairs {
                self.contact.add_rows_of_cuts(pool);
                self.contact.rows.hold_gripped();
                self.where_is.take(&self.contact.rows);
                limited.pinched = limited.pinched.max(self.contact.rows.share() as u32);
                rounds = 0..ROUNDS_OF_REPAIR;
                continue;
            }
            limited.contact_cuts = 1;
            limited.given_way = given_way;
            limited.asks_for_halves = stride.can_be_halved && !given_way;
            if limited.asks_for_halves {
                return limited;
            }
            let lost = self.shorten(units, stride, state, ends, pool);
            limited.lost_motion = limited.lost_motion.max(lost);
            break;
        }
        self.contact.tell_crept(&mut state.crept);
        units.iter().for_each(|unit| unit.forget_creep(state));
        limited.sweeps = self.descents.iter().map(|descent| descent.sweeps).sum();
        limited.closest = Some(self.contact.cuts.closest).filter(|closest| closest.is_finite());
        limited.held_back_bodies = self.led.arrive(model, part, state);
        limited
    }

    /// Finds ends that are within all limits, and that rows keep apart.
    fn resolve(&mut self, units: &mut [Unit], model: &Model, state: &State, rounds: Range<usize>, pool: &Pool) {
        // What brings intersecting things apart may contradict itself.
        let bears = self.contact.brings_apart().is_none() && self.bearers(units, pool);
        if bears && self.joint.has_all() && self.bear(units, model, state) {
            return;
        }
        self.solve(units, model, rounds, pool);
        if bears && !self.joint.has_all() && self.bearers(units, pool) {
            self.bear(units, model, state);
        }
    }

    /// Finds those that bear something heavy on their rows. Returns whether there are any.
    fn bearers(&mut self, units: &[Unit], pool: &Pool) -> bool {
        let Self { contact, where_is, joint, .. } = self;
        where_is.gather(&mut contact.rows, units, pool);
        joint.gather(&contact.rows, &contact.places)
    }

    /// Solves those. Returns whether that was done.
    fn bear(&mut self, units: &mut [Unit], model: &Model, state: &State) -> bool {
        let Self { joint, descents, contact, proposed, .. } = self;
        joint.run(units, descents, &mut contact.rows, model, state, proposed)
    }

    /// Sweeps over rows and springs in turn, until springs are short enough and rows are kept; in so many rounds at least, and at most.
    fn solve(&mut self, units: &mut [Unit], model: &Model, rounds: Range<usize>, pool: &Pool) {
        let rows = &mut self.contact.rows;
        if rows.is_empty() {
            let descents = &mut self.descents;
            for (unit, descent) in units.iter_mut().zip(descents).filter(|(_, descent)| descent.is_needed) {
                while !descent.is_over {
                    unit.descend(model, descent, false, pool);
                }
            }
            return;
        }
        rows.pack(pool);
        self.go_round(units, model, rounds, pool);
        self.contact.rows.unpack();
    }

    /// Goes through such rounds.
    fn go_round(&mut self, units: &mut [Unit], model: &Model, rounds: Range<usize>, pool: &Pool) {
        let Self { contact, where_is, worklist, obstacles, momenta, descents, left_of_energy, .. } = self;
        // What brings intersecting things apart may contradict itself.
        let may_agree = contact.brings_apart().is_none();
        let rows = &mut contact.rows;
        let is_pinched = may_agree && rows.any_shares();
        for round in 0..rounds.end {
            where_is.gather(rows, units, pool);
            if rounds.contains(&round) {
                if descents.iter().all(|descent| descent.is_done) && rows.are_kept() {
                    return;
                }
                if may_agree && worklist.run(where_is, rows, units, descents, pool) {
                    descents.iter_mut().for_each(|descent| descent.is_done = true);
                    return;
                }
            }
            if round == ROUNDS {
                if is_pinched {
                    return;
                }
                left_of_energy.clear();
                left_of_energy.extend(units.iter_mut().zip(&*descents).map(|(unit, descent)| unit.left_of_energy(descent, pool)));
                if !none_is_struck(left_of_energy) {
                    return;
                }
            }
            if is_pinched && (round == GIVES_WAY || round == GIVES_IN) {
                rows.unpack();
                if round == GIVES_WAY {
                    rows.give_way()
                } else {
                    rows.give_in()
                }
                rows.pack(pool);
            }
            // Single springs and rows agree among themselves before coarse levels join in.
            where_is.sweep(rows, units, pool);
            for (unit, descent) in units.iter_mut().zip(descents.iter_mut()) {
                unit.smooth(model, descent, pool);
            }
            where_is.gather(rows, units, pool);
            where_is.sweep(rows, units, pool);
            if round % RENEWED == 0 {
                for (unit, obstacles) in units.iter_mut().zip(obstacles.iter_mut()) {
                    if round == 0 {
                        rows.obstacles(unit.cloth(), obstacles, pool);
                    } else {
                        rows.renew(obstacles, pool);
                    }
                    unit.levels_mut().obstruct(obstacles, round == 0, pool);
                }
            }
            units.iter().zip(&*descents).for_each(|(unit, descent)| momenta[unit.index()] = descent.momentum());
            rows.go_on(momenta, pool);
            for ((unit, descent), obstacles) in units.iter_mut().zip(descents.iter_mut()).zip(obstacles.iter()) {
                unit.descend(model, descent, true, pool);
                unit.levels_mut().resisted(&mut |obstacle, push| rows.lean(obstacles[obstacle as usize].row, push));
            }
        }
    }

    /// Writes ends and velocities, each cloth within its limit.
    fn conclude(
        &mut self,
        units: &mut [Unit],
        stride: Stride<'_>,
        state: &mut State,
        ends: &mut Vectors,
        corrections: &mut Vectors,
        pool: &Pool,
    ) -> Limited {
        let touches = !self.contact.rows.is_empty();
        let step = stride.plan.length as f32;
        let mut limited = Limited::default();
        self.lost.clear();
        self.lost.resize(stride.model.cloths.len(), 0.0);
        self.rates.clear();
        self.left_of_energy.clear();
        let is_needed = |descent: &Descent| touches || descent.is_needed;
        for (unit, descent) in units.iter_mut().zip(&self.descents) {
            if !is_needed(descent) {
                self.rates.push(0.0);
                continue;
            }
            if touches {
                self.left_of_energy.push(unit.settle_touching(state, descent, pool));
            } else {
                let left_of_energy = unit.hand_out(descent.frame, descent.energy, pool);
                limited.lost_motion = limited.lost_motion.max(unit.settle(stride, state, ends, descent, left_of_energy, pool));
            }
            self.rates.push(unit.tell_velocities(stride, state, ends, corrections, descent, pool));
            if !touches {
                unit.brake_hanging(stride, state, ends, descent, pool);
            }
        }
        for (particle, way) in self.where_is.loose() {
            let (start, proposed) = (state.positions.get(particle), ends.get(particle));
            if way != proposed - start {
                ends.set(particle, start + way);
                state.velocities.set(particle, state.velocities.get(particle) + (start + way - proposed) / step);
            }
        }
        // What was pushed has the velocity with which it goes.
        for particle in self.contact.rows.pushed().chain(self.contact.rows.gripped()) {
            if std::mem::replace(&mut self.is_pushed[particle], true) {
                continue;
            }
            self.pushed.push(particle as u32);
            if let Some((unit, _)) = self.where_is.of(particle) {
                let further = corrections.get(particle) * (1.0 / step - self.rates[unit]);
                state.velocities.set(particle, state.velocities.get(particle) + further);
            }
        }
        self.pushed.drain(..).for_each(|particle| self.is_pushed[particle as usize] = false);
        self.contact.calm(&mut state.velocities, stride.plan.length);
        self.contact.tell_carriers(&mut self.carriers);
        let lying = Lying { model: stride.model, length: step, start: &self.contact.places.x, proposed: &self.proposed, pool };
        if touches && self.contact.brings_apart().is_none() {
            self.gains.bound(stride, lying, &self.velocities, state, ends, &self.carriers);
            self.lost.clone_from(&self.gains.taken);
        }
        for ((unit, descent), &left) in units.iter_mut().zip(&self.descents).zip(&self.left_of_energy) {
            unit.brake_lying(lying, state, ends, left, &self.carriers, descent);
        }
        if let Some(most) = self.contact.brings_apart() {
            units.iter().for_each(|unit| ease::ease(stride, unit.cloth(), state, &self.proposed, ends, most));
        }
        for (unit, descent) in units.iter_mut().zip(&self.descents).filter(|(_, descent)| is_needed(descent)) {
            let frames = if touches { self.frames_of(unit) } else { [descent.frame; 2] };
            let verdict = unit.certify(stride, state, ends, frames, pool);
            limited.cuts += u32::from(verdict.cut);
            limited.held_back_pins += u32::from(verdict.held_back_pins);
            self.lost[unit.index()] = self.lost[unit.index()].max(verdict.lost_motion);
        }
        limited.lost_motion = self.lost.iter().copied().fold(limited.lost_motion, f64::max);
        limited
    }
}

/// Whether no cloth gains energy from what it touches, of all cloths such parts of their proposed energies being left [1].
fn none_is_struck(left_of_energy: &[f64]) -> bool {
    !left_of_energy.is_empty() && left_of_energy.iter().all(|left| *left < 1.0)
}
