//! Everything that can touch: numbers of vertices are those of particles, then those of bodies.

use std::ops::Range;

use glam::{DVec3, Vec3};

use super::detect::Pair;
use super::monotone::Monotone;
use super::proximity::Kind;
use super::reach::{along_links, within_two};
use super::tree::Tree;
use super::{MARGIN, MARGIN_OF_EDGES};

use crate::model::{Adjacency, BodyShape, ClothRange, Model};

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
    /// Whether it has triangles. Networks have none, nor has what is thick or a plane.
    pub is_surface: bool,
}

/// Everything that can touch.
pub(crate) struct Surfaces {
    /// The triangles of each cloth, or the links of a network, and the triangles of each body that has any.
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
    /// Vertices joined to each by an edge or a link, and those so near that they cannot keep the thickness, in rising order.
    pub ring: Adjacency<u32>,
    pub near: Adjacency<u32>,
    /// Where vertices are at rest [m], and of each owner the square of how far those that are so near may be apart there, at most [m^2]:
    /// most pairs need no look at the list.
    rest: Vec<Vec3>,
    reaches: Vec<f32>,
    /// 1/mass of each vertex [1/kg]; zero for what is held and for bodies.
    pub weights: Vec<f32>,
    /// The number of particles.
    pub particles: usize,
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
            let tree = tree_of(model, cloth, place);
            let is_surface = tree.is_surface();
            skins.push(Skin { thickness: 0.5 * fabric.thickness, radius: 0.0, friction: fabric.friction, is_surface });
            // Charts are made of triangles; a network may touch itself anywhere.
            let has_charts = model.contact.among_cloths && is_surface;
            let charts = has_charts.then(|| Monotone::new(&tree, |vertex| place(vertex).as_dvec3()));
            monotone.push(charts.unwrap_or_default());
            cloths.push(tree);
        }
        let (mut surfaces, mut thick, mut planes) = (Vec::new(), Vec::new(), Vec::new());
        let mut triangles: Vec<[u32; 3]> = model.triangles.to_vec();
        for (index, body) in bodies.list.iter().enumerate() {
            let owner = (model.cloths.len() + index) as u32;
            let vertices = body.vertices.start + particles..body.vertices.end + particles;
            owners[vertices.clone()].fill(owner);
            let is_surface = body.shape == BodyShape::Surface;
            skins.push(Skin { thickness: body.thickness, radius: body.radius, friction: body.friction, is_surface });
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
        let links = model.cloths.iter().filter(|cloth| cloth.is_network).flat_map(|cloth| links_of(model, cloth));
        let ring = sorted(all, sides.chain(links.flat_map(|&[a, b]| [(a, b), (b, a)])).collect());
        let near_of = |vertex: u32| {
            let of = owners[vertex as usize] as usize;
            let near = if model.cloths.get(of).is_some_and(|cloth| cloth.is_network) {
                along_links(&ring, vertex, 2.0 * skins[of].thickness, |point| place(point).as_dvec3())
            } else {
                within_two(&ring, vertex)
            };
            near.into_iter().map(move |other| (vertex, other))
        };
        let near = sorted(all, (0..all as u32).flat_map(near_of).collect());
        let rest: Vec<Vec3> = (0..all as u32).map(place).collect();
        let mut reaches = vec![0.0_f32; skins.len()];
        for vertex in 0..all {
            let reach = &mut reaches[owners[vertex] as usize];
            *reach =
                near.of(vertex).iter().map(|&other| rest[vertex].distance_squared(rest[other as usize])).fold(*reach, f32::max);
        }
        let weights = weights_of(model, all);
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
            rest,
            reaches,
            weights,
            particles,
        })
    }

    /// Takes what is held in a model that is the same but for that.
    pub fn weigh(&mut self, model: &Model) {
        self.weights = weights_of(model, self.count());
    }

    /// The number of vertices.
    pub fn count(&self) -> usize {
        self.owners.len()
    }

    /// The tree of a cloth, or of a body after all cloths.
    pub fn tree(&self, owner: Owner) -> &Tree {
        match (owner as usize).checked_sub(self.cloths.len()) {
            None => &self.cloths[owner as usize],
            Some(body) => &self.bodies[body],
        }
    }

    /// The same, to be changed.
    pub fn tree_mut(&mut self, owner: Owner) -> &mut Tree {
        match (owner as usize).checked_sub(self.cloths.len()) {
            None => &mut self.cloths[owner as usize],
            Some(body) => &mut self.bodies[body],
        }
    }

    /// Whose the two features of a pair are.
    pub fn owners_of(&self, Pair { kind, corners }: Pair) -> [Owner; 2] {
        [corners[0], corners[kind.split()]].map(|corner| self.owners[corner as usize])
    }

    /// The cloth of a pair, if there is one only: with itself or with a body.
    pub fn cloth_of(&self, pair: [Owner; 2]) -> Option<Owner> {
        let is_cloth = |owner: &Owner| (*owner as usize) < self.cloths.len();
        let mut cloths = pair.into_iter().filter(is_cloth);
        let first = cloths.next()?;
        cloths.all(|other| other == first).then_some(first)
    }

    /// How far mid-surfaces of two owners are kept apart [m].
    pub fn thickness(&self, pair: [Owner; 2]) -> f64 {
        pair.iter().map(|&owner| self.skins[owner as usize].thickness).sum()
    }

    /// Radii inside of the skins of two owners [m].
    pub fn radius(&self, pair: [Owner; 2]) -> f64 {
        pair.iter().map(|&owner| self.skins[owner as usize].radius).sum()
    }

    /// Pairs nearer than this become rows, in thicknesses [1].
    pub fn margin(&self, kind: Kind, owners: [Owner; 2]) -> f64 {
        // Where two cloths lie on each other their vertices keep them apart; edges count where these do not. Links have no triangles for
        // the vertices of others.
        let are_cloths = owners.iter().all(|&owner| (owner as usize) < self.cloths.len());
        if kind == Kind::EdgeEdge && are_cloths && self.are_surfaces(owners) { MARGIN_OF_EDGES } else { MARGIN }
    }

    /// Coulomb's coefficient between two owners [1]: the geometric mean, so that what is slippery stays so.
    pub fn friction(&self, pair: [Owner; 2]) -> f64 {
        let [a, b] = pair.map(|owner| self.skins[owner as usize].friction);
        (a * b).sqrt()
    }

    /// Whether both features of a pair belong to surfaces.
    pub fn are_surfaces(&self, pair: [Owner; 2]) -> bool {
        pair.iter().all(|&owner| self.skins[owner as usize].is_surface)
    }

    /// Whether one vertex is so near another, within its cloth, that they cannot keep the thickness.
    pub fn are_near(&self, a: u32, b: u32) -> bool {
        let is_in_reach =
            self.rest[a as usize].distance_squared(self.rest[b as usize]) <= self.reaches[self.owners[a as usize] as usize];
        is_in_reach && self.near.of(a as usize).binary_search(&b).is_ok()
    }
}

