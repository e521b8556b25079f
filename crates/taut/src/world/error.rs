//! The one error of the facade.

use std::fmt;

use crate::advance::Failure;
use crate::model::Model;
use crate::scene::{SceneError, shorten};
use crate::state::SnapshotError;

/// What cannot be built, or a call that cannot be followed. The world is then as it was before.
///
/// Each kind prints as one sentence with a remedy. More kinds may come: match with a `_` arm.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A field of what was asked for, its value, what is allowed and a remedy. Cloths and bodies are numbered in the order in which they
    /// were given: `scene.cloth[0].strain_limit = 1.5: must be in [1e-9, 1]; try 0.05`. From building a world, and from setting gravity
    /// or wind.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// An argument of a call: `vertices[2] = 700: there are 451, numbered from 0`. From all calls of a world and of a pool that take
    /// numbers.
    #[error("{name} = {value}: {problem}")]
    Argument {
        /// Which one, such as `vertices[2]`.
        name: String,
        /// What was given.
        value: String,
        /// What is wrong, what is allowed and what to do.
        problem: String,
    },
    /// A vertex is no longer at a finite place: the forces were too strong for the step. From [`World::step`](super::World::step), and from
    /// [`World::restore`](super::World::restore) where bytes were made up.
    #[error(
        "cloth[{cloth}], vertex {vertex}: no longer at a finite place after the step to {time:.6} s; the world is as it was before; look \
         for huge speeds, winds or stiffnesses"
    )]
    NonFinite {
        /// Number of its cloth.
        cloth: usize,
        /// Its number in the cloth.
        vertex: usize,
        /// End of the step in which it happened [s].
        time: f64,
    },
    /// Bytes that are no snapshot of this world. From [`World::restore`](super::World::restore).
    #[error(transparent)]
    Snapshot(#[from] SnapshotError),
}

impl Error {
    pub(super) fn argument(name: impl Into<String>, value: impl fmt::Display, problem: impl Into<String>) -> Self {
        Self::Argument { name: name.into(), value: shorten(&value.to_string()), problem: problem.into() }
    }

    /// Why steps over `dt` seconds were not taken.
    pub(super) fn of_steps(model: &Model, failure: Failure, dt: f64) -> Self {
        let Failure::NonFinite { particle, time } = failure else { return Self::argument("dt", dt, failure.to_string()) };
        let vertex = model.numbering.vertex(particle) as usize;
        let cloth = model.cloths.iter().position(|cloth| cloth.particles().contains(&vertex)).unwrap_or_default();
        Self::NonFinite { cloth, vertex: vertex - model.cloths[cloth].first, time }
    }
}

/// Refuses a number beyond the end.
pub(super) fn below(name: &str, index: usize, count: usize) -> Result<(), Error> {
    if index < count { Ok(()) } else { Err(Error::argument(name, index, format!("there are {count}, numbered from 0"))) }
}

/// Refuses what is no time to spend.
pub(super) fn duration(name: &str, time: f64) -> Result<(), Error> {
    let is_one = time.is_finite() && time >= 0.0;
    if is_one { Ok(()) } else { Err(Error::argument(name, time, "must be a finite time, 0 s or longer")) }
}

/// Refuses a list that has not one entry for each of so many things.
pub(super) fn as_many(name: &str, given: usize, count: usize, things: &str) -> Result<(), Error> {
    let problem = || format!("must have one entry for each of {count} {things}");
    if given == count { Ok(()) } else { Err(Error::argument(name, format!("a list of {given}"), problem())) }
}
