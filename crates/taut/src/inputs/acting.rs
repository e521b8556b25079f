//! What acts from outside, as one number: whether a world that sleeps may go on doing so.

use glam::DVec3;
use xxhash_rust::xxh3::Xxh3;

use super::Inputs;
use crate::model::Model;

impl Inputs {
    /// A number for all that acts in a step between two times [s]; none where something changes in it, or a hand leads. Other numbers mean that
    /// something is different. `off` is how far each pin group is off its path [m]; `bodies` is workspace, and comes back as the places of the
    /// vertices of bodies at the end [m].
    #[must_use]
    pub fn acting(
        &self,
        model: &Model,
        [start, end]: [f64; 2],
        off: impl Iterator<Item = DVec3>,
        bodies: &mut [DVec3],
    ) -> Option<u64> {
        let Self { gravity, air, pins, bodies: paths, limits, grips } = self;
        // Hands and what is held may be slower than what counts as still.
        if !grips.leads().is_empty() || grips.held().any(|(_, target)| target.arrival > end) {
            return None;
        }
        let mut told = Told(Xxh3::new());
        told.vector(gravity.at(end));
        if let Some(air) = air {
            // Gusts travel with the wind.
            if air.waves.iter().any(|wave| wave.amplitude.length() * air.gusts(end) > 0.0) {
                return None;
            }
            told.vector(air.velocity(end).as_dvec3());
            told.number(f64::from(air.density));
            told.number(f64::from(air.model as u8));
            told.number(f64::from(air.law as u8));
            for vortex in &air.flows.vortices {
                told.vector(vortex.centre);
                told.vector(vortex.axis.as_dvec3());
                told.number(f64::from(vortex.strength));
                told.number(f64::from(vortex.core));
            }
            for outflow in &air.flows.outflows {
                told.vector(outflow.centre);
                told.number(f64::from(outflow.strength));
                told.number(f64::from(outflow.core));
            }
        }
        limits.iter().for_each(|limit| told.number(limit.at(end)));
        for (group, all) in model.pins.iter().enumerate() {
            let places = pins.places(model, group, end);
            (0..all.start.len()).for_each(|index| told.vector(places.of(index)));
        }
        off.for_each(|way| told.vector(way));
        if (0..model.bodies.list.len()).any(|body| paths.turned(body, [start, end]) != DVec3::ZERO) {
            return None;
        }
        paths.places(&model.bodies, end, bodies);
        bodies.iter().for_each(|place| told.vector(*place));
        for (particle, target) in grips.held() {
            told.number(f64::from(particle));
            told.vector(target.place);
        }
        for shift in grips.shifts() {
            told.number(shift.group as f64);
            told.vector(shift.target);
            told.number(shift.speed);
        }
        Some(told.0.digest())
    }
}

/// What was told so far.
struct Told(Xxh3);

impl Told {
    fn number(&mut self, number: f64) {
        self.0.update(&number.to_le_bytes());
    }

    fn vector(&mut self, vector: DVec3) {
        vector.to_array().into_iter().for_each(|number| self.number(number));
    }
}
