//! Pairs of features whose ways in a step come near.

use glam::DVec3;

use super::Places;
use super::proximity::Kind;
use super::surfaces::Surfaces;
use super::tree::{Bounds, Leaf, Tree};

/// Boxes are wider by this part of the largest coordinate: places are rounded to single precision.
const ROUNDING: f32 = 2.0 * f32::EPSILON;

/// Two features.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Pair {
    pub kind: Kind,
    pub corners: [u32; 4],
}

/// Pairs, with the workspace to find them.
pub(crate) struct Detection {
    /// Those that come within a wide margin on a first way, and those that come within a narrow one on another way, unless both of
    /// their features end near enough to where they did.
    pub pairs: Vec<Pair>,
    pub further: Vec<Pair>,
    /// The wide margin [m], and the ends of the first way.
    margin: f64,
    ends: Vec<DVec3>,
    /// The vertices that are asked about.
    asked: Vec<bool>,
    bounds: Vec<Bounds>,
    stack: Vec<[u32; 2]>,
    /// Features of one leaf that meet another one.
    met: [Vec<u32>; 2],
}

impl Detection {
    pub fn new(vertices: usize) -> Self {
        Self {
            pairs: Vec::new(),
            further: Vec::new(),
            margin: 0.0,
            ends: vec![DVec3::ZERO; vertices],
            asked: vec![true; vertices],
            bounds: vec![Bounds::NOTHING; vertices],
            stack: Vec::new(),
            met: Default::default(),
        }
    }

    /// Finds all pairs of features that share no vertex and come within `margin` [m] of each other; but for those of cloth that is so
    /// flat that it cannot touch itself.
    pub fn run(&mut self, surfaces: &mut Surfaces, places: &Places, margin: f64) {
        self.margin = margin;
        self.ends.clone_from(&places.ends);
        self.asked.fill(true);
        self.further.clear();
        surfaces.monotone.iter_mut().for_each(|monotone| monotone.run(places));
        let mut pairs = std::mem::take(&mut self.pairs);
        self.search(surfaces, places, margin, &mut pairs);
        self.pairs = pairs;
    }

    /// Finds the pairs that come within a narrower `margin` [m] on a way with the same start: that are among the pairs of the first one
    /// or, further ones, not. Pairs that were apart by the wide margin along an axis are so by the narrow one if what their ends have
    /// moved since makes no difference.
    pub fn run_again(&mut self, surfaces: &mut Surfaces, places: &Places, margin: f64) {
        let near = 0.5 * (self.margin - margin);
        for ((asked, then), now) in self.asked.iter_mut().zip(&self.ends).zip(&places.ends) {
            *asked = then.distance_squared(*now) > near * near;
        }
        for (monotone, tree) in surfaces.monotone.iter_mut().zip(&surfaces.cloths) {
            monotone.run_again(tree, places, |vertex| self.asked[vertex as usize] = true);
        }
        let mut pairs = std::mem::take(&mut self.further);
        self.search(surfaces, places, margin, &mut pairs);
        self.further = pairs;
    }

    /// Those of the first way that no further one makes needless, then the further ones.
    pub fn all(&self) -> impl Iterator<Item = Pair> {
        let asked = |pair: &Pair| pair.corners.iter().any(|&corner| self.asked[corner as usize]);
        self.pairs.iter().copied().filter(move |pair| !asked(pair)).chain(self.further.iter().copied())
    }

    fn search(&mut self, surfaces: &mut Surfaces, places: &Places, margin: f64, pairs: &mut Vec<Pair>) {
        let Self { asked, bounds, stack, met, .. } = self;
        pairs.clear();
        let half = 0.5 * margin as f32;
        for ((bounds, x), end) in bounds.iter_mut().zip(&places.x).zip(&places.ends) {
            let ways = [x.as_vec3a(), end.as_vec3a()];
            *bounds = Bounds::around(ways, ways.map(|place| half + ROUNDING * place.abs().max_element()));
        }
        for tree in surfaces.cloths.iter_mut().chain(&mut surfaces.bodies) {
            tree.refit(bounds, asked);
        }
        let Surfaces { cloths, monotone, bodies, thick, skins, among_cloths, .. } = &*surfaces;
        let mut found = Found { bounds, asked, met, pairs };
        for (index, tree) in cloths.iter().enumerate() {
            if *among_cloths {
                tree.meet_itself(stack, |one, two| {
                    if !monotone[index].spares(one, two) {
                        found.within(tree, one, two);
                    }
                });
                for other in &cloths[index + 1..] {
                    tree.meet(other, stack, |one, two| found.between([tree, other], [one, two]));
                }
            }
            for body in bodies {
                tree.meet(body, stack, |one, two| found.between([tree, body], [one, two]));
            }
            for thick in thick {
                found.around(tree, thick.vertices.clone(), skins[thick.owner as usize].radius as f32);
            }
        }
    }
}

