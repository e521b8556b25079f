//! Simple flows that are superposed on the wind, after Ling, Damodaran & Gay 1994 and the flow primitives of Wejchert &
//! Haumann 1991.
//!
//! Outside of its core each is an exact solution for air without friction: free of divergence and of rotation. Inside, the
//! speed falls to zero in proportion to the distance, so that nothing is singular and no speed exceeds that at the core.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use crate::scene::Flow;

/// Air that turns round a straight line (Rankine's vortex): `V = Gamma / (2 pi) (A x D) / max(|D|, core)^2`, A being the
/// direction of the line and D the way from the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vortex {
    /// A point on the line [m].
    pub centre: DVec3,
    /// Its direction, a unit vector.
    pub axis: Vec3,
    /// Gamma / (2 pi) [m^2/s].
    pub strength: f32,
    /// [m]
    pub core: f32,
}

/// Air that comes out of a point, or goes into it: `V = Q / (4 pi) D / max(|D|, core)^3`, D being the way from the point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outflow {
    /// The point [m].
    pub centre: DVec3,
    /// Q / (4 pi) [m^3/s].
    pub strength: f32,
    /// [m]
    pub core: f32,
}

impl Vortex {
    /// Velocity of the air at a point that is so far from the centre [m/s].
    #[inline(always)]
    #[must_use]
    pub fn velocity(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let Vec3 { x: a, y: b, z: c } = self.axis;
        // A x D is as long as the way from the line.
        let (u, v, w) = (b * z - c * y, c * x - a * z, a * y - b * x);
        let square = u * u + v * v + w * w;
        let core = self.core * self.core;
        let factor = self.strength / if square > core { square } else { core };
        [u * factor, v * factor, w * factor]
    }
}

impl Outflow {
    /// Velocity of the air at a point that is so far from the centre [m/s].
    #[inline(always)]
    #[must_use]
    pub fn velocity(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let distance = (x * x + y * y + z * z).sqrt();
        let radius = if distance > self.core { distance } else { self.core };
        let factor = self.strength / (radius * radius * radius);
        [x * factor, y * factor, z * factor]
    }
}

/// Flows put together, of each kind.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Flows {
    /// Vortices.
    pub vortices: Vec<Vortex>,
    /// Sources and sinks.
    pub outflows: Vec<Outflow>,
}

impl Flows {
    /// Sorts flows by kind; the uniform ones are added up, and so are the greatest speeds of the others [m/s].
    pub(super) fn new(flows: impl Iterator<Item = Flow>) -> (Self, DVec3, f64) {
        let (mut sorted, mut uniform, mut greatest) = (Self::default(), DVec3::ZERO, 0.0);
        for flow in flows {
            match flow {
                Flow::Uniform(velocity) => uniform += DVec3::from_array(velocity),
                Flow::Vortex { centre, axis, circulation, core } => {
                    let strength = circulation / TAU;
                    greatest += strength.abs() / core;
                    let (centre, axis) = (DVec3::from_array(centre), DVec3::from_array(axis).normalize().as_vec3());
                    sorted.vortices.push(Vortex { centre, axis, strength: strength as f32, core: core as f32 });
                }
                Flow::Source { centre, flow, core } => {
                    let strength = flow / (4.0 * PI);
                    greatest += strength.abs() / (core * core);
                    let centre = DVec3::from_array(centre);
                    sorted.outflows.push(Outflow { centre, strength: strength as f32, core: core as f32 });
                }
            }
        }
        (sorted, uniform, greatest)
    }
}
