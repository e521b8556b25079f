//! What would cross on the way from the start of a step to its end.
//!
//! A pair of features must keep the floor, or most of its distance where that is less. What does not cross features that share no
//! vertex does not cross at all: the first place where two triangles come to intersect is such a pair.

use glam::DVec3;

use super::batch::Batch;
use super::crossing::Motion;
use super::detect::{Detection, Pair};
use super::proximity::{Closest, Kind};
use super::surfaces::Surfaces;
use super::untangle::Tangle;
use super::{FLOOR, Places, floor};
use crate::geometry::{CHUNK, Pool, for_each_part};

/// What is shortened goes at most this part of its way [1]: what is allowed may be so nearly all that nothing would change.
const SHORTER: f64 = 0.95;

/// A pair that would come too near.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cut {
    pub pair: Pair,
    /// The part of the step that it may go [1].
    pub allowed: f64,
    /// Its distance at the start [m].
    pub distance: f64,
    /// Of the plane that a particle would pass, if it is one.
    pub plane: Option<DVec3>,
}

/// The pairs of a step that would cross.
pub(crate) struct Cuts {
    pub list: Vec<Cut>,
    /// The part of its way that each vertex may go [1].
    pub factors: Vec<f64>,
    /// Of the vertices that may not go all of it.
    pub shortened: Vec<u32>,
    /// The least distance at the start of the step [m].
    pub closest: f64,
    /// What parts of the pairs find.
    parts: Vec<(Vec<Cut>, f64)>,
}

impl Cuts {
    pub fn new(vertices: usize) -> Self {
        Self { list: Vec::new(), factors: vec![1.0; vertices], shortened: Vec::new(), closest: f64::INFINITY, parts: Vec::new() }
    }

    /// Finds those among the pairs of a detection, and particles that would pass planes and are not fastened behind them.
    pub fn find(&mut self, surfaces: &Surfaces, places: &Places, detection: &Detection, tangle: &Tangle, pool: &Pool) {
        self.list.clear();
        self.closest = f64::INFINITY;
        let chunks: [_; 2] = [&detection.pairs, &detection.further].map(|pairs| pairs.chunks(CHUNK));
        let count = chunks.iter().map(|chunks| chunks.len()).sum();
        if self.parts.len() < count {
            self.parts.resize_with(count, Default::default);
        }
        let [first, further] = chunks;
        let of_first = first.len();
        let chunk = |index: usize| match index.checked_sub(of_first) {
            None => first.clone().nth(index),
            Some(index) => further.clone().nth(index),
        };
        for_each_part(&mut self.parts[..count], count * CHUNK, pool, |index, (cuts, closest)| {
            cuts.clear();
            *closest = f64::INFINITY;
            let mut each = |(pair, gap): (Pair, f32)| {
                if let Some((cut, distance)) = look(surfaces, places, pair, gap) {
                    *closest = closest.min(distance);
                    cuts.extend(cut);
                }
            };
            let found = chunk(index).into_iter().flatten();
            if index >= of_first {
                found.for_each(|candidate| each((candidate.pair, candidate.gap)));
                return;
            }
            // Those that were found on another way are looked at on this one, along both lines: what these do not tell takes much longer.
            let mut batches = [Kind::PointTriangle, Kind::EdgeEdge].map(Batch::new);
            for candidate in found.filter(|candidate| !detection.is_asked(&candidate.pair)) {
                let batch = &mut batches[candidate.pair.kind as usize];
                if batch.put(candidate.pair.corners) {
                    batch.take(&detection.ways, None, f32::INFINITY).for_each(&mut each);
                }
            }
            batches.iter_mut().for_each(|batch| batch.take(&detection.ways, None, f32::INFINITY).for_each(&mut each));
        });
        for (cuts, closest) in &self.parts[..count] {
            self.list.extend(cuts);
            self.closest = self.closest.min(*closest);
        }
        // How they were found makes no difference.
        self.list.sort_unstable_by_key(|cut| cut.pair);
        for plane in &surfaces.planes {
            let [from, to] = [&places.x, &places.ends].map(|places| places[plane.vertex as usize]);
            for particle in (0..surfaces.particles).filter(|&particle| !tangle.stays(particle as u32, plane.owner)) {
                let distance = plane.normal.dot(places.x[particle] - from);
                let end = plane.normal.dot(places.ends[particle] - to);
                if distance <= 0.0 || distance.is_nan() {
                    continue;
                }
                self.closest = self.closest.min(distance);
                let floor = floor(surfaces.thickness([surfaces.owners[particle], plane.owner]), distance);
                if end < floor {
                    let corners = [particle as u32, plane.vertex, plane.vertex, plane.vertex];
                    let pair = Pair { kind: Kind::PointTriangle, corners };
                    let allowed = (distance - floor) / (distance - end);
                    self.list.push(Cut { pair, allowed, distance, plane: Some(plane.normal) });
                }
            }
        }
    }

    /// Lowers the factors of what would cross to what is allowed, times `part`.
    pub fn shorten(&mut self, part: f64) {
        for vertex in self.shortened.drain(..) {
            self.factors[vertex as usize] = 1.0;
        }
        for cut in &self.list {
            for vertex in cut.pair.corners {
                let factor = &mut self.factors[vertex as usize];
                if *factor == 1.0 {
                    self.shortened.push(vertex);
                }
                *factor = factor.min(cut.allowed.min(SHORTER) * part);
            }
        }
    }
}

/// What a pair that is not far from each other all the way would cross, and its distance at the start [m].
fn look(surfaces: &Surfaces, places: &Places, pair: Pair, gap: f32) -> Option<(Option<Cut>, f64)> {
    let owners = surfaces.owners_of(pair);
    let radius = surfaces.radius(owners);
    let thickness = surfaces.thickness(owners);
    let least = FLOOR * thickness + radius;
    if f64::from(gap) >= least {
        return None;
    }
    let motion = Motion::of(places, pair).of_near_part(least);
    let closest = Closest::new(pair.kind, &motion.x);
    let distance = closest.way.length() - radius;
    if distance <= 0.0 || distance.is_nan() {
        return Some((None, distance));
    }
    let allowed = motion.allowed(&closest, floor(thickness, distance), radius);
    Some(((allowed < 1.0).then_some(Cut { pair, allowed, distance, plane: None }), distance))
}
