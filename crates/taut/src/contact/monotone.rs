//! Charts that cannot touch themselves in a step.
//!
//! With u the rest coordinates of a chart and J the derivatives, by u, of places projected onto a plane with fixed axes, two points of
//! the domain are projected to places apart by at least `LEAST` times their distance at rest, if the symmetric part of J is at least
//! that on every triangle: `du . (p(u + du) - p(u))` is the integral of `du . J du` along the line between them, which stays on the
//! chart. J is linear in places, so that what holds at the start and at the end of a step holds on all of its straight way.

use glam::{BVec4A, DVec3, Vec2, Vec3, Vec3A, Vec4, Vec4Swizzles};
use pulp::{Simd, WithSimd};

use super::Places;
use super::charts::{Chart, Charts};
use super::tree::{Leaf, Tree};
use crate::geometry::{Pool, arch, for_each_chunk, for_each_part};

/// The least derivative along any line of a chart that is monotone [1].
const LEAST: f32 = 0.2;
/// What is known of derivatives is rounded by far less than this [1].
const ROUNDING: f32 = 0.01;
/// Triangles in the cores of charts, at most. Around smaller ones most triangles are looked at more often, larger ones bend too much.
const CORE: usize = 44;

/// Charts that a thread looks at together.
const PART: usize = 32;
/// Triangles that are looked at without asking in between.
const TOGETHER: usize = 16;

/// Which charts of a surface are monotone in a step.
#[derive(Debug, Clone, Default)]
pub(crate) struct Monotone {
    charts: Charts,
    parts: Vec<Part>,
    /// Workspace: of each leaf of the tree, the most by which derivatives have changed [1].
    changes: Vec<f32>,
}

/// Some charts, one after the other.
#[derive(Debug, Clone, Default)]
struct Part {
    /// Which are monotone, and which were on the way before; and how each is laid on a plane.
    now: [bool; PART],
    before: [bool; PART],
    laid: [Laid; PART],
    flat: Flat,
}

/// How a chart is laid on a plane: its axes, and by how much derivatives are more than `LEAST` on the known way, at least [1].
#[derive(Debug, Clone, Copy, Default)]
struct Laid {
    axes: [Vec3; 2],
    spare: f32,
}

/// Workspace: the places of the vertices of a chart, from the first one, at the start and at the end [m]; and those laid on a plane.
#[derive(Debug, Clone, Default)]
struct Flat {
    places: Vec<[Vec3A; 2]>,
    laid: Vec<Vec4>,
}

impl Monotone {
    /// The charts of a surface; `place` is where a vertex is at rest [m].
    pub fn new(tree: &Tree, place: impl Fn(u32) -> DVec3) -> Self {
        let charts = Charts::new(tree, place, CORE);
        let parts = vec![Part::default(); charts.list.len().div_ceil(PART)];
        Self { charts, parts, changes: vec![0.0; tree.leaves.len()] }
    }

    /// Finds out which are.
    pub fn run(&mut self, places: &Places, pool: &Pool) {
        self.parts.iter_mut().for_each(|part| part.now.fill(true));
        self.find(
            pool,
            #[inline(always)]
            |charts, chart, laid, flat| {
                laid.axes = lay(charts, chart, places, flat);
                let holds;
                (holds, laid.spare) = look(charts, chart, flat);
                holds
            },
        );
    }

    /// Finds out which of them still are on another way with the same start, where the known way had such `ends`; and tells the vertices
    /// of those that are no longer.
    pub fn run_again(&mut self, tree: &Tree, places: &Places, ends: &[DVec3], pool: &Pool, mut tell: impl FnMut(u32)) {
        self.parts.iter_mut().for_each(|part| part.before = part.now);
        let (mut changes, largest) = (std::mem::take(&mut self.changes), &self.charts.largest);
        for_each_chunk(&mut changes, pool, |first, changes| {
            for (change, leaf) in changes.iter_mut().zip(&tree.leaves[first..]) {
                *change = change_of(tree, leaf, largest, |vertex| places.ends[vertex as usize] - ends[vertex as usize]);
            }
        });
        self.find(
            pool,
            #[inline(always)]
            |charts, chart, laid, flat| {
                let around = &charts.around[chart.around.clone()];
                let change = most(around.iter().map(|&leaf| changes[leaf as usize]));
                laid.spare > change + ROUNDING || {
                    lay_ends(charts, chart, places, laid.axes, flat);
                    look(charts, chart, flat).0
                }
            },
        );
        self.changes = changes;
        let Self { charts, parts, .. } = self;
        let are_lost = parts.iter().flat_map(|part| part.before.iter().zip(&part.now).map(|(before, now)| *before && !now));
        for (chart, _) in charts.list.iter().zip(are_lost).filter(|(_, is_lost)| *is_lost) {
            charts.leaves[chart.leaves.clone()].iter().for_each(|&leaf| tree.vertices_of(leaf).for_each(&mut tell));
        }
    }

