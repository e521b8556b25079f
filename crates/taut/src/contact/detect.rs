//! Pairs of features whose ways in a step come near.

use glam::DVec3;
use pulp::{Simd, WithSimd};

use super::batch::{BATCH, Batch};
use super::bounds::{Bounds, Four, meeting, numbers};
use super::met::{Meetings, Met};
use super::proximity::Kind;
use super::rows::square_stood_for;
use super::surfaces::{Owner, Surfaces, Thick};
use super::tree::{Leaf, Tree};
use super::ways::{Asks, Ways};
use super::{FLOOR, MARGIN, Places};
use crate::geometry::{Pool, arch, for_each_part};

/// Two features.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Pair {
    pub kind: Kind,
    pub corners: [u32; 4],
}

/// A pair that was found, how far its features are apart on the way on which it was, at least [m], and whether it may ask for a row there
/// (ways.rs).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate {
    pub pair: Pair,
    pub gap: f32,
    pub may_ask: bool,
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
    met: Meetings,
    /// What parts of the pairs of leaves hold.
    parts: Vec<Vec<Candidate>>,
}

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
            met: Meetings::default(),
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
        self.search(surfaces, places, self.margin, true, &mut pairs, pool);
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
        self.search(surfaces, places, margin, false, &mut pairs, pool);
        self.further = pairs;
    }

    /// Whether the way now was asked about a pair.
    pub fn is_asked(&self, pair: &Pair) -> bool {
        is_asked(&self.asked, pair)
    }

    /// Finds the pairs that come within so many thicknesses; `for_rows` says whether any of them may ask for a row.
    fn search(
        &mut self,
        surfaces: &mut Surfaces,
        places: &Places,
        margin: f64,
        for_rows: bool,
        pairs: &mut Vec<Candidate>,
        pool: &Pool,
    ) {
        let Self { ways, asked, bounds, met, parts, .. } = self;
        pairs.clear();
        // What each of two features is wide adds up to their margin.
        let half = |vertex: usize| (margin * surfaces.skins[surfaces.owners[vertex] as usize].thickness) as f32;
        ways.take(places, half, bounds, pool);
        for tree in surfaces.cloths.iter_mut().chain(&mut surfaces.bodies) {
            tree.refit_nodes(bounds, asked, pool);
        }
        met.find(surfaces, bounds, asked, pool);
        let met = &met.list;
        for Met { trees, leaves, .. } in met.iter().filter(|met| met.thick.is_none()) {
            trees.iter().zip(leaves).for_each(|(tree, leaf)| surfaces.tree_mut(*tree).mark(*leaf));
        }
        for tree in surfaces.cloths.iter_mut().chain(&mut surfaces.bodies) {
            tree.refit_marked(bounds, pool);
        }
        let surfaces = &*surfaces;
        let count = met.len().div_ceil(PART);
        if parts.len() < count {
            parts.resize_with(count, Vec::new);
        }
        let asked = (!for_rows).then_some(&**asked);
        for_each_part(&mut parts[..count], met.len() * PART, pool, |index, pairs| {
            pairs.clear();
            let batches = [Kind::PointTriangle, Kind::EdgeEdge].map(Batch::new);
            let rules = Rules { owners: None, margin: 0.0, enough: 0.0, of_near_part: None, asks: None, stood_for: None };
            let mut found =
                Found { surfaces, thicknesses: margin, for_rows, ways, rules, bounds, asked, batches, pairs, settled: 0 };
            arch().dispatch(Search { found: &mut found, met: met[index * PART..].chunks(PART).next().unwrap_or_default() });
            found.look_at_all();
        });
        parts[..count].iter().for_each(|part| pairs.extend(part));
    }
}

/// Looks at pairs of leaves.
struct Search<'a, 'b> {
    found: &'b mut Found<'a>,
    met: &'b [Met],
}

impl WithSimd for Search<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.met.iter().for_each(|met| self.found.features_of(met));
    }
}

/// The pairs that are found, and what they are looked for with: how many thicknesses apart they may be, and whether any of them may ask
/// for a row.
struct Found<'a> {
    surfaces: &'a Surfaces,
    thicknesses: f64,
    for_rows: bool,
    ways: &'a Ways,
    rules: Rules,
    bounds: &'a [Bounds],
    /// The vertices that are asked about, if it is not all.
    asked: Option<&'a [bool]>,
    /// Pairs that have not been looked at yet, by their kind.
    batches: [Batch; 2],
    pairs: &'a mut Vec<Candidate>,
    /// Of so many of the pairs it is known whether they may ask for a row.
    settled: usize,
}

