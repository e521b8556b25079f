//! One cloth in one step: cycles over its levels until few springs are over, what puts the last of them right, and the certificate.

use glam::Vec3;

use super::brake::{HANGS, LIES, Lying, Ways};
use super::calm::{cycles_from_now, room_from_now};
use super::certificate::Certificate;
use super::descent::Descent;
use super::direct::Direct;
use super::finish::Finish;
use super::patch::Patch;
use super::*;
use crate::contact::{Carried, Carrier, RigidMotion};
use crate::state::Stretch;

/// One cloth: its levels and its certificate.
pub(super) struct Unit {
    /// Which, and what it has.
    index: usize,
    cloth: ClothRange,
    certificate: Certificate,
    levels: Box<dyn Levels>,
    finish: Finish,
    patch: Patch,
    /// Made when it is asked for the first time: most cloths never do.
    direct: Option<Direct>,
    may_solve: bool,
    is_small: bool,
    progresses_slowly: bool,
    /// So few springs over their limit are put right one by one after so many cycles.
    few: usize,
    at_least: u32,
    /// Length of its shortest spring [m], and the mass of what is not held [kg].
    shortest: f32,
    mass: f64,
    /// Inverse masses of its particles, none of those that are gripped in this step; and those, with theirs [1/kg].
    weights: Vec<f32>,
    gripped: Vec<(usize, f32)>,
    /// Workspace: what chunks of particles add to sums.
    energies: Vec<[f64; 1]>,
    products: Vec<[f64; 2]>,
    turns: Vec<[f64; 3]>,
}

impl Unit {
    /// A cloth; none if nothing in it is limited.
    pub fn new(model: &Model, index: usize, cloth: &ClothRange, plan: &Plan) -> Option<Self> {
        let strain = *model.springs.strain_limit.get(cloth.springs.clone())?.first()?;
        let largest = if cloth.rates.is_empty() { LARGEST_BACK_OFF_UNSCALED } else { LARGEST_BACK_OFF };
        let shrunk = back_off_of_step(plan, cloth);
        let masses = &model.particles.mass[cloth.particles()];
        let heaviest = masses.iter().fold(0.0, |most: f32, mass| most.max(*mass));
        let is_heavy = heaviest > HEAVY * masses.iter().sum::<f32>() / masses.len() as f32;
        let back_off = if cloth.lattice_of_levels().is_some() && !is_heavy { BACK_OFF_OF_GRIDS } else { BACK_OFF };
        let delta = (back_off * shrunk).min(largest * strain) / (1.0 + strain);
        let mut levels: Box<dyn Levels> = match cloth.lattice_of_levels() {
            Some(lattice) => Box::new(lattice::LatticeLevels::new(model, &model.lattices[lattice], strain, delta, shrunk)),
            None => Box::new(general::GeneralLevels::new(&model.hierarchies[cloth.hierarchy?], cloth, strain, delta)),
        };
        Some(Self {
            index,
            cloth: cloth.clone(),
            certificate: Certificate::new(model, cloth),
            finish: Finish::new(model, cloth),
            patch: Patch::new(cloth.count),
            direct: None,
            may_solve: cloth.springs.len() <= if is_heavy { SMALL_IF_HEAVY } else { SMALL },
            is_small: cloth.springs.len() <= SMALL,
            progresses_slowly: is_heavy && cloth.springs.len() > SLOW_PROGRESS_FROM,
            at_least: if is_heavy { AT_LEAST_IF_HEAVY } else { AT_LEAST },
            few: (FEW * cloth.springs.len() as f32) as usize,
            shortest: model.springs.rest[cloth.springs.clone()].iter().fold(f32::INFINITY, |least, &rest| least.min(rest)),
            mass: model.particles.free_masses(cloth).iter().sum(),
            weights: model.particles.inverse_mass[cloth.particles()].to_vec(),
            gripped: Vec::new(),
            energies: vec![[0.0]; levels.motion().weights.len().div_ceil(CHUNK)],
            products: vec![[0.0; 2]; cloth.count.div_ceil(CHUNK)],
            turns: vec![[0.0; 3]; cloth.count.div_ceil(CHUNK)],
            levels,
        })
    }

