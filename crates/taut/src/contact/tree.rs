//! A tree of boxes over the triangles of a surface, or over the links of a network: of fixed shape, refitted to where they go in a step.

use std::collections::BTreeSet;
use std::ops::Range;

use glam::Vec3;

use super::bounds::{Bounds, Four, LANES};
use crate::geometry::{Pool, for_each_chunk, for_each_of_both};

/// Triangles, or links of a network, in a leaf, at most: there is a bit for each edge of as many triangles.
const LEAF: usize = 8;
const _: () = assert!(3 * LEAF <= u32::BITS as usize);

/// A node: an inner one with two children, the first right after it, or a leaf.
#[derive(Debug, Clone)]
struct Node {
    bounds: Bounds,
    /// Whether it holds a vertex that is asked about.
    asked: bool,
    /// The second child of an inner node.
    second: u32,
    /// The run of leaves below, or the leaf itself.
    leaves: [u32; 2],
}

impl Node {
    fn leaf(&self) -> Option<usize> {
        (self.second == 0).then_some(self.leaves[0] as usize)
    }

    /// How many nodes it has with all below.
    fn size(&self) -> usize {
        2 * (self.leaves[1] - self.leaves[0]) as usize - 1
    }
}

/// The features of a leaf: its triangles (none in a network), and the edges and vertices that no leaf before it has.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leaf {
    /// Its number among the leaves, and its node.
    pub index: u32,
    node: u32,
    pub triangles: [u32; 2],
    pub edges: [u32; 2],
    pub vertices: [u32; 2],
    /// All of its vertices, among the corners of the tree.
    corners: [u32; 2],
    /// Where the boxes of its triangles, edges and vertices begin among those of a leaf, in fours, and where they end.
    fours: [u32; 4],
}

/// The triangles, edges and vertices of a surface in the order of the leaves, and the tree over them. A network has no triangles: its
/// links are edges, and a point that no link is tied to is an edge of no length, from itself to itself.
#[derive(Debug, Clone)]
pub(crate) struct Tree {
    pub triangles: Vec<[u32; 3]>,
    pub edges: Vec<[u32; 2]>,
    pub vertices: Vec<u32>,
    corners: Vec<u32>,
    pub triangle_bounds: Vec<Bounds>,
    pub edge_bounds: Vec<Bounds>,
    pub leaves: Vec<Leaf>,
    nodes: Vec<Node>,
    /// Workspace: the box of each leaf, and whether one of its vertices is asked about.
    fits: Vec<(Bounds, bool)>,
    /// The boxes of the features of each leaf that is marked, so many fours for each.
    marks: Vec<bool>,
    fours: Vec<Four>,
    fours_each: usize,
}

impl Tree {
    /// The tree of some triangles; `place` is where a vertex is at rest.
    pub fn new(triangles: &[[u32; 3]], place: impl Fn(u32) -> Vec3) -> Self {
        Self::over(triangles, &place, |[a, b, c]| [[a, b], [b, c], [c, a]], |tree, corners| tree.triangles.push(corners))
    }

    /// The tree of some links.
    pub fn of_links(links: &[[u32; 2]], place: impl Fn(u32) -> Vec3) -> Self {
        Self::over(links, &place, |link| [link], |_, _| ())
    }

