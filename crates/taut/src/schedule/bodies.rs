//! In how many parts a step is taken where bodies move: so that none goes further than it may in any of them, where it is near cloth.
//!
//! Only what moves against the cloth counts. A body that goes along with it is as one that stands, and so is the part of a long one that is
//! nowhere near: the feet of a figure that wears a skirt.

use glam::DVec3;

use crate::geometry::Vectors;
use crate::inputs::Inputs;
use crate::model::{Bodies, Body, BodyShape, ClothRange, Model};

/// Steps are taken in so many parts at most; bodies that ask for more may lag.
const MOST_PARTS: f64 = 64.0;

/// Where the bodies begin a step, and where they end it [m].
pub(crate) struct BodyWays {
    places: [Vec<DVec3>; 2],
}

/// Where cloths are and how fast.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moving<'a> {
    /// Where the coordinates of each begin [m].
    pub origins: &'a [DVec3],
    /// Of all particles, from there [m].
    pub positions: &'a Vectors,
    /// [m/s]
    pub velocities: &'a Vectors,
}

/// The room that a cloth takes up in a step, and how it goes.
struct Zone {
    /// A box around it at the start of the step, and where that would go [m].
    low: DVec3,
    high: DVec3,
    /// How far it would go, on the mean [m].
    way: DVec3,
}

impl BodyWays {
    pub fn new(model: &Model) -> Self {
        Self { places: [model.bodies.rest.clone(), model.bodies.rest.clone()] }
    }

    /// The number of parts of a step between two times [s], with cloths as they are when it begins.
    pub fn parts(&mut self, model: &Model, inputs: &Inputs, cloths: Moving<'_>, [start, end]: [f64; 2]) -> u32 {
        if !model.contact.is_on || !inputs.bodies.any_moves() {
            return 1;
        }
        for (places, time) in self.places.iter_mut().zip([start, end]) {
            inputs.bodies.places(&model.bodies, time, places);
        }
        // Most bodies are slow: then nobody needs to know where cloth is.
        let bodies = || model.bodies.list.iter().map(|body| (body, self.most(body), model.contact.furthest(body)));
        let fast = || bodies().filter(|(_, most, furthest)| most > furthest);
        if fast().next().is_none() {
            return 1;
        }
        let mut parts = 1.0_f64;
        for cloth in &model.cloths {
            let zone = Zone::new(cloth, cloths, end - start);
            let skin = model.contact.cloths[cloth.index].thickness + model.contact.cell;
            for (body, most, furthest) in fast() {
                let near = zone.grown(body.radius + body.thickness + skin + most);
                parts = parts.max(self.against(&model.bodies, body, &near) / furthest);
            }
        }
        parts.ceil().min(MOST_PARTS) as u32
    }

    /// How far a vertex goes [m].
    fn way(&self, vertex: usize) -> DVec3 {
        let [from, to] = &self.places;
        to[vertex] - from[vertex]
    }

    /// How far a body goes, at most [m].
    fn most(&self, body: &Body) -> f64 {
        body.vertices.clone().map(|vertex| self.way(vertex).length()).fold(0.0, f64::max)
    }

    /// How far it goes against a cloth in the zone where that is near, as seen from the world or from the cloth, whichever is less [m].
    fn against(&self, bodies: &Bodies, body: &Body, zone: &Zone) -> f64 {
        let [from, _] = &self.places;
        let own = body.vertices.clone();
        let against = |way: DVec3| way.length().min((way - zone.way).length());
        match body.shape {
            BodyShape::Plane => own.map(|vertex| against(self.way(vertex))).fold(0.0, f64::max),
            BodyShape::Sphere | BodyShape::Capsule => {
                let (first, last) = (own.start, own.end - 1);
                let Some(near) = zone.clip(from[first], from[last]) else { return 0.0 };
                near.map(|at| against(self.way(first).lerp(self.way(last), at))).into_iter().fold(0.0, f64::max)
            }
            BodyShape::Surface => {
                let triangles =
                    bodies.triangles[body.triangles.clone()].iter().map(|corners| corners.map(|corner| corner as usize));
                let near = triangles.filter(|corners| zone.meets(corners.map(|corner| from[corner])));
                near.flatten().map(|corner| against(self.way(corner))).fold(0.0, f64::max)
            }
        }
    }
}

impl Zone {
    fn new(cloth: &ClothRange, Moving { origins, positions, velocities }: Moving<'_>, step: f64) -> Self {
        let own = cloth.particles();
        let mean = |column: &[f32]| column[own.clone()].iter().map(|&v| f64::from(v)).sum::<f64>() / own.len() as f64;
        let ends = |column: &[f32]| {
            let ends = column[own.clone()].iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], &x| {
                [if x < low { x } else { low }, if x > high { x } else { high }]
            });
            ends.map(f64::from)
        };
        let way = DVec3::from_array(velocities.columns().map(mean)) * step;
        let [x, y, z] = positions.columns().map(ends);
        let [low, high] = [0, 1].map(|side| DVec3::new(x[side], y[side], z[side]) + origins[cloth.index]);
        Self { low: low.min(low + way), high: high.max(high + way), way }
    }

    /// Wider by so much on all sides [m].
    fn grown(&self, by: f64) -> Self {
        Self { low: self.low - by, high: self.high + by, way: self.way }
    }

    /// Whether the box around some places meets it.
    fn meets(&self, places: [DVec3; 3]) -> bool {
        let [a, b, c] = places;
        a.min(b).min(c).cmple(self.high).all() && a.max(b).max(c).cmpge(self.low).all()
    }

    /// The part of a line from one place to another that is in it, as two parts of the way [1]; none if it passes by.
    fn clip(&self, from: DVec3, to: DVec3) -> Option<[f64; 2]> {
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        for axis in 0..3 {
            let (start, way) = (from[axis], to[axis] - from[axis]);
            let [low, high] = [self.low[axis] - start, self.high[axis] - start];
            if way == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let [one, other] = [low / way, high / way];
            (first, last) = (first.max(one.min(other)), last.min(one.max(other)));
        }
        (first <= last).then_some([first, last])
    }
}