/// 1/mass of all particles and of so many vertices together with those of bodies [1/kg].
fn weights_of(model: &Model, vertices: usize) -> Vec<f32> {
    let mut weights = model.particles.inverse_mass.clone();
    weights.resize(vertices, 0.0);
    weights
}

/// The links of a network.
fn links_of<'a>(model: &'a Model, cloth: &ClothRange) -> &'a [[u32; 2]] {
    &model.springs.ends[cloth.springs.clone()]
}

/// The tree of a cloth: of its triangles or, in a network, of its links and of the points that no link is tied to.
pub(super) fn tree_of(model: &Model, cloth: &ClothRange, place: impl Fn(u32) -> Vec3) -> Tree {
    let range = cloth.particles();
    if cloth.is_network {
        let mut links = links_of(model, cloth).to_vec();
        let mut is_tied = vec![false; range.len()];
        links.as_flattened().iter().for_each(|&end| is_tied[end as usize - range.start] = true);
        let loose = range.filter(|point| !is_tied[point - cloth.first]);
        links.extend(loose.map(|point| [point as u32; 2]));
        return Tree::of_links(&links, place);
    }
    let triangles = model.triangles.iter().copied();
    Tree::new(&triangles.filter(|corners| range.contains(&(corners[0] as usize))).collect::<Vec<_>>(), place)
}

/// Lists in rising order without doubles.
fn sorted(owners: usize, mut pairs: Vec<(u32, u32)>) -> Adjacency<u32> {
    pairs.sort_unstable();
    pairs.dedup();
    Adjacency::new(owners, pairs.into_iter())
}