    fn over<const N: usize, const E: usize>(
        features: &[[u32; N]],
        place: &dyn Fn(u32) -> Vec3,
        edges_of: fn([u32; N]) -> [[u32; 2]; E],
        keep: fn(&mut Self, [u32; N]),
    ) -> Self {
        let middle = |corners: [u32; N]| corners.map(place).iter().sum::<Vec3>() / N as f32;
        let mut order: Vec<([u32; N], Vec3)> = features.iter().map(|&corners| (corners, middle(corners))).collect();
        let mut tree = Self {
            triangles: Vec::new(),
            edges: Vec::new(),
            vertices: Vec::new(),
            corners: Vec::new(),
            triangle_bounds: Vec::new(),
            edge_bounds: Vec::new(),
            leaves: Vec::new(),
            nodes: Vec::new(),
            fits: Vec::new(),
            marks: Vec::new(),
            fours: Vec::new(),
            fours_each: 0,
        };
        if !order.is_empty() {
            Splitter { edges_of, keep, edges: BTreeSet::new(), vertices: BTreeSet::new() }.split(&mut tree, &mut order);
        }
        tree.triangle_bounds = vec![Bounds::NOTHING; tree.triangles.len()];
        tree.edge_bounds = vec![Bounds::NOTHING; tree.edges.len()];
        tree.fits = vec![(Bounds::NOTHING, false); tree.leaves.len()];
        tree.marks = vec![false; tree.leaves.len()];
        tree.fours_each = tree.leaves.iter().map(|leaf| leaf.fours[3] as usize).max().unwrap_or_default();
        tree.fours = vec![Four::NOTHING; tree.fours_each * tree.leaves.len()];
        tree
    }

    /// Whether it has triangles, as all have but those of networks.
    pub fn is_surface(&self) -> bool {
        !self.triangles.is_empty()
    }

    /// The corners of the triangles of a leaf, as often as triangles have them.
    pub fn vertices_of(&self, leaf: u32) -> impl Iterator<Item = u32> {
        let [from, to] = self.leaves[leaf as usize].triangles;
        self.triangles[from as usize..to as usize].as_flattened().iter().copied()
    }

    /// The box of a leaf.
    pub fn bounds_of(&self, leaf: &Leaf) -> Bounds {
        self.nodes[leaf.node as usize].bounds
    }

    /// The leaves in runs that are nodes of at most so many triangles, or single leaves.
    pub fn runs(&self, most: usize) -> Vec<Range<usize>> {
        let (mut runs, mut index) = (Vec::new(), 0);
        while let Some(node) = self.nodes.get(index) {
            let run = node.leaves[0] as usize..node.leaves[1] as usize;
            let triangles = self.leaves[run.end - 1].triangles[1] - self.leaves[run.start].triangles[0];
            if node.leaf().is_none() && triangles as usize > most {
                index += 1;
            } else {
                runs.push(run);
                index += node.size();
            }
        }
        runs
    }

    /// The box of a triangle, of those of the vertices.
    pub fn around_triangle(&self, triangle: usize, vertices: &[Bounds]) -> Bounds {
        let [a, b, c] = self.triangles[triangle].map(|corner| vertices[corner as usize]);
        a.and(b).and(c)
    }

    /// The same of an edge.
    pub fn around_edge(&self, edge: usize, vertices: &[Bounds]) -> Bounds {
        let [a, b] = self.edges[edge].map(|end| vertices[end as usize]);
        a.and(b)
    }

    /// Fits all boxes to those of the vertices.
    pub fn refit(&mut self, vertices: &[Bounds], asked: &[bool], pool: &Pool) {
        let mut bounds = std::mem::take(&mut self.triangle_bounds);
        for_each_chunk(&mut bounds, pool, |first, bounds| {
            (first..).zip(bounds).for_each(|(triangle, bounds)| *bounds = self.around_triangle(triangle, vertices));
        });
        self.triangle_bounds = bounds;
        let mut bounds = std::mem::take(&mut self.edge_bounds);
        for_each_chunk(&mut bounds, pool, |first, bounds| {
            (first..).zip(bounds).for_each(|(edge, bounds)| *bounds = self.around_edge(edge, vertices));
        });
        self.edge_bounds = bounds;
        self.refit_nodes(vertices, asked, pool);
    }

