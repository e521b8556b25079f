//! Pairs of features whose ways in a step come near.

use glam::DVec3;

use super::proximity::Kind;
use super::surfaces::{Owner, Surfaces, Thick};
use super::tree::{Bounds, Leaf, Tree};
use super::ways::Ways;
use super::{FLOOR, MARGIN, Places};
use crate::geometry::{Pool, for_each_part};

/// Two features.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Pair {
    pub kind: Kind,
    pub corners: [u32; 4],
}

/// A pair that was found, and how far its features are apart on the way on which it was, at least [m] (ways.rs).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate {
    pub pair: Pair,
    pub gap: f32,
}

/// Two leaves that meet, and whose they are: a cloth, and a cloth or a body after all cloths. Instead of the second there may be something
/// thick, by its number.
#[derive(Debug, Clone, Copy)]
struct Met {
    trees: [u32; 2],
    leaves: [u32; 2],
    thick: Option<u32>,
}

/// Pairs of leaves that a thread looks at together.
const PART: usize = 64;

/// The first certificate of a step asks for a margin that is wider than its floors by this part of what the rows ask for more [1], so
/// that those that follow repairs can ask about little.
const TO_SPARE: f64 = 0.25;

/// Pairs, with the workspace to find them.
pub(crate) struct Detection {
    /// Those that come within a wide margin on a known way, and those that come within a narrower one on the way now, unless both of
    /// their features end near enough to where they did.
    pub pairs: Vec<Candidate>,
    pub further: Vec<Candidate>,
    /// Vertices of cloths that come within the wide margin of something thick on the known way, each with the number of that.
    pub beside: Vec<(u32, u32)>,
    /// The wide margin, in thicknesses between the features of a pair [1], and the ends of the known way; that of the first search is
    /// the way that rows are made of.
    margin: f64,
    ends: Vec<DVec3>,
    ends_of_rows: Vec<DVec3>,
    /// How many certificates have asked since, and the ends of the way of the first one.
    certificates: u32,
    first_ends: Vec<DVec3>,
    /// Ways as they are now.
    pub ways: Ways,
    /// The vertices that are asked about.
    asked: Vec<bool>,
    bounds: Vec<Bounds>,
    stack: Vec<[u32; 2]>,
    met: Vec<Met>,
    parts: Vec<Part>,
}

/// What a part of the pairs of leaves holds, and features of one leaf that meet another one.
#[derive(Debug, Default)]
struct Part {
    pairs: Vec<Candidate>,
    near: [Boxes; 2],
}

/// Features of a leaf, each with its box.
type Boxes = Vec<(u32, Bounds)>;

impl Detection {
    pub fn new(vertices: usize) -> Self {
        Self {
            pairs: Vec::new(),
            further: Vec::new(),
            beside: Vec::new(),
            margin: 0.0,
            ends: vec![DVec3::ZERO; vertices],
            ends_of_rows: vec![DVec3::ZERO; vertices],
            certificates: 0,
            first_ends: vec![DVec3::ZERO; vertices],
            ways: Ways::new(vertices),
            asked: vec![true; vertices],
            bounds: vec![Bounds::NOTHING; vertices],
            stack: Vec::new(),
            met: Vec::new(),
            parts: Vec::new(),
        }
    }

    /// Finds all pairs of features that share no vertex and come within the margin of rows; but for those of cloth that is so flat that
    /// it cannot touch itself.
    pub fn run(&mut self, surfaces: &mut Surfaces, places: &Places, pool: &Pool) {
        self.margin = MARGIN;
        self.certificates = 0;
        self.ends.clone_from(&places.ends);
        self.ends_of_rows.clone_from(&places.ends);
        self.asked.fill(true);
        self.further.clear();
        surfaces.monotone.iter_mut().for_each(|monotone| monotone.run(places, pool));
        let mut pairs = std::mem::take(&mut self.pairs);
        self.search(surfaces, places, self.margin, &mut pairs, pool);
        self.pairs = pairs;
        self.find_beside(surfaces);
    }

