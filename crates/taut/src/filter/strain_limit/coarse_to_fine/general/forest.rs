//! Ropes, chains and trees: networks without loops that hang on one held particle at most, solved exactly.
//!
//! Corrections along the springs at the *end* of a step damp a swing, and pulling links below their limit makes a chain
//! bounce. Here the step D is the one nearest to the proposed one, in the mass norm, that keeps `n (X + D)_uv <= T` for every
//! spring, with the directions n at the *start* of the step, pulls that never push, and the limit T just below R. Springs
//! that turn end up longer than their projection on n; T is lowered for them until their true length is right (SHAKE with
//! inequalities; docs/equations.md, "Networks without loops").

use glam::{DMat3, DVec3, Vec4, Vec4Swizzles};

use crate::geometry::Vectors;

/// T is this much below what is enough, as a part of R: rounding of the ends must not lead over it.
const MARGIN: f32 = 5e-6;
/// Springs at least this long, as a part of T, are taken for taut at first.
const TAUT: f64 = 0.9;
/// How often the set of taut springs may change, and how often their targets.
const CHANGES: usize = 24;
const TURNS: usize = 12;
/// Lengths and gaps are met to this part of T.
const EXACT: f64 = 1e-7;

/// The trees among the pieces of a network.
pub(super) struct Forest {
    /// Parents before children.
    bodies: Vec<Body>,
}

/// A free particle, the spring to its parent and what hangs on it.
struct Body {
    /// Its place on the finest level, and that of its parent.
    place: usize,
    above: Above,
    mass: f64,
    /// Greatest length of the spring to the parent [m]; infinite without one.
    limit: f32,
    /// From the parent to the particle at the start of the step; length, T and how far the spring may grow [m].
    direction: DVec3,
    length: f64,
    target: f64,
    gap: f64,
    taut: bool,
    /// The proposed displacement and the corrected one [m].
    proposed: DVec3,
    d: DVec3,
    /// With the subtree that is tied to it, it costs `d A d / 2 - b d` to move the particle by d: A [kg], b [kg m].
    inertia: DMat3,
    bias: DVec3,
    /// A^-1 b [m], A^-1 n [1/kg] and n A^-1 n [1/kg].
    free: DVec3,
    give: DVec3,
    compliance: f64,
}

/// What a particle hangs on.
#[derive(Clone, Copy, PartialEq)]
enum Above {
    Nothing,
    /// The place of a held particle.
    Held(usize),
    /// The number of a body.
    Body(usize),
}

impl Forest {
    /// The trees of a network; none if there is no tree in it. Springs come with their greatest lengths [m]; `weights` are inverse
    /// masses by place.
    pub fn new(springs: impl Iterator<Item = ([u32; 2], f32)>, weights: &[f32]) -> Option<Self> {
        let mut around: Vec<Vec<(usize, f32)>> = vec![Vec::new(); weights.len()];
        for (ends, limit) in springs {
            let [a, b] = ends.map(|end| end as usize);
            around[a].push((b, limit));
            around[b].push((a, limit));
        }
        let mut seen = vec![false; weights.len()];
        let mut bodies = Vec::new();
        for first in (0..weights.len()).filter(|&place| weights[place] > 0.0) {
            if !seen[first] {
                bodies.extend(tree(first, &around, weights, &mut seen, bodies.len()).into_iter().flatten());
            }
        }
        (!bodies.is_empty()).then_some(Self { bodies })
    }

    /// Corrects displacements that start at `x`; leaves them as they are where no exact answer is found. Springs may be
    /// `enough` of their limit long.
    pub fn correct(&mut self, x: &[Vec4], d: &mut Vectors, enough: f32) {
        self.load(x, d, enough);
        for _ in 0..TURNS {
            if !self.settle(d) {
                return;
            }
            if !self.lower_targets(d) {
                self.bodies.iter().for_each(|body| d.set(body.place, body.d.as_vec3()));
                return;
            }
        }
    }

    fn load(&mut self, x: &[Vec4], d: &Vectors, enough: f32) {
        for index in 0..self.bodies.len() {
            let above = match self.bodies[index].above {
                Above::Nothing => None,
                Above::Held(place) => Some(place),
                Above::Body(other) => Some(self.bodies[other].place),
            };
            let body = &mut self.bodies[index];
            body.proposed = d.get(body.place).as_dvec3();
            if let Some(above) = above {
                let from = x[body.place].xyz().as_dvec3() - x[above].xyz().as_dvec3();
                body.length = from.length();
                body.direction = from.normalize_or_zero();
                body.target = f64::from(body.limit * (enough - MARGIN));
                body.gap = body.target - body.length;
                body.taut = body.length > TAUT * body.target;
            }
        }
    }

