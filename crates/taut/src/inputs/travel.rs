//! The way of what keyframes move, a body or a pin: first it turns about a line, then it is displaced.

use glam::{DQuat, DVec3};

use super::track::{Ramp, Track};
use crate::geometry::turn_about;
use crate::scene::{Keyframe, Turn};

/// Between two keyframes of a turn distances are looked at after so much of it each [degrees] ..
const FINEST: f64 = 3.0;
/// .. but not more often than this: further turns bring the same places again.
const MOST_LOOKS: f64 = 1000.0;

/// First a turn, then a displacement [m].
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Travel {
    turning: Option<Turning>,
    way: Track,
}

/// A turn about a fixed line.
#[derive(Debug, Clone, PartialEq)]
struct Turning {
    /// Its direction, of length 1.
    axis: DVec3,
    /// A point of it [m].
    point: DVec3,
    /// [degrees]
    angle: Ramp,
}

/// Where a travel has led at some time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pose {
    /// A point of the line, and the turn; none where nothing has turned.
    turned: Option<(DVec3, DQuat)>,
    way: DVec3,
}

impl Travel {
    pub fn new(turn: Option<&Turn>, keyframes: &[Keyframe]) -> Self {
        let turning = turn.filter(|turn| !turn.angle.is_empty()).map(|turn| Turning {
            axis: DVec3::from_array(turn.axis).normalize(),
            point: DVec3::from_array(turn.point),
            angle: Ramp::of_angle(turn),
        });
        Self { turning, way: Track::new(DVec3::ZERO, keyframes) }
    }

    /// Whether there is no keyframe.
    pub fn is_still(&self) -> bool {
        self.turning.is_none() && self.way.times().next().is_none()
    }

    /// Where it has led at `time` [s].
    pub fn at(&self, time: f64) -> Pose {
        let turned = self.turning.as_ref().and_then(|turning| {
            let angle = turning.angle.at(time);
            // What has not turned is where it was to the last bit.
            (angle != 0.0).then(|| (turning.point, turn_about(turning.axis, angle)))
        });
        Pose { turned, way: self.way.at(time) }
    }

    /// How far it turns between two times [s]: its axis times the angle [rad].
    pub fn turned(&self, [from, to]: [f64; 2]) -> DVec3 {
        let turned =
            |turning: &Turning| turning.axis * ((turning.angle.at(to) - turning.angle.at(from)) * (std::f64::consts::PI / 180.0));
        self.turning.as_ref().map_or(DVec3::ZERO, turned)
    }

    /// Times among which the greatest distance is, nearly, from what travels otherwise [s]. On straight lines it is greatest at
    /// a keyframe.
    pub fn moments(&self) -> Vec<f64> {
        let mut moments: Vec<f64> = self.way.times().collect();
        let mut before = (0.0, 0.0);
        for (time, angle) in self.turning.iter().flat_map(|turning| turning.angle.keyframes()) {
            let looks = ((angle - before.1).abs() / FINEST).ceil().clamp(1.0, MOST_LOOKS) as u32;
            let part = |look: u32| f64::from(look) / f64::from(looks);
            moments.extend((1..looks).map(|look| before.0 + (time - before.0) * part(look)));
            moments.push(time);
            before = (time, angle);
        }
        moments
    }
}

impl Pose {
    /// Where this is of what was at `place`, both from `origin`, a place in the world [m].
    pub fn of(&self, place: DVec3, origin: DVec3) -> DVec3 {
        let turned = match self.turned {
            Some((point, turn)) => {
                let point = point - origin;
                point + turn * (place - point)
            }
            None => place,
        };
        turned + self.way
    }
}
