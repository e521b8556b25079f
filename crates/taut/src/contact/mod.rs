//! What touches: cloth and bodies, cloth and cloth.
//!
//! Everything that can touch is a vertex, an edge or a triangle with a thickness around it. A sphere is a thick vertex, a capsule a
//! thick edge, so that whole triangles stay outside of them and not their vertices alone; boxes and other bodies are surfaces like
//! cloth; a plane bounds a half-space; links of networks are edges of no triangle. Where cloth is nearly flat it cannot touch itself
//! (charts.rs, monotone.rs). Other pairs that come near (tree.rs, detect.rs, batch.rs) become rows, half-spaces that a filter keeps displacements
//! in (rows.rs); what a step ends with is certified to be free of crossings on all of its way (certificate.rs). What intersects at the
//! start is told (start.rs), and brought apart in the first steps (untangle/).

mod batch;
mod bounds;
mod certificate;
mod charts;
mod crossing;
mod detect;
mod met;
mod monotone;
mod pierce;
mod proximity;
mod reach;
mod rows;
mod start;
mod surfaces;
mod tree;
mod untangle;
mod ways;

use glam::DVec3;

use crate::geometry::{Pool, Vectors, Watch, for_each_chunk};
use crate::model::Model;
pub use rows::Touching;
pub(crate) use rows::{Carried, Carrier, Grip, Obstacle, RigidMotion, Rows, Support};
pub use start::{Fault, Intersection, Intersections, Meeting, Other};
use surfaces::Surfaces;
use untangle::Tangle;

/// The floor of the certificate, as a part of the thickness between two things [1]: what is left between them at least.
const FLOOR: f64 = 0.1;
/// A pair that is hardly further than the floor, or nearer, gives up this part of its distance in a step at most [1].
const GIVEN: f64 = 0.2;
/// .. and of distances below this part of the thickness [1] less and less, so that no number of steps makes one too small for numbers.
const SCANT: f64 = 0.01;
/// Pairs nearer than this many thicknesses become rows [1].
const MARGIN: f64 = 1.5;
/// The same of edges of cloth with edges of cloth.
const MARGIN_OF_EDGES: f64 = 0.7;
/// What is joined by so few edges that they cannot keep its thickness keeps this part of it [1].
const NEAR: f64 = 0.2;
/// What is nearer than its thickness is brought apart by this part of it in an automatic step [1], and by less in a shorter one: it has
/// the velocity with which it goes, so that short steps must not throw it.
const RECOVERY: f64 = 0.1;

/// Where everything starts a step and where it ends [m], from a place near the first cloth: all particles, then all vertices of bodies.
#[derive(Debug, Default)]
pub(crate) struct Places {
    pub x: Vec<DVec3>,
    pub ends: Vec<DVec3>,
    /// How far each body turns, axis times angle [rad].
    pub turns: Vec<DVec3>,
    /// What is nearer than its thickness is brought apart by this part of it in the step [1].
    pub recovery: f64,
}

impl Places {
    /// How far the step brings two features apart that start at a distance [m].
    fn target(&self, thickness: f64, distance: f64) -> f64 {
        thickness.min(distance + self.recovery * thickness)
    }
}

/// Contact of a model, with its workspace.
pub(crate) struct Contact {
    surfaces: Surfaces,
    pub places: Places,
    detection: detect::Detection,
    pub rows: Rows,
    pub cuts: certificate::Cuts,
    tangle: Tangle,
    /// What it spends its time on.
    pub watch: Watch,
}

impl Contact {
    /// What can touch in a model; none if nothing can.
    pub fn new(model: &Model) -> Option<Self> {
        let surfaces = Surfaces::new(model)?;
        let all = surfaces.count();
        Some(Self {
            places: Places {
                x: vec![DVec3::ZERO; all],
                ends: vec![DVec3::ZERO; all],
                turns: vec![DVec3::ZERO; model.bodies.list.len()],
                recovery: RECOVERY,
            },
            detection: detect::Detection::new(all),
            rows: Rows::new(model, &surfaces),
            cuts: certificate::Cuts::new(all),
            tangle: Tangle::new(model, &surfaces),
            watch: Watch::default(),
            surfaces,
        })
    }

    /// The same of a model in which only limits, or what is held, have changed; it remembers nothing of the steps before.
    pub fn renewed(mut self, model: &Model) -> Self {
        self.surfaces.weigh(model);
        self.rows = Rows::new(model, &self.surfaces);
        self.cuts = certificate::Cuts::new(self.surfaces.count());
        self.detection = detect::Detection::new(self.surfaces.count());
        self.tangle = Tangle::new(model, &self.surfaces);
        self
    }

    /// Takes where a step starts: particles from the origins of their cloths, vertices of bodies in the world [m].
    pub fn start(&mut self, model: &Model, origins: &[DVec3], positions: &Vectors, bodies: &[DVec3], pool: &Pool) {
        fill(&mut self.places.x, model, origins, positions, bodies, pool);
    }