/// The pairs that are found, and what they are looked for with.
struct Found<'a> {
    bounds: &'a [Bounds],
    asked: &'a [bool],
    met: &'a mut [Vec<u32>; 2],
    pairs: &'a mut Vec<Pair>,
}

impl Found<'_> {
    /// Two leaves of one tree.
    fn within(&mut self, tree: &Tree, one: &Leaf, two: &Leaf) {
        if one.triangles != two.triangles {
            return self.between([tree, tree], [one, two]);
        }
        for &vertex in &tree.vertices[range(one.vertices)] {
            range(one.triangles).for_each(|triangle| self.point_and_triangle(vertex, tree, triangle));
        }
        for edge in range(one.edges) {
            for other in edge + 1..one.edges[1] as usize {
                self.edges([tree, tree], [edge, other]);
            }
        }
    }

    /// Two leaves of two trees, or of one.
    fn between(&mut self, trees: [&Tree; 2], leaves: [&Leaf; 2]) {
        let boxes = [0, 1].map(|side| trees[side].bounds_of(leaves[side]));
        let mut met = std::mem::take(self.met);
        for [this, that] in [[0, 1], [1, 0]] {
            let triangles = range(leaves[that].triangles);
            let nears = |triangle: &usize| trees[that].triangle_bounds[*triangle].meets(&boxes[this]);
            met[0].clear();
            met[0].extend(triangles.filter(nears).map(|triangle| triangle as u32));
            for &vertex in &trees[this].vertices[range(leaves[this].vertices)] {
                if self.bounds[vertex as usize].meets(&boxes[that]) {
                    met[0].iter().for_each(|&triangle| self.point_and_triangle(vertex, trees[that], triangle as usize));
                }
            }
        }
        for [this, that] in [[0, 1], [1, 0]] {
            let edges = range(leaves[this].edges);
            let nears = |edge: &usize| trees[this].edge_bounds[*edge].meets(&boxes[that]);
            met[this].clear();
            met[this].extend(edges.filter(nears).map(|edge| edge as u32));
        }
        for &edge in &met[0] {
            met[1].iter().for_each(|&other| self.edges(trees, [edge as usize, other as usize]));
        }
        *self.met = met;
    }

    /// A thick vertex or edge, and a tree.
    fn around(&mut self, tree: &Tree, vertices: std::ops::Range<u32>, radius: f32) {
        let radius = radius * (1.0 + f32::EPSILON);
        let bounds = self.bounds;
        let grown = |vertex: u32| bounds[vertex as usize].grown(radius);
        let all = vertices.clone().fold(Bounds::NOTHING, |all, vertex| all.and(grown(vertex)));
        let asked = vertices.clone().any(|vertex| self.asked[vertex as usize]);
        tree.within(&all, asked, |leaf| {
            for triangle in range(leaf.triangles) {
                let [a, b, c] = tree.triangles[triangle];
                for vertex in vertices.clone() {
                    if grown(vertex).meets(&tree.triangle_bounds[triangle]) {
                        self.add(Kind::PointTriangle, [vertex, a, b, c]);
                    }
                }
            }
            if vertices.len() == 2 {
                let first = vertices.start;
                for edge in range(leaf.edges).filter(|&edge| all.meets(&tree.edge_bounds[edge])) {
                    let [a, b] = tree.edges[edge];
                    self.add(Kind::EdgeEdge, [first, first + 1, a, b]);
                }
            }
        });
    }

    fn point_and_triangle(&mut self, vertex: u32, tree: &Tree, triangle: usize) {
        let [a, b, c] = tree.triangles[triangle];
        if self.bounds[vertex as usize].meets(&tree.triangle_bounds[triangle]) && ![a, b, c].contains(&vertex) {
            self.add(Kind::PointTriangle, [vertex, a, b, c]);
        }
    }

    fn edges(&mut self, [a, b]: [&Tree; 2], [edge, other]: [usize; 2]) {
        if a.edge_bounds[edge].meets(&b.edge_bounds[other]) {
            let ([p, q], [r, s]) = (a.edges[edge], b.edges[other]);
            if p != r && p != s && q != r && q != s {
                self.add(Kind::EdgeEdge, [p, q, r, s]);
            }
        }
    }

    fn add(&mut self, kind: Kind, corners: [u32; 4]) {
        if corners.iter().any(|&corner| self.asked[corner as usize]) {
            self.pairs.push(Pair { kind, corners });
        }
    }
}

fn range([from, to]: [u32; 2]) -> std::ops::Range<usize> {
    from as usize..to as usize
}
