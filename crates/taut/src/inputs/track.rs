//! A vector that may change with time.

use glam::DVec3;

use crate::scene::{Cloth, Keyframe, Turn};

/// Straight lines between keyframes, constant after the last.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// At the time 0, and always if there are no keyframes.
    start: DVec3,
    keyframes: Vec<Keyframe>,
}

impl Track {
    /// What never changes.
    #[must_use]
    pub fn constant(value: DVec3) -> Self {
        Self { start: value, keyframes: Vec::new() }
    }

    /// From `start` at the time 0 through keyframes, whose times rise from above 0 [s].
    #[must_use]
    pub fn new(start: DVec3, keyframes: &[Keyframe]) -> Self {
        Self { start, keyframes: keyframes.to_vec() }
    }

    /// The value at `time` [s].
    #[must_use]
    pub fn at(&self, time: f64) -> DVec3 {
        let mut before = (0.0, self.start);
        for &Keyframe(at, value) in &self.keyframes {
            let value = DVec3::from_array(value);
            if time < at {
                return before.1.lerp(value, (time - before.0) / (at - before.0));
            }
            before = (at, value);
        }
        before.1
    }

    /// The greatest length that it ever has: straight lines are nowhere longer than at their ends.
    #[must_use]
    pub fn greatest(&self) -> f64 {
        self.keyframes.iter().map(|keyframe| DVec3::from_array(keyframe.1).length()).fold(self.start.length(), f64::max)
    }

    /// The times at which its direction changes [s].
    pub fn times(&self) -> impl Iterator<Item = f64> {
        self.keyframes.iter().map(|keyframe| keyframe.0)
    }
}

/// A number that changes along straight lines between keyframes.
#[derive(Debug, Clone, PartialEq)]
pub struct Ramp {
    start: f64,
    /// Times [s] and values.
    keyframes: Vec<(f64, f64)>,
}

impl Ramp {
    /// The strain limit of a cloth.
    pub(super) fn of_limit(cloth: &Cloth) -> Self {
        let keyframes = cloth.strain_limit_keyframes.iter().map(|key| (key.0, key.1)).collect();
        Self { start: cloth.material().strain_limit, keyframes }
    }

    /// The angle of a turn [degrees].
    pub(super) fn of_angle(turn: &Turn) -> Self {
        Self { start: 0.0, keyframes: turn.angle.iter().map(|key| (key.0, key.1)).collect() }
    }

    /// Whether it ever changes.
    #[must_use]
    pub fn changes(&self) -> bool {
        !self.keyframes.is_empty()
    }

    /// Its keyframes: times [s] and values.
    pub(super) fn keyframes(&self) -> impl Iterator<Item = (f64, f64)> {
        self.keyframes.iter().copied()
    }

    /// The value at `time` [s].
    #[must_use]
    pub fn at(&self, time: f64) -> f64 {
        let mut before = (0.0, self.start);
        for &(at, value) in &self.keyframes {
            if time < at {
                return before.1 + (value - before.1) * ((time - before.0) / (at - before.0));
            }
            before = (at, value);
        }
        before.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keyframes_are_joined_by_straight_lines_and_held_after_the_last() {
        let keyframes = [Keyframe(1.0, [2.0, 0.0, 0.0]), Keyframe(3.0, [2.0, 4.0, 0.0])];
        let track = Track::new(DVec3::ZERO, &keyframes);
        for (time, expected) in [(0.0, [0.0, 0.0]), (0.25, [0.5, 0.0]), (1.0, [2.0, 0.0]), (2.0, [2.0, 2.0]), (9.0, [2.0, 4.0])] {
            let at = track.at(time);
            assert!((at - DVec3::new(expected[0], expected[1], 0.0)).length() < 1e-12, "{time}: {at}");
        }
    }
}