/// What counts between two owners.
struct Rules {
    owners: Option<[Owner; 2]>,
    /// Pairs that are as far apart count no more, radii included [m]; the same, no less, where one of both is thick.
    margin: f64,
    /// What need not be told better of the pairs of two owners [m]. Those of one are mostly neighbours in a plane: no second line helps there.
    enough: f32,
    of_near_part: Option<f32>,
    /// What they ask of rows, by their kind, if any may. Beside something thick, vertices stand for what has no longer sides [m].
    asks: Option<[Asks; 2]>,
    stood_for: Option<f32>,
}

impl Rules {
    fn of(surfaces: &Surfaces, owners: [Owner; 2], margin: f64, for_rows: bool) -> Self {
        let (thickness, radius) = (surfaces.thickness(owners), surfaces.radius(owners));
        let are_sides = surfaces.are_surfaces(owners);
        let asks = |kind: Kind| {
            let within = (surfaces.margin(kind, owners) * thickness + radius) * (1.0 + f64::from(f32::EPSILON));
            Asks { within: within as f32, are_sides }
        };
        let asks = for_rows.then(|| [Kind::PointTriangle, Kind::EdgeEdge].map(asks));
        let margin = margin * thickness + radius;
        let has_vertices = radius > 0.0 && owners.iter().any(|&owner| surfaces.skins[owner as usize].is_surface);
        let stood_for = has_vertices.then(|| square_stood_for(radius, thickness).sqrt() as f32);
        let of_near_part = (radius > 0.0).then_some((margin * (1.0 + f64::from(f32::EPSILON))) as f32);
        let enough = if owners[0] == owners[1] { f32::NEG_INFINITY } else { margin as f32 };
        Self { owners: Some(owners), margin, enough, of_near_part, asks, stood_for }
    }
}