    /// Fits the boxes of nodes alone. Where `asked` says so of no vertex of two nodes, they do not meet.
    pub fn refit_nodes(&mut self, vertices: &[Bounds], asked: &[bool], pool: &Pool) {
        let mut fits = std::mem::take(&mut self.fits);
        for_each_chunk(&mut fits, pool, |first, fits| {
            for (fit, leaf) in fits.iter_mut().zip(&self.leaves[first..]) {
                let corners = &self.corners[leaf.corners[0] as usize..leaf.corners[1] as usize];
                *fit = corners.iter().fold((Bounds::NOTHING, false), |(bounds, any), &corner| {
                    (bounds.and(vertices[corner as usize]), any | asked[corner as usize])
                });
            }
        });
        for index in (0..self.nodes.len()).rev() {
            (self.nodes[index].bounds, self.nodes[index].asked) = match self.nodes[index].leaf() {
                Some(leaf) => fits[leaf],
                None => {
                    let [one, two] = [index + 1, self.nodes[index].second as usize].map(|child| &self.nodes[child]);
                    (one.bounds.and(two.bounds), one.asked | two.asked)
                }
            };
        }
        self.fits = fits;
    }

    /// Marks a leaf.
    pub fn mark(&mut self, leaf: u32) {
        self.marks[leaf as usize] = true;
    }

    /// Fits the boxes of the features of the leaves that are marked, and marks none.
    pub fn refit_marked(&mut self, vertices: &[Bounds], pool: &Pool) {
        let (mut marks, mut fours) = (std::mem::take(&mut self.marks), std::mem::take(&mut self.fours));
        for_each_of_both(&mut marks, &mut fours, self.fours_each, pool, |first, marks, fours| {
            let leaves = marks.iter_mut().zip(fours.chunks_mut(self.fours_each)).zip(&self.leaves[first..]);
            for ((mark, fours), leaf) in leaves.filter(|((mark, _), _)| **mark) {
                *mark = false;
                let [triangles, edges, own] = [leaf.triangles, leaf.edges, leaf.vertices].map(range);
                let [_, first_edge, first_vertex, end] = leaf.fours.map(|four| four as usize);
                let (of_triangles, others) = fours[..end].split_at_mut(first_edge);
                let (of_edges, of_vertices) = others.split_at_mut(first_vertex - first_edge);
                fill(of_triangles, triangles.map(|triangle| self.around_triangle(triangle, vertices)));
                fill(of_edges, edges.map(|edge| self.around_edge(edge, vertices)));
                fill(of_vertices, self.vertices[own].iter().map(|&vertex| vertices[vertex as usize]));
            }
        });
        (self.marks, self.fours) = (marks, fours);
    }

    /// The boxes of the triangles, edges and vertices of a leaf that was marked.
    pub fn fours(&self, leaf: &Leaf) -> [&[Four]; 3] {
        let fours = &self.fours[leaf.index as usize * self.fours_each..];
        [0, 1, 2].map(|list| &fours[range([leaf.fours[list], leaf.fours[list + 1]])])
    }

    /// Calls `visit` with the leaves of this tree and another that meet.
    pub fn meet(&self, other: &Self, visit: impl FnMut(&Leaf, &Leaf)) {
        if !self.nodes.is_empty() && !other.nodes.is_empty() {
            self.meet_from(Some(other), &mut vec![[0, 0]], visit);
        }
    }

    /// Calls `visit` with the pairs of leaves of this tree that meet, each with itself, too.
    pub fn meet_itself(&self, visit: impl FnMut(&Leaf, &Leaf)) {
        if !self.nodes.is_empty() {
            self.meet_from(None, &mut vec![[0, 0]], visit);
        }
    }

    /// The same of the pairs of nodes on a stack, of this tree and another or of this one alone.
    pub fn meet_from(&self, other: Option<&Self>, stack: &mut Vec<[u32; 2]>, mut visit: impl FnMut(&Leaf, &Leaf)) {
        while let Some(pair) = stack.pop() {
            self.follow(other, pair, stack, &mut visit);
        }
    }

