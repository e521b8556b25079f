//! Where the bodies of a scene go.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};

use super::paths::{Followed, NEAR};
use super::travel::Travel;
use super::{BodyForm, BodyShift};
use crate::model::{Bodies, Body, BodyShape, Model};
use crate::scene::{self, Scene, SceneError};

/// The path of a body.
#[derive(Debug, Clone, PartialEq)]
enum Path {
    /// It stays.
    Still,
    /// First it turns, then it is displaced [m].
    Moved(Travel),
    /// With its frames per second [1/s].
    Followed(Followed, f64),
}

/// The path of each body of a model.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BodyPaths {
    paths: Vec<Path>,
    /// Of the bodies that are off their paths.
    shifts: Vec<BodyShift>,
    /// Of the bodies that have none, since their vertices are told.
    forms: Vec<BodyForm>,
}

impl BodyPaths {
    /// What the bodies of a scene say.
    pub(super) fn new(scene: &Scene, model: &Model, followed: &BTreeMap<String, Followed>) -> Result<Self, SceneError> {
        let bodies = scene.body.iter().zip(&model.bodies.list).enumerate();
        let paths = bodies.map(|(index, (asked, body))| {
            let Some(files) = &asked.motion else { return Ok(moved(asked)) };
            let refuse = |problem: String| SceneError::with_value(format!("body[{index}].motion"), files, problem);
            let array = followed.get(&files.name()).ok_or_else(|| refuse("its places were not given".to_owned()))?;
            check(&model.bodies, body, array).map_err(refuse)?;
            Ok(Path::Followed(array.clone(), array.rate.unwrap_or(scene.fps)))
        });
        Ok(Self { paths: paths.collect::<Result<_, _>>()?, shifts: Vec::new(), forms: Vec::new() })
    }

    /// Moves bodies off their paths, or tells their vertices; all others are on theirs.
    pub(super) fn take(&mut self, shifts: &[BodyShift], forms: &[BodyForm]) {
        // One that went back to its path is as one that was never moved.
        let is_on =
            |shift: &BodyShift| BodyShift { start: 0.0, arrival: 0.0, ..*shift } == BodyShift::constant(shift.body, DVec3::ZERO);
        self.shifts = shifts.iter().filter(|shift| !is_on(shift)).copied().collect();
        self.forms = forms.to_vec();
    }

    /// How far a body is off its path at `time` [m].
    #[must_use]
    pub fn shift_of(&self, body: usize, time: f64) -> DVec3 {
        self.shift(body).map_or(DVec3::ZERO, |shift| shift.at(time))
    }

    /// How a body is turned off its path at `time`.
    #[must_use]
    pub fn rotation_of(&self, body: usize, time: f64) -> DQuat {
        self.shift(body).map_or(DQuat::IDENTITY, |shift| shift.rotation(time))
    }

    fn shift(&self, body: usize) -> Option<&BodyShift> {
        self.shifts.iter().find(|shift| shift.body == body)
    }

    /// Writes where the vertices of all bodies are at `time` [s] in the world [m].
    ///
    /// # Panics
    /// If `bodies` are not those of the scene, or `places` has another length than their vertices.
    pub fn places(&self, bodies: &Bodies, time: f64, places: &mut [DVec3]) {
        self.places_of_paths(bodies, time, places);
        for shift in &self.shifts {
            let (body, offset, rotation) = (&bodies.list[shift.body], shift.at(time), shift.rotation(time));
            let places = &mut places[body.vertices.clone()];
            // What has not turned is where it was to the last bit.
            if rotation != DQuat::IDENTITY {
                let middle = middle(body, places);
                places.iter_mut().for_each(|place| *place = middle + rotation * (*place - middle));
            }
            places.iter_mut().for_each(|place| *place += offset);
        }
    }