    /// Takes how far particles have crept before a step that is such a part of an automatic one.
    pub fn go_on(&mut self, crept: &Vectors, part: f64) {
        self.places.recovery = RECOVERY * part;
        self.rows.take_crept(crept);
    }

    /// Takes where it ends.
    pub fn end(&mut self, model: &Model, origins: &[DVec3], ends: &Vectors, bodies: &[DVec3], pool: &Pool) {
        fill(&mut self.places.ends, model, origins, ends, bodies, pool);
    }

    /// What is kept between a body and the thickest cloth [m].
    pub fn thickness_on(&self, body: usize) -> f64 {
        let (cloths, bodies) = self.surfaces.skins.split_at(self.surfaces.cloths.len());
        bodies[body].thickness + cloths.iter().map(|skin| skin.thickness).fold(0.0, f64::max)
    }

    /// Looks for what intersects where a step of so many seconds starts, if it may, and brings it apart in this step. Returns at how many
    /// places it does.
    pub fn untangle(&mut self, may_cross: bool, step: f64) -> usize {
        let Self { surfaces, places, tangle, watch, .. } = self;
        if may_cross {
            let start = watch.now();
            let found = tangle.look(surfaces, &places.x, step);
            watch.times.detection += watch.now() - start;
            return found;
        }
        tangle.rest();
        0
    }

    /// Whether anything intersects, or is fastened in a body, at the start of this step.
    pub fn may_cross(&self) -> bool {
        self.tangle.is_on()
    }

    /// How far a step brings apart what intersects [m]; none where nothing does.
    pub fn brings_apart(&self) -> Option<f64> {
        self.tangle.most()
    }

    /// Takes from velocities what brings intersecting things apart in a step of so many seconds.
    pub fn calm(&self, velocities: &mut Vectors, step: f64) {
        let d = |vertex: usize| self.places.ends[vertex] - self.places.x[vertex];
        self.tangle.calm(&self.surfaces, velocities, d, step);
    }

    /// Finds what comes near on the way, and makes rows of it.
    pub fn find_rows(&mut self, pool: &Pool) {
        let Self { surfaces, places, detection, rows, tangle, watch, .. } = self;
        let start = watch.now();
        rows.clear();
        detection.run(surfaces, places, pool);
        tangle.spare(surfaces, &mut detection.pairs);
        tangle.spare_sunk(surfaces, &mut detection.beside);
        rows.take_planes(surfaces, places, tangle);
        rows.take_thick(surfaces, places, detection, pool);
        rows.take_pairs(surfaces, places, detection, tangle.most().is_none(), pool);
        rows.take_asked(surfaces, tangle.asked());
        rows.sort(places, pool);
        watch.times.detection += watch.now() - start;
    }

    /// Finds what would cross on the way, or come nearer than the floor, and how far it may go.
    pub fn certify(&mut self, pool: &Pool) {
        let Self { surfaces, places, detection, cuts, tangle, watch, .. } = self;
        let start = watch.now();
        detection.run_again(surfaces, places, pool);
        tangle.spare(surfaces, &mut detection.further);
        let detected = watch.now();
        watch.times.detection += detected - start;
        cuts.find(surfaces, places, detection, tangle, pool);
        watch.times.certificate += watch.now() - detected;
    }

    /// Tells how far particles have crept along what they stick to, as the step ends.
    pub fn tell_crept(&mut self, crept: &mut Vectors) {
        self.rows.tell_crept(&self.places, crept);
    }

    /// What pushed cloth in the last step.
    pub fn touching(&self) -> impl Iterator<Item = Touching> {
        self.rows.touching(&self.surfaces, &self.places)
    }

    /// Tells of each cloth what carries it.
    pub fn tell_carriers(&mut self, carriers: &mut Vec<Carried>) {
        self.rows.tell_carriers(&self.surfaces, &self.places, carriers);
    }

    /// Makes rows of what the last certificate found.
    pub fn add_rows_of_cuts(&mut self, pool: &Pool) {
        let Self { surfaces, places, rows, cuts, .. } = self;
        rows.take_cuts(surfaces, places, cuts);
        rows.arrange(places, pool);
    }
}

/// What the certificate leaves of a distance, at least, between two things that keep `thickness` [m].
fn floor(thickness: f64, distance: f64) -> f64 {
    (FLOOR * thickness).min(distance * (1.0 - GIVEN * (distance / (SCANT * thickness)).min(1.0)))
}

/// Places of all particles and bodies.
fn fill(places: &mut [DVec3], model: &Model, origins: &[DVec3], vectors: &Vectors, bodies: &[DVec3], pool: &Pool) {
    let base = origins[0];
    places[model.particle_count()..].iter_mut().zip(bodies).for_each(|(place, body)| *place = *body - base);
    for (cloth, origin) in model.cloths.iter().zip(origins) {
        let (own, way) = (cloth.particles(), *origin - base);
        for_each_chunk(&mut places[own.clone()], pool, |first, places| {
            for (particle, place) in (own.start + first..).zip(places) {
                *place = vectors.get(particle).as_dvec3() + way;
            }
        });
    }
}