    /// Finds the vertices that come near what is thick.
    fn find_beside(&mut self, surfaces: &Surfaces) {
        let Self { bounds, beside, .. } = self;
        beside.clear();
        for (number, thick) in (0..).zip(&surfaces.thick) {
            let all = around(bounds, thick, surfaces.skins[thick.owner as usize].radius as f32);
            for tree in surfaces.cloths.iter().filter(|tree| tree.is_surface()) {
                tree.within(&all, true, |leaf| {
                    let near = tree.vertices[range(leaf.vertices)].iter().filter(|&&vertex| all.meets(&bounds[vertex as usize]));
                    beside.extend(near.map(|&vertex| (vertex, number)));
                });
            }
        }
    }

    /// Finds the pairs that come within the floors of the certificate on a way with the same start. Pairs that were apart by a wider
    /// margin along an axis are so by the narrow one if what their ends have moved since makes no difference: those are not asked
    /// about, and what the known way found of them is enough.
    pub fn run_again(&mut self, surfaces: &mut Surfaces, places: &Places, pool: &Pool) {
        let mut margin = FLOOR;
        match self.certificates {
            // Others may follow, and can ask about little if this one asks for more.
            0 => {
                margin += TO_SPARE * (self.margin - FLOOR);
                self.first_ends.clone_from(&places.ends);
            }
            // The way of the first one is the known way now.
            1 => {
                let asked = &self.asked;
                self.pairs.retain(|candidate| !is_asked(asked, &candidate.pair));
                self.pairs.append(&mut self.further);
                std::mem::swap(&mut self.ends, &mut self.first_ends);
                self.margin = FLOOR + TO_SPARE * (self.margin - FLOOR);
            }
            _ => {}
        }
        self.certificates += 1;
        for (((asked, then), now), &owner) in self.asked.iter_mut().zip(&self.ends).zip(&places.ends).zip(&surfaces.owners) {
            let near = (self.margin - margin) * surfaces.skins[owner as usize].thickness;
            *asked = then.distance_squared(*now) > near * near;
        }
        for (monotone, tree) in surfaces.monotone.iter_mut().zip(&surfaces.cloths) {
            monotone.run_again(tree, places, &self.ends_of_rows, pool, |vertex| self.asked[vertex as usize] = true);
        }
        let mut pairs = std::mem::take(&mut self.further);
        self.search(surfaces, places, margin, &mut pairs, pool);
        self.further = pairs;
    }

    /// Whether the way now was asked about a pair.
    pub fn is_asked(&self, pair: &Pair) -> bool {
        is_asked(&self.asked, pair)
    }