    fn places_of_paths(&self, bodies: &Bodies, time: f64, places: &mut [DVec3]) {
        places.copy_from_slice(&bodies.rest);
        for (index, (body, path)) in bodies.list.iter().zip(&self.paths).enumerate() {
            let places = &mut places[body.vertices.clone()];
            if let Some(form) = self.forms.iter().find(|form| form.body == index) {
                form.write(time, places);
                continue;
            }
            match path {
                Path::Still => {}
                Path::Moved(travel) => {
                    let pose = travel.at(time);
                    places.iter_mut().for_each(|place| *place = pose.of(*place, DVec3::ZERO));
                }
                Path::Followed(array, rate) => {
                    let places = places.iter_mut().enumerate();
                    places.for_each(|(vertex, place)| *place = array.at(vertex, time * rate));
                }
            }
        }
    }

    /// Writes how far each body turns between two times [s], its axis times the angle [rad]: a ball that turns about its middle does not
    /// move it. What follows an array has no turn of its own.
    pub fn turns(&self, times: [f64; 2], turns: &mut [DVec3]) {
        turns.iter_mut().enumerate().for_each(|(body, turn)| *turn = self.turned(body, times));
    }

    /// How far one body turns.
    #[must_use]
    pub fn turned(&self, body: usize, times: [f64; 2]) -> DVec3 {
        let is_told = self.forms.iter().any(|form| form.body == body);
        let own = match &self.paths[body] {
            Path::Moved(travel) if !is_told => travel.turned(times),
            _ => DVec3::ZERO,
        };
        let Some(shift) = self.shift(body) else { return own };
        let rotation = shift.rotation(times[0]);
        shift.turned_between(times) + if rotation == DQuat::IDENTITY { own } else { rotation * own }
    }

    /// Whether any body ever moves, or was moved.
    #[must_use]
    pub fn any_moves(&self) -> bool {
        !self.shifts.is_empty() || !self.forms.is_empty() || (0..self.paths.len()).any(|body| self.moves(body))
    }

    /// Whether the vertices of a body move each for itself.
    #[must_use]
    pub fn deforms(&self, body: usize) -> bool {
        matches!(self.paths[body], Path::Followed(..)) || self.forms.iter().any(|form| form.body == body)
    }

    /// Whether a body ever moves by itself.
    #[must_use]
    pub fn moves(&self, body: usize) -> bool {
        self.paths[body] != Path::Still
    }
}

/// What a body turns about: the mean of its vertices, of a plane its point.
fn middle(body: &Body, places: &[DVec3]) -> DVec3 {
    if body.shape == BodyShape::Plane { places[0] } else { places.iter().sum::<DVec3>() / places.len() as f64 }
}

/// The path of a body without a motion.
fn moved(asked: &scene::Body) -> Path {
    let travel = Travel::new(asked.turn.as_ref(), &asked.keyframes);
    if travel.is_still() { Path::Still } else { Path::Moved(travel) }
}

/// What is wrong with the motion of a body, if anything is.
fn check(bodies: &Bodies, body: &Body, array: &Followed) -> Result<(), String> {
    let Followed { vertices, places, .. } = array;
    let (name, count) = (&body.name, body.vertices.len());
    if *vertices != count {
        return Err(format!(
            "has places of {vertices} vertices in every frame, the mesh of {name:?} has {count} vertices; give one for each, in the \
             order of the mesh"
        ));
    }
    array.check()?;
    let rest = &bodies.rest[body.vertices.clone()];
    let (low, high) = rest.iter().fold((DVec3::MAX, DVec3::MIN), |(low, high), &place| (low.min(place), high.max(place)));
    for (vertex, (place, home)) in places.iter().zip(rest).enumerate() {
        if place.distance(*home) > NEAR * low.distance(high) {
            return Err(format!(
                "has vertex {vertex} of {name:?} at {:?} in frame 0, but the mesh, scaled, rotated and translated, has it at {:?}; all \
                 places are in the world, and a motion begins where the mesh is: take the first frame for the mesh",
                place.to_array(),
                home.to_array()
            ));
        }
    }
    Ok(())
}