    /// Makes the step of this cloth admissible.
    pub fn apply(
        &mut self,
        stride: Stride<'_>,
        state: &mut State,
        ends: &mut Vectors,
        corrections: &mut Vectors,
        pool: &Pool,
    ) -> Limited {
        let proposed = measure(stride.model, &self.cloth, ends, pool);
        let limited = Limited { springs: proposed.over, ..Limited::default() };
        if proposed.worst <= 1.0 || proposed.worst.is_nan() {
            state.calm[self.index].brake = 0.0;
            return limited;
        }
        let mut descent = self.begin(proposed, state, ends, pool);
        let left_of_energy = loop {
            while !descent.is_over {
                self.descend(stride.model, &mut descent, false, pool);
            }
            let left_of_energy = self.hand_out(descent.frame, descent.energy, pool);
            if !self.want_less_room(left_of_energy) || !descent.take_again() {
                break left_of_energy;
            }
            self.levels.load(&state.positions, ends, descent.room, pool);
        };
        let lost = self.settle(stride, state, ends, &descent, left_of_energy, pool);
        self.tell_velocities(stride, state, ends, corrections, &descent, pool);
        self.brake_hanging(stride, state, ends, &descent, pool);
        let verdict = self.certify(stride, state, ends, [descent.frame; 2], pool);
        Limited {
            sweeps: descent.earlier + descent.sweeps,
            cuts: u32::from(verdict.cut),
            lost_motion: 1.0 - (1.0 - lost) * (1.0 - verdict.lost_motion),
            held_back_pins: u32::from(verdict.held_back_pins),
            ..limited
        }
    }

    /// Takes a proposed step, of which `proposed` tells how far springs are over. What touches nothing in it is free of its brake.
    pub fn begin(&mut self, proposed: Stretch, state: &mut State, ends: &Vectors, pool: &Pool) -> Descent {
        let Calm { cycles: at_least, room, ref mut brake } = state.calm[self.index];
        let brake = std::mem::take(brake);
        if self.is_gripped() {
            self.release();
        }
        self.levels.load(&state.positions, ends, room, pool);
        let frame = self.certificate.frame(&state.positions, ends, &self.levels.motion());
        let energy = frame.map(|frame| self.levels.motion().energy(frame, &mut self.energies, pool));
        let rounding = self.rounding(&state.positions, pool);
        Descent {
            worst: proposed.worst,
            frame,
            energy,
            rounding,
            enough: self.enough(rounding),
            at_least,
            room,
            brake,
            sweeps: 0,
            earlier: 0,
            since_restart: 0,
            next_look: PROGRESS_INTERVAL,
            before: f32::INFINITY,
            over_before: usize::MAX,
            over: None,
            is_done: false,
            is_over: false,
            is_needed: true,
        }
    }

    /// Grips a particle of it, which goes such a way in this step [m].
    pub fn grip(&mut self, own: usize, way: Vec3) {
        self.gripped.push((own, std::mem::take(&mut self.weights[own])));
        self.levels.hold(own, way);
    }

    /// Whether anything is gripped.
    pub fn is_gripped(&self) -> bool {
        !self.gripped.is_empty()
    }

    /// Lets all go that was gripped.
    pub fn release(&mut self) {
        self.gripped.drain(..).for_each(|(own, weight)| self.weights[own] = weight);
        self.levels.release();
    }

    /// Sees a cloth that nothing holds, but that touches something, from the world instead of from its centre of mass: that stops.
    pub fn stand(&self, state: &State, ends: &Vectors, weights: &[f32], descent: &mut Descent) {
        if self.certificate.is_free() {
            let way = |particle: usize| f64::from((ends.get(particle) - state.positions.get(particle)).length_squared());
            descent.frame = Some(Vec3::ZERO);
            descent.energy = Some(self.cloth.particles().map(|p| way(p) / f64::from(weights[p])).sum());
        }
    }

