//! Where the pins of a scene go.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;

use super::travel::{Pose, Travel};
use crate::model::Model;
use crate::scene::{Scene, SceneError};

/// At the start a pin is where the cloth is, and a body where its mesh is, but for this part of their size [1].
pub(super) const NEAR: f64 = 1e-3;
/// Places beyond this are refused [m]: single precision tells them 64 m apart.
const FARTHEST: f64 = 1e9;

/// Where some vertices are in every frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Followed {
    /// How many they are.
    pub vertices: usize,
    /// Their places in the world [m], frame after frame.
    pub places: Arc<[DVec3]>,
    /// Frames per second [1/s]; the scene's own where there is none.
    pub rate: Option<f64>,
}

/// The path of a pin group.
#[derive(Debug, Clone, PartialEq)]
enum Path {
    /// As keyframes say.
    Travel(Travel),
    /// With its frames per second [1/s].
    Followed(Followed, f64),
}

/// The path of each pin group of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct Paths {
    paths: Vec<Path>,
}

impl Paths {
    /// What the pins of a scene say.
    pub(super) fn new(scene: &Scene, model: &Model, followed: &BTreeMap<String, Followed>) -> Result<Self, SceneError> {
        let mut paths = Vec::new();
        for (cloth, asked) in scene.cloth.iter().enumerate() {
            for (index, pin) in asked.pins.iter().enumerate() {
                let at = format!("cloth[{cloth}].pins[{index}].follow");
                paths.push(match &pin.follow {
                    None => Path::Travel(Travel::new(pin.turn.as_ref(), &pin.keyframes)),
                    Some(files) => {
                        let array = followed
                            .get(&files.name())
                            .ok_or_else(|| SceneError::with_value(at.as_str(), files, "its places were not given"))?;
                        check(model, paths.len(), array).map_err(|problem| SceneError::with_value(at, files, problem))?;
                        Path::Followed(array.clone(), array.rate.unwrap_or(scene.fps))
                    }
                });
            }
        }
        Ok(Self { paths })
    }

    /// How keyframes move a group; none if its particles follow an array.
    pub(super) fn travel(&self, group: usize) -> Option<&Travel> {
        match &self.paths[group] {
            Path::Travel(travel) => Some(travel),
            Path::Followed(..) => None,
        }
    }

    /// Where particle number `index` of a pin group is at `time` [s], from the origin that its cloth has at the start [m].
    #[must_use]
    pub fn position(&self, model: &Model, group: usize, index: usize, time: f64) -> DVec3 {
        self.places(model, group, time).of(index)
    }

    /// Where the particles of a pin group are at `time` [s].
    #[must_use]
    pub fn places<'a>(&'a self, model: &'a Model, group: usize, time: f64) -> GroupPlaces<'a> {
        let pins = &model.pins[group];
        let reached = match &self.paths[group] {
            Path::Travel(travel) => Reached::Pose(travel.at(time)),
            Path::Followed(array, rate) => Reached::Frame(array, time * rate),
        };
        GroupPlaces { start: &pins.start, origin: model.origins[pins.cloth].at, reached }
    }
}

/// Where the particles of a pin group are at one time.
pub struct GroupPlaces<'a> {
    start: &'a [DVec3],
    origin: DVec3,
    reached: Reached<'a>,
}

enum Reached<'a> {
    Pose(Pose),
    /// So many frames after the start.
    Frame(&'a Followed, f64),
}

impl GroupPlaces<'_> {
    /// Where particle number `index` of the group is, from the origin that its cloth has at the start [m].
    #[must_use]
    pub fn of(&self, index: usize) -> DVec3 {
        match &self.reached {
            Reached::Pose(pose) => pose.of(self.start[index], self.origin),
            Reached::Frame(array, frames) => array.at(index, *frames) - self.origin,
        }
    }
}

impl Followed {
    /// The place of a vertex so many frames after the start [m]: on a straight line between frames, at the last one after it.
    pub(super) fn at(&self, vertex: usize, frames: f64) -> DVec3 {
        let last = self.places.len() / self.vertices - 1;
        let place = |frame: usize| self.places[frame.min(last) * self.vertices + vertex];
        let frame = frames as usize;
        let part = frames - frame as f64;
        if part > 0.0 { place(frame).lerp(place(frame + 1), part) } else { place(frame) }
    }

    /// What is wrong with it whatever it is for, if anything is; it has at least one vertex.
    pub(super) fn check(&self) -> Result<(), String> {
        let Self { vertices, places, rate } = self;
        if places.is_empty() || places.len() % vertices != 0 {
            return Err("has no frame; give at least one".to_owned());
        }
        if let Some(rate) = rate.filter(|rate| !(rate.is_finite() && *rate > 0.0)) {
            return Err(format!("has {rate} frames per second; must be a finite number above 0, such as 30"));
        }
        if let Some(place) = places.iter().position(|place| !(place.is_finite() && place.abs().max_element() <= FARTHEST)) {
            let (frame, vertex) = (place / vertices, place % vertices);
            return Err(format!(
                "has vertex {vertex} at {:?} in frame {frame}; all places must be finite numbers within {FARTHEST:e} m of the origin",
                places[place].to_array()
            ));
        }
        Ok(())
    }
}

/// What is wrong with the array of a group, if anything is.
fn check(model: &Model, group: usize, array: &Followed) -> Result<(), String> {
    let pins = &model.pins[group];
    let Followed { vertices, places, .. } = array;
    if *vertices != pins.particles.len() {
        return Err(format!("has places of {vertices} vertices, the pin holds {}; give one for each", pins.particles.len()));
    }
    array.check()?;
    let cloth = &model.cloths[pins.cloth];
    let rest = cloth.particles().map(|particle| model.particles.rest.get(particle).as_dvec3());
    let (low, high) = rest.fold((DVec3::MAX, DVec3::MIN), |(low, high), place| (low.min(place), high.max(place)));
    for (index, place) in places[..*vertices].iter().enumerate() {
        let home = pins.start[index] + model.origins[pins.cloth].at;
        if place.distance(home) > NEAR * low.distance(high) {
            let vertex = model.numbering.vertex(pins.particles[index]) as usize - cloth.first;
            return Err(format!(
                "has vertex {vertex} at {:?} in its first frame, but the cloth has it at {:?}; at time 0 a pin is where the \
                 cloth is: begin with the cloth's own places",
                place.to_array(),
                home.to_array()
            ));
        }
    }
    Ok(())
}
