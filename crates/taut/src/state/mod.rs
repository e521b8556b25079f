//! What changes while a scene runs: positions, velocities and the time.

mod clock;
mod led;
mod snapshot;
mod stretch;
mod world;

use glam::{DVec3, Vec3};
use xxhash_rust::xxh3::{Xxh3, xxh3_64};

pub use clock::Clock;
pub use snapshot::SnapshotError;
pub use stretch::{Stretch, longest_of, measure, measure_squares};

use crate::geometry::{Pool, Vectors};
use crate::model::{Model, Numbering};
use crate::schedule::{Halving, Sleep};

/// Positions, velocities and time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct State {
    /// Where the coordinates of each cloth begin now [m].
    pub origins: Vec<DVec3>,
    /// X, from the origin of its cloth [m].
    pub positions: Vectors,
    /// V, with which the integrator goes on [m/s].
    pub velocities: Vectors,
    /// Velocities of the motion [m/s]; empty where V is just that. See [`Self::of_motion`].
    pub motion: Vectors,
    /// Steps and time since the start.
    pub clock: Clock,
    /// What a two-step integrator remembers.
    pub past: Past,
    /// How calm each cloth is; empty where no filter asks for it.
    pub calm: Vec<Calm>,
    /// How far each pin group of the model is off its path.
    pub offsets: Vec<Offset>,
    /// Where the vertices of bodies are, in the world [m].
    pub bodies: Vec<DVec3>,
    /// How far each body that cloth has held back comes nearer to its path in the next step at most [m]; below zero it waits, zero where it
    /// is free. Empty where nothing can touch.
    pub paces: Vec<f32>,
    /// Whether anything may intersect, and steps look for it: from a start, or from a state from elsewhere, until a step finds nothing.
    /// Where nothing does, it makes no difference but time.
    pub may_cross: bool,
    /// In how many parts contact has steps taken; none where nothing touches.
    pub halving: Option<Halving>,
    /// Whether it sleeps; none where it never does.
    pub sleep: Option<Sleep>,
    /// Loads under which the brakes of cloths became firm, as mean accelerations [m/s^2]; zero where there is no brake. Empty where nothing
    /// can touch.
    pub loads: Vec<Vec3>,
    /// How far each particle has crept along what it sticks to, and is to be taken back [m]; empty where nothing can touch.
    pub crept: Vectors,
    /// What a user holds that something in its way keeps from where it should be, by rising particles.
    pub behind: Vec<Behind>,
}

/// A held particle that is not where it should be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Behind {
    /// Which.
    pub particle: u32,
    /// How fast it may go in the next step [m/s].
    pub speed: f32,
}

/// How calm a cloth is, as its strain limit finds it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calm {
    /// So many cycles the limit takes at least, as the cloth hangs calm; zero where it does not.
    pub cycles: u32,
    /// Part of the back-off that coarse levels keep [1]: less than 1 where cloth is held taut.
    pub room: f32,
    /// Part of its way in a step that cloth which lies calm on something does not go [1], since its ways turn back on each other.
    pub brake: f32,
}

impl Default for Calm {
    fn default() -> Self {
        Self { cycles: 0, room: 1.0, brake: 0.0 }
    }
}

impl Calm {
    /// All three as the coordinates of a vector.
    #[must_use]
    pub fn to_vector(self) -> Vec3 {
        Vec3::new(self.cycles as f32, self.room, self.brake)
    }

    /// What [`Self::to_vector`] wrote; all the room where that is none, and no brake.
    #[must_use]
    pub fn from_vector(vector: Vec3) -> Self {
        let room = if vector.y > 0.0 && vector.y <= 1.0 { vector.y } else { 1.0 };
        let brake = if vector.z > 0.0 && vector.z < 1.0 { vector.z } else { 0.0 };
        Self { cycles: vector.x as u32, room, brake }
    }
}

/// A pin group on its way to a place beside its path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Offset {
    /// How far it is off its path [m].
    pub now: DVec3,
    /// Where it was last asked to go [m], and the part of its speed that the cloth followed lately [1].
    pub target: DVec3,
    /// See `target`.
    pub pace: f64,
}

impl Default for Offset {
    fn default() -> Self {
        Self { now: DVec3::ZERO, target: DVec3::ZERO, pace: 1.0 }
    }
}

/// The last step, as a two-step integrator needs it; empty with all others, and zero before the first step.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Past {
    /// X less the X before [m].
    pub displacements: Vectors,
    /// What forces added to V [m/s]; filters are left out.
    pub gains: Vectors,
    /// How long that step was [s].
    pub length: f64,
}

impl Past {
    /// No step yet.
    #[must_use]
    pub fn none(model: &Model) -> Self {
        let count = if model.solver.integrator.remembers() { model.particle_count() } else { 0 };
        Self { displacements: Vectors::zeros(count), gains: Vectors::zeros(count), length: 0.0 }
    }

    /// Whether nothing has ever moved.
    #[must_use]
    pub fn is_blank(&self) -> bool {
        self.displacements.iter().chain(self.gains.iter()).all(|vector| vector == Vec3::ZERO)
    }
}

