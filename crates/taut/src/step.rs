//! The whole story of a time step.

use std::mem;
use std::sync::Arc;

use glam::DVec3;

use crate::diagnostics::{self, Diagnostics, Glance, StateReport, StepReport};
use crate::filter::{self, Filter, Touching};
use crate::forces::Forces;
use crate::geometry::{Pool, Times, Vectors};
use crate::inputs::{Inputs, Ramp};
use crate::integrate::{self, Integrator, Proposal};
use crate::model::Model;
use crate::schedule::{BodyWays, Moving, Parts, Plan, Schedule, Stillness, Stride};
use crate::state::State;

/// The workspace of a simulation: allocated once, and anew where other particles are held. Never part of a result.
pub struct Work {
    /// The model with what a user holds and with limits that have changed, if there are any; and what these are.
    as_held: Option<Model>,
    held: Vec<u32>,
    limits: Vec<Option<f32>>,
    forces: Forces,
    integrator: Integrator,
    filter: Filter,
    diagnostics: Diagnostics,
    pool: Arc<Pool>,
    schedule: Schedule,
    /// The last step, planned.
    plan: Plan,
    /// Where the step leads [m].
    ends: Vectors,
    bodies: BodyWays,
    body_places: Vec<DVec3>,
    /// The state before a part of a step that contact may have to halve; before several steps.
    before_part: State,
    pub(crate) before: State,
    /// Velocities of the motion before the last step [m/s] and its length [s]; zero where that is not known.
    last: (Vectors, f64),
    /// Where each part of the last steps ended, if that is asked for.
    trace: Option<Vec<Waypoint>>,
    clock: Option<fn() -> f64>,
}

/// Where everything is at the end of a part of a step.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Waypoint {
    /// Of all particles, in the world [m].
    pub particles: Vec<DVec3>,
    /// Of the vertices of all bodies [m].
    pub bodies: Vec<DVec3>,
}

impl Work {
    /// Workspace for a model and the steps of its scene, on `threads` threads.
    #[must_use]
    pub fn new(model: &Model, schedule: &Schedule, threads: usize) -> Self {
        Self::with_pool(model, schedule, Arc::new(Pool::new(threads)))
    }

    /// The same on the threads of a pool, which simulations may share.
    #[must_use]
    pub fn with_pool(model: &Model, schedule: &Schedule, pool: Arc<Pool>) -> Self {
        let plan = schedule.plan(model, schedule.step_length);
        Self {
            as_held: None,
            held: Vec::new(),
            limits: vec![None; model.cloths.len()],
            forces: Forces::new(model),
            integrator: Integrator::new(model, &plan),
            filter: Filter::new(model, &plan),
            diagnostics: Diagnostics::new(model),
            ends: Vectors::zeros(model.particle_count()),
            before_part: if model.contact.is_on { State::new(model) } else { State::default() },
            before: State::new(model),
            last: (Vectors::zeros(model.particle_count()), 0.0),
            trace: None,
            clock: None,
            bodies: BodyWays::new(model),
            body_places: model.bodies.rest.clone(),
            schedule: schedule.clone(),
            plan,
            pool,
        }
    }

    /// The threads.
    #[must_use]
    pub fn pool(&self) -> Arc<Pool> {
        Arc::clone(&self.pool)
    }

    /// Goes on with other threads; returns those it had.
    pub fn replace_pool(&mut self, pool: Arc<Pool>) -> Arc<Pool> {
        mem::replace(&mut self.pool, pool)
    }

    /// The steps of the scene.
    #[must_use]
    pub fn schedule(&self) -> &Schedule {
        &self.schedule
    }

    /// Whether steps tell where their parts end, from now on: between these all ways are straight. Takes memory and time.
    pub fn keep_trace(&mut self, keep: bool) {
        self.trace = keep.then(Vec::new);
    }

    /// Where the parts of the steps since [`Self::keep_trace`] or the last call that took several began have ended, in their order;
    /// none where that was not asked for.
    #[must_use]
    pub fn trace(&self) -> Option<&[Waypoint]> {
        self.trace.as_deref()
    }

    /// Measures by a clock of the host from now on what steps spend their time on; with none, as it is at first, nothing does. The clock
    /// tells seconds since any moment, and is asked a few times a step. Nothing that is computed depends on it.
    pub fn set_clock(&mut self, clock: Option<fn() -> f64>) {
        self.clock = clock;
        self.filter.set_clock(clock);
    }

    /// Forgets the last step, and what touched in it: the state is no longer its end.
    pub fn forget_step(&mut self) {
        self.filter.forget_touching();
        self.last.1 = 0.0;
    }

