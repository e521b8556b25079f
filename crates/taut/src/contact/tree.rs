//! A tree of boxes over the triangles of a surface: of fixed shape, refitted to where they go in a step.

use std::collections::BTreeSet;

use glam::Vec3;

/// Triangles in a leaf, at most.
const LEAF: usize = 8;

/// A box.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    pub low: Vec3,
    pub high: Vec3,
}

impl Bounds {
    pub const NOTHING: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    pub fn and(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    pub fn meets(&self, other: &Self) -> bool {
        (self.low.cmple(other.high) & other.low.cmple(self.high)).all()
    }
}

/// A node: an inner one with two children, the first right after it, or a leaf.
#[derive(Debug, Clone)]
struct Node {
    bounds: Bounds,
    /// The second child of an inner node.
    second: u32,
    /// What is in a leaf: a run of each list of [`Tree`].
    leaf: Option<Leaf>,
}

/// The features of a leaf: its triangles, and the edges and vertices that no leaf before it has.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leaf {
    pub triangles: [u32; 2],
    pub edges: [u32; 2],
    pub vertices: [u32; 2],
}

/// The triangles, edges and vertices of a surface in the order of the leaves, and the tree over them.
#[derive(Debug, Clone)]
pub(crate) struct Tree {
    pub triangles: Vec<[u32; 3]>,
    pub edges: Vec<[u32; 2]>,
    pub vertices: Vec<u32>,
    pub triangle_bounds: Vec<Bounds>,
    pub edge_bounds: Vec<Bounds>,
    nodes: Vec<Node>,
}

impl Tree {
    /// The tree of some triangles; `place` is where a vertex is at rest.
    pub fn new(triangles: &[[u32; 3]], place: impl Fn(u32) -> Vec3) -> Self {
        let mut order: Vec<([u32; 3], Vec3)> =
            triangles.iter().map(|&corners| (corners, corners.map(&place).iter().sum::<Vec3>() / 3.0)).collect();
        let mut tree = Self {
            triangles: Vec::new(),
            edges: Vec::new(),
            vertices: Vec::new(),
            triangle_bounds: vec![Bounds::NOTHING; triangles.len()],
            edge_bounds: Vec::new(),
            nodes: Vec::new(),
        };
        if !order.is_empty() {
            tree.split(&mut order, &mut BTreeSet::new(), &mut BTreeSet::new());
        }
        tree.edge_bounds = vec![Bounds::NOTHING; tree.edges.len()];
        tree
    }

