//! Fast projection on to inextensible warp and weft.
//!
//! R. Goldenthal, D. Harmon, R. Fattal, M. Bercovier, E. Grinspun, *Efficient simulation of inextensible cloth*, ACM
//! Transactions on Graphics 26(3), 2007, algorithm 1. Each structural spring is replaced by the constraint
//! C = |P_uv|^2 / L - L = 0, both ways. One iteration is a Newton step in the multipliers,
//!
//! (J W J^T) m = C(P), P <- P - W J^T m, with J = dC/dP at the iterate and W the inverse masses
//!
//! (their h^2 is taken into m), solved directly (multipliers.rs).
//!
//! *What is constrained.* Warp and weft, as in the paper: the structural springs of grids, of quads and of networks.
//! Shear springs stay springs. With every edge of a triangle mesh constrained there are about as many constraints as
//! degrees of freedom, and the cloth cannot bend (locking); such a mesh is refused when the model is built.
//!
//! *When it stops.* The constraint is equality, whatever lambda; lambda is how far a thread may be off its length when the
//! iterations stop. There is always one: the paper's loop, entered only beyond the tolerance, would let the cloth creep
//! to 1 + lambda and snap back to 1.
//!
//! *Ours.* A thread that is just straight between two pins makes the system singular, and Newton's method overshoots
//! there. The diagonal is made a little larger, and a step that makes the constraints worse, in the sum of their squares,
//! is halved. Elsewhere both do nothing.

use glam::DVec3;

use super::StrainLimit;
use super::multipliers::System;
use crate::filter::Limited;
use crate::geometry::{Pool, Vectors};
use crate::model::{ClothRange, Model};
use crate::scene::FilterKind;
use crate::schedule::Stride;
use crate::state::State;

/// A Newton step is halved at most so many times.
const MOST_HALVINGS: u32 = 6;
/// Positions are rounded to single precision; threads that are off their length by less are left alone.
const ROUNDING: f64 = 2e-6;

/// All cloths that have threads.
pub(in super::super) struct FastProjection {
    cloths: Vec<Threads>,
}

impl FastProjection {
    pub(in super::super) fn new(model: &Model) -> Self {
        Self { cloths: model.cloths.iter().filter_map(|cloth| Threads::new(model, cloth)).collect() }
    }
}

impl StrainLimit for FastProjection {
    fn apply(&mut self, stride: Stride<'_>, state: &mut State, ends: &mut Vectors, _: &Pool) -> Limited {
        let mut limited = Limited::default();
        for cloth in &mut self.cloths {
            let done = cloth.apply(stride, state, ends);
            limited.springs += done.springs;
            limited.sweeps += done.sweeps;
        }
        limited
    }
}

/// The constraints of one cloth and their linear system.
struct Threads {
    first: usize,
    threads: Vec<Thread>,
    /// W of the cloth's particles [1/kg].
    weights: Vec<f64>,
    /// P [m]; where it began, where this iteration began and its Newton step [m].
    p: Vec<DVec3>,
    start: Vec<DVec3>,
    before: Vec<DVec3>,
    newton: Vec<DVec3>,
    /// Half of dC/dP_v of each thread: P_uv / L.
    slope: Vec<DVec3>,
    /// C, then m.
    multipliers: Vec<f64>,
    system: System,
    tolerance: f64,
}

/// How far threads are off their lengths.
#[derive(Clone, Copy)]
struct Off {
    /// The largest | |P_uv| / L - 1 |.
    worst: f64,
    /// The sum of C^2 [m^2].
    squares: f64,
}

struct Thread {
    /// Particles, from the cloth's first.
    ends: [u32; 2],
    /// L [m].
    length: f64,
}

