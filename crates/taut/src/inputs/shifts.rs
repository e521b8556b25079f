//! Bodies that are moved off their paths, and bodies whose vertices are told.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DQuat, DVec3};

use crate::geometry::turn_about;

/// How far a body is off its path: turned about its middle, and then displaced. It goes on a straight line from one place to another, turns
/// evenly, and is there from then on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyShift {
    /// Which body, in the order of the model.
    pub body: usize,
    /// How far it is off its path at first, and in the end [m].
    pub from: DVec3,
    /// See `from`.
    pub to: DVec3,
    /// How it is turned at first.
    pub turned: DQuat,
    /// How it turns from there: the axis times the angle [rad].
    pub turn: DVec3,
    /// When it begins to go, and when it is there [s].
    pub start: f64,
    /// See `start`.
    pub arrival: f64,
}

impl BodyShift {
    /// A body that stays so far off its path [m].
    #[must_use]
    pub fn constant(body: usize, offset: DVec3) -> Self {
        let (turned, turn) = (DQuat::IDENTITY, DVec3::ZERO);
        Self { body, from: offset, to: offset, turned, turn, start: 0.0, arrival: 0.0 }
    }

    /// The same when it has arrived.
    #[must_use]
    pub fn settled(self) -> Self {
        Self { turned: self.rotation(self.arrival), ..Self::constant(self.body, self.to) }
    }

    /// How far it is off its path at `time` [s].
    #[must_use]
    pub fn at(&self, time: f64) -> DVec3 {
        match part(self.start, self.arrival, time) {
            0.0 => self.from,
            1.0 => self.to,
            part => self.from.lerp(self.to, part),
        }
    }

    /// How it is turned at `time` [s].
    #[must_use]
    pub fn rotation(&self, time: f64) -> DQuat {
        let angle = self.turn.length();
        if angle == 0.0 {
            return self.turned;
        }
        let degrees = angle * part(self.start, self.arrival, time) * (180.0 / PI);
        (turn_about(self.turn / angle, degrees) * self.turned).normalize()
    }

    /// How far it turns between two times [s]: the axis times the angle [rad].
    #[must_use]
    pub fn turned_between(&self, times: [f64; 2]) -> DVec3 {
        let [from, to] = times.map(|time| part(self.start, self.arrival, time));
        self.turn * (to - from)
    }
}

/// The part of a way that is done at `time` [1].
fn part(start: f64, arrival: f64, time: f64) -> f64 {
    if time >= arrival { 1.0 } else { ((time - start) / (arrival - start)).max(0.0) }
}

/// A body whose vertices are told in place of its path: each goes in a straight line from one place to another, and stays there.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyForm {
    /// Which body, in the order of the model.
    pub body: usize,
    /// Where its vertices are at first, and in the end, in the world [m].
    pub from: Arc<[DVec3]>,
    /// See `from`.
    pub to: Arc<[DVec3]>,
    /// When they begin to go, and when they are there [s].
    pub start: f64,
    /// See `start`.
    pub arrival: f64,
}

impl BodyForm {
    /// A body whose vertices stay where they are [m].
    #[must_use]
    pub fn constant(body: usize, places: Arc<[DVec3]>) -> Self {
        Self { body, from: Arc::clone(&places), to: places, start: 0.0, arrival: 0.0 }
    }

    /// Writes where they are at `time` [s].
    pub fn write(&self, time: f64, places: &mut [DVec3]) {
        let part = part(self.start, self.arrival, time);
        if part == 1.0 {
            return places.copy_from_slice(&self.to);
        }
        for (place, (from, to)) in places.iter_mut().zip(self.from.iter().zip(&*self.to)) {
            *place = from.lerp(*to, part);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shift_goes_straight_and_stays() {
        let shift = BodyShift { from: DVec3::X, to: DVec3::Y, start: 1.0, arrival: 3.0, ..BodyShift::constant(0, DVec3::ZERO) };
        for (time, expected) in [(0.0, DVec3::X), (1.5, DVec3::new(0.75, 0.25, 0.0)), (3.0, DVec3::Y), (9.0, DVec3::Y)] {
            assert!((shift.at(time) - expected).length() < 1e-12, "{time}");
        }
        assert_eq!(BodyShift::constant(0, DVec3::Z).at(7.0), DVec3::Z);
        assert_eq!(shift.settled(), BodyShift::constant(0, DVec3::Y));
    }

    #[test]
    fn a_body_turns_evenly_from_how_it_was_turned() {
        let quarter = DQuat::from_rotation_x(0.5 * PI);
        let shift =
            BodyShift { turned: quarter, turn: DVec3::Z * PI, start: 1.0, arrival: 3.0, ..BodyShift::constant(0, DVec3::ZERO) };
        for (time, expected) in [(0.5, DVec3::Z), (2.0, DVec3::Z), (9.0, DVec3::Z)] {
            assert!((shift.rotation(time) * DVec3::Y - expected).length() < 1e-12, "{time}");
        }
        for (time, expected) in [(0.5, DVec3::X), (2.0, DVec3::Y), (9.0, -DVec3::X)] {
            assert!((shift.rotation(time) * DVec3::X - expected).length() < 1e-12, "{time}");
        }
        assert_eq!(shift.turned_between([0.0, 2.0]), DVec3::Z * 0.5 * PI);
        assert_eq!(shift.settled().rotation(0.0), shift.rotation(3.0));
    }

    #[test]
    fn vertices_that_are_told_go_straight_and_stay() {
        let (from, to) = (Arc::from([DVec3::ZERO]), Arc::from([DVec3::X]));
        let form = BodyForm { body: 0, from, to, start: 1.0, arrival: 3.0 };
        for (time, expected) in [(0.0, 0.0), (1.5, 0.25), (3.0, 1.0), (9.0, 1.0)] {
            let mut places = [DVec3::NAN];
            form.write(time, &mut places);
            assert!((places[0] - DVec3::X * expected).length() < 1e-12, "{time}");
        }
    }
}
