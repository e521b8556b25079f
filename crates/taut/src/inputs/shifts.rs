//! Bodies that are moved off their paths.

use glam::DVec3;

/// How far a body is off its path: on a straight line from one place to another, and there from then on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyShift {
    /// Which body, in the order of the model.
    pub body: usize,
    /// How far it is off its path at first, and in the end [m].
    pub from: DVec3,
    /// See `from`.
    pub to: DVec3,
    /// When it begins to go, and when it is there [s].
    pub start: f64,
    /// See `start`.
    pub arrival: f64,
}

impl BodyShift {
    /// A body that stays so far off its path [m].
    #[must_use]
    pub fn constant(body: usize, offset: DVec3) -> Self {
        Self { body, from: offset, to: offset, start: 0.0, arrival: 0.0 }
    }

    /// How far it is off its path at `time` [s].
    #[must_use]
    pub fn at(&self, time: f64) -> DVec3 {
        if time >= self.arrival {
            self.to
        } else if time <= self.start {
            self.from
        } else {
            self.from.lerp(self.to, (time - self.start) / (self.arrival - self.start))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shift_goes_straight_and_stays() {
        let shift = BodyShift { body: 0, from: DVec3::X, to: DVec3::Y, start: 1.0, arrival: 3.0 };
        for (time, expected) in [(0.0, DVec3::X), (1.5, DVec3::new(0.75, 0.25, 0.0)), (3.0, DVec3::Y), (9.0, DVec3::Y)] {
            assert!((shift.at(time) - expected).length() < 1e-12, "{time}");
        }
        assert_eq!(BodyShift::constant(0, DVec3::Z).at(7.0), DVec3::Z);
    }
}