    /// Goes on by one cycle, and puts the last few springs right one by one; not `beside_rows`, which have a say in that.
    pub fn descend(&mut self, model: &Model, descent: &mut Descent, beside_rows: bool, pool: &Pool) {
        let cycle @ Cycle { enough, is_last, .. } = descent.cycle(model);
        let left = self.levels.cycle(cycle, pool);
        descent.sweeps += 1;
        descent.over = left.map(|left| left.over);
        descent.is_done = false;
        descent.since_restart = if left.is_some_and(|left| left.worst > RESTART * descent.worst) {
            0
        } else {
            descent.since_restart.saturating_add(1)
        };
        let Some(left) = left else { return };
        descent.worst = left.worst;
        let mut is_stuck = is_last;
        if descent.sweeps >= descent.next_look && !self.progresses_slowly {
            let are_many = left.over > STUBBORN && !self.is_small;
            let are_fewer = left.over as f32 <= FEWER * descent.over_before as f32;
            is_stuck |= left.worst - enough > PROGRESS * descent.before && !(are_many && are_fewer);
            (descent.before, descent.over_before) = (left.worst - enough, left.over);
            descent.next_look = descent.sweeps + PROGRESS_INTERVAL;
        }
        let few = descent.sweeps >= self.at_least && left.over <= self.few;
        let finishes = !beside_rows && left.over > 0 && (few || is_stuck);
        if finishes {
            self.finish.hold(self.gripped.iter().map(|(own, _)| *own));
        }
        descent.is_done = left.worst <= enough || finishes && self.finish.run(&mut *self.levels, enough);
        if is_stuck && !descent.is_done && left.over <= STUBBORN {
            descent.is_done = self.patch.run(&mut *self.levels, self.finish.around(), &self.weights, enough);
        }
        descent.is_over = descent.is_done || is_stuck;
    }

    /// Sweeps the finest level alone, before the next cycle.
    pub fn smooth(&mut self, model: &Model, descent: &mut Descent, pool: &Pool) {
        if let Some(left) = self.levels.smooth(descent.cycle(model), pool) {
            descent.worst = left.worst;
        }
    }

    /// Calls `visit` with the ends of springs that the last cycle left over, if it told and they are few. Returns whether they are.
    pub fn over(&self, descent: &Descent, mut visit: impl FnMut(usize)) -> bool {
        if descent.is_done {
            return true;
        }
        let are_few = descent.over.is_some_and(|over| over <= FEW_BESIDE_ROWS * self.few);
        if are_few {
            self.levels.over(descent.enough, &mut |ends| ends.into_iter().for_each(&mut visit));
        }
        are_few
    }

    /// Pulls together the ends of each spring of a particle that is over. Tells which particles that moves, and how far [m].
    pub fn put_right(&mut self, own: usize, descent: &Descent, mut tell: impl FnMut(usize, Vec3)) {
        let Self { levels, finish, weights, .. } = self;
        let aim = 1.0 - levels.back_off();
        for &(other, limit) in finish.around().of(own) {
            let ends = [own, other as usize];
            let (way, reach) = (levels.between(own, ends[1]), descent.enough * limit);
            let (square, both) = (way.length_squared(), weights[own] + weights[ends[1]]);
            if square > reach * reach && both > 0.0 {
                let pull = way * ((1.0 - aim * limit / square.sqrt()) / both);
                for (end, pull) in ends.into_iter().zip([pull, -pull]).filter(|(end, _)| weights[*end] > 0.0) {
                    levels.shift(end, pull * weights[end]);
                    tell(end, pull * weights[end]);
                }
            }
        }
    }

    /// Hands the corrected ends of what touches something out: that may give it energy and momentum. Returns the part of the kinetic
    /// energy of the proposal that is left [1].
    pub fn settle_touching(&mut self, state: &mut State, descent: &Descent, pool: &Pool) -> f64 {
        let left_of_energy = self.left_of_energy(descent, pool);
        self.remember(state, descent, left_of_energy, left_of_energy > DOUBLED);
        left_of_energy
    }

    /// Looks at the corrected ends. Returns the part of the kinetic energy of the proposal that is left [1].
    pub fn left_of_energy(&mut self, descent: &Descent, pool: &Pool) -> f64 {
        self.levels.settle(pool);
        match (descent.frame, descent.energy) {
            (Some(frame), Some(before)) => self.levels.motion().energy(frame, &mut self.energies, pool) / before,
            _ => 1.0,
        }
    }

    /// Whether cycles that leave so many times the kinetic energy of the proposal, and so pulled further than the step moves, want less room.
    fn want_less_room(&self, left_of_energy: f64) -> bool {
        left_of_energy > if self.is_small { RAISED } else { DOUBLED }
    }