    fn split(&mut self, triangles: &mut [([u32; 3], Vec3)], edges: &mut BTreeSet<[u32; 2]>, vertices: &mut BTreeSet<u32>) {
        let index = self.nodes.len();
        self.nodes.push(Node { bounds: Bounds::NOTHING, second: 0, leaf: None });
        if triangles.len() <= LEAF {
            let from = [self.triangles.len(), self.edges.len(), self.vertices.len()];
            for &([a, b, c], _) in &*triangles {
                self.triangles.push([a, b, c]);
                let sides = [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]);
                self.edges.extend(sides.into_iter().filter(|side| edges.insert(*side)));
                self.vertices.extend([a, b, c].into_iter().filter(|vertex| vertices.insert(*vertex)));
            }
            let to = [self.triangles.len(), self.edges.len(), self.vertices.len()];
            let run = |list: usize| [from[list] as u32, to[list] as u32];
            self.nodes[index].leaf = Some(Leaf { triangles: run(0), edges: run(1), vertices: run(2) });
            return;
        }
        let all = triangles.iter().fold(Bounds::NOTHING, |all, &(_, at)| all.and(Bounds { low: at, high: at }));
        let size = all.high - all.low;
        let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or_default();
        let middle = triangles.len() / 2;
        triangles.select_nth_unstable_by(middle, |a, b| a.1[axis].total_cmp(&b.1[axis]).then(a.0.cmp(&b.0)));
        let (first, second) = triangles.split_at_mut(middle);
        self.split(first, edges, vertices);
        self.nodes[index].second = self.nodes.len() as u32;
        self.split(second, edges, vertices);
    }

    /// Fits all boxes to those of the vertices.
    pub fn refit(&mut self, vertices: &[Bounds]) {
        let of = |vertex: u32| vertices[vertex as usize];
        for (bounds, &[a, b, c]) in self.triangle_bounds.iter_mut().zip(&self.triangles) {
            *bounds = of(a).and(of(b)).and(of(c));
        }
        for (bounds, &[a, b]) in self.edge_bounds.iter_mut().zip(&self.edges) {
            *bounds = of(a).and(of(b));
        }
        for index in (0..self.nodes.len()).rev() {
            self.nodes[index].bounds = match self.nodes[index].leaf {
                Some(Leaf { triangles: [from, to], .. }) => {
                    self.triangle_bounds[from as usize..to as usize].iter().fold(Bounds::NOTHING, |all, bounds| all.and(*bounds))
                }
                None => self.nodes[index + 1].bounds.and(self.nodes[self.nodes[index].second as usize].bounds),
            };
        }
    }

    /// Calls `visit` with the leaves of this tree and another that meet. `stack` is workspace.
    pub fn meet(&self, other: &Self, stack: &mut Vec<[u32; 2]>, mut visit: impl FnMut(&Leaf, &Leaf)) {
        if self.nodes.is_empty() || other.nodes.is_empty() {
            return;
        }
        stack.clear();
        stack.push([0, 0]);
        while let Some(pair) = stack.pop() {
            self.descend(other, pair, stack, &mut visit);
        }
    }

    /// Visits two leaves that meet, or puts the children of two nodes that meet on the stack.
    fn descend(&self, other: &Self, [a, b]: [u32; 2], stack: &mut Vec<[u32; 2]>, visit: &mut impl FnMut(&Leaf, &Leaf)) {
        let (one, two) = (&self.nodes[a as usize], &other.nodes[b as usize]);
        if !one.bounds.meets(&two.bounds) {
            return;
        }
        match (&one.leaf, &two.leaf) {
            (Some(one), Some(two)) => visit(one, two),
            (None, Some(_)) => stack.extend([[one.second, b], [a + 1, b]]),
            (Some(_), None) => stack.extend([[a, two.second], [a, b + 1]]),
            (None, None) => stack.extend([[one.second, two.second], [one.second, b + 1], [a + 1, two.second], [a + 1, b + 1]]),
        }
    }

    /// Calls `visit` with the pairs of leaves of this tree that meet, each with itself, too.
    pub fn meet_itself(&self, stack: &mut Vec<[u32; 2]>, mut visit: impl FnMut(&Leaf, &Leaf)) {
        if self.nodes.is_empty() {
            return;
        }
        stack.clear();
        stack.push([0, 0]);
        while let Some([a, b]) = stack.pop() {
            let node = &self.nodes[a as usize];
            match &node.leaf {
                _ if a != b => self.descend(self, [a, b], stack, &mut visit),
                Some(leaf) => visit(leaf, leaf),
                None => stack.extend([[a + 1, node.second], [node.second, node.second], [a + 1, a + 1]]),
            }
        }
    }

    /// Calls `visit` with the leaves that meet a box.
    pub fn within(&self, bounds: &Bounds, mut visit: impl FnMut(&Leaf)) {
        let mut index = 0;
        // A node that is not met is left out with all below it: the next one is the second child of the last one that was entered.
        let mut later = Vec::new();
        while index < self.nodes.len() {
            let node = &self.nodes[index];
            if node.bounds.meets(bounds) {
                match &node.leaf {
                    Some(leaf) => visit(leaf),
                    None => {
                        later.push(node.second as usize);
                        index += 1;
                        continue;
                    }
                }
            }
            match later.pop() {
                Some(next) => index = next,
                None => return,
            }
        }
    }
}
