//! The coarse-to-fine velocity constraint: a hard limit at any resolution.
//!
//! Sweeping springs one by one cannot carry a load across a fine mesh. Here every cloth has levels, each with fewer
//! particles than the one before and with springs that never contradict the finer ones; a cycle corrects the coarsest
//! level first and hands its displacements down. Cycles go on until every spring is within its limit; a certificate
//! measures the very positions that will be written (docs/equations.md, "Coarse to fine").

mod certificate;
mod direct;
mod finish;
mod general;
mod impulse;
mod interior;
mod lattice;
mod motion;
mod patch;
mod queue;

use super::StrainLimit;
use crate::filter::Limited;
use glam::Vec3;

use crate::geometry::{CHUNK, Pool, Vectors};
use crate::model::{ClothRange, Model};
use crate::schedule::{Plan, Stride};
use crate::state::{Calm, State, measure};
use certificate::Certificate;
use direct::Direct;
use finish::Finish;
use motion::Motion;
use patch::Patch;

/// How far below its limit R a corrected spring is aimed, as a part of its length L [1]. On grids less is enough, but not for the loads of
/// heavy points ..
const BACK_OFF: f32 = 0.012;
const BACK_OFF_OF_GRIDS: f32 = 0.006;
/// .. and at most, as a part of the strain that R allows; where masses are scaled ..
const LARGEST_BACK_OFF: f32 = 0.7;
/// .. and elsewhere, where springs still vibrate within a step: cloth without dampers would gain energy.
const LARGEST_BACK_OFF_UNSCALED: f32 = 0.5;
/// The finest level aims below its limit by this part of the back-off, coarse ones by all of it: what they have put right, the finest
/// does not find wrong again.
const FINEST: f32 = 0.5;
/// A limit that takes all of the proposed step but for the first of these parts of its kinetic energy holds cloth taut, one that leaves the
/// second lets it move. Taut cloth would be short of its limit by the back-off: there coarse levels aim by this part of it ..
const HELD: [f64; 2] = [0.2, 0.6];
const LEAST_ROOM: f32 = 0.5;
/// .. to which they come little by little, by this part of the difference in a step, since a jump would be seen.
const PACE: f32 = 0.05;
/// Cloths with at most so many springs are solved directly where cycles do not end, or make more than this times the kinetic energy of the
/// proposed step: taking that back would cost a hundredth of the motion.
const SMALL: usize = 6000;
const RAISED: f64 = 1.02;
/// Cloths with at most so many springs and something heavy to bear are, too, but that takes them long: only where all cycles and a patch do
/// not put it right, or make twice that energy.
const SMALL_IF_HEAVY: usize = 30_000;
const DOUBLED: f64 = 2.0;
/// Cycles that do have pulled further than the step moves: steps of stiff, light cloth that bears something heavy are short, and their
/// motion is a small part of the back-off. This part of the room is left then, down to what is as good as none.
const SHRINK: f32 = 0.25;
const NO_ROOM: f32 = 1e-3;
/// Coarse levels are swept twice: they carry the loads, and all of them together have fewer springs than half the finest ..
const COARSE_SWEEPS: usize = 2;
/// .. and those with at most so many particles cost nothing.
const COARSEST: usize = 81;
const COARSEST_SWEEPS: usize = 3;
/// Cycle k starts k / (k + lag) of the last one's way further, at most this part of it. Where cloth hangs calm, what is pulled too far
/// would be seen as jerks: a longer lag.
const MOMENTUM: f32 = 0.85;
const LAG: f32 = 1.0;
const CALM_LAG: f32 = 2.0;
/// Where more than these parts of the cloth are over the limit, one more cycle each is sure not to be the last, and not measured.
const UNMEASURED: [f32; 2] = [0.25, 0.85];
/// Where no more than this part of the springs is over the limit, they are put right one by one instead of by further cycles; but not
/// before so many cycles: a cloth at rest would take one cycle now and three the next time, and each leaves it elsewhere.
const FEW: f32 = 0.01;
const AT_LEAST: u32 = 3;
/// .. and, where a particle has more than so many times the mean mass, not before so many: the reaction of a few springs, which that
/// drops, is much of what a heavy point or a hand does to its cloth.
const HEAVY: f32 = 16.0;
const AT_LEAST_IF_HEAVY: u32 = 16;
/// Where so many cycles leave more than this part of what the worst spring was too long, further ones are of no use ..
const PATIENCE: u32 = 8;
const PROGRESS: f32 = 0.7;
/// .. but in cloth of more springs than these that bears something heavy: there progress is slow, and a direct solution slower.
const PATIENT: usize = 1500;
/// If no more than so many springs are over the limit then, the place around them is solved directly.
const STUBBORN: usize = 100;
/// A cloth hangs calm where its limit takes all of the proposed step but for this part of its kinetic energy. There a cycle more or less
/// would be seen as a jerk: as many cycles as were needed are taken from then on, until it moves.
const CALM: f64 = 0.1;
/// A cycle that makes the worst spring this much worse ends the momentum.
const RESTART: f32 = 1.1;