    /// Takes down how everything moves before a step of `dt` seconds, of which [`tensions`] may be asked.
    pub(crate) fn note(&mut self, state: &State, dt: f64) {
        self.last.0.copy_on(state.of_motion(), &self.pool);
        self.last.1 = dt;
    }

    /// Follows what is held. Levels are tied to it, in the model and in the workspace: both are made anew where that has changed,
    /// and nothing is done where only targets have moved.
    fn follow(&mut self, model: &Model, inputs: &Inputs) {
        if inputs.grips.particles() != self.held {
            inputs.grips.particles().clone_into(&mut self.held);
            self.rebuild(model, Filter::follow);
        }
    }

    /// Follows the strain limits that change, frame by frame: those at the end of the frame in which `time` lies [s]. The filter is
    /// made anew when they do.
    fn follow_limits(&mut self, model: &Model, inputs: &Inputs, time: f64) {
        if !inputs.limits.iter().any(Ramp::changes) {
            return;
        }
        let frame = self.schedule.frame();
        let end = (time / frame * (1.0 - 1e-9)).ceil() * frame;
        let mut changed = false;
        for (cloth, (limit, ramp)) in
            self.limits.iter_mut().zip(&inputs.limits).enumerate().filter(|(_, (_, ramp))| ramp.changes())
        {
            let now = ramp.at(end) as f32;
            if *limit != Some(now) {
                *limit = Some(now);
                self.as_held.get_or_insert_with(|| model.clone()).set_limit(cloth, now);
                changed = true;
            }
        }
        if let (true, Some(model)) = (changed, &self.as_held) {
            self.filter.follow(model, &self.plan);
            self.filter.set_clock(self.clock);
        }
    }

    /// Makes anew what may remember a step: after one that failed nothing of it is left.
    pub(crate) fn renew(&mut self, model: &Model) {
        self.rebuild(model, |filter, model, plan| *filter = Filter::new(model, plan));
    }

    /// Makes anew what depends on what is held and on limits.
    fn rebuild(&mut self, model: &Model, filter: impl FnOnce(&mut Filter, &Model, &Plan)) {
        self.as_held = (!self.held.is_empty()).then(|| model.holding(&self.held));
        for (cloth, limit) in self.limits.iter().enumerate() {
            if let Some(limit) = *limit {
                self.as_held.get_or_insert_with(|| model.clone()).set_limit(cloth, limit);
            }
        }
        let model = self.as_held.as_ref().unwrap_or(model);
        let plan = self.schedule.plan(model, self.schedule.step_length);
        self.forces = Forces::new(model);
        self.integrator = Integrator::new(model, &plan);
        filter(&mut self.filter, model, &plan);
        self.filter.set_clock(self.clock);
        self.plan = plan;
    }

    /// Plans a step of `dt` seconds, unless it is like the last one.
    fn plan(&mut self, model: &Model, dt: f64) {
        if self.plan.length != dt {
            self.plan = self.schedule.plan(self.as_held.as_ref().unwrap_or(model), dt);
        }
    }
}

/// Who asks for steps, and may be asked meanwhile.
pub trait Host: Send {
    /// How many steps to take without asking again; none ends them.
    fn turn(&mut self) -> Option<u64> {
        Some(u64::MAX)
    }

    /// Looks at every proposal before the filter does, and may change it; false ends the steps. Of a step in several parts each is
    /// proposed, some of them twice, in halves.
    fn look(&mut self, _: Proposal<'_>) -> bool {
        true
    }

    /// Whether steps need no look where everything lies still.
    fn lets_sleep(&self) -> bool {
        true
    }
}

/// One that wants all steps as they come.
pub struct Content;

impl Host for Content {}

impl<F: FnMut() -> Option<u64> + Send> Host for F {
    fn turn(&mut self) -> Option<u64> {
        self()
    }
}

/// Advances by one step of `dt` seconds under what acts from outside.
pub fn step(model: &Model, state: &mut State, inputs: &Inputs, dt: f64, work: &mut Work) -> StepReport {
    step_for(model, state, inputs, dt, work, &mut Content).unwrap_or_default()
}

