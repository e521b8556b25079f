//! How near links of networks come to everything else, at a moment and on the straight way between two, by other means than those of the
//! engine: every pair that may meet, in double precision.

use std::collections::BTreeSet;

use glam::DVec3;

use super::Simulation;
use super::oracle::places;

/// What the pairs of a scene come to.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// The least distance of two features now that share no vertex, as a part of their thickness [1].
    pub least: f64,
    /// How many pairs could not be shown to stay apart on the way from the last look.
    pub passed: usize,
}

/// Corners of a feature: a point has one of them three times, a link its second one twice.
type Feature = [u32; 3];

/// Watches the networks of a simulation.
pub struct Watch {
    /// Links, and points that have none.
    links: Vec<Feature>,
    /// Edges of cloths and surfaces, the middles of spheres and the lines of capsules.
    edges: Vec<Feature>,
    triangles: Vec<Feature>,
    points: Vec<Feature>,
    /// Of each vertex: its part of the thickness, and the radius inside of it [m].
    skins: Vec<[f64; 2]>,
    before: Vec<DVec3>,
}

impl Watch {
    pub fn new(run: &mut Simulation) -> Self {
        run.work.keep_trace(true);
        let model = &run.model;
        let count = model.particle_count();
        let mut skins = Vec::new();
        let (mut links, mut edges, mut points) = (Vec::new(), BTreeSet::new(), Vec::new());
        for (index, cloth) in model.cloths.iter().enumerate() {
            skins.extend(cloth.particles().map(|_| [0.5 * model.contact.cloths[index].thickness, 0.0]));
            if cloth.is_network {
                let own = &model.springs.ends[cloth.springs.clone()];
                let loose = cloth.particles().map(|point| point as u32).filter(|point| !own.as_flattened().contains(point));
                links.extend(own.iter().map(|&[a, b]| [a, b, b]));
                links.extend(loose.map(|point| [point; 3]));
                points.extend(cloth.particles().map(|point| [point as u32; 3]));
            }
        }
        for body in &model.bodies.list {
            skins.extend(body.vertices.clone().map(|_| [body.thickness, body.radius]));
            if body.radius > 0.0 {
                let [first, last] = [body.vertices.start + count, body.vertices.end - 1 + count].map(|end| end as u32);
                edges.insert([first, last, last]);
            }
        }
        let of_bodies = model.bodies.triangles.iter().map(|corners| corners.map(|corner| corner + count as u32));
        let triangles: Vec<Feature> = model.triangles.iter().copied().chain(of_bodies).collect();
        for &[a, b, c] in &triangles {
            edges.extend([[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b), a.max(b)]));
        }
        let edges = edges.into_iter().collect();
        Self { links, edges, triangles, points, skins, before: world(run) }
    }

    /// Looks at where everything is after some steps, and at the ways there from the last look: straight ones between the ends of the parts
    /// that the steps were taken in.
    pub fn look(&mut self, run: &Simulation) -> Seen {
        let points = run.work.trace().expect("a trace").iter().map(|point| [&point.particles[..], &point.bodies].concat());
        let parts = points.map(|now| self.look_at(now)).collect::<Vec<_>>();
        let last = parts.last().expect("at least one step");
        Seen { least: last.least, passed: parts.iter().map(|part| part.passed).sum() }
    }

    fn look_at(&mut self, now: Vec<DVec3>) -> Seen {
        let before = std::mem::replace(&mut self.before, now);
        let mut seen = Seen { least: f64::INFINITY, passed: 0 };
        let boxes = |features: &[Feature]| -> Vec<[DVec3; 2]> { features.iter().map(|of| self.around(&before, of)).collect() };
        let [links, edges, triangles, points] = [&self.links, &self.edges, &self.triangles, &self.points].map(|of| boxes(of));
        let lists = [
            (&self.links, &links, &self.links, &links),
            (&self.links, &links, &self.edges, &edges),
            (&self.points, &points, &self.triangles, &triangles),
        ];
        for (index, (ones, of_ones, others, of_others)) in lists.into_iter().enumerate() {
            for (at, (one, span)) in ones.iter().zip(of_ones).enumerate() {
                for (other, to) in others.iter().zip(of_others).skip(if index == 0 { at + 1 } else { 0 }) {
                    let apart = span[0].cmpgt(to[1]).any() || span[1].cmplt(to[0]).any();
                    if !apart && !one.iter().any(|corner| other.contains(corner)) {
                        self.pair(&before, one, other, &mut seen);
                    }
                }
            }
        }
        seen
    }

    fn pair(&self, before: &[DVec3], one: &Feature, other: &Feature, seen: &mut Seen) {
        let ([first, inner], [second, outer]) = (self.skins[one[0] as usize], self.skins[other[0] as usize]);
        let radius = inner + outer;
        let least = (distance(&self.before, one, other) - radius) / (first + second);
        seen.least = seen.least.min(least);
        let at = |time: f64| -> Vec<DVec3> {
            one.iter().chain(other).map(|&v| before[v as usize].lerp(self.before[v as usize], time)).collect()
        };
        let d: Vec<DVec3> = one.iter().chain(other).map(|&v| self.before[v as usize] - before[v as usize]).collect();
        let mean = d.iter().sum::<DVec3>() / 6.0;
        let most = |d: &[DVec3]| d.iter().map(|d| (*d - mean).length()).fold(0.0, f64::max);
        let fastest = most(&d[..3]) + most(&d[3..]);
        let are_lines = [one, other].map(|feature| feature[1] == feature[2]);
        let gap = |time: f64| {
            let x = at(time);
            between([x[0], x[1], x[2]], [x[3], x[4], x[5]], are_lines) - radius
        };
        seen.passed += usize::from(!stays_apart(&gap, fastest, [0.0, 1.0], 24));
    }

    /// Low and high corners of all places of a feature on its way, with its skin.
    fn around(&self, before: &[DVec3], feature: &Feature) -> [DVec3; 2] {
        let [thickness, radius] = self.skins[feature[0] as usize];
        let all = || feature.iter().flat_map(|&v| [before[v as usize], self.before[v as usize]]);
        let room = DVec3::splat(thickness + radius);
        [all().fold(DVec3::INFINITY, DVec3::min) - room, all().fold(DVec3::NEG_INFINITY, DVec3::max) + room]
    }
}