    /// Finds which springs are taut and what they make of the proposed displacements. Returns whether it came to an end.
    fn settle(&mut self, d: &Vectors) -> bool {
        for _ in 0..CHANGES {
            self.gather();
            if !self.spread(d) {
                return true;
            }
        }
        false
    }

    /// From the leaves to the roots: what it costs to move each particle.
    fn gather(&mut self) {
        for body in &mut self.bodies {
            (body.inertia, body.bias) = (DMat3::from_diagonal(DVec3::splat(body.mass)), body.proposed * body.mass);
        }
        for index in (0..self.bodies.len()).rev() {
            let (others, rest) = self.bodies.split_at_mut(index);
            let body = &mut rest[0];
            let (n, inverse) = (body.direction, body.inertia.inverse());
            body.free = inverse * body.bias;
            body.give = inverse * n;
            body.compliance = n.dot(body.give);
            if let (true, Above::Body(parent)) = (body.taut, body.above) {
                let pull = n / body.compliance;
                others[parent].inertia += DMat3::from_cols(pull * n.x, pull * n.y, pull * n.z);
                others[parent].bias += pull * (n.dot(body.free) - body.gap);
            }
        }
    }

    /// From the roots to the leaves: the displacements. Returns whether a spring is taut that was slack, or the other way.
    fn spread(&mut self, d: &Vectors) -> bool {
        let mut changed = false;
        for index in 0..self.bodies.len() {
            let above = self.above(index, d);
            let body = &mut self.bodies[index];
            let over = body.direction.dot(body.free - above) - body.gap;
            if body.taut {
                body.d = body.free - body.give * (over / body.compliance);
                body.taut = over >= 0.0;
                changed |= !body.taut;
            } else {
                body.d = body.free;
                body.taut = over > EXACT * body.target && body.length > 0.0;
                changed |= body.taut;
            }
        }
        changed
    }

    /// Lowers the targets by what springs are too long. Returns whether there was anything to do.
    fn lower_targets(&mut self, d: &Vectors) -> bool {
        let mut any = false;
        for index in 0..self.bodies.len() {
            let above = self.above(index, d);
            let body = &mut self.bodies[index];
            if body.above == Above::Nothing {
                continue;
            }
            let over = (body.direction * body.length + body.d - above).length() - body.target;
            if over > EXACT * body.target {
                any = true;
            }
            if body.taut || over > 0.0 {
                body.gap -= over;
            }
        }
        any
    }

    /// The displacement of what a body hangs on [m].
    fn above(&self, index: usize, d: &Vectors) -> DVec3 {
        match self.bodies[index].above {
            Above::Nothing => DVec3::ZERO,
            Above::Held(place) => d.get(place).as_dvec3(),
            Above::Body(other) => self.bodies[other].d,
        }
    }
}

/// The piece of the free particle `first` as bodies that are numbered from `offset`; none if it has a loop, or hangs on
/// more than one spring to a held particle.
fn tree(first: usize, around: &[Vec<(usize, f32)>], weights: &[f32], seen: &mut [bool], offset: usize) -> Option<Vec<Body>> {
    let mut piece = vec![first];
    seen[first] = true;
    let (mut between, mut held) = (0, Vec::new());
    for at in 0.. {
        let Some(&place) = piece.get(at) else { break };
        for &(other, limit) in &around[place] {
            if weights[other] == 0.0 {
                held.push((place, other, limit));
                continue;
            }
            between += 1;
            if !seen[other] {
                seen[other] = true;
                piece.push(other);
            }
        }
    }
    // Every spring between free particles was met from both ends.
    if between != 2 * (piece.len() - 1) || held.len() > 1 || between + held.len() == 0 {
        return None;
    }
    let root = match held.first() {
        Some(&(place, other, limit)) => Body::new(place, weights, Above::Held(other), limit),
        None => Body::new(first, weights, Above::Nothing, f32::INFINITY),
    };
    let mut bodies = vec![root];
    for at in 0..piece.len() {
        let (place, above) = (bodies[at].place, bodies[at].above);
        for &(other, limit) in around[place].iter().filter(|&&(other, _)| weights[other] > 0.0) {
            if !matches!(above, Above::Body(parent) if bodies[parent - offset].place == other) {
                bodies.push(Body::new(other, weights, Above::Body(offset + at), limit));
            }
        }
    }
    Some(bodies)
}

impl Body {
    fn new(place: usize, weights: &[f32], above: Above, limit: f32) -> Self {
        Self {
            place,
            above,
            mass: 1.0 / f64::from(weights[place]),
            limit,
            direction: DVec3::ZERO,
            length: 0.0,
            target: f64::INFINITY,
            gap: f64::INFINITY,
            taut: false,
            proposed: DVec3::ZERO,
            d: DVec3::ZERO,
            inertia: DMat3::ZERO,
            bias: DVec3::ZERO,
            free: DVec3::ZERO,
            give: DVec3::ZERO,
            compliance: 0.0,
        }
    }
}