/// Advances by one step of `dt` seconds under what acts from outside. The step is taken in several parts where bodies would go further
/// than they may, and where it would have to be cut since something would cross something else. None if the host ends
/// it: the state is then of no use.
pub fn step_for(
    model: &Model,
    state: &mut State,
    inputs: &Inputs,
    dt: f64,
    work: &mut Work,
    host: &mut dyn Host,
) -> Option<StepReport> {
    let end = state.clock.next(dt);
    let times = [state.time(), end.time()];
    if let Some(asleep) = state.sleep.filter(|sleep| sleep.is_asleep()) {
        if host.lets_sleep() && asleep.goes_on(acting(model, state, inputs, times, work)) {
            state.clock = end;
            return Some(StepReport { asleep: true, ..StepReport::default() });
        }
        state.wake();
    }
    let cloths = Moving { origins: &state.origins, positions: &state.positions, velocities: &state.velocities };
    let least = work.bodies.parts(model, inputs, cloths, times);
    let mut parts = Parts::new(least, state.halving);
    let (mut all, mut given_up): (Option<StepReport>, _) = (None, Times::default());
    let pool = work.pool();
    while let Some(part) = parts.next() {
        if parts.can_be_halved() {
            work.before_part.copy_from(state, &pool);
        }
        let report = one_step(model, state, inputs, (part * dt, parts.can_be_halved()), work, host)?;
        if report.limited.asks_for_halves {
            state.copy_from(&work.before_part, &pool);
            parts.halve();
            given_up = given_up.and(report.times);
            continue;
        }
        parts.take(report.limited.contact_cuts > 0, report.limited.given_way);
        if let Some(trace) = &mut work.trace {
            trace.push(Waypoint { particles: state.places(model), bodies: state.bodies.clone() });
        }
        all = Some(all.map_or(report, |all| all.and(report)));
    }
    state.clock = end;
    state.halving = state.halving.map(|before| parts.remember(before));
    let all = all.unwrap_or_default();
    if let Some(sleep) = state.sleep {
        let still = Stillness::of(model, inputs.gravity.at(end.time()).length());
        let may_sleep = host.lets_sleep() && !all.limited.is_troubled() && !state.may_cross && state.behind.is_empty();
        let fastest = may_sleep.then_some(all.fastest);
        let sleep = sleep.after(dt, fastest, still, || acting(model, state, inputs, times, work));
        state.sleep = Some(sleep);
        if sleep.is_asleep() {
            state.stop();
        }
    }
    Some(StepReport { halved: u32::from(parts.was_halved()), times: all.times.and(given_up), ..all })
}

/// What acts from outside in a step, as one number; none where that changes.
fn acting(model: &Model, state: &State, inputs: &Inputs, times: [f64; 2], work: &mut Work) -> Option<u64> {
    inputs.acting(model, times, state.offsets.iter().map(|offset| offset.now), &mut work.body_places)
}

fn one_step(
    model: &Model,
    state: &mut State,
    inputs: &Inputs,
    (dt, can_be_halved): (f64, bool),
    work: &mut Work,
    host: &mut dyn Host,
) -> Option<StepReport> {
    work.follow(model, inputs); // what is held -> levels
    work.follow_limits(model, inputs, state.clock.next(dt).time());
    work.plan(model, dt); // dt -> parts of the step
    let Work { as_held, forces, integrator, filter, pool, plan, ends, .. } = work;
    let stride = Stride { model: as_held.as_ref().unwrap_or(model), inputs, plan, can_be_halved };
    pool.install(model.load(), || {
        state.follow(stride.model, pool); // origins stay near cloths that travel
        filter::hold(stride, state); // paths, targets, hands -> v of what is held
        let evaluations = integrate::propose(stride, state, ends, forces, integrator, pool); // forces: x, v -> x*, v*
        if !host.look(Proposal::new(stride, state, ends, integrator)) {
            return None;
        }
        let limited = filter::apply(stride, state, ends, filter, pool); // x*, v* -> admissible ones
        let fastest = if state.sleep.is_some() { fastest(&state.positions, ends, dt) } else { 0.0 };
        let repaired = integrate::advance(stride, state, ends, forces, integrator, pool); // x = x*
        Some(StepReport { evaluations, limited, repaired, fastest, times: filter.take_times(), ..StepReport::default() })
    })
}

/// How fast the fastest particle goes from where it is to where a step of `dt` seconds leads [m/s].
fn fastest(positions: &Vectors, ends: &Vectors, dt: f64) -> f32 {
    let columns = [(&positions.x, &ends.x), (&positions.y, &ends.y), (&positions.z, &ends.z)];
    let [x, y, z] = columns.map(|(from, to)| from.iter().zip(to).map(|(from, to)| (to - from) * (to - from)));
    // What is no number is the fastest of all.
    let squares = x.zip(y).zip(z).map(|((x, y), z)| (x + y + z).to_bits());
    (f64::from(f32::from_bits(squares.max().unwrap_or_default())).sqrt() / dt) as f32
}

/// A glance at a state between two steps.
pub fn glance(model: &Model, state: &State, work: &mut Work) -> Glance {
    let Work { diagnostics, pool, .. } = work;
    pool.install(model.particle_count(), || diagnostics::glance(model, state, diagnostics, pool))
}

