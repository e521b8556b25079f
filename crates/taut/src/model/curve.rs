//! Springs whose force follows a measured curve (after Breen, House & Wozny 1994).

use super::part::{Part, SpringSeed};
use super::{Adjacency, SpringKind};
use crate::geometry::power;
use crate::scene::{self, Cloth, FilterKind};

/// Straight pieces through the origin, as a sum of ramps: `y = slope x + sum rise (x - at)` over the ramps with `x > at`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curve {
    /// At the origin; below it, too, if the curve is not odd.
    slope: f32,
    /// Where the slope changes, and by how much.
    ramps: Vec<[f32; 2]>,
    /// Whether it is turned round the origin for x < 0, as shear is.
    odd: bool,
}

impl Curve {
    /// A curve as the scene gives it, up to `limit`; from there, or from its last point, it goes straight on.
    pub(super) fn new(curve: &scene::Curve, limit: f64, odd: bool) -> Self {
        let slopes = curve.0.windows(2).map(|pair| (pair[0][0], (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0])));
        let slopes: Vec<(f64, f64)> = slopes.take_while(|(at, _)| *at < limit).collect();
        let ramps = slopes.windows(2).map(|pair| [pair[1].0 as f32, (pair[1].1 - pair[0].1) as f32]).collect();
        Self { slope: slopes[0].1 as f32, ramps, odd }
    }

    /// The curve at x.
    #[inline]
    #[must_use]
    pub fn value(&self, x: f32) -> f32 {
        let along = if self.odd { x.abs() } else { x };
        let sum = self.ramps.iter().fold(self.slope * along, |sum, [at, rise]| sum + rise * (along - at).max(0.0));
        if self.odd && x < 0.0 { -sum } else { sum }
    }

    /// Its integral from 0 to x.
    #[must_use]
    pub fn integral(&self, x: f32) -> f64 {
        let along = f64::from(if self.odd { x.abs() } else { x });
        let part = |at: f32, slope: f32| 0.5 * f64::from(slope) * power((along - f64::from(at)).max(0.0), 2);
        let first = 0.5 * f64::from(self.slope) * along * along;
        self.ramps.iter().fold(first, |sum, [at, rise]| sum + part(*at, *rise))
    }

    /// Value over x: the stiffness of a straight spring that would pull as much; at the origin the slope.
    #[inline]
    #[must_use]
    pub fn secant(&self, x: f32) -> f32 {
        // Of two subnormal numbers there is no quotient worth having.
        if x.abs() > f32::MIN_POSITIVE { self.value(x) / x } else { self.slope }
    }

    /// No slope of it is larger.
    #[must_use]
    pub fn steepest(&self) -> f64 {
        let slopes = self.ramps.iter().scan(f64::from(self.slope), |slope, [_, rise]| {
            *slope += f64::from(*rise);
            Some(*slope)
        });
        slopes.fold(f64::from(self.slope), f64::max)
    }
}

/// How the force of a spring follows from a curve C: `F = breadth C(gain (|X_uv| / L - 1))`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Follows {
    /// Which of the model's curves.
    pub curve: u32,
    /// Breadth of the cloth that the spring stands for [m]; 1 in a network.
    pub breadth: f32,
    /// From the strain of the spring to what the curve is over [1].
    pub gain: f32,
}

impl Follows {
    /// No slope of the force of a spring of the rest length L by its length is larger [N/m].
    pub(super) fn steepest(self, curve: &Curve, rest: f64) -> f64 {
        f64::from(self.breadth) * f64::from(self.gain) / rest * curve.steepest()
    }
}

/// A spring with a curve as one of its ends sees it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CurvedLink {
    /// The particle at the other end.
    pub other: u32,
    /// L [m].
    pub rest: f32,
    /// Its curve.
    pub follows: Follows,
}

/// The springs that follow curves, of all cloths.
#[derive(Debug, Default)]
pub struct CurvedSprings {
    /// The curves.
    pub curves: Vec<Curve>,
    /// The springs around each particle.
    pub links: Adjacency<CurvedLink>,
}

impl CurvedSprings {
    /// Pull of a spring of a length [N].
    #[inline]
    #[must_use]
    pub fn pull(&self, link: &CurvedLink, length: f32) -> f32 {
        let Follows { curve, breadth, gain } = link.follows;
        breadth * self.curves[curve as usize].value(gain * (length / link.rest - 1.0))
    }

    /// Energy of a spring of a length [J]: the integral of its pull.
    #[must_use]
    pub fn energy(&self, link: &CurvedLink, length: f32) -> f64 {
        let Follows { curve, breadth, gain } = link.follows;
        let integral = self.curves[curve as usize].integral(gain * (length / link.rest - 1.0));
        f64::from(breadth) * f64::from(link.rest) / f64::from(gain) * integral
    }
}

/// The curves of one cloth, by the kind of spring.
#[derive(Default)]
pub(super) struct CurvesOfCloth {
    warp: Option<u32>,
    weft: Option<u32>,
    shear: Option<u32>,
    network: bool,
}

impl CurvesOfCloth {
    /// Adds a cloth's curves to those of the model. A filter that limits stretch does what they say beyond the limit.
    pub fn new(cloth: &Cloth, filter: FilterKind, all: &mut Vec<Curve>) -> Self {
        let Some(curves) = &cloth.curves else { return Self::default() };
        let limit = if filter == FilterKind::None { f64::INFINITY } else { cloth.material().strain_limit };
        let mut add = |curve: &scene::Curve, limit, odd| {
            all.push(Curve::new(curve, limit, odd));
            all.len() as u32 - 1
        };
        let warp = curves.tension.as_ref().map(|curve| add(curve, limit, false));
        let weft = curves.tension_weft.as_ref().map(|curve| add(curve, limit, false)).or(warp);
        let shear = curves.shear.as_ref().map(|curve| add(curve, f64::INFINITY, true));
        Self { warp, weft, shear, network: cloth.network.is_some() }
    }

    /// Whether shear has a curve.
    pub fn shears(&self) -> bool {
        self.shear.is_some()
    }

    /// What a spring follows, if it does.
    ///
    /// A structural spring stands for a strip of the breadth A_e / L. A diagonal of a cell a b is strained by g a b / L^2 when
    /// the cell is sheared by the angle g. Both diagonals share the energy of the cell: `F = L / 2 C(g)`.
    pub fn of(&self, seed: &SpringSeed, part: &Part) -> Option<Follows> {
        let rest = part.rest_length(seed.ends);
        let follow = |curve: Option<u32>, breadth: f64, gain: f64| {
            curve.map(|curve| Follows { curve, breadth: breadth as f32, gain: gain as f32 })
        };
        let [a, b] = seed.ends;
        match seed.kind {
            SpringKind::Structural if self.network => follow(self.warp, 1.0, 1.0),
            // The particles of a row of a grid follow one another.
            SpringKind::Structural if b == a + 1 => follow(self.weft, seed.weight * rest, 1.0),
            SpringKind::Structural => follow(self.warp, seed.weight * rest, 1.0),
            SpringKind::Shear => follow(self.shear, 0.5 * rest, 1.0 / seed.weight),
            SpringKind::Flexion => None,
        }
    }
}
