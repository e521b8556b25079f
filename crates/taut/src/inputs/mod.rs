//! What comes with a step from outside: gravity, the moving air, where held particles and bodies go. A step reads it and never changes it.

mod acting;
mod air;
mod bodies;
mod flow;
mod grips;
mod paths;
mod reach;
mod shifts;
mod track;
mod travel;

use std::collections::BTreeMap;

use glam::DVec3;

pub use air::{Air, OCTAVES, Wave};
pub use bodies::BodyPaths;
pub use flow::{Flows, Outflow, Vortex};
pub use grips::{Grips, Lead, Shift, Target};
pub use paths::{Followed, GroupPlaces, Paths};
pub use shifts::{BodyForm, BodyShift};
pub use track::{Ramp, Track};

use crate::model::{Model, Rates};
use crate::scene::{Scene, SceneError, WindLaw};

/// What acts on a model in a step. All of it may change from one step to the next.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// Acceleration of gravity [m/s^2].
    pub gravity: Track,
    /// The moving air, if any.
    pub air: Option<Air>,
    /// Where the pins of the scene go.
    pub pins: Paths,
    /// Where the bodies of the scene go.
    pub bodies: BodyPaths,
    /// The strain limit of each cloth [1].
    pub limits: Vec<Ramp>,
    /// What a user holds.
    pub grips: Grips,
}

impl Inputs {
    /// What a scene asks for; `followed` holds the arrays that its pins and bodies follow.
    ///
    /// # Errors
    /// Pins move further apart than the cloth between them reaches, or an array does not fit its pins or its body.
    pub fn new(scene: &Scene, model: &Model, followed: &BTreeMap<String, Followed>) -> Result<Self, SceneError> {
        let pins = Paths::new(scene, model, followed)?;
        reach::check(&pins, model)?;
        let gravity = Track::new(DVec3::from_array(scene.gravity()), &scene.gravity_keyframes);
        Ok(Self {
            gravity,
            air: scene.wind.as_ref().map(Air::new),
            pins,
            bodies: BodyPaths::new(scene, model, followed)?,
            limits: scene.cloth.iter().map(Ramp::of_limit).collect(),
            grips: Grips::default(),
        })
    }

    /// Takes what a user holds, bodies off their paths too.
    pub fn take(&mut self, grips: Grips) {
        self.grips = grips;
        self.follow_bodies();
    }

    /// Moves a body off its path; see [`Grips::shift_body`].
    pub fn shift_body(&mut self, shift: BodyShift) {
        self.grips.shift_body(shift);
        self.follow_bodies();
    }

    /// Tells the vertices of a body; see [`Grips::form_body`].
    pub fn form_body(&mut self, form: BodyForm) {
        self.grips.form_body(form);
        self.follow_bodies();
    }

    fn follow_bodies(&mut self) {
        self.bodies.take(self.grips.body_shifts(), self.grips.body_forms());
    }

    /// Displaces what holds a cloth [m], as the state has the cloth displaced.
    pub fn translate(&mut self, model: &Model, cloth: usize, offset: DVec3) {
        self.grips.translate(&model.cloths[cloth].particles(), |group| model.pins[group].cloth == cloth, offset);
    }

    /// Has all bodies where they were sent: a time that is set knows nothing of their ways.
    pub fn settle_bodies(&mut self) {
        for form in self.grips.body_forms().to_vec() {
            let shift = self.grips.body_shifts().iter().find(|shift| shift.body == form.body).copied();
            self.grips.form_body(BodyForm::constant(form.body, form.to));
            shift.into_iter().for_each(|shift| self.grips.shift_body(shift));
        }
        self.grips.body_shifts().to_vec().into_iter().for_each(|shift| self.grips.shift_body(shift.settled()));
        self.follow_bodies();
    }

    /// The largest rate at which the air slows a particle [1/s].
    #[must_use]
    pub fn drag(&self, rates: &Rates) -> f64 {
        let wind = self.air.as_ref().map_or(0.0, |air| {
            let [without_lift, with_lift] = rates.wind;
            f64::from(air.density) * air.greatest_speed * if air.law == WindLaw::DragLift { with_lift } else { without_lift }
        });
        rates.still_air + wind
    }
}