    /// Whether two leaves cannot touch each other, or one itself, as they are on a chart that is monotone.
    pub fn spares(&self, one: &Leaf, other: &Leaf) -> bool {
        [[one, other], [other, one]].into_iter().any(|[core, leaf]| {
            // Networks have no charts.
            let Some(&chart) = self.charts.of_leaf.get(core.index as usize) else { return false };
            let leaves = self.charts.leaves_of(chart);
            self.is_monotone(chart) && [core, leaf].iter().all(|leaf| leaves.binary_search(&leaf.index).is_ok())
        })
    }

    fn is_monotone(&self, chart: u32) -> bool {
        self.parts[chart as usize / PART].now[chart as usize % PART]
    }

    /// Finds out for which of those that were monotone `holds` says that they are.
    fn find(&mut self, pool: &Pool, holds: impl Fn(&Charts, &Chart, &mut Laid, &mut Flat) -> bool + Sync) {
        let Self { charts, parts, .. } = self;
        for_each_part(parts, charts.facets.len(), pool, |index, part| {
            let own = charts.list.chunks(PART).nth(index).unwrap_or_default();
            arch().dispatch(Looks { charts, own, part, holds: &holds });
        });
    }
}

/// Looks at the charts of a part.
struct Looks<'a, H> {
    charts: &'a Charts,
    own: &'a [Chart],
    part: &'a mut Part,
    holds: H,
}

impl<H: Fn(&Charts, &Chart, &mut Laid, &mut Flat) -> bool> WithSimd for Looks<'_, H> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { charts, own, part: Part { now, laid, flat, .. }, holds } = self;
        for ((is_monotone, laid), chart) in now.iter_mut().zip(laid).zip(own) {
            *is_monotone = *is_monotone && holds(charts, chart, laid, flat);
        }
    }
}

/// The most by which what has moved since changes the derivatives of the triangles of a leaf, at least [1]. With E its edges and A what makes
/// derivatives of them, that of the symmetric part of `E A`, projected onto any plane, is at most `|dE| |A|`.
fn change_of(tree: &Tree, leaf: &Leaf, largest: &[f32], moved: impl Fn(u32) -> DVec3) -> f32 {
    let [from, to] = leaf.triangles.map(|triangle| triangle as usize);
    let of = |(corners, largest): (&[u32; 3], &f32)| {
        let [a, b, c] = corners.map(&moved);
        let [b, c] = [b - a, c - a].map(|edge| edge.as_vec3a().length_squared());
        (b + c) * largest * largest
    };
    most(tree.triangles[from..to].iter().zip(&largest[from..to]).map(of)).sqrt()
}

/// The largest of numbers that are not below zero. What is no number counts as the largest: its bits do.
fn most(numbers: impl Iterator<Item = f32>) -> f32 {
    f32::from_bits(numbers.map(|number| number.abs().to_bits()).max().unwrap_or_default())
}

/// Lays a chart on the plane that fits it at the start and at the end: two numbers of a vertex for each. Returns the axes of the plane.
#[inline(always)]
fn lay(charts: &Charts, chart: &Chart, places: &Places, flat: &mut Flat) -> [Vec3; 2] {
    let Flat { places: own, laid } = flat;
    own.clear();
    laid.clear();
    let vertices = &charts.vertices[chart.vertices.clone()];
    let Some(&(origin, _)) = vertices.first() else { return [Vec3::ZERO; 2] };
    let [mut first, mut second] = [Vec3A::ZERO; 2];
    own.extend(vertices.iter().map(|&(vertex, [u, v])| {
        let [start, end] = [&places.x, &places.ends].map(|places| from_origin(places, origin, vertex));
        first += (start + end) * u;
        second += (start + end) * v;
        [start, end]
    }));
    let [first, second] = chart.spread.map(|[of_first, of_second]| (first * of_first + second * of_second).normalize_or_zero());
    // The two axes at right angles that are nearest to both directions.
    let [sum, difference] = [first + second, first - second].map(|way| way.normalize_or_zero() * std::f32::consts::FRAC_1_SQRT_2);
    let axes = [sum + difference, sum - difference];
    laid.extend(own.iter().map(|&[start, end]| {
        let [[x, y], [then_x, then_y]] = [start, end].map(|place| axes.map(|axis| axis.dot(place)));
        Vec4::new(x, y, then_x, then_y)
    }));
    axes.map(Vec3::from)
}