    /// Pairs of nodes below which all is that meets, about so many if there are as many.
    pub fn fronts(&self, other: Option<&Self>, count: usize, fronts: &mut Vec<[u32; 2]>) {
        fronts.clear();
        if self.nodes.is_empty() || other.is_some_and(|other| other.nodes.is_empty()) {
            return;
        }
        fronts.push([0, 0]);
        let mut next = 0;
        // What is followed is replaced by what is below it; leaves stay.
        while next < fronts.len() && fronts.len() < count {
            let pair = fronts[next];
            let mut are_leaves = false;
            self.follow(other, pair, fronts, &mut |_, _| are_leaves = true);
            if are_leaves {
                next += 1;
            } else {
                fronts.swap_remove(next);
            }
        }
    }

    /// Visits two nodes, of this tree and another or of this one alone: leaves that meet, or what is below them on the stack.
    fn follow(&self, other: Option<&Self>, [a, b]: [u32; 2], stack: &mut Vec<[u32; 2]>, visit: &mut impl FnMut(&Leaf, &Leaf)) {
        if a != b || other.is_some() {
            return self.descend(other.unwrap_or(self), [a, b], stack, visit);
        }
        let node = &self.nodes[a as usize];
        match node.leaf() {
            _ if !node.asked => {}
            Some(leaf) => visit(&self.leaves[leaf], &self.leaves[leaf]),
            None => stack.extend([[a + 1, node.second], [node.second, node.second], [a + 1, a + 1]]),
        }
    }

    /// Visits two leaves that meet, or puts the children of two nodes that meet on the stack.
    fn descend(&self, other: &Self, [a, b]: [u32; 2], stack: &mut Vec<[u32; 2]>, visit: &mut impl FnMut(&Leaf, &Leaf)) {
        let (one, two) = (&self.nodes[a as usize], &other.nodes[b as usize]);
        if !(one.asked | two.asked) || !one.bounds.meets(&two.bounds) {
            return;
        }
        match (one.leaf(), two.leaf()) {
            (Some(one), Some(two)) => visit(&self.leaves[one], &other.leaves[two]),
            (None, Some(_)) => stack.extend([[one.second, b], [a + 1, b]]),
            (Some(_), None) => stack.extend([[a, two.second], [a, b + 1]]),
            (None, None) => stack.extend([[one.second, two.second], [one.second, b + 1], [a + 1, two.second], [a + 1, b + 1]]),
        }
    }

    /// Calls `visit` with the leaves that meet a box; only those that are asked about unless the box is.
    pub fn within(&self, bounds: &Bounds, asked: bool, mut visit: impl FnMut(&Leaf)) {
        let mut index = 0;
        while let Some(node) = self.nodes.get(index) {
            let meets = (asked | node.asked) && node.bounds.meets(bounds);
            if let (true, Some(leaf)) = (meets, node.leaf()) {
                visit(&self.leaves[leaf]);
            }
            // A node that is not met is left out with all below it.
            index += if meets { 1 } else { node.size() };
        }
    }
}

/// What a tree is split with: the edges of a feature, what keeps the feature itself, and the edges and vertices that leaves have already.
struct Splitter<const N: usize, const E: usize> {
    edges_of: fn([u32; N]) -> [[u32; 2]; E],
    keep: fn(&mut Tree, [u32; N]),
    edges: BTreeSet<[u32; 2]>,
    vertices: BTreeSet<u32>,
}