/// What is left to do on the finest level.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Measure {
    /// The largest |P_uv| / R.
    worst: f32,
    /// Springs longer than what is enough.
    over: usize,
}

impl Measure {
    /// What is left in two parts of a level together.
    fn and(self, other: Self) -> Self {
        Self { worst: if other.worst > self.worst { other.worst } else { self.worst }, over: self.over + other.over }
    }
}

/// What one cycle is told.
#[derive(Clone, Copy)]
struct Cycle {
    /// So many cycles have been since the last one without momentum, which grows with them.
    since_restart: u8,
    /// Springs that are no longer than this part of R are not worth further work.
    enough: f32,
    /// More cycles will follow: a measure is not wanted, unless all is done already.
    is_sure: bool,
    /// No more cycles will follow: a measure is wanted in any case.
    is_last: bool,
    /// The cloth hangs calm.
    is_calm: bool,
}

/// Levels of one cloth. Its particles are numbered from its first.
trait Levels: Send {
    /// Takes a proposed step: where it begins and where it ends [m]. Coarse levels aim by `room` of their back-off below R.
    fn load(&mut self, positions: &Vectors, ends: &Vectors, room: f32, pool: &Pool);
    /// One pass over all levels, from the coarsest to the finest. Returns what is left then, or nothing where that is not worth
    /// measuring.
    fn cycle(&mut self, cycle: Cycle, pool: &Pool) -> Option<Measure>;
    /// How far below R springs of the finest level are aimed, as a part of R.
    fn back_off(&self) -> f32;
    /// Calls `visit` with the ends of each spring of the finest level that is longer than `enough` of R, as far as the last measure
    /// found them.
    fn over(&self, enough: f32, visit: &mut dyn FnMut([usize; 2]));
    /// From where one particle ends so far to where another does [m].
    fn between(&self, from: usize, to: usize) -> Vec3;
    /// How far a particle goes so far [m].
    fn displacement(&self, particle: usize) -> Vec3;
    /// Moves the end of a particle [m].
    fn shift(&mut self, particle: usize, way: Vec3);
    /// Takes the corrected ends for the displacements.
    fn settle(&mut self, pool: &Pool);
    /// The displacements of all particles.
    fn motion(&mut self) -> Motion<'_>;
    /// Gives the corrected ends back, and what was added to them [m].
    fn store(&self, positions: &Vectors, ends: &mut Vectors, corrections: &mut Vectors, pool: &Pool);
}

/// One cloth: its levels and its certificate.
struct Unit {
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
    is_patient: bool,
    /// So few springs over their limit are put right one by one after so many cycles.
    few: usize,
    at_least: u32,
    /// Length of its shortest spring [m].
    shortest: f32,
    /// Workspace: what chunks of particles add to sums.
    energies: Vec<[f64; 1]>,
    products: Vec<[f64; 2]>,
}

/// All cloths.
pub(super) struct CoarseToFine {
    units: Vec<Unit>,
    /// What the filter added to the ends of the step [m].
    corrections: Vectors,
}

impl CoarseToFine {
    pub(super) fn new(model: &Model, plan: &Plan) -> Self {
        let units = model.cloths.iter().enumerate().filter_map(|(index, cloth)| Unit::new(model, index, cloth, plan)).collect();
        Self { units, corrections: Vectors::zeros(model.particle_count()) }
    }
}