impl Found<'_> {
    /// The features of two leaves, or of one and something thick.
    #[inline(always)]
    fn features_of(&mut self, &Met { trees, leaves: [one, two], thick }: &Met) {
        let [a, b] = trees.map(|index| self.surfaces.tree(index));
        let leaves = [&a.leaves[one as usize], &b.leaves[two as usize]];
        let owner = |tree: &Tree| self.surfaces.owners[tree.vertices[0] as usize];
        if let Some(number) = thick {
            let thick = &self.surfaces.thick[number as usize];
            self.follow([owner(a), thick.owner]);
            self.beside(a, leaves[0], thick, self.surfaces.skins[thick.owner as usize].radius);
            return;
        }
        self.follow([owner(a), owner(b)]);
        if trees[0] == trees[1] && one == two {
            self.within(a, leaves[0]);
        } else {
            self.between([a, b], leaves);
        }
    }

    /// A leaf with itself.
    #[inline(always)]
    fn within(&mut self, tree: &Tree, leaf: &Leaf) {
        let [triangles, edges, _] = tree.fours(leaf);
        let own = &tree.triangles[range(leaf.triangles)];
        for &vertex in &tree.vertices[range(leaf.vertices)] {
            self.point_and_triangles(vertex, own, triangles, u32::MAX);
        }
        let own = &tree.edges[range(leaf.edges)];
        for (edge, number) in own.iter().zip(1..) {
            self.two_edges(*edge, own, edges, u32::MAX.unbounded_shl(number));
        }
    }

    /// Two leaves of two trees, or of one. Of each of them those features count that meet the box of the other one.
    #[inline(always)]
    fn between(&mut self, trees: [&Tree; 2], leaves: [&Leaf; 2]) {
        let boxes = [0, 1].map(|side| Four::same(&trees[side].bounds_of(leaves[side])));
        let fours = [0, 1].map(|side| trees[side].fours(leaves[side]));
        let near = |side: usize, list: usize| meeting(fours[side][list], &boxes[1 - side], u32::MAX);
        for [this, that] in [[0, 1], [1, 0]] {
            let near_triangles = near(that, 0);
            if near_triangles == 0 {
                continue;
            }
            let vertices = &trees[this].vertices[range(leaves[this].vertices)];
            let triangles = &trees[that].triangles[range(leaves[that].triangles)];
            for number in numbers(near(this, 2)) {
                self.point_and_triangles(vertices[number as usize], triangles, fours[that][0], near_triangles);
            }
        }
        let near_edges = near(1, 1);
        if near_edges != 0 {
            let [ones, others] = [0, 1].map(|side| &trees[side].edges[range(leaves[side].edges)]);
            for number in numbers(near(0, 1)) {
                self.two_edges(ones[number as usize], others, fours[1][1], near_edges);
            }
        }
    }

    /// A leaf and a thick vertex or edge.
    fn beside(&mut self, tree: &Tree, leaf: &Leaf, thick: &Thick, radius: f64) {
        let (bounds, vertices, half) = (self.bounds, &thick.vertices, radius as f32);
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
    }

    /// A vertex and those of some triangles that count.
    #[inline(always)]
    fn point_and_triangles(&mut self, vertex: u32, triangles: &[[u32; 3]], fours: &[Four], among: u32) {
        let around = Four::same(&self.bounds[vertex as usize]);
        for number in numbers(meeting(fours, &around, among)) {
            let [a, b, c] = triangles[number as usize];
            if ![a, b, c].contains(&vertex) {
                self.add(Kind::PointTriangle, [vertex, a, b, c]);
            }
        }
    }

    /// An edge and those of others that count.
    #[inline(always)]
    fn two_edges(&mut self, [p, q]: [u32; 2], others: &[[u32; 2]], fours: &[Four], among: u32) {
        let around = Four::same(&self.bounds[p as usize].and(self.bounds[q as usize]));
        for number in numbers(meeting(fours, &around, among)) {
            let [r, s] = others[number as usize];
            if p != r && p != s && q != r && q != s {
                self.add(Kind::EdgeEdge, [p, q, r, s]);
            }
        }
    }

    #[inline(always)]
    fn add(&mut self, kind: Kind, corners: [u32; 4]) {
        if self.asked.is_some_and(|asked| !is_asked(asked, &Pair { kind, corners })) {
            return;
        }
        if self.batches[kind as usize].put(corners) {
            self.look(kind);
        }
    }

    /// Goes on with pairs of two owners, to which other `rules` may apply.
    fn follow(&mut self, owners: [Owner; 2]) {
        if self.rules.owners != Some(owners) {
            self.look_at_all();
            self.rules = Rules::of(self.surfaces, owners, self.thicknesses, self.for_rows);
        }
    }

    /// Looks at all that wait, and finds out which of the pairs that are near enough may ask for rows: that takes longer, so it comes last.
    fn look_at_all(&mut self) {
        self.look(Kind::PointTriangle);
        self.look(Kind::EdgeEdge);
        if let Some(asks) = self.rules.asks {
            self.ask(Kind::PointTriangle, asks[0]);
            self.ask(Kind::EdgeEdge, asks[1]);
        }
        self.settled = self.pairs.len();
    }

    /// Keeps those of the pairs of a kind that wait which are near enough.
    fn look(&mut self, kind: Kind) {
        let Self { ways, rules: Rules { margin, enough, of_near_part, .. }, batches, pairs, .. } = self;
        // About half are near enough, so that to branch would be slow.
        let (batch, mut kept) = (&mut batches[kind as usize], pairs.len());
        pairs.resize(kept + batch.count(), Candidate { pair: Pair { kind, corners: [0; 4] }, gap: 0.0, may_ask: false });
        for (pair, gap) in batch.take(ways, *of_near_part, *enough) {
            pairs[kept] = Candidate { pair, gap, may_ask: false };
            kept += usize::from(f64::from(gap) < *margin);
        }
        pairs.truncate(kept);
    }

    /// Finds out which of those of a kind that are not known yet may ask for rows.
    fn ask(&mut self, kind: Kind, asks: Asks) {
        let Self { ways, rules: Rules { stood_for, .. }, pairs, settled, .. } = self;
        let (mut batch, mut waiting) = (Batch::new(kind), [0; BATCH]);
        for index in *settled..pairs.len() {
            let Candidate { pair, gap, .. } = pairs[index];
            let is_stood_for = || stood_for.is_some_and(|longest| ways.are_within(&pair.corners[kind.split()..], longest));
            if pair.kind == kind && gap < asks.within && !is_stood_for() {
                waiting[batch.count()] = index;
                if batch.put(pair.corners) {
                    batch.may_ask(ways, asks).zip(waiting).for_each(|(may_ask, index)| pairs[index].may_ask = may_ask);
                }
            }
        }
        batch.may_ask(ways, asks).zip(waiting).for_each(|(may_ask, index)| pairs[index].may_ask = may_ask);
    }
}

/// A box around what is thick.
pub(super) fn around(bounds: &[Bounds], thick: &Thick, radius: f32) -> Bounds {
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
