//! The coarse-to-fine velocity constraint: a hard limit at any resolution.
//!
//! Sweeping springs one by one cannot carry a load across a fine mesh. Here every cloth has levels, each with fewer
//! particles than the one before and with springs that never contradict the finer ones; a cycle corrects the coarsest
//! level first and hands its displacements down. Cycles go on until every spring is within its limit; a certificate
//! measures the very positions that will be written (docs/equations.md, "Coarse to fine").

mod apart;
mod balance;
mod blocks;
mod brake;
mod calm;
mod certificate;
mod descent;
mod direct;
mod ease;
mod finish;
mod gains;
mod general;
mod impulse;
mod interior;
mod joint;
mod lattice;
mod led;
mod motion;
mod patch;
mod queue;
mod touch;
mod unit;
mod where_is;
mod worklist;

use super::StrainLimit;
use crate::filter::Limited;
use glam::Vec3;

use crate::contact::{Contact, Obstacle, Touching};
use crate::geometry::{CHUNK, Pool, Vectors, Watch};
use crate::model::{ClothRange, Model};
use crate::schedule::{Plan, Stride};
use crate::state::{Calm, State, measure};
use apart::Apart;
use motion::Motion;
use touch::Touch;
use unit::Unit;

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
/// Cloths with at most so many springs are solved directly where neither cycles nor a patch put them right, or where, however little room
/// they have, they make more than this times the kinetic energy of the proposed step: taking that back would cost a hundredth of the motion.
const SMALL: usize = 6000;
const RAISED: f64 = 1.02;
/// Cloths with at most so many springs and something heavy to bear are, too, but that takes them long: only where all cycles and a patch do
/// not put it right, or make twice that energy.
const SMALL_IF_HEAVY: usize = 30_000;
const DOUBLED: f64 = 2.0;
/// Cycles that do have pulled further than the step moves: steps of stiff, light cloth that bears something heavy are short, and their
/// motion is a small part of the back-off. They are taken again with this part of the room, down to what is as good as none.
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
const LAG_AT_REST: f32 = 2.0;
/// Where more than these parts of the cloth are over the limit, one more cycle each is sure not to be the last, and not measured.
const UNMEASURED: [f32; 2] = [0.25, 0.85];
/// Where no more than this part of the springs is over the limit, they are put right one by one instead of by further cycles; but not
/// before so many cycles: a cloth at rest would take one cycle now and three the next time, and each leaves it elsewhere.
const FEW: f32 = 0.01;
const AT_LEAST: u32 = 3;
/// .. or, beside rows, so many times that part.
const FEW_BESIDE_ROWS: usize = 2;
/// .. and, where a particle has more than so many times the mean mass, not before so many: the reaction of a few springs, which that
/// drops, is much of what a heavy point or a hand does to its cloth.
const HEAVY: f32 = 16.0;
const AT_LEAST_IF_HEAVY: u32 = 16;
/// Where so many cycles leave more than this part of what the worst spring was too long, further ones are of no use ..
const PROGRESS_INTERVAL: u32 = 8;
const PROGRESS: f32 = 0.7;
/// .. unless they leave at most this part of the springs that were over, and those are too many for a patch in a cloth too large for a direct
/// solution: there nothing else would help ..
const FEWER: f32 = 0.95;
/// .. but in cloth of more springs than these that bears something heavy: there progress is slow, and a direct solution slower.
const SLOW_PROGRESS_FROM: usize = 1500;
/// If no more than so many springs are over the limit then, the place around them is solved directly.
const STUBBORN: usize = 100;
/// A cloth hangs calm where its limit takes all of the proposed step but for this part of its kinetic energy. There a cycle more or less
/// would be seen as a jerk: as many cycles as were needed are taken from then on, until it moves.
const ENERGY_AT_REST: f64 = 0.1;
/// .. but no more than so many where it touches something: sweeps over rows in turn with them never end at once.
const MOST_IF_TOUCHED: u32 = 12;
/// .. and none where bodies push it rather than cloth: nothing has to carry what lies on top.
const MOST_ON_BODIES: u32 = 0;
/// Cloth lies on something where all of the proposed step is taken but for this part of its kinetic energy: more than cloth that hangs calm
/// has, since ways that turn back on each other are some of it.
const ENERGY_IN_CONTACT: f64 = 0.3;
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
trait Levels: Send + Sync {
    /// Takes a proposed step: where it begins and where it ends [m]. Coarse levels aim by `room` of their back-off below R.
    fn load(&mut self, positions: &Vectors, ends: &Vectors, room: f32, pool: &Pool);
    /// Holds a particle at the end of such a way, until the next step [m].
    fn hold(&mut self, particle: usize, way: Vec3);
    /// Lets all go that is held so.
    fn release(&mut self);
    /// Takes what coarse levels may not do from now on, until the next step; springs alone, if nothing. `anew` says whether anything but
    /// their room and pushes has changed since the last time.
    fn obstruct(&mut self, obstacles: &[Obstacle], anew: bool, pool: &Pool);
    /// Tells the obstacles that coarse levels have leant on since the last time, and how hard [kg m].
    fn resisted(&mut self, tell: &mut dyn FnMut(u32, f32));
    /// One pass over all levels, from the coarsest to the finest. Returns what is left then, or nothing where that is not worth
    /// measuring.
    fn cycle(&mut self, cycle: Cycle, pool: &Pool) -> Option<Measure>;
    /// Sweeps the finest level alone before a cycle. Returns what is left then, if that cycle will tell what it leaves.
    fn smooth(&mut self, cycle: Cycle, pool: &Pool) -> Option<Measure>;
    /// How far below R springs of the finest level are aimed, as a part of R.
    fn back_off(&self) -> f32;
    /// Calls `visit` with the ends of each spring of the finest level that is longer than `enough` of R, as far as the last measure
    /// found them.
    fn over(&self, enough: f32, visit: &mut dyn FnMut([usize; 2]));
    /// From where one particle ends so far to where another does [m].
    fn between(&self, from: usize, to: usize) -> Vec3;
    /// Whether any spring is tied to a particle: others the levels do not know, and leave alone.
    fn knows(&self, particle: usize) -> bool;
    /// How far a particle goes so far [m].
    fn displacement(&self, particle: usize) -> Vec3;
    /// Moves the end of a particle [m].
    fn shift(&mut self, particle: usize, way: Vec3);
    /// How far some particles go so far [m].
    fn displacements(&self, particles: &[u32], ways: &mut [Vec3]) {
        particles.iter().zip(ways).for_each(|(&particle, way)| *way = self.displacement(particle as usize));
    }
    /// Moves the ends of those of them whose ways have changed [m].
    fn shift_all(&mut self, particles: &[u32], [before, now]: [&[Vec3]; 2]) {
        for (&particle, (before, now)) in particles.iter().zip(before.iter().zip(now)).filter(|(_, (before, now))| before != now)
        {
            self.shift(particle as usize, *now - *before);
        }
    }
    /// Takes the corrected ends for the displacements.
    fn settle(&mut self, pool: &Pool);
    /// The displacements of all particles.
    fn motion(&mut self) -> Motion<'_>;
    /// Gives the corrected ends back, and what was added to them [m].
    fn store(&self, positions: &Vectors, ends: &mut Vectors, corrections: &mut Vectors, pool: &Pool);
}