    /// Hands corrected ends that leave so many times the kinetic energy out, within the bound on it. Returns the part of the motion that
    /// this bound took [1].
    pub fn settle(
        &mut self,
        stride: Stride<'_>,
        state: &mut State,
        ends: &Vectors,
        descent: &Descent,
        mut left_of_energy: f64,
        pool: &Pool,
    ) -> f64 {
        let Descent { frame, energy, .. } = *descent;
        let model = stride.model;
        let want_less_room = self.want_less_room(left_of_energy);
        // Pins that move differently may ask for what no place allows.
        if let Some(frame) = frame.filter(|_| want_less_room || !descent.is_done)
            && self.solve(model, &state.positions, ends, frame, descent.rounding)
        {
            left_of_energy = self.hand_out(Some(frame), energy, pool);
        }
        self.remember(state, descent, left_of_energy, want_less_room);
        // Kinetic energy must not rise: shortening an admissible step keeps it admissible, because X is. It is not where a limit
        // has tightened, and what pulls the cloth within it does work.
        let tightened =
            || stride.inputs.limits[self.index].changes() && measure(model, &self.cloth, &state.positions, pool).worst > 1.0;
        if let Some(frame) = frame.filter(|_| left_of_energy > 1.0 && !tightened()) {
            let kept = left_of_energy.recip().sqrt();
            self.levels.motion().slow_down(frame, kept as f32);
            // Nobody can tell a particle from another one that is nearer than what rounding its place takes.
            let taken = (1.0 - kept) * (left_of_energy * energy.unwrap_or_default() / self.mass).sqrt();
            return if taken > f64::from(descent.rounding * self.shortest) { 1.0 - kept } else { 0.0 };
        }
        0.0
    }

    /// Which cloth it is.
    pub fn index(&self) -> usize {
        self.index
    }

    /// The cloth.
    pub fn cloth(&self) -> &ClothRange {
        &self.cloth
    }

    /// Its levels.
    pub fn levels(&self) -> &dyn Levels {
        &*self.levels
    }

    /// The same, to be changed.
    pub fn levels_mut(&mut self) -> &mut dyn Levels {
        &mut *self.levels
    }

    /// Remembers how calm the cloth hangs, and whether its cycles want less room, whatever made up for what they did.
    fn remember(&self, state: &mut State, descent: &Descent, left_of_energy: f64, want_less_room: bool) {
        let cycles = cycles_from_now(descent.at_least, descent.sweeps, left_of_energy < ENERGY_AT_REST);
        let room = room_from_now(descent.room, left_of_energy, want_less_room);
        state.calm[self.index] = Calm { cycles, room, ..state.calm[self.index] };
    }

    /// Writes the corrected ends, and gives velocities their part of the corrections. Returns that part [1/s].
    pub fn tell_velocities(
        &mut self,
        stride: Stride<'_>,
        state: &mut State,
        ends: &mut Vectors,
        corrections: &mut Vectors,
        descent: &Descent,
        pool: &Pool,
    ) -> f32 {
        self.levels.store(&state.positions, ends, corrections, pool);
        let products = &mut self.products;
        let rate = impulse::rate(stride, &self.cloth, &state.velocities, corrections, descent.frame, products, pool);
        state.velocities.add_scaled(self.cloth.particles(), corrections, rate, pool);
        rate
    }

    /// Leaves a part of its way out where it hangs on what moves as one and touches nothing, and its ways turn back. All of the way is
    /// needed where a limit tightens: where the step starts, springs are over it.
    pub fn brake_hanging(&mut self, stride: Stride<'_>, state: &mut State, ends: &mut Vectors, descent: &Descent, pool: &Pool) {
        let hangs = !self.certificate.is_free() && !stride.inputs.limits[self.index].changes();
        let Some(frame) = descent.frame.filter(|_| hangs) else { return };
        let length = stride.plan.length as f32;
        let ways = Ways { model: stride.model, cloth: &self.cloth, length, with: |_| frame, pool };
        state.calm[self.index].brake = ways.brake(descent.brake, HANGS, state, ends, &mut self.turns);
    }

