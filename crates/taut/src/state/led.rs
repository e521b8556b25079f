//! Bodies that a host sends somewhere: they go on from where they are, which may be behind their paths.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;

use super::State;
use crate::geometry::{turn_about, turn_between};
use crate::inputs::{BodyForm, BodyShift, Inputs};
use crate::model::Model;

impl State {
    /// Sends a body off its path [m] and turns it in a time [s], at once if that is zero. The turn is an axis times an angle [rad]; without
    /// one the body stays turned as it is.
    ///
    /// # Panics
    /// There is no such body.
    pub fn pose_body(&mut self, model: &Model, inputs: &mut Inputs, body: usize, to: DVec3, rotation: Option<DVec3>, over: f64) {
        let (from, start) = (self.body_offset(model, inputs, body), self.time());
        let turned = inputs.bodies.rotation_of(body, start);
        let asked = |rotation: DVec3| turn_about(rotation.normalize_or_zero(), rotation.length() * (180.0 / PI));
        let goal = rotation.map_or(turned, asked);
        if over > 0.0 {
            let turn = turn_between(turned, goal);
            return inputs.shift_body(BodyShift { body, from, to, turned, turn, start, arrival: start + over });
        }
        inputs.shift_body(BodyShift { turned: goal, ..BodyShift::constant(body, to) });
        self.put_body(model, inputs, body);
    }

    /// Sends the vertices of a body to places [m] in a time [s]; at once if that is zero.
    ///
    /// # Panics
    /// There is no such body, or it has another number of vertices.
    pub fn form_body(&mut self, model: &Model, inputs: &mut Inputs, body: usize, to: Arc<[DVec3]>, over: f64) {
        let start = self.time();
        if over > 0.0 {
            let from = self.bodies[model.bodies.list[body].vertices.clone()].into();
            return inputs.form_body(BodyForm { body, from, to, start, arrival: start + over });
        }
        inputs.form_body(BodyForm::constant(body, to));
        self.put_body(model, inputs, body);
    }

    /// How far a body is off its path [m]: the mean of its vertices.
    ///
    /// # Panics
    /// There is no such body.
    #[must_use]
    pub fn body_offset(&self, model: &Model, inputs: &Inputs, body: usize) -> DVec3 {
        let places = self.paths(model, inputs);
        let own = model.bodies.list[body].vertices.clone();
        let count = own.len().max(1) as f64;
        let lag: DVec3 = own.map(|vertex| self.bodies[vertex] - places[vertex]).sum();
        inputs.bodies.shift_of(body, self.time()) + lag / count
    }

    /// Has a body where it shall be now, whatever lies between.
    fn put_body(&mut self, model: &Model, inputs: &Inputs, body: usize) {
        let places = self.paths(model, inputs);
        let own = model.bodies.list[body].vertices.clone();
        self.bodies[own.clone()].copy_from_slice(&places[own]);
    }

    /// Where the paths of all bodies are now [m].
    fn paths(&self, model: &Model, inputs: &Inputs) -> Vec<DVec3> {
        let mut places = self.bodies.clone();
        inputs.bodies.places(&model.bodies, self.time(), &mut places);
        places
    }
}