/// Lays a chart on the same plane at the end alone.
#[inline(always)]
fn lay_ends(charts: &Charts, chart: &Chart, places: &Places, axes: [Vec3; 2], flat: &mut Flat) {
    flat.laid.clear();
    let vertices = &charts.vertices[chart.vertices.clone()];
    let Some(&(origin, _)) = vertices.first() else { return };
    let axes = axes.map(Vec3A::from);
    flat.laid.extend(vertices.iter().map(|&(vertex, _)| {
        let end = from_origin(&places.ends, origin, vertex);
        let [x, y] = axes.map(|axis| axis.dot(end));
        Vec4::new(x, y, x, y)
    }));
}

/// Where a vertex is, seen from another one [m].
#[inline(always)]
fn from_origin(places: &[DVec3], origin: u32, vertex: u32) -> Vec3A {
    (places[vertex as usize] - places[origin as usize]).as_vec3a()
}

/// Whether the symmetric part of the derivatives is large enough on all triangles of a chart that has any, at both times; and by how much
/// more than that, at least [1].
#[inline(always)]
fn look(charts: &Charts, chart: &Chart, flat: &Flat) -> (bool, f32) {
    let mut spare = Vec4::INFINITY;
    let mut rises = !chart.leaves.is_empty();
    let rest = &charts.vertices[chart.vertices.clone()];
    for facets in charts.facets[chart.facets.clone()].chunks(TOGETHER) {
        for facet in facets {
            rises &= rise(facet.map(usize::from), rest, &flat.laid, &mut spare);
        }
        if !rises {
            return (false, 0.0);
        }
    }
    (rises, spare.min_element())
}

