//! Compliant constraints in place of springs, one pass over them in a small step.
//!
//! M. Macklin, M. Müller, N. Chentanez, *XPBD: position-based simulation of compliant constrained dynamics*, Motion in
//! Games 2016, eqs. (17) and (18); M. Macklin et al., *Small steps in physics simulation*, SCA 2019: one iteration a step and many
//! steps converge faster than one step with many iterations.
//!
//! A type 1 spring is the constraint C = |P_uv| - L with the compliance 1 / k of the spring that it replaces, both ways,
//! as today's engines have it; and beyond its limit R it is rigid, as their stretch limits are. With s = k h^2, the sum
//! w of the inverse masses and the multiplier m, which begins every step at zero,
//!
//! dm = -(s C + m) / (1 + s w), and ends move by w_u dm and w_v dm along the spring.
//!
//! The limit holds no better than a single Gauss-Seidel pass of rigid constraints can make it: more steps, not
//! more iterations, make it hold better.

use glam::Vec3;

use super::StrainLimit;
use super::coloured::{ColouredSprings, Found, Pass};
use crate::filter::Limited;
use crate::geometry::{Pool, Vectors};
use crate::model::Model;
use crate::schedule::Stride;
use crate::state::State;

/// The constraints by colour.
pub(in super::super) struct Xpbd {
    springs: ColouredSprings<Constraint>,
}

struct Constraint {
    /// L [m].
    rest: f32,
    /// R [m].
    limit: f32,
    /// k [N/m], and s = k h^2 [kg].
    spring: f64,
    stiffness: f32,
    /// w_u and w_v [1/kg].
    weights: [f32; 2],
    /// m [kg m]: the impulse of the spring in this step, times h.
    multiplier: f32,
}

impl Xpbd {
    pub(in super::super) fn new(model: &Model) -> Self {
        let springs = &model.springs;
        let keep = |spring: usize, weights: [f32; 2]| Constraint {
            rest: springs.rest[spring],
            limit: springs.greatest_length(spring),
            spring: f64::from(springs.stiffness[spring]),
            stiffness: 0.0,
            weights,
            multiplier: 0.0,
        };
        Self { springs: ColouredSprings::new(model, 0..springs.type1, keep) }
    }
}

impl StrainLimit for Xpbd {
    fn apply(&mut self, stride: Stride<'_>, state: &mut State, ends: &mut Vectors, pool: &Pool) -> Limited {
        let (model, step) = (stride.model, stride.plan.length as f32);
        let mut limited = Limited::default();
        let square = stride.plan.length * stride.plan.length;
        self.springs.for_each(|constraint| {
            constraint.stiffness = (constraint.spring * square) as f32;
            constraint.multiplier = 0.0;
        });
        while limited.sweeps < model.solver.iterations() {
            let pass = Pass { step, backwards: limited.sweeps % 2 == 1, local: false };
            let found = self.springs.sweep(ends, &mut state.velocities, pass, pool, correct);
            if limited.sweeps == 0 {
                limited.springs = found.over;
            }
            limited.sweeps += 1;
        }
        limited
    }
}

fn correct(p_uv: Vec3, constraint: &mut Constraint, found: &mut Found) -> Option<[Vec3; 2]> {
    let Constraint { rest, limit, stiffness, weights: [w_u, w_v], ref mut multiplier, .. } = *constraint;
    let length = p_uv.length();
    if length == 0.0 {
        return None;
    }
    found.over += u32::from(length > limit);
    let weight = w_u + w_v;
    let change = -(stiffness * (length - rest) + *multiplier) / (1.0 + stiffness * weight);
    *multiplier += change;
    // What the compliant spring leaves beyond the limit, a rigid one takes.
    let rigid = ((limit - length) / weight - change).min(0.0);
    let pull = p_uv * ((change + rigid) / length);
    Some([pull * -w_u, pull * w_v])
}