/// Examines a state without advancing it.
pub fn inspect(model: &Model, state: &State, inputs: &Inputs, work: &mut Work) -> StateReport {
    work.follow(model, inputs);
    let Work { as_held, diagnostics, pool, .. } = work;
    let model = as_held.as_ref().unwrap_or(model);
    pool.install(model.particle_count(), || diagnostics::inspect(model, state, inputs, diagnostics, pool))
}

/// Gravity, drag and wind on a state: the accelerations of all particles [m/s^2].
pub fn external<'a>(model: &Model, state: &State, inputs: &Inputs, work: &'a mut Work) -> &'a Vectors {
    work.follow(model, inputs);
    let Work { as_held, forces, pool, plan, .. } = work;
    let model = as_held.as_ref().unwrap_or(model);
    pool.install(model.particle_count(), || {
        crate::forces::external(Stride { model, inputs, plan, can_be_halved: false }, state, forces, pool)
    });
    forces.acceleration()
}

/// A place where cloth touches something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// The particle of the cloth that is nearest to the place.
    pub particle: u32,
    /// The body that it touches; none: cloth.
    pub body: Option<u32>,
    /// On the cloth, in the world [m].
    pub place: DVec3,
    /// The way in which the cloth is pushed, of length 1.
    pub normal: DVec3,
    /// How hard, along the normal, on the mean of the last step [N].
    pub force: f64,
    /// Friction on the cloth, across the normal [N].
    pub friction: DVec3,
}

/// Where cloth was pushed in the last step, or in the last part of it. Nothing keeps that but the workspace: it is lost where a state
/// comes from elsewhere.
#[must_use]
pub fn touches(state: &State, work: &Work) -> Vec<Touch> {
    let base = state.origins.first().copied().unwrap_or_default();
    // A displacement in a step h is that of a force for the time h, which gives a velocity for the time h.
    let square = work.plan.length * work.plan.length;
    let told = |touching: Touching| Touch {
        particle: touching.particle,
        body: touching.body,
        place: touching.place + base,
        normal: touching.normal.as_dvec3(),
        force: f64::from(touching.push) / square,
        friction: touching.hold.as_dvec3() / square,
    };
    work.filter.touching().into_iter().map(told).collect()
}

/// Moves the particles of a state from elsewhere until no spring is over its limit; see [`filter::admit`].
pub fn admit(model: &Model, state: &mut State, inputs: &Inputs, work: &mut Work) {
    work.follow(model, inputs);
    work.follow_limits(model, inputs, state.time());
    let Work { as_held, filter, pool, plan, .. } = work;
    let model = as_held.as_ref().unwrap_or(model);
    pool.install(model.load(), || filter::admit(Stride { model, inputs, plan, can_be_halved: false }, state, filter, pool));
    work.forget_step();
}

/// Tension of each spring in the last step [N], of the strain limit, too: those nearest to Hooke's law that make what the step did to
/// momentum ([`diagnostics::tensions`]). None where no step is known.
#[must_use]
pub fn tensions(model: &Model, state: &State, inputs: &Inputs, work: &mut Work) -> Option<Vec<f64>> {
    let (touches, pool) = (work.filter.touching(), work.pool());
    let Work { as_held, forces, plan, last: (before, length), .. } = work;
    if *length == 0.0 {
        return None;
    }
    let model = as_held.as_ref().unwrap_or(model);
    let still = Vectors::zeros(model.particle_count());
    let mut wanted: Vec<DVec3> = pool.install(model.particle_count(), || {
        // Seen as it moves, without what vibrates within a step; dampers lie along springs, and count as tension.
        let (inside, outside) = (state.moment_with(&still), state.moment_with(state.of_motion()));
        crate::forces::inside_and_outside(Stride { model, inputs, plan, can_be_halved: false }, inside, outside, forces, &pool);
        let gained = |particle| state.of_motion().get(particle).as_dvec3() - before.get(particle).as_dvec3();
        let told = forces.acceleration();
        let missing = |particle| gained(particle) / *length - told.get(particle).as_dvec3();
        let force = |particle: usize| missing(particle) * f64::from(model.particles.mass[particle]);
        (0..model.particle_count()).map(force).collect()
    });
    for touch in touches {
        let force = (touch.normal * touch.push + touch.hold).as_dvec3() / (plan.length * plan.length);
        for (vertex, part) in touch.ends {
            if let Some(wanted) = wanted.get_mut(vertex as usize) {
                *wanted -= force * f64::from(part);
            }
        }
    }
    Some(diagnostics::tensions(model, state, &wanted))
}
