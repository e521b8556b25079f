//! Everything that can touch: numbers of vertices are those of particles, then those of bodies.

use std::ops::Range;

use glam::DVec3;

use super::detect::Pair;
use super::monotone::Monotone;
use super::tree::Tree;
use super::{FLOOR, MARGIN};
use crate::model::{Adjacency, BodyShape, Model};

/// Whose a vertex is: a cloth, or a body after all cloths.
pub(crate) type Owner = u32;

/// A vertex or an edge with a large radius: a sphere or a capsule.
#[derive(Debug, Clone)]
pub(crate) struct Thick {
    pub owner: Owner,
    /// One vertex or two.
    pub vertices: Range<u32>,
}

/// The half-space in front of a plane.
#[derive(Debug, Clone)]
pub(crate) struct HalfSpace {
    pub owner: Owner,
    /// The vertex that is a point of it, and its normal.
    pub vertex: u32,
    pub normal: DVec3,
}

/// What a cloth or a body is to others.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Skin {
    /// Half of the thickness of a cloth, all of that of a body [m].
    pub thickness: f64,
    /// Radius inside of the skin [m]: zero but for thick vertices and edges.
    pub radius: f64,
    /// Coulomb's coefficient [1].
    pub friction: f64,
}

/// Everything that can touch.
pub(crate) struct Surfaces {
    /// The triangles of each cloth, and of each body that has any.
    pub cloths: Vec<Tree>,
    pub bodies: Vec<Tree>,
    /// Of each cloth, where it cannot touch itself; nothing is asked for where none may.
    pub monotone: Vec<Monotone>,
    pub thick: Vec<Thick>,
    pub planes: Vec<HalfSpace>,
    pub skins: Vec<Skin>,
    /// Cloths touch themselves and each other.
    pub among_cloths: bool,
    pub owners: Vec<Owner>,
    /// Vertices joined to each by an edge, and those within two edges, in rising order.
    pub ring: Adjacency<u32>,
    pub near: Adjacency<u32>,
    /// 1/mass of each vertex [1/kg]; zero for what is held and for bodies.
    pub weights: Vec<f32>,
    /// The number of particles.
    pub particles: usize,
    /// The largest thickness between any two [m].
    thickest: f64,
}

impl Surfaces {
    pub fn new(model: &Model) -> Option<Self> {
        let (particles, bodies) = (model.particle_count(), &model.bodies);
        if !model.contact.is_on || model.cloths.is_empty() {
            return None;
        }
        let all = particles + bodies.rest.len();
        let mut owners = vec![0; all];
        let mut skins = Vec::new();
        let (mut cloths, mut monotone) = (Vec::new(), Vec::new());
        let place = |vertex: u32| match (vertex as usize).checked_sub(particles) {
            Some(body) => bodies.rest[body].as_vec3(),
            None => model.particles.rest.get(vertex as usize),
        };
        for (index, cloth) in model.cloths.iter().enumerate() {
            owners[cloth.particles()].fill(index as u32);
            let fabric = model.contact.cloths[index];
            skins.push(Skin { thickness: 0.5 * fabric.thickness, radius: 0.0, friction: fabric.friction });
            let range = cloth.particles();
            let own: Vec<[u32; 3]> =
                model.triangles.iter().copied().filter(|corners| range.contains(&(corners[0] as usize))).collect();
            let tree = Tree::new(&own, place);
            let charts = model.contact.among_cloths.then(|| Monotone::new(&tree, |vertex| place(vertex).as_dvec3()));
            monotone.push(charts.unwrap_or_default());
            cloths.push(tree);
        }
        let (mut surfaces, mut thick, mut planes) = (Vec::new(), Vec::new(), Vec::new());
        let mut triangles: Vec<[u32; 3]> = model.triangles.to_vec();
        for (index, body) in bodies.list.iter().enumerate() {
            let owner = (model.cloths.len() + index) as u32;
            let vertices = body.vertices.start + particles..body.vertices.end + particles;
            owners[vertices.clone()].fill(owner);
            skins.push(Skin { thickness: body.thickness, radius: body.radius, friction: body.friction });
            let vertices = vertices.start as u32..vertices.end as u32;
            match body.shape {
                BodyShape::Sphere | BodyShape::Capsule => thick.push(Thick { owner, vertices }),
                BodyShape::Plane => {
                    let [point, tip] = [0, 1].map(|end| bodies.rest[body.vertices.start + end]);
                    planes.push(HalfSpace { owner, vertex: vertices.start, normal: (tip - point).normalize() });
                }
                BodyShape::Surface => {
                    let shifted = |corners: &[u32; 3]| corners.map(|corner| corner + particles as u32);
                    let own: Vec<[u32; 3]> = bodies.triangles[body.triangles.clone()].iter().map(shifted).collect();
                    triangles.extend(&own);
                    surfaces.push(Tree::new(&own, place));
                }
            }
        }
        let sides = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)]);
        let ring = sorted(all, sides.collect());
        let within_two = (0..all as u32).flat_map(|vertex| {
            let ring = &ring;
            let once = ring.of(vertex as usize).iter().copied();
            let twice = once.clone().flat_map(|other| ring.of(other as usize).iter().copied());
            once.chain(twice).chain([vertex]).map(move |other| (vertex, other))
        });
        let near = sorted(all, within_two.collect());
        let mut weights = model.particles.inverse_mass.clone();
        weights.resize(all, 0.0);
        let cloth_most = skins[..cloths.len()].iter().map(|skin| skin.thickness).fold(0.0, f64::max);
        let most = skins.iter().map(|skin| skin.thickness).fold(0.0, f64::max);
        Some(Self {
            cloths,
            bodies: surfaces,
            monotone,
            thick,
            planes,
            skins,
            among_cloths: model.contact.among_cloths,
            owners,
            ring,
            near,
            weights,
            particles,
            thickest: cloth_most + most,
        })
    }

    /// The number of vertices.
    pub fn count(&self) -> usize {
        self.owners.len()
    }

    /// Whose the two features of a pair are.
    pub fn owners_of(&self, Pair { kind, corners }: Pair) -> [Owner; 2] {
        [corners[0], corners[kind.split()]].map(|corner| self.owners[corner as usize])
    }

    /// How far mid-surfaces of two owners are kept apart [m].
    pub fn thickness(&self, pair: [Owner; 2]) -> f64 {
        pair.iter().map(|&owner| self.skins[owner as usize].thickness).sum()
    }

    /// The largest of these, for margins of rows ..
    pub fn widest_margin(&self) -> f64 {
        MARGIN * self.thickest
    }

    /// .. and for floors of certificates [m].
    pub fn widest_floor(&self) -> f64 {
        FLOOR * self.thickest
    }

    /// Radii inside of the skins of two owners [m].
    pub fn radius(&self, pair: [Owner; 2]) -> f64 {
        pair.iter().map(|&owner| self.skins[owner as usize].radius).sum()
    }

    /// Coulomb's coefficient between two owners [1]: the geometric mean, so that what is slippery stays so.
    pub fn friction(&self, pair: [Owner; 2]) -> f64 {
        let [a, b] = pair.map(|owner| self.skins[owner as usize].friction);
        (a * b).sqrt()
    }

    /// Whether one vertex is within two edges of another.
    pub fn are_near(&self, a: u32, b: u32) -> bool {
        self.near.of(a as usize).binary_search(&b).is_ok()
    }
}

/// Lists in rising order without doubles.
fn sorted(owners: usize, mut pairs: Vec<(u32, u32)>) -> Adjacency<u32> {
    pairs.sort_unstable();
    pairs.dedup();
    Adjacency::new(owners, pairs.into_iter())
}