    fn search(&mut self, surfaces: &mut Surfaces, places: &Places, margin: f64, pairs: &mut Vec<Candidate>, pool: &Pool) {
        let Self { ways, asked, bounds, stack, met, parts, .. } = self;
        pairs.clear();
        // What each of two features is wide adds up to their margin.
        let half = |vertex: usize| (margin * surfaces.skins[surfaces.owners[vertex] as usize].thickness) as f32;
        ways.take(places, half, bounds, pool);
        for tree in surfaces.cloths.iter_mut().chain(&mut surfaces.bodies) {
            tree.refit_nodes(bounds, asked, pool);
        }
        let Surfaces { cloths, monotone, bodies, thick, skins, owners, among_cloths, .. } = &*surfaces;
        let tree = |index: u32| match (index as usize).checked_sub(cloths.len()) {
            None => &cloths[index as usize],
            Some(body) => &bodies[body],
        };
        met.clear();
        for index in 0..cloths.len() {
            let others = if *among_cloths { index } else { cloths.len() }..cloths.len() + bodies.len();
            for other in others {
                let trees = [index as u32, other as u32];
                let take = |one: &Leaf, two: &Leaf| {
                    met.push(Met { trees, leaves: [one.index, two.index], thick: None });
                };
                if other > index {
                    cloths[index].meet(tree(trees[1]), stack, take);
                } else {
                    cloths[index].meet_itself(stack, take);
                }
            }
        }
        for (index, tree) in (0..).zip(cloths) {
            for (number, thick) in (0..).zip(thick) {
                let radius = skins[thick.owner as usize].radius as f32;
                let is_asked = thick.vertices.clone().any(|vertex| asked[vertex as usize]);
                tree.within(&around(bounds, thick, radius), is_asked, |leaf| {
                    met.push(Met { trees: [index; 2], leaves: [leaf.index; 2], thick: Some(number) });
                });
            }
        }
        let count = met.len().div_ceil(PART);
        if parts.len() < count {
            parts.resize_with(count, Part::default);
        }
        for_each_part(&mut parts[..count], met.len() * PART, pool, |index, Part { pairs, near }| {
            pairs.clear();
            let mut found = Found { ways, margin: 0.0, bounds, asked, near, pairs };
            let between = |owners: [Owner; 2]| margin * surfaces.thickness(owners);
            for &Met { trees, leaves: [one, two], thick: number } in met[index * PART..].iter().take(PART) {
                let [a, b] = trees.map(tree);
                let leaves = [&a.leaves[one as usize], &b.leaves[two as usize]];
                let is_own = number.is_none() && trees[0] == trees[1];
                if is_own && monotone[trees[0] as usize].spares(leaves[0], leaves[1]) {
                    continue;
                }
                let owner = |tree: &Tree| owners[tree.vertices[0] as usize];
                if let Some(number) = number {
                    let thick = &thick[number as usize];
                    found.margin = between([owner(a), thick.owner]);
                    found.beside(a, leaves[0], thick, skins[thick.owner as usize].radius);
                    continue;
                }
                found.margin = between([owner(a), owner(b)]);
                if is_own && one == two {
                    found.within(a, leaves[0]);
                } else {
                    found.between([a, b], leaves);
                }
            }
        });
        parts[..count].iter().for_each(|part| pairs.extend(&part.pairs));
    }
}

/// The pairs that are found, and what they are looked for with.
struct Found<'a> {
    ways: &'a Ways,
    /// Pairs that are as far apart count no more, radii included [m].
    margin: f64,
    bounds: &'a [Bounds],
    asked: &'a [bool],
    near: &'a mut [Boxes; 2],
    pairs: &'a mut Vec<Candidate>,
}