/// All cloths.
pub(super) struct CoarseToFine {
    units: Vec<Unit>,
    /// What is held of each cloth, if it can move apart.
    held: Vec<Apart>,
    /// What the filter added to the ends of the step [m].
    corrections: Vectors,
    /// If anything can touch.
    touch: Option<Touch>,
}

impl CoarseToFine {
    /// Set up for steps that are planned like this one; with the `contact` of the same model as it was before limits or what is held changed, if
    /// there is any.
    pub(super) fn new(model: &Model, plan: &Plan, contact: Option<Contact>) -> Self {
        let units: Vec<Unit> =
            model.cloths.iter().enumerate().filter_map(|(index, cloth)| Unit::new(model, index, cloth, plan)).collect();
        let touch = Touch::new(model, &units, contact);
        let held = units.iter().filter_map(|unit| Apart::new(model, unit.cloth(), unit.levels().back_off() / FINEST)).collect();
        Self { units, held, corrections: Vectors::zeros(model.particle_count()), touch }
    }
}

impl StrainLimit for CoarseToFine {
    fn apply(&mut self, stride: Stride<'_>, state: &mut State, ends: &mut Vectors, pool: &Pool) -> Limited {
        let Self { units, held, corrections, touch } = self;
        let beyond_reach = held.iter_mut().map(|held| u32::from(held.keep(stride, state, ends, pool))).sum();
        let limited = match touch {
            Some(touch) => touch.apply(units, stride, state, ends, corrections, pool),
            None => {
                let each = units.iter_mut().map(|unit| unit.apply(stride, state, ends, corrections, pool));
                each.fold(Limited::default(), Limited::and)
            }
        };
        Limited { beyond_reach, ..limited }
    }

    fn touching(&self) -> Vec<Touching> {
        self.touch.as_ref().map_or_else(Vec::new, |touch| touch.contact.touching().collect())
    }

    fn forget_touching(&mut self) {
        if let Some(touch) = &mut self.touch {
            touch.contact.rows.clear();
        }
    }

    fn take_contact(&mut self) -> Option<Contact> {
        self.touch.take().map(|touch| touch.contact)
    }

    fn lost(&self) -> &[f64] {
        self.touch.as_ref().map_or(&[], |touch| &touch.lost)
    }

    fn watch(&mut self) -> Option<&mut Watch> {
        self.touch.as_mut().map(|touch| &mut touch.contact.watch)
    }
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
fn momentum(cycles: u8, is_calm: bool, most: f32) -> f32 {
    let lag = if is_calm { LAG_AT_REST } else { LAG };
    if cycles < 2 { 0.0 } else { most.min(f32::from(cycles) / (f32::from(cycles) + lag)) }
}
