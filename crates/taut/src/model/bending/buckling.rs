//! Type 2 springs after Choi & Ko 2002: under compression the cloth between two particles buckles at once.
//!
//! It is taken for an arc of constant curvature and of the length L it has at rest. With its half angle u, the distance of its
//! ends is `L sin(u) / u`, its curvature `2 u / L`, its energy `k_b (2 u / L)^2 L / 2`. The derivative of the energy by the
//! distance is the force, `f_b = 4 k_b / L^2 * u^2 / (cos u - sin(u) / u)`. The polynomial below follows it. The force does not
//! begin at zero: until an elastic spring of stiffness c_b pushes as much, the cloth is compressed and does not buckle.

use crate::geometry::power;

/// `u^2 / (cos u - sin(u) / u)` for the compression `t = 1 - sin(u) / u`, within 0.7 %: -3, then the powers of t.
const CURVE: [f64; 6] = [-3.0, -2.335, 5.055, -24.640, 35.628, -20.509];
/// The curve is nowhere steeper.
const STEEPEST: f64 = 27.0;

/// A type 2 spring as one of its ends sees it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Buckling {
    /// The particle at the other end.
    pub other: u32,
    /// L [m].
    pub rest: f32,
    /// 4 k_b / L^2 [N].
    pub scale: f32,
    /// c_b L: what the elastic spring would push at distance zero [N].
    pub elastic: f32,
    /// Compression (L - distance) / L at which the cloth buckles [1].
    pub knee: f32,
}

impl Buckling {
    /// A spring of length L [m] with bending stiffness k_b [N m^2] that is compressed with c_b [N/m] before it buckles.
    pub(in crate::model) fn new(other: u32, rest: f64, bending: f64, compression: f64) -> Self {
        let (scale, elastic) = (4.0 * bending / (rest * rest), compression * rest);
        // The elastic push grows from zero, the other one lies above it until they meet, or everywhere.
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if elastic * middle < -scale * curve(middle) { low = middle } else { high = middle }
        }
        Self { other, rest: rest as f32, scale: scale as f32, elastic: elastic as f32, knee: high as f32 }
    }

    /// Pull of the spring at a distance [N]: negative, since it pushes; zero if it is not compressed.
    #[inline]
    #[must_use]
    pub fn pull(&self, distance: f32) -> f32 {
        let t = 1.0 - distance / self.rest;
        if t <= 0.0 {
            return 0.0;
        }
        if t < self.knee {
            return -self.elastic * t;
        }
        let [a, b, c, d, e, f] = CURVE.map(|factor| factor as f32);
        self.scale * (a + t * (b + t * (c + t * (d + t * (e + t * f)))))
    }

    /// Derivative of the pull by the distance [N/m]; none where it is not compressed.
    #[must_use]
    pub fn slope(&self, distance: f64) -> f64 {
        let rest = f64::from(self.rest);
        let t = 1.0 - distance / rest;
        if t <= 0.0 {
            return 0.0;
        }
        if t < f64::from(self.knee) {
            return f64::from(self.elastic) / rest;
        }
        let [_, b, c, d, e, f] = CURVE;
        -f64::from(self.scale) / rest * (b + t * (2.0 * c + t * (3.0 * d + t * (4.0 * e + t * 5.0 * f))))
    }

    /// Energy at a distance [J]: the integral of the pull.
    #[must_use]
    pub fn energy(&self, distance: f32) -> f64 {
        let rest = f64::from(self.rest);
        let (t, knee) = (1.0 - f64::from(distance) / rest, f64::from(self.knee));
        let (compressed, buckled) = (t.clamp(0.0, knee), t.clamp(knee, 1.0));
        let elastic = 0.5 * f64::from(self.elastic) * compressed * compressed;
        rest * (elastic - f64::from(self.scale) * (integral(buckled) - integral(knee)))
    }

    /// No derivative of the pull by the distance is larger [N/m].
    pub(super) fn steepest(&self) -> f64 {
        f64::from(self.elastic).max(STEEPEST * f64::from(self.scale)) / f64::from(self.rest)
    }
}

fn curve(t: f64) -> f64 {
    CURVE.iter().rev().fold(0.0, |sum, factor| sum * t + factor)
}

fn integral(t: f64) -> f64 {
    (1..).zip(CURVE).map(|(exponent, factor)| factor * power(t, exponent) / f64::from(exponent)).sum()
}