/// Positions and velocities at one moment, as forces see them; those of a state, or of a stage within a step.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a> {
    /// Where the coordinates of each cloth begin [m].
    pub origins: &'a [DVec3],
    /// X, from there [m].
    pub positions: &'a Vectors,
    /// V [m/s].
    pub velocities: &'a Vectors,
    /// t [s].
    pub time: f64,
}

impl Offset {
    fn numbers(&self) -> [f64; 7] {
        let Self { now, target, pace } = self;
        [now.x, now.y, now.z, target.x, target.y, target.z, *pace]
    }
}

impl State {
    /// The model at rest where the scene put it.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        Self::at(model, model.particles.rest.clone(), Vectors::zeros(model.particle_count()), Clock::default())
    }

    /// The model at some places, from the origins that cloths have at the start; a two-step integrator starts anew.
    #[must_use]
    pub fn at(model: &Model, positions: Vectors, velocities: Vectors, clock: Clock) -> Self {
        let origins = model.origins.iter().map(|origin| origin.at).collect();
        let offsets = vec![Offset::default(); model.pins.len()];
        let motion = if model.solver.tells_motion_apart() { velocities.clone() } else { Vectors::default() };
        let calm = if model.solver.takes_cycles() { vec![Calm::default(); model.cloths.len()] } else { Vec::new() };
        Self {
            origins,
            positions,
            velocities,
            motion,
            clock,
            past: Past::none(model),
            calm,
            offsets,
            bodies: model.bodies.rest.clone(),
            paces: vec![0.0; if model.contact.is_on { model.bodies.list.len() } else { 0 }],
            may_cross: model.contact.untangles,
            halving: model.contact.is_on.then(Halving::default),
            sleep: model.solver.sleep.then(Sleep::default),
            loads: vec![Vec3::ZERO; if model.contact.is_on { model.cloths.len() } else { 0 }],
            crept: Vectors::zeros(if model.contact.is_on { model.particle_count() } else { 0 }),
            behind: Vec::new(),
        }
    }

    /// The velocities that users see [m/s]: those with which positions move. V is another one after a step in which a filter held
    /// something, as weight (docs/equations.md, "Velocities of the motion").
    #[must_use]
    pub fn of_motion(&self) -> &Vectors {
        if self.motion.is_empty() { &self.velocities } else { &self.motion }
    }

    /// Gives all particles other velocities [m/s]; they are those of the motion as well.
    pub fn set_velocities(&mut self, velocities: Vectors) {
        if !self.motion.is_empty() {
            self.motion.clone_from(&velocities);
        }
        self.velocities = velocities;
        self.wake();
    }

    /// Wakes it, if it sleeps.
    pub fn wake(&mut self) {
        self.sleep = self.sleep.map(|_| Sleep::default());
    }

    /// Has nothing move any more.
    pub fn stop(&mut self) {
        let Self { velocities, motion, past: Past { displacements, gains, .. }, .. } = self;
        for Vectors { x, y, z } in [velocities, motion, displacements, gains] {
            [x, y, z].into_iter().for_each(|column| column.fill(0.0));
        }
    }

    /// What a run needs to go on besides positions and velocities of the motion, with a vector for every particle: V, if it differs from
    /// the velocity of the motion; what a two-step integrator remembers; how far particles have crept where things touch.
    pub fn memory(&self) -> impl Iterator<Item = &Vectors> {
        let own = (!self.motion.is_empty()).then_some(&self.velocities);
        own.into_iter().chain([&self.past.displacements, &self.past.gains, &self.crept]).filter(|vectors| !vectors.is_empty())
    }

    /// What a run needs besides: how calm each cloth is, and where things touch in how many parts steps are taken, how bodies come back to
    /// their paths, and the loads that brakes hold for; and whether it sleeps.
    pub fn memory_of_steps(&self) -> impl Iterator<Item = Vec3> {
        self.memory_awake().chain(self.sleep.into_iter().flat_map(Sleep::to_vectors))
    }

    fn memory_awake(&self) -> impl Iterator<Item = Vec3> {
        let calm = self.calm.iter().map(|calm| calm.to_vector());
        let paces = self.paces.iter().map(|&pace| Vec3::X * pace);
        calm.chain(self.halving.map(Halving::to_vector)).chain(paces).chain(self.loads.iter().copied())
    }

    /// Takes what [`Self::memory_of_steps`] told.
    pub fn recall_steps(&mut self, mut memory: impl Iterator<Item = Vec3>) {
        self.calm.iter_mut().zip(&mut memory).for_each(|(calm, vector)| *calm = Calm::from_vector(vector));
        self.halving.iter_mut().zip(&mut memory).for_each(|(halving, vector)| *halving = Halving::from_vector(vector));
        self.paces
            .iter_mut()
            .zip(&mut memory)
            .for_each(|(pace, vector)| *pace = if vector.x.is_finite() { vector.x } else { 0.0 });
        self.loads
            .iter_mut()
            .zip(&mut memory)
            .for_each(|(load, vector)| *load = if vector.is_finite() { vector } else { Vec3::ZERO });
        if let (Some(sleep), Some(of_span), Some(of_all)) = (&mut self.sleep, memory.next(), memory.next()) {
            *sleep = Sleep::from_vectors([of_span, of_all]);
        }
    }

    /// The vectors of [`Self::memory`], to be filled.
    pub fn memory_mut(&mut self) -> impl Iterator<Item = &mut Vectors> {
        let own = (!self.motion.is_empty()).then_some(&mut self.velocities);
        own.into_iter()
            .chain([&mut self.past.displacements, &mut self.past.gains, &mut self.crept])
            .filter(|vectors| !vectors.is_empty())
    }

    /// Time since the start [s].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.clock.time()
    }

    /// Where it is now.
    #[must_use]
    pub fn moment(&self) -> Moment<'_> {
        self.moment_with(&self.velocities)
    }

    /// The same with other velocities [m/s].
    #[must_use]
    pub fn moment_with<'a>(&'a self, velocities: &'a Vectors) -> Moment<'a> {
        Moment { origins: &self.origins, positions: &self.positions, velocities, time: self.time() }
    }

    /// Makes this a copy of `other`, a state of the same model.
    pub fn copy_from(&mut self, other: &Self, pool: &Pool) {
        self.origins.clone_from(&other.origins);
        self.positions.copy_on(&other.positions, pool);
        self.velocities.copy_on(&other.velocities, pool);
        self.motion.copy_on(&other.motion, pool);
        self.past.displacements.copy_on(&other.past.displacements, pool);
        self.past.gains.copy_on(&other.past.gains, pool);
        self.past.length = other.past.length;
        self.clock = other.clock;
        self.calm.clone_from(&other.calm);
        self.offsets.clone_from(&other.offsets);
        self.bodies.clone_from(&other.bodies);
        self.paces.clone_from(&other.paces);
        self.may_cross = other.may_cross;
        self.halving = other.halving;
        self.sleep = other.sleep;
        self.loads.clone_from(&other.loads);
        self.crept.copy_on(&other.crept, pool);
        self.behind.clone_from(&other.behind);
    }

    /// The state with its vectors in the order of the user's vertices.
    #[must_use]
    pub fn to_vertices(&self, numbering: &Numbering) -> Self {
        self.reordered(|vectors| numbering.to_vertices(vectors), |particle| numbering.vertex(particle))
    }

    /// The state from one whose vectors are in the order of the user's vertices.
    #[must_use]
    pub fn to_particles(&self, numbering: &Numbering) -> Self {
        self.reordered(|vectors| numbering.to_particles(vectors), |vertex| numbering.particle(vertex))
    }

    fn reordered(&self, order: impl Fn(&Vectors) -> Vectors, number: impl Fn(u32) -> u32) -> Self {
        let mut state = self.clone();
        let Self { positions, velocities, motion, past: Past { displacements, gains, .. }, crept, behind, .. } = &mut state;
        for vectors in [positions, velocities, motion, displacements, gains, crept] {
            *vectors = order(vectors);
        }
        behind.iter_mut().for_each(|held| held.particle = number(held.particle));
        behind.sort_unstable_by_key(|held| held.particle);
        state
    }

    /// XXH3 hash of the state. It is taken of all local positions, of all velocities of the motion, of the memory, if any, of particles
    /// and of steps, each as x, y, z in little-endian `f32`, and of the origins: see [`hash_of`]. Offsets that pins have count as
    /// well, what is held and behind its place, and how near it is to sleep.
    #[must_use]
    pub fn hash(&self) -> u64 {
        let all = [&self.positions, self.of_motion()].into_iter().chain(self.memory());
        let hash = hash_of(all.flat_map(Vectors::iter).chain(self.memory_awake()), &self.origins);
        let moved = self.offsets.iter().filter(|offset| **offset != Offset::default());
        let behind = self.behind.iter().flat_map(|held| [f64::from(held.particle), f64::from(held.speed)]);
        let calm = self.sleep.filter(|sleep| *sleep != Sleep::default()).into_iter().flat_map(Sleep::to_vectors);
        let calm = calm.flat_map(|vector| vector.to_array()).map(f64::from);
        let numbers = moved.flat_map(Offset::numbers).chain(behind).chain(calm);
        numbers.fold(hash, |hash, number| hash.rotate_left(17) ^ xxh3_64(&number.to_le_bytes()))
    }
}

/// XXH3 hash of vectors as x, y, z in little-endian `f32`, then of all origins as x, y, z in little-endian `f64`. Origins are left out
/// if every one of them is that of the world.
#[must_use]
pub fn hash_of(vectors: impl Iterator<Item = Vec3>, origins: &[DVec3]) -> u64 {
    let mut hash = Xxh3::new();
    for vector in vectors {
        let mut bytes = [0; 12];
        for (place, part) in bytes.chunks_exact_mut(4).zip(vector.to_array()) {
            place.copy_from_slice(&part.to_le_bytes());
        }
        hash.update(&bytes);
    }
    if origins.iter().any(|origin| *origin != DVec3::ZERO) {
        origins.iter().flat_map(|origin| origin.to_array()).for_each(|part| hash.update(&part.to_le_bytes()));
    }
    hash.digest()
}