impl<const N: usize, const E: usize> Splitter<N, E> {
    fn split(&mut self, tree: &mut Tree, features: &mut [([u32; N], Vec3)]) {
        let index = tree.nodes.len();
        let leaf = tree.leaves.len() as u32;
        tree.nodes.push(Node { bounds: Bounds::NOTHING, asked: true, second: 0, leaves: [leaf, leaf + 1] });
        if features.len() <= LEAF {
            let from = [tree.triangles.len(), tree.edges.len(), tree.vertices.len(), tree.corners.len()];
            let all: BTreeSet<u32> = features.iter().flat_map(|feature| feature.0).collect();
            tree.corners.extend(all);
            for &(corners, _) in &*features {
                (self.keep)(tree, corners);
                let sides = (self.edges_of)(corners).map(|[a, b]| [a.min(b), a.max(b)]);
                tree.edges.extend(sides.into_iter().filter(|side| self.edges.insert(*side)));
                tree.vertices.extend(corners.into_iter().filter(|vertex| self.vertices.insert(*vertex)));
            }
            let to = [tree.triangles.len(), tree.edges.len(), tree.vertices.len(), tree.corners.len()];
            let run = |list: usize| [from[list] as u32, to[list] as u32];
            let (node, [triangles, edges, vertices, corners]) = (index as u32, [0, 1, 2, 3].map(run));
            let mut fours = [0; 4];
            for list in 0..3 {
                fours[list + 1] = fours[list] + (to[list] - from[list]).div_ceil(LANES) as u32;
            }
            tree.leaves.push(Leaf { index: leaf, node, triangles, edges, vertices, corners, fours });
            return;
        }
        let places = || features.iter().map(|feature| feature.1);
        let size = places().fold(Vec3::NEG_INFINITY, Vec3::max) - places().fold(Vec3::INFINITY, Vec3::min);
        let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or_default();
        let middle = features.len() / 2;
        features.select_nth_unstable_by(middle, |a, b| a.1[axis].total_cmp(&b.1[axis]).then(a.0.cmp(&b.0)));
        let (first, second) = features.split_at_mut(middle);
        self.split(tree, first);
        tree.nodes[index].second = tree.nodes.len() as u32;
        self.split(tree, second);
        tree.nodes[index].leaves[1] = tree.leaves.len() as u32;
    }
}

/// Writes boxes.
fn fill(fours: &mut [Four], mut boxes: impl Iterator<Item = Bounds>) {
    fours.iter_mut().for_each(|four| *four = Four::new(boxes.by_ref().take(LANES)));
}

fn range([from, to]: [u32; 2]) -> Range<usize> {
    from as usize..to as usize
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A crumpled sheet of so many cells along each side, from such a height on, with its boxes fitted.
    fn crumpled(cells: u32, height: f32, seed: u32) -> Tree {
        let across = cells + 1;
        let random = |seed: u32| (seed as f32 * 0.618_034).fract() - 0.5;
        let place =
            |vertex: u32| Vec3::new((vertex % across) as f32, (vertex / across) as f32, height + 3.0 * random(vertex + seed));
        let corners = (0..cells * cells).flat_map(|cell| {
            let a = cell / cells * across + cell % cells;
            [[a, a + 1, a + across], [a + 1, a + across + 1, a + across]]
        });
        let mut tree = Tree::new(&corners.collect::<Vec<_>>(), place);
        let around = |vertex: u32| Bounds::around([place(vertex).into(); 2], [0.2; 2]);
        let bounds: Vec<Bounds> = (0..across * across).map(around).collect();
        tree.refit_nodes(&bounds, &vec![true; bounds.len()], &Pool::new(1));
        tree
    }

    proptest! {
        /// What lies below all fronts is all that meets, and each pair once, however many fronts there are.
        #[test]
        fn fronts_share_out_what_meets(cells in 1_u32..14, seed in 0_u32..100, height in 0.0_f32..3.0, count in 1_usize..200) {
            let [one, two] = [crumpled(cells, 0.0, seed), crumpled(cells, height, seed + 7)];
            for other in [None, Some(&two)] {
                let mut expected = BTreeSet::new();
                let mut take = |a: &Leaf, b: &Leaf| assert!(expected.insert([a.index, b.index]), "found once");
                match other {
                    Some(other) => one.meet(other, &mut take),
                    None => one.meet_itself(&mut take),
                }
                let (mut fronts, mut found, mut times) = (Vec::new(), BTreeSet::new(), 0);
                one.fronts(other, count, &mut fronts);
                for front in fronts {
                    one.meet_from(other, &mut vec![front], |a, b| {
                        found.insert([a.index, b.index]);
                        times += 1;
                    });
                }
                prop_assert_eq!(times, found.len());
                prop_assert_eq!(found, expected);
            }
        }
    }
}