/// Whether a gap that changes by `fastest` in a unit of time at most is above zero all the time.
fn stays_apart(gap: &impl Fn(f64) -> f64, fastest: f64, [from, to]: [f64; 2], depth: u32) -> bool {
    let middle = 0.5 * (from + to);
    let now = gap(middle);
    now > 0.5 * fastest * (to - from)
        || now > 0.0
            && depth > 0
            && stays_apart(gap, fastest, [from, middle], depth - 1)
            && stays_apart(gap, fastest, [middle, to], depth - 1)
}

/// Particles, then vertices of bodies, in the world.
fn world(run: &Simulation) -> Vec<DVec3> {
    places(run).into_iter().chain(run.state.bodies.iter().copied()).collect()
}

fn distance(x: &[DVec3], one: &Feature, other: &Feature) -> f64 {
    let at = |feature: &Feature| feature.map(|corner| x[corner as usize]);
    between(at(one), at(other), [one, other].map(|feature| feature[1] == feature[2]))
}

/// The distance of two features that are lines, or points and triangles.
fn between(a: [DVec3; 3], b: [DVec3; 3], are_lines: [bool; 2]) -> f64 {
    match are_lines {
        [true, true] => of_segments([a[0], a[1]], [b[0], b[1]]),
        [true, false] => of_triangle(a[0], b),
        _ => of_triangle(b[0], a),
    }
}

fn of_segment(p: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let length = (b - a).length_squared();
    let part = if length > 0.0 { ((p - a).dot(b - a) / length).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a.lerp(b, part))
}

/// Of two segments: between two ends, an end and an inner place, or two inner places, where the way is along the common normal.
fn of_segments(a: [DVec3; 2], b: [DVec3; 2]) -> f64 {
    let ends = [of_segment(a[0], b), of_segment(a[1], b), of_segment(b[0], a), of_segment(b[1], a)];
    let least = ends.into_iter().fold(f64::INFINITY, f64::min);
    let (u, v) = (a[1] - a[0], b[1] - b[0]);
    let normal = u.cross(v);
    let square = normal.length_squared();
    if square <= 1e-24 * u.length_squared() * v.length_squared() {
        return least;
    }
    let r = b[0] - a[0];
    let (s, t) = (r.cross(v).dot(normal) / square, r.cross(u).dot(normal) / square);
    let is_inner = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
    if is_inner { least.min(r.dot(normal).abs() / square.sqrt()) } else { least }
}

fn of_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let sides = [[a, b], [b, c], [c, a]];
    if sides.iter().all(|[from, to]| (*to - *from).cross(p - *from).dot(normal) >= 0.0) {
        return (p - a).dot(normal.normalize()).abs();
    }
    sides.into_iter().map(|side| of_segment(p, side)).fold(f64::INFINITY, f64::min)
}