/// The same of a triangle. With J the derivatives at one time, [xx, xy] those by the first axis, that is `xx > LEAST`, `yy > LEAST` and
/// `(xx - LEAST) (yy - LEAST) > ((xy + yx) / 2)^2`.
#[inline(always)]
fn rise(corners: [usize; 3], rest: &[(u32, [f32; 2])], laid: &[Vec4], spare: &mut Vec4) -> bool {
    let [a, b, c] = corners.map(|corner| Vec2::from(rest[corner].1));
    let (u, v) = (b - a, c - a);
    let inverse = 1.0 / u.perp_dot(v);
    let (u, v) = (u * inverse, v * inverse);
    let [a, b, c] = corners.map(|corner| laid[corner]);
    let (b, c) = (b - a, c - a);
    let (x, y) = (b * v.y - c * u.y, c * u.x - b * v.x);
    let firsts = BVec4A::new(true, false, true, false);
    let (along, across) = (Vec4::select(firsts, x, y) - LEAST, Vec4::select(firsts, y, x));
    let both = 0.5 * (across + across.yxwz());
    // The least eigenvalue is no less than the lesser of both less what is across.
    *spare = spare.min(along - both.abs());
    (along.cmpgt(Vec4::ZERO) & (along * along.yxwz()).cmpgt(both * both)).all()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::pierce::pierces;
    use super::*;

    const ACROSS: u32 = 16;

    /// A crooked sheet of 1 m in the plane of x and y with a hole in it, its tree and its charts.
    fn sheet() -> (Vec<DVec3>, Tree, Monotone) {
        let random = |seed: u32| (f64::from(seed) * 0.618_034).fract() - 0.5;
        let place = |at: u32, seed: u32| {
            let off = if at == 0 || at == ACROSS { 0.0 } else { 0.5 * random(seed) };
            (f64::from(at) + off) / f64::from(ACROSS)
        };
        let vertices = 0..(ACROSS + 1).pow(2);
        let rest: Vec<DVec3> = vertices
            .map(|vertex| {
                DVec3::new(place(vertex % (ACROSS + 1), 7 * vertex), place(vertex / (ACROSS + 1), 13 * vertex + 3), 0.0)
            })
            .collect();
        let cells = (0..ACROSS * ACROSS).map(|cell| [cell % ACROSS, cell / ACROSS]);
        let whole = cells.filter(|[i, j]| !((5..8).contains(i) && (9..11).contains(j)));
        let triangles: Vec<[u32; 3]> = whole
            .flat_map(|[i, j]| {
                let a = j * (ACROSS + 1) + i;
                let [b, c, d] = [a + 1, a + ACROSS + 2, a + ACROSS + 1];
                if (i + j) % 3 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
            })
            .collect();
        let tree = Tree::new(&triangles, |vertex| rest[vertex as usize].as_vec3());
        let monotone = Monotone::new(&tree, |vertex| rest[vertex as usize]);
        (rest, tree, monotone)
    }

    fn places(x: Vec<DVec3>, ends: Vec<DVec3>) -> Places {
        Places { x, ends, ..Places::default() }
    }

    /// How many pairs of neighbouring leaves there are, and how many of them are spared.
    fn spared(tree: &Tree, monotone: &Monotone) -> [usize; 2] {
        let mut counts = [0; 2];
        for one in &tree.leaves {
            let own: Vec<u32> = tree.vertices_of(one.index).collect();
            for other in &tree.leaves[one.index as usize..] {
                if tree.vertices_of(other.index).any(|vertex| own.contains(&vertex)) {
                    counts[0] += 1;
                    counts[1] += usize::from(monotone.spares(one, other));
                }
            }
        }
        counts
    }

    #[test]
    fn what_is_flat_is_spared_however_it_lies_and_what_is_folded_is_not() {
        let (rest, tree, mut monotone) = sheet();
        let turned: Vec<DVec3> = rest.iter().map(|place| DVec3::new(3.0 - place.y, 0.6 * place.x, 2.0 - 0.8 * place.x)).collect();
        monotone
            .run(&places(turned.clone(), turned.iter().map(|place| *place + DVec3::new(0.1, 5.0, 0.0)).collect()), &Pool::new(1));
        let [neighbours, flat] = spared(&tree, &monotone);
        assert!(flat * 3 > neighbours * 2, "{flat} of {neighbours}");
        // The hole bounds domains; far from it all neighbours are spared.
        let is_far = |leaf: &Leaf| tree.vertices_of(leaf.index).all(|vertex| rest[vertex as usize].x > 0.8);
        let far: Vec<&Leaf> = tree.leaves.iter().filter(|leaf| is_far(leaf)).collect();
        let mut count = 0;
        for (one, other) in far.iter().flat_map(|one| far.iter().map(move |other| (*one, *other))) {
            let own: Vec<u32> = tree.vertices_of(one.index).collect();
            if tree.vertices_of(other.index).any(|vertex| own.contains(&vertex)) {
                count += 1;
                assert!(monotone.spares(one, other), "{} and {}", one.index, other.index);
            }
        }
        assert!(count >= 20, "{count}");
        // Laid over along its middle, with a gap.
        let folded: Vec<DVec3> =
            rest.iter().map(|place| if place.x > 0.5 { DVec3::new(1.0 - place.x, place.y, 0.01) } else { *place }).collect();
        monotone.run(&places(rest.clone(), folded), &Pool::new(1));
        for one in &tree.leaves {
            for other in &tree.leaves {
                let side = |leaf: &Leaf| tree.vertices_of(leaf.index).map(|vertex| rest[vertex as usize].x);
                let across = side(one).fold(1.0, f64::min) < 0.45 && side(other).fold(0.0, f64::max) > 0.55;
                assert!(!(across && monotone.spares(one, other)), "layers that lie on each other are not spared");
            }
        }
        // A way on which it goes through itself: flat at both ends, but for a mirror.
        monotone.run(&places(rest.clone(), rest.iter().map(|place| DVec3::new(-place.x, place.y, 0.0)).collect()), &Pool::new(1));
        assert_eq!(spared(&tree, &monotone)[1], 0);
    }

    #[test]
    fn what_has_been_spared_and_no_longer_is_gets_told() {
        let (rest, tree, mut monotone) = sheet();
        monotone.run(&places(rest.clone(), rest.clone()), &Pool::new(1));
        let before = spared(&tree, &monotone)[1];
        let mut told = vec![false; rest.len()];
        let crumpled = rest.iter().map(|place| if place.x > 0.8 { DVec3::new(1.6 - place.x, place.y, 0.0) } else { *place });
        let crumpled = places(rest.clone(), crumpled.collect());
        monotone.run_again(&tree, &crumpled, &rest, &Pool::new(1), |vertex| told[vertex as usize] = true);
        let after = spared(&tree, &monotone)[1];
        assert!(0 < after && after < before, "{after} of {before}");
        let mut lost = Monotone::new(&tree, |vertex| rest[vertex as usize]);
        lost.run(&places(rest.clone(), rest.clone()), &Pool::new(1));
        lost.run_again(&tree, &places(rest.clone(), vec![DVec3::NAN; rest.len()]), &rest, &Pool::new(1), |_| ());
        assert_eq!(spared(&tree, &lost)[1], 0);
        for one in &tree.leaves {
            let is_told = tree.vertices_of(one.index).any(|vertex| told[vertex as usize]);
            let is_far = tree.vertices_of(one.index).all(|vertex| rest[vertex as usize].x < 0.3);
            let is_turned = tree.vertices_of(one.index).all(|vertex| rest[vertex as usize].x > 0.8);
            assert!(!(is_far && is_told) && (!is_turned || is_told));
        }
    }

    proptest! {
        /// What is known of the known way never says more than looking at all triangles would.
        #[test]
        fn what_has_hardly_moved_is_as_if_it_were_looked_at(
            high in 0.0..0.3_f64,
            fast in 1.0..9.0_f64,
            moved in 0.0..0.06_f64,
            turned in 0.0..6.0_f64,
        ) {
            let (rest, tree, mut monotone) = sheet();
            let random = |seed: usize| (seed as f64 * 0.618_034).fract() - 0.5;
            let wave = |place: &DVec3| *place + DVec3::Z * high * (fast * (place.x + place.y * turned.cos())).sin();
            let x: Vec<DVec3> = rest.iter().map(wave).collect();
            let shift = |(vertex, place): (usize, &DVec3)| {
                *place + moved * DVec3::new(random(7 * vertex), random(11 * vertex + 5), random(13 * vertex + 1))
            };
            let ends: Vec<DVec3> = x.iter().enumerate().map(shift).collect();
            monotone.run(&places(x.clone(), x.clone()), &Pool::new(1));
            let mut everywhere = monotone.clone();
            let laid = everywhere.parts.iter_mut().flat_map(|part| &mut part.laid);
            laid.for_each(|laid| laid.spare = 0.0);
            let again = places(x.clone(), ends);
            let told = [&mut monotone, &mut everywhere].map(|monotone| {
                let mut told = vec![false; x.len()];
                monotone.run_again(&tree, &again, &x, &Pool::new(1), |vertex| told[vertex as usize] = true);
                told
            });
            prop_assert_eq!(&told[0], &told[1]);
            for one in &tree.leaves {
                for other in &tree.leaves {
                    prop_assert_eq!(monotone.spares(one, other), everywhere.spares(one, other));
                }
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn what_is_spared_does_not_meet_on_its_way(
            waves in prop::array::uniform2((0.0..0.35_f64, 1.0..14.0_f64, 0.0..6.0_f64, 0.0..0.12_f64)),
            noise in 0.0..0.02_f64,
            time in 0.0..1.0_f64,
        ) {
            let (rest, tree, mut monotone) = sheet();
            let random = |seed: usize| (seed as f64 * 0.618_034).fract() - 0.5;
            let [x, ends] = [0, 1].map(|when| {
                let (high, fast, turned, wide) = waves[when];
                let of = |(vertex, place): (usize, &DVec3)| {
                    let along = fast * (place.x * turned.cos() + place.y * turned.sin());
                    let shift = DVec3::new(wide * along.cos(), wide * (1.7 * along).sin(), high * along.sin());
                    *place + shift + noise * DVec3::new(random(7 * vertex + when), random(11 * vertex + 5), random(13 * vertex + 1))
                };
                rest.iter().enumerate().map(of).collect::<Vec<_>>()
            });
            let then: Vec<DVec3> = x.iter().zip(&ends).map(|(from, to)| from.lerp(*to, time)).collect();
            monotone.run(&places(x, ends), &Pool::new(1));
            let triangles = |leaf: &Leaf| &tree.triangles[leaf.triangles[0] as usize..leaf.triangles[1] as usize];
            for one in &tree.leaves {
                for other in tree.leaves.iter().filter(|other| monotone.spares(one, other)) {
                    for &[a, b, c] in triangles(one) {
                        for corners in triangles(other) {
                            for edge in [[a, b], [b, c], [c, a]].into_iter().filter(|edge| !edge.iter().any(|end| corners.contains(end))) {
                                let met = pierces(edge.map(|end| then[end as usize]), corners.map(|corner| then[corner as usize]));
                                prop_assert!(met.is_none(), "{:?} meets {:?}", edge, corners);
                            }
                        }
                    }
                }
            }
        }
    }
}