impl Threads {
    /// A cloth; none if nothing in it is constrained.
    fn new(model: &Model, cloth: &ClothRange) -> Option<Self> {
        let springs = &model.springs;
        let weight = |end: u32| f64::from(model.particles.inverse_mass[end as usize]);
        let constrained = |spring: &usize| {
            let [u, v] = springs.ends[*spring].map(weight);
            springs.kind[*spring].is_rod(FilterKind::FastProjection) && u + v > 0.0
        };
        let local = |spring: usize| springs.ends[spring].map(|end| end - cloth.first as u32);
        let threads: Vec<Thread> = cloth
            .springs
            .clone()
            .filter(constrained)
            .map(|spring| Thread { ends: local(spring), length: f64::from(springs.rest[spring]) })
            .collect();
        let weights: Vec<f64> = cloth.particles().map(|particle| weight(particle as u32)).collect();
        Some(Self {
            first: cloth.first,
            system: System::new(threads.iter().map(|thread| thread.ends), &weights)?,
            p: vec![DVec3::ZERO; cloth.count],
            start: vec![DVec3::ZERO; cloth.count],
            before: vec![DVec3::ZERO; cloth.count],
            newton: vec![DVec3::ZERO; cloth.count],
            slope: vec![DVec3::ZERO; threads.len()],
            multipliers: vec![0.0; threads.len()],
            tolerance: f64::from(springs.strain_limit[cloth.springs.start]),
            threads,
            weights,
        })
    }

    fn apply(&mut self, stride: Stride<'_>, state: &mut State, ends: &mut Vectors) -> Limited {
        for (place, (p, start)) in self.p.iter_mut().zip(&mut self.start).enumerate() {
            *p = ends.get(self.first + place).as_dvec3();
            *start = *p;
        }
        let mut limited = Limited::default();
        let mut off = self.evaluate();
        let over = |multiplier: &f64, thread: &Thread| multiplier.abs() > 2.0 * self.tolerance * thread.length;
        limited.springs = self.multipliers.iter().zip(&self.threads).filter(|(c, thread)| over(c, thread)).count() as u32;
        let mut enough = ROUNDING;
        while off.worst > enough && limited.sweeps < stride.model.solver.iterations() {
            let Some(less) = self.project(off) else { break };
            off = less;
            enough = self.tolerance;
            limited.sweeps += 1;
        }
        if limited.sweeps > 0 {
            self.store(stride.plan.length, state, ends);
        }
        limited
    }

    /// C and its slopes at the iterate.
    fn evaluate(&mut self) -> Off {
        let mut off = Off { worst: 0.0, squares: 0.0 };
        for ((thread, slope), c) in self.threads.iter().zip(&mut self.slope).zip(&mut self.multipliers) {
            let [u, v] = thread.ends.map(|end| self.p[end as usize]);
            let p_uv = v - u;
            *slope = p_uv / thread.length;
            let square = p_uv.length_squared();
            *c = square / thread.length - thread.length;
            off.worst = off.worst.max((square.sqrt() / thread.length - 1.0).abs());
            off.squares += *c * *c;
        }
        off
    }

    /// One Newton step, as far along as it makes things better; none if it does not, or if something is not finite.
    fn project(&mut self, off: Off) -> Option<Off> {
        if !self.system.solve(&self.slope, &mut self.multipliers) {
            return None;
        }
        self.before.copy_from_slice(&self.p);
        self.newton.fill(DVec3::ZERO);
        for ((thread, slope), m) in self.threads.iter().zip(&self.slope).zip(&self.multipliers) {
            let [u, v] = thread.ends.map(|end| end as usize);
            let pull = *slope * (2.0 * m);
            self.newton[u] += pull * self.weights[u];
            self.newton[v] -= pull * self.weights[v];
        }
        let mut part = 1.0;
        for _ in 0..=MOST_HALVINGS {
            for ((p, before), newton) in self.p.iter_mut().zip(&self.before).zip(&self.newton) {
                *p = *before + *newton * part;
            }
            let now = self.evaluate();
            if now.squares < off.squares {
                return Some(now);
            }
            part *= 0.5;
        }
        self.p.copy_from_slice(&self.before);
        None
    }

    /// Gives the corrected ends back, and adds the corrections over `step` seconds to the velocities.
    fn store(&self, step: f64, state: &mut State, ends: &mut Vectors) {
        for (place, (p, start)) in self.p.iter().zip(&self.start).enumerate().filter(|(place, _)| self.weights[*place] > 0.0) {
            let particle = self.first + place;
            ends.set(particle, p.as_vec3());
            state.velocities.set(particle, state.velocities.get(particle) + ((*p - *start) / step).as_vec3());
        }
    }
}