impl StrainLimit for CoarseToFine {
    fn apply(&mut self, stride: Stride<'_>, state: &mut State, ends: &mut Vectors, pool: &Pool) -> Limited {
        let mut limited = Limited::default();
        for unit in &mut self.units {
            let done = unit.apply(stride, state, ends, &mut self.corrections, pool);
            limited.springs += done.springs;
            limited.sweeps += done.sweeps;
            limited.cuts += done.cuts;
            limited.held_back_pins += done.held_back_pins;
            limited.lost_motion = limited.lost_motion.max(done.lost_motion);
        }
        limited
    }
}

impl Unit {
    /// A cloth; none if nothing in it is limited.
    fn new(model: &Model, index: usize, cloth: &ClothRange, plan: &Plan) -> Option<Self> {
        let strain = *model.springs.strain_limit.get(cloth.springs.clone())?.first()?;
        let largest = if cloth.rates.is_empty() { LARGEST_BACK_OFF_UNSCALED } else { LARGEST_BACK_OFF };
        let shrunk = back_off_of_step(plan, cloth);
        let masses = &model.particles.mass[cloth.particles()];
        let heaviest = masses.iter().fold(0.0, |most: f32, mass| most.max(*mass));
        let is_heavy = heaviest > HEAVY * masses.iter().sum::<f32>() / masses.len() as f32;
        let back_off = if cloth.lattice.is_some() && !is_heavy { BACK_OFF_OF_GRIDS } else { BACK_OFF };
        let delta = (back_off * shrunk).min(largest * strain) / (1.0 + strain);
        let mut levels: Box<dyn Levels> = match cloth.lattice {
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
            is_patient: is_heavy && cloth.springs.len() > PATIENT,
            at_least: if is_heavy { AT_LEAST_IF_HEAVY } else { AT_LEAST },
            few: (FEW * cloth.springs.len() as f32) as usize,
            shortest: model.springs.rest[cloth.springs.clone()].iter().fold(f32::INFINITY, |least, &rest| least.min(rest)),
            energies: vec![[0.0]; levels.motion().weights.len().div_ceil(CHUNK)],
            products: vec![[0.0; 2]; cloth.count.div_ceil(CHUNK)],
            levels,
        })
    }

    fn apply(
        &mut self,
        stride: Stride<'_>,
        state: &mut State,
        ends: &mut Vectors,
        corrections: &mut Vectors,
        pool: &Pool,
    ) -> Limited {
        let model = stride.model;
        let proposed = measure(model, &self.cloth, ends, pool);
        let mut limited = Limited { springs: proposed.over, ..Limited::default() };
        let mut worst = proposed.worst;
        if worst <= 1.0 || worst.is_nan() {
            return limited;
        }
        let Calm { cycles: at_least, room } = state.calm[self.index];
        self.levels.load(&state.positions, ends, room, pool);
        let frame = self.certificate.frame(&state.positions, ends, &self.levels.motion());
        let energy = frame.map(|frame| self.levels.motion().energy(frame, &mut self.energies, pool));
        let rounding = self.rounding(&state.positions, pool);
        let enough = self.enough(rounding);
        let (mut since_restart, mut is_done) = (0_u8, false);
        let (mut next_look, mut before) = (PATIENCE, f32::INFINITY);
        while limited.sweeps < model.solver.iterations() {
            let is_sure = limited.sweeps + 1 < at_least;
            let is_last = limited.sweeps + 1 == model.solver.iterations();
            let left = self.levels.cycle(Cycle { since_restart, enough, is_sure, is_last, is_calm: at_least > 0 }, pool);
            limited.sweeps += 1;
            since_restart =
                if left.is_some_and(|left| left.worst > RESTART * worst) { 0 } else { since_restart.saturating_add(1) };
            let Some(left) = left else { continue };
            worst = left.worst;
            let mut is_stuck = is_last;
            if limited.sweeps >= next_look && !self.is_patient {
                is_stuck |= worst - enough > PROGRESS * before;
                (next_look, before) = (limited.sweeps + PATIENCE, worst - enough);
            }
            let few = limited.sweeps >= self.at_least && left.over <= self.few;
            let finishes = left.over > 0 && (few || is_stuck);
            is_done = worst <= enough || finishes && self.finish.run(&mut *self.levels, enough);
            if is_stuck && !is_done && !self.is_small && left.over <= STUBBORN {
                let weights = &model.particles.inverse_mass[self.cloth.particles()];
                is_done = self.patch.run(&mut *self.levels, self.finish.around(), weights, enough);
            }
            if is_done || is_stuck {
                break;
            }
        }
        let mut left_of_energy = self.settle(frame, energy, pool);
        // Pins that move differently may ask for what no place allows.
        let is_poor = !is_done || left_of_energy > if self.is_small { RAISED } else { DOUBLED };
        if let Some(frame) = frame.filter(|_| is_poor)
            && self.solve(model, &state.positions, ends, frame, rounding)
        {
            left_of_energy = self.settle(Some(frame), energy, pool);
        }
        // Kinetic energy must not rise: shortening an admissible step keeps it admissible, because X is. It is not where a limit
        // has tightened, and what pulls the cloth within it does work.
        let tightened =
            || stride.inputs.limits[self.index].changes() && measure(model, &self.cloth, &state.positions, pool).worst > 1.0;
        if let Some(frame) = frame.filter(|_| left_of_energy > 1.0 && !tightened()) {
            let kept = left_of_energy.recip().sqrt();
            self.levels.motion().slow_down(frame, kept as f32);
            limited.lost_motion = 1.0 - kept;
        }
        let cycles = cycles_from_now(at_least, limited.sweeps, left_of_energy < CALM);
        state.calm[self.index] = Calm { cycles, room: room_from_now(room, left_of_energy) };
        self.levels.store(&state.positions, ends, corrections, pool);
        let rate = impulse::rate(stride, &self.cloth, &state.velocities, corrections, frame, &mut self.products, pool);
        state.velocities.add_scaled(self.cloth.particles(), corrections, rate, pool);
        let verdict = self.certificate.enforce(stride, state, ends, frame, stride.inputs.limits[self.index].changes(), pool);
        limited.cuts = u32::from(verdict.cut);
        limited.lost_motion = 1.0 - (1.0 - limited.lost_motion) * (1.0 - verdict.lost_motion);
        limited.held_back_pins = u32::from(verdict.held_back_pins);
        limited
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
    fn settle(&mut self, frame: Option<Vec3>, before: Option<f64>, pool: &Pool) -> f64 {
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
    if cloth.rates.is_empty() { 1.0 } else { plan.of(cloth).relative.min(1.0).sqrt() as f32 }
}

/// How many cycles the next step takes at least, after one of which as much was asked and that took so many. It rises little by little: a
/// single step that took many is no reason for all that follow.
fn cycles_from_now(at_least: u32, taken: u32, calm: bool) -> u32 {
    match calm {
        true if taken > at_least => taken.min(at_least + at_least / 4 + 4),
        true => at_least,
        false => at_least * 3 / 4,
    }
}

/// The room of coarse levels in the next step, after one with `room` whose limit left such a part of its kinetic energy.
fn room_from_now(room: f32, left_of_energy: f64) -> f32 {
    if left_of_energy > DOUBLED {
        return (SHRINK * room).max(NO_ROOM);
    }
    let freedom = ((left_of_energy - HELD[0]) / (HELD[1] - HELD[0])).clamp(0.0, 1.0) as f32;
    room + PACE * (LEAST_ROOM + (1.0 - LEAST_ROOM) * freedom - room)
}

/// How many cycles are sure not to be the last where such a part of the cloth is over its limit.
fn cycles_to_come(share: f32) -> u32 {
    UNMEASURED.iter().filter(|least| share > **least).count() as u32
}

/// How often a coarse level of so many particles is swept.
fn coarse_sweeps(particles: usize) -> usize {
    if particles <= COARSEST { COARSEST_SWEEPS } else { COARSE_SWEEPS }
}

/// Part of the last cycle's way that the next one starts with, so many cycles after the last start without it. The first cycle
/// corrects more than any other, and once: that does not go on. Few cycles want little momentum: what they pull too far,
/// nothing pulls back, and it comes back in the next step as a jerk (docs/decisions/coarse-to-fine.md).
fn momentum(cycles: u8, is_calm: bool) -> f32 {
    let lag = if is_calm { CALM_LAG } else { LAG };
    if cycles < 2 { 0.0 } else { MOMENTUM.min(f32::from(cycles) / (f32::from(cycles) + lag)) }
}