impl Found<'_> {
    /// A leaf with itself.
    fn within(&mut self, tree: &Tree, leaf: &Leaf) {
        let mut near = std::mem::take(self.near);
        self.triangles(tree, leaf, None, &mut near[0]);
        for &vertex in &tree.vertices[range(leaf.vertices)] {
            near[0].iter().for_each(|triangle| self.point_and_triangle(vertex, tree, triangle));
        }
        self.edges(tree, leaf, None, &mut near[0]);
        for (index, edge) in near[0].iter().enumerate() {
            near[0][index + 1..].iter().for_each(|other| self.two_edges([tree, tree], [edge, other]));
        }
        *self.near = near;
    }

    /// Two leaves of two trees, or of one.
    fn between(&mut self, trees: [&Tree; 2], leaves: [&Leaf; 2]) {
        let boxes = [0, 1].map(|side| trees[side].bounds_of(leaves[side]));
        let mut near = std::mem::take(self.near);
        for [this, that] in [[0, 1], [1, 0]] {
            self.triangles(trees[that], leaves[that], Some(&boxes[this]), &mut near[0]);
            for &vertex in &trees[this].vertices[range(leaves[this].vertices)] {
                if self.bounds[vertex as usize].meets(&boxes[that]) {
                    near[0].iter().for_each(|triangle| self.point_and_triangle(vertex, trees[that], triangle));
                }
            }
        }
        for [this, that] in [[0, 1], [1, 0]] {
            self.edges(trees[this], leaves[this], Some(&boxes[that]), &mut near[this]);
        }
        for edge in &near[0] {
            near[1].iter().for_each(|other| self.two_edges(trees, [edge, other]));
        }
        *self.near = near;
    }

    /// The triangles of a leaf with their boxes; those alone that meet another one, if it is given.
    fn triangles(&self, tree: &Tree, leaf: &Leaf, other: Option<&Bounds>, list: &mut Boxes) {
        list.clear();
        let all = range(leaf.triangles).map(|triangle| (triangle as u32, tree.around_triangle(triangle, self.bounds)));
        list.extend(all.filter(|(_, bounds)| other.is_none_or(|other| bounds.meets(other))));
    }

    /// The same of edges.
    fn edges(&self, tree: &Tree, leaf: &Leaf, other: Option<&Bounds>, list: &mut Boxes) {
        list.clear();
        let all = range(leaf.edges).map(|edge| (edge as u32, tree.around_edge(edge, self.bounds)));
        list.extend(all.filter(|(_, bounds)| other.is_none_or(|other| bounds.meets(other))));
    }

    /// A leaf and a thick vertex or edge.
    fn beside(&mut self, tree: &Tree, leaf: &Leaf, thick: &Thick, radius: f64) {
        let (bounds, vertices, half) = (self.bounds, &thick.vertices, radius as f32);
        let margin = self.margin;
        self.margin += radius;
        for triangle in range(leaf.triangles) {
            let [a, b, c] = tree.triangles[triangle];
            let around = tree.around_triangle(triangle, bounds);
            for vertex in vertices.clone() {
                if grown(bounds, vertex, half).meets(&around) {
                    self.add(Kind::PointTriangle, [vertex, a, b, c]);
                }
            }
        }
        // A sphere is an edge of no length where no triangle stands for its way to an edge.
        if vertices.len() == 2 || !tree.is_surface() {
            let ([first, last], all) = ([vertices.start, vertices.end - 1], around(bounds, thick, half));
            for edge in range(leaf.edges).filter(|&edge| all.meets(&tree.around_edge(edge, bounds))) {
                let [a, b] = tree.edges[edge];
                self.add(Kind::EdgeEdge, [first, last, a, b]);
            }
        }
        self.margin = margin;
    }

    fn point_and_triangle(&mut self, vertex: u32, tree: &Tree, (triangle, bounds): &(u32, Bounds)) {
        let [a, b, c] = tree.triangles[*triangle as usize];
        if self.bounds[vertex as usize].meets(bounds) && ![a, b, c].contains(&vertex) {
            self.add(Kind::PointTriangle, [vertex, a, b, c]);
        }
    }

    fn two_edges(&mut self, [a, b]: [&Tree; 2], [(edge, bounds), (other, around)]: [&(u32, Bounds); 2]) {
        if bounds.meets(around) {
            let ([p, q], [r, s]) = (a.edges[*edge as usize], b.edges[*other as usize]);
            if p != r && p != s && q != r && q != s {
                self.add(Kind::EdgeEdge, [p, q, r, s]);
            }
        }
    }

    fn add(&mut self, kind: Kind, corners: [u32; 4]) {
        let pair = Pair { kind, corners };
        if !is_asked(self.asked, &pair) {
            return;
        }
        let gap = self.ways.gap(pair);
        if f64::from(gap) < self.margin {
            self.pairs.push(Candidate { pair, gap });
        }
    }
}

/// A box around what is thick.
fn around(bounds: &[Bounds], thick: &Thick, radius: f32) -> Bounds {
    thick.vertices.clone().fold(Bounds::NOTHING, |all, vertex| all.and(grown(bounds, vertex, radius)))
}

/// The same around one of its vertices, a little larger than its radius asks for.
fn grown(bounds: &[Bounds], vertex: u32, radius: f32) -> Bounds {
    bounds[vertex as usize].grown(radius * (1.0 + f32::EPSILON))
}

fn is_asked(asked: &[bool], pair: &Pair) -> bool {
    pair.corners.iter().any(|&corner| asked[corner as usize])
}

fn range([from, to]: [u32; 2]) -> std::ops::Range<usize> {
    from as usize..to as usize
}