    /// Leaves a part of its way out where it lies on something, of whose proposed energy `left_of_energy` is left as seen from the world or
    /// from what holds it. What several bodies carry apart, or grip and move, has no brake: it would take the speed that these give it.
    pub fn brake_lying(
        &mut self,
        lying: Lying<'_>,
        state: &mut State,
        ends: &mut Vectors,
        left_of_energy: f64,
        carriers: &[Carried],
        descent: &Descent,
    ) {
        let carried = &carriers[self.index];
        let frame = match (carried.by, descent.frame) {
            // What is held, and moves, may leave behind what the cloth touches.
            (Carrier::Nothing, Some(frame)) if frame == Vec3::ZERO || carried.is_alone(carriers) => {
                Some((RigidMotion::along(frame.as_dvec3()), left_of_energy))
            }
            (Carrier::Rigid(frame), _) if self.certificate.is_free() && !self.is_gripped() => {
                Some((frame, lying.ways(&self.cloth, frame).left_of_energy(state, lying.proposed, ends)))
            }
            _ => None,
        };
        let ways = frame.filter(|(_, left)| *left < ENERGY_IN_CONTACT).map(|(frame, _)| lying.ways(&self.cloth, frame));
        let brake = ways.map_or(0.0, |ways| ways.brake(descent.brake, LIES, state, ends, &mut self.turns));
        let calm = &mut state.calm[self.index];
        calm.brake = brake;
        calm.cycles = calm.cycles.min(if carried.is_on_bodies { MOST_ON_BODIES } else { MOST_IF_TOUCHED });
    }

    /// Forgets how far particles have crept where the brake is on: cloth that lies still does not creep.
    pub fn forget_creep(&self, state: &mut State) {
        if state.calm[self.index].brake > 0.0 {
            self.cloth.particles().for_each(|particle| state.crept.set(particle, Vec3::ZERO));
        }
    }

    /// Measures the ends, and shortens them where springs are over, towards where the step starts, moved along with the frame.
    pub fn certify(
        &mut self,
        stride: Stride<'_>,
        state: &mut State,
        ends: &mut Vectors,
        frames: [Option<Vec3>; 2],
        pool: &Pool,
    ) -> certificate::Verdict {
        let tightens = stride.inputs.limits[self.index].changes();
        self.certificate.enforce(stride, state, ends, frames, tightens, pool)
    }

    /// Finds the place within all limits nearest to the proposed one, in small cloths. Returns whether that was done.
    fn solve(&mut self, model: &Model, positions: &Vectors, ends: &Vectors, frame: Vec3, rounding: f32) -> bool {
        if self.may_solve && self.direct.is_none() {
            self.direct = Direct::new(model, &self.cloth);
            self.may_solve = self.direct.is_some();
        }
        self.direct.as_mut().is_some_and(|direct| direct.run(&mut *self.levels, positions, ends, frame, rounding))
    }

    /// Takes the corrected ends for the displacements. Returns what is left of the kinetic energy in the `frame`, which was `before`.
    pub fn hand_out(&mut self, frame: Option<Vec3>, before: Option<f64>, pool: &Pool) -> f64 {
        self.levels.settle(pool);
        let mut motion = self.levels.motion();
        let (Some(frame), Some(before)) = (frame, before) else { return 1.0 };
        if self.certificate.is_free() {
            // What was put right one by one must not add up to a momentum.
            let astray = frame - motion.mean();
            motion.shift(astray);
        }
        motion.energy(frame, &mut self.energies, pool) / before
    }

    /// Part of R below which the levels are done.
    fn enough(&self, rounding: f32) -> f32 {
        1.0 - rounding.max(2e-5).min(0.5 * self.levels.back_off())
    }

    /// What rounding the ends of the shortest spring to single precision once more can add to it, as a part of its length.
    fn rounding(&self, positions: &Vectors, pool: &Pool) -> f32 {
        4.0 * f32::EPSILON * positions.reach(self.cloth.particles(), pool) / self.shortest
    }
}

/// What is left of back-offs in steps that are shorter than automatic ones [1]: their root. What a step takes back too far is
/// lost, and more steps would lose more of the motion; but with back-offs in proportion to the step cycles do not end where
/// masses differ.
fn back_off_of_step(plan: &Plan, cloth: &ClothRange) -> f32 {
    plan.part_of_automatic(cloth).sqrt() as f32
}
