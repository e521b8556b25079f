//! What would cross something goes only a part of its way, and what hangs on it.
//!
//! A step is shortened towards where it starts. What is worn is carried along: pins and all bodies that it is near go the same way, and in
//! many steps that is most of its own. It is shortened towards where that would take it: one fold that is stuck would hold back all of the
//! cloth and its pins otherwise, and then the bodies, which do not go through what is held.

use glam::Vec3;

use super::super::impulse::take_back;
use super::super::motion::{lost, ways};
use super::super::unit::Unit;
use super::Touch;
use crate::geometry::{Pool, Vectors};
use crate::model::Model;
use crate::schedule::Stride;
use crate::state::State;

/// So often a step is shortened where it would cross something, and what is carried along so often again, from where everything starts; from
/// some round on by half as much again. Then everything stays.
const SHORTENED: usize = 12;
const HALVED: usize = 6;

impl Touch {
    /// Finds what carries each cloth that touches something along: the way of its pins, if that is the same for all and all bodies that are
    /// near go it.
    pub(super) fn find_frames(&mut self, units: &[Unit], model: &Model, state: &State) {
        let Self { contact, descents, frames, stopped, led, .. } = self;
        let particles = model.particle_count();
        let near = || contact.rows.vertices().iter().filter_map(|&vertex| (vertex as usize).checked_sub(particles));
        frames.clear();
        frames.resize(model.cloths.len(), Vec3::ZERO);
        if contact.rows.is_empty() {
            return;
        }
        for (unit, descent) in units.iter().zip(descents) {
            let pins = descent.frame.filter(|frame| *frame != Vec3::ZERO && stopped.is_empty());
            let all_go = |way: &Vec3| {
                let mut bodies = model.bodies.list.iter().filter(|body| near().any(|vertex| body.vertices.contains(&vertex)));
                bodies.all(|body| led.goes_along(body, state, way.as_dvec3()))
            };
            frames[unit.index()] = pins.filter(all_go).unwrap_or_default();
        }
    }

    /// Where a cloth is shortened towards, and what its velocities are seen from then, as the certificate of its limit takes them.
    pub(super) fn frames_of(&self, unit: &Unit) -> [Option<Vec3>; 2] {
        let frame = self.frames[unit.index()];
        [Some(frame).filter(|frame| *frame != Vec3::ZERO), Some(frame)]
    }

    /// Shortens the ways of what would cross, until nothing does. Returns the part of the motion that was lost [1].
    pub(super) fn shorten(
        &mut self,
        units: &mut [Unit],
        stride: Stride<'_>,
        state: &mut State,
        ends: &mut Vectors,
        pool: &Pool,
    ) -> f64 {
        let (model, step) = (stride.model, stride.plan.length as f32);
        let all: Vec<f64> = ways(model, &state.positions, ends).collect();
        let before = ends.clone();
        let is_carried = self.frames.iter().any(|frame| *frame != Vec3::ZERO);
        for round in 0..if is_carried { 2 * SHORTENED } else { SHORTENED } {
            if round == SHORTENED {
                self.frames.fill(Vec3::ZERO);
            }
            self.contact.cuts.shorten(if round % SHORTENED < HALVED { 1.0 } else { 0.5 });
            self.shorten_cloth(units, model, state, ends, step);
            let Self { contact, frames, led, .. } = self;
            led.shorten(stride, state, &contact.cuts.factors[model.particle_count()..], frames);
            for unit in units.iter_mut() {
                unit.certify(stride, state, ends, self.frames_of(unit), pool);
            }
            self.contact.end(model, &state.origins, ends, &self.led.ends, pool);
            self.contact.certify(pool);
            if self.contact.cuts.list.is_empty() {
                let mut sum = 0.0;
                for ((way, all), least) in ways(model, &before, ends).zip(&all).zip(&mut self.lost) {
                    *least = least.max(lost(way, *all));
                    sum += way;
                }
                return lost(sum, all.iter().sum());
            }
        }
        // Where everything is, nothing crosses.
        for particle in 0..ends.len() {
            let (start, end) = (state.positions.get(particle), ends.get(particle));
            take_back(&mut state.velocities, particle, start - end, Some(Vec3::ZERO), step);
            ends.set(particle, start);
        }
        self.led.stop(state);
        self.lost.fill(1.0);
        1.0
    }

    /// Lets the particles of what would cross go only such a part of their ways.
    fn shorten_cloth(&self, units: &[Unit], model: &Model, state: &mut State, ends: &mut Vectors, step: f32) {
        let Self { contact, where_is, frames, .. } = self;
        for &vertex in contact.cuts.shortened.iter().filter(|&&vertex| (vertex as usize) < model.particle_count()) {
            let (vertex, factor) = (vertex as usize, contact.cuts.factors[vertex as usize]);
            let frame = where_is.of(vertex).map_or(Vec3::ZERO, |(unit, _)| frames[units[unit].index()]);
            let (start, end) = (state.positions.get(vertex) + frame, ends.get(vertex));
            let now = start + (end - start) * factor as f32;
            take_back(&mut state.velocities, vertex, now - end, Some(frame), step);
            ends.set(vertex, now);
        }
    }
}
