//! A proposed step in, an admissible step out: velocities, and the ends to which they lead.
//!
//! What is held goes where its path or a hand says; then a strain limit makes the rest fit.

mod hands;
mod held;
mod strain_limit;

pub use crate::contact::Touching;
use crate::geometry::{Pool, Times, Vectors, Watch};
use crate::model::Model;
use crate::scene::FilterKind;
use crate::schedule::{Plan, Stride};
use crate::state::{Past, State};
use held::CATCHES_UP;
use strain_limit::StrainLimit;

/// What a filter did in one step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Limited {
    /// Springs that would have gone over their limit.
    pub springs: u32,
    /// Passes over the springs; cycles over all levels in the coarse-to-fine filter.
    pub sweeps: u32,
    /// Cloths whose step the certificate had to shorten.
    pub cuts: u32,
    /// Cloths whose pins went only a part of their way: they were asked to go further apart than the cloth reaches, or could follow.
    pub held_back_pins: u32,
    /// Those that were asked for more than their reach, and went as far as that.
    pub(crate) beyond_reach: u32,
    /// The part of its motion that the certificate, or the bound on the kinetic energy, took from a cloth, the largest of all cloths [1].
    pub lost_motion: f64,
    /// Rows of contact: pairs that were near, or came near.
    pub contacts: u32,
    /// Whether the step was shortened where something would have crossed something else.
    pub contact_cuts: u32,
    /// Whether it was left as it was for that, to be taken in halves.
    pub(crate) asks_for_halves: bool,
    /// Whether the bodies that press there have given way already, so that halves are of no use.
    pub(crate) given_way: bool,
    /// Rows of contact that shared too little room, as what they keep apart is pressed from two sides.
    pub pinched: u32,
    /// Bodies that end behind their paths, since what is pressed between them and other things cannot go out of their way.
    pub held_back_bodies: u32,
    /// The least distance at the start of the step of what touches [m]; none if nothing is near.
    pub closest: Option<f64>,
    /// Places where something intersected at the start of the step, while that is brought apart.
    pub penetrations: u32,
}

impl Limited {
    /// Whether something is not where it should be, for want of room.
    pub(crate) fn is_troubled(&self) -> bool {
        self.cuts + self.contact_cuts + self.pinched + self.held_back_pins + self.held_back_bodies + self.penetrations > 0
    }

    /// What was done for two cloths, or in two parts of a step, together.
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            springs: self.springs + other.springs,
            sweeps: self.sweeps + other.sweeps,
            cuts: self.cuts + other.cuts,
            held_back_pins: self.held_back_pins + other.held_back_pins,
            beyond_reach: self.beyond_reach + other.beyond_reach,
            lost_motion: self.lost_motion.max(other.lost_motion),
            contacts: self.contacts + other.contacts,
            contact_cuts: self.contact_cuts + other.contact_cuts,
            asks_for_halves: self.asks_for_halves || other.asks_for_halves,
            given_way: self.given_way || other.given_way,
            pinched: self.pinched + other.pinched,
            held_back_bodies: self.held_back_bodies + other.held_back_bodies,
            closest: [self.closest, other.closest].into_iter().flatten().reduce(f64::min),
            penetrations: self.penetrations.max(other.penetrations),
        }
    }
}

/// The filter of a model with its workspace.
pub struct Filter {
    strain_limit: Box<dyn StrainLimit>,
    watch: Watch,
}

impl Filter {
    /// The filter that the model's solver asks for, set up for steps that are planned like this one.
    #[must_use]
    pub fn new(model: &Model, plan: &Plan) -> Self {
        Self { strain_limit: strain_limit::new(model, plan, None), watch: Watch::default() }
    }

    /// Follows a model in which limits, or what is held, have changed. What can touch stays the same, and takes far longer to make than the
    /// rest.
    pub fn follow(&mut self, model: &Model, plan: &Plan) {
        let contact = self.strain_limit.take_contact();
        self.strain_limit = strain_limit::new(model, plan, contact);
    }

    /// Takes a clock of the host [s], if it brought one.
    pub fn set_clock(&mut self, clock: Option<fn() -> f64>) {
        self.watch.clock = clock;
        if let Some(watch) = self.strain_limit.watch() {
            watch.clock = clock;
        }
    }

    /// What it spent its time on since that was last asked for.
    pub fn take_times(&mut self) -> Times {
        self.watch.take()
    }

    /// What pushed cloth in the last step; nothing where the filter knows no contact.
    #[must_use]
    pub fn touching(&self) -> Vec<Touching> {
        self.strain_limit.touching()
    }

    /// Forgets that: the state is no longer the end of that step.
    pub fn forget_touching(&mut self) {
        self.strain_limit.forget_touching();
    }
}

/// Gives what is held the velocity that its path, its target or its hand asks for in this step.
pub fn hold(stride: Stride<'_>, state: &mut State) {
    hands::start(stride, state);
    held::hold(stride, state);
    hands::hold(stride, state);
}

/// Makes the step admissible: its ends [m], and the velocities that lead there.
pub fn apply(stride: Stride<'_>, state: &mut State, ends: &mut Vectors, filter: &mut Filter, pool: &Pool) -> Limited {
    held::place(stride, state, ends);
    hands::place(stride, state, ends);
    let Filter { strain_limit, watch } = filter;
    let start = watch.now();
    let limited = strain_limit.apply(stride, state, ends, pool);
    let all = watch.now() - start;
    // All but what contact took for itself.
    let contact = strain_limit.watch().map(Watch::take).unwrap_or_default();
    let solve = (all - contact.detection - contact.certificate).max(0.0);
    watch.times = watch.times.and(Times { solve, ..contact });
    held::finish(stride, state, ends, &limited, strain_limit.lost());
    hands::finish(stride, state, ends, limited.held_back_pins > 0);
    Limited { held_back_pins: limited.held_back_pins.max(limited.beyond_reach), ..limited }
}

/// Moves the particles of a state from elsewhere, which may be over the limit, until none of their springs is. Only the
/// coarse-to-fine filter needs that: it keeps to its limit, and must not start beyond it.
///
/// The state is taken for the end of a step that starts at rest, where the scene put the cloth, and that step is made admissible. A
/// two-step integrator starts anew.
pub fn admit(stride: Stride<'_>, state: &mut State, filter: &mut Filter, pool: &Pool) {
    let model = stride.model;
    if model.solver.filter != FilterKind::CoarseToFine {
        return;
    }
    let mut start = State { origins: state.origins.clone(), may_cross: false, ..State::new(model) };
    filter.strain_limit.apply(stride, &mut start, &mut state.positions, pool);
    filter.strain_limit.watch().map(Watch::take); // that is no step
    state.past = Past::none(model);
}
