//! Which pairs want rows.

use glam::DVec3;

use super::super::detect::{Candidate, Pair};
use super::super::proximity::{Closest, Kind};
use super::super::surfaces::{Owner, Surfaces};
use super::super::{FLOOR, MARGIN, NEAR, Places};
use super::NONE;

/// A neighbour that is nearer by this part of its distance: the pair is not the nearest one there [1].
const NEARER: f64 = 0.25;
/// The same where a point meets an edge or a point: it is over a triangle beside them then, which has a row. One along a line that is
/// tilted towards where the point goes would hold it up as it slides over an inner edge of what is flat. Balls, which touch many places
/// at once, are no such points, and of what is joined by few edges the triangle beside may have the point as a corner. Where
/// things intersect it may be one that brings them apart instead.
const OVER: f64 = 0.02;
/// Where an edge or a triangle meets an edge or a vertex of a body, that has to stick out: the sines by which its neighbours are further
/// away add up to more than this [1]. On what is flat or hollow, however tilted the cloth, vertices stand on the triangles beside it.
const STICKS_OUT: f64 = 1e-3;

/// A row that is wanted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    pub corners: [u32; 4],
    pub parts: [f64; 4],
    /// So many of the corners are those of the first feature.
    pub split: usize,
    pub owners: [Owner; 2],
    pub normal: DVec3,
    /// The distance along the normal at X, the one that thicknesses ask for, and the one that this step shall bring [m].
    pub distance: f64,
    pub thickness: f64,
    pub target: f64,
    /// What a turning body adds to the relative displacement along it [m].
    pub carried: DVec3,
}

impl Wanted {
    /// What a pair asks for, if it is near, or comes near, on the way on which it was found, unless that `is_implied` by other rows; `all` says
    /// whether all pairs that are may ask.
    pub fn of(
        surfaces: &Surfaces,
        places: &Places,
        candidate: Candidate,
        all: bool,
        is_implied: impl FnOnce(&Self) -> bool,
    ) -> Option<Self> {
        // Most pairs are far enough from each other, and stay so.
        let Candidate { pair, gap, may_ask: true } = candidate else { return None };
        let Pair { kind, corners } = pair;
        let gap = f64::from(gap);
        let split = kind.split();
        let owners = surfaces.owners_of(pair);
        let (thickness, radius) = (surfaces.thickness(owners), surfaces.radius(owners));
        let part = surfaces.margin(kind, owners);
        // Of those that are joined nearly all are.
        if gap >= part * thickness + radius {
            return None;
        }
        let are_near = owners[0] == owners[1] && is_near(surfaces, corners, split);
        let (part, thickness) = if are_near { (MARGIN, NEAR * thickness) } else { (part, thickness) };
        if gap >= part * thickness + radius {
            return None;
        }
        let x = corners.map(|corner| places.x[corner as usize]);
        let closest = Closest::new(kind, &x);
        let length = closest.way.length();
        if kind == Kind::EdgeEdge && is_stood_for(surfaces, owners, &closest) {
            return None;
        }
        let normal = if length > 0.0 { closest.way / length } else { across(surfaces, owners, x)? };
        let distance = length - radius;
        let end: DVec3 = (0..4).map(|end| places.ends[corners[end] as usize] * closest.parts[end]).sum();
        let margin = part * thickness;
        if distance > margin && normal.dot(end) - radius > margin {
            return None;
        }
        let target = places.target(thickness, distance);
        let carried = carried(surfaces, places, owners, normal);
        let wanted = Self { corners, parts: closest.parts, split, owners, normal, distance, thickness, target, carried };
        if is_implied(&wanted) {
            return None;
        }
        let is_thick = owners.iter().any(|&owner| surfaces.skins[owner as usize].radius > 0.0);
        let over = if all && !is_thick && !are_near { OVER } else { NEARER };
        // What is nearer than the certificate allows may lose hardly anything of that, whatever else is beside it.
        let is_scarce = distance < FLOOR * surfaces.thickness(owners);
        (is_scarce || is_nearest(surfaces, places, corners, &closest, split, normal, over)).then_some(wanted)
    }
}

/// Whether a point and a triangle stand for two edges: those are closest at the end of one of them, and the other one is the side of a
/// triangle. Links, and what is thick, are sides of none.
fn is_stood_for(surfaces: &Surfaces, owners: [Owner; 2], closest: &Closest) -> bool {
    let (one, other) = closest.parts.split_at(Kind::EdgeEdge.split());
    let is_surface = owners.map(|owner| surfaces.skins[owner as usize].is_surface);
    one.contains(&0.0) && is_surface[1] || other.contains(&0.0) && is_surface[0]
}

/// Across two links that touch exactly: with nothing to say which of them is on which side, one of both ways is as good as the other.
fn across(surfaces: &Surfaces, owners: [Owner; 2], [a, b, c, d]: [DVec3; 4]) -> Option<DVec3> {
    let is_link = |owner: Owner| {
        let skin = &surfaces.skins[owner as usize];
        !skin.is_surface && skin.radius == 0.0
    };
    owners.into_iter().all(is_link).then(|| (b - a).cross(d - c).try_normalize()).flatten()
}

/// What the turn of a ball or a capsule adds to the relative displacement of two features: its surface is that far from its vertices. The
/// normal points to the first of the two, whichever is the body: either way the place on the surface is one radius along or against it.
pub(super) fn carried(surfaces: &Surfaces, places: &Places, owners: [Owner; 2], normal: DVec3) -> DVec3 {
    let cloths = surfaces.cloths.len();
    let of = |owner: Owner| match (owner as usize).checked_sub(cloths) {
        Some(body) => places.turns[body].cross(normal) * -surfaces.skins[owner as usize].radius,
        None => DVec3::ZERO,
    };
    owners.into_iter().map(of).sum()
}

/// Whether features of one surface are joined by so few edges that they cannot keep its thickness.
pub(super) fn is_near(surfaces: &Surfaces, corners: [u32; 4], split: usize) -> bool {
    let (one, other) = corners.split_at(split);
    one.iter().any(|&a| other.iter().any(|&b| surfaces.are_near(a, b)))
}

/// Whether no neighbour of either feature is nearer to the other along the normal. Between two points of a link there is nothing but the
/// link, whatever else both are tied to.
fn is_nearest(
    surfaces: &Surfaces,
    places: &Places,
    corners: [u32; 4],
    closest: &Closest,
    split: usize,
    normal: DVec3,
    over: f64,
) -> bool {
    let [one, other] = [0..split, split..4].map(|range| range.filter(|&end| closest.parts[end] != 0.0).count());
    let side = |range: std::ops::Range<usize>, opposite: usize, toward: DVec3| {
        let counts = range.clone().filter(|&end| closest.parts[end] != 0.0);
        let mut vertices = [NONE; 3];
        let (mut count, mut point) = (0, DVec3::ZERO);
        for end in counts {
            vertices[count] = corners[end];
            count += 1;
            point += places.x[corners[end] as usize] * closest.parts[end].abs();
        }
        let is_body = surfaces.owners[corners[range.start] as usize] as usize >= surfaces.cloths.len();
        let part = if opposite == 1 { over } else { NEARER };
        // No neighbour is nearer; and together they are further, seen along an edge, unless there are fewer than inside of a surface.
        let is_nearest = |neighbours: &mut dyn Iterator<Item = u32>, along_edge: DVec3, inside: usize| {
            let (mut count, mut together) = (0, 0.0);
            for vertex in neighbours {
                let way = places.x[vertex as usize] - point;
                if toward.dot(way) > part * way.length() {
                    return false;
                }
                count += 1;
                together += toward.dot((way - along_edge * along_edge.dot(way)).normalize_or_zero());
            }
            !is_body || opposite == 1 || count < inside || together < -STICKS_OUT
        };
        match count {
            1 => is_nearest(&mut surfaces.ring.of(vertices[0] as usize).iter().copied(), DVec3::ZERO, 1),
            2 if !surfaces.skins[surfaces.owners[vertices[0] as usize] as usize].is_surface => true,
            2 => {
                let other = surfaces.ring.of(vertices[1] as usize);
                let both = |vertex: &&u32| other.binary_search(vertex).is_ok();
                let [from, to] = [0, 1].map(|end| places.x[vertices[end] as usize]);
                let edge = (to - from).normalize_or_zero();
                is_nearest(&mut surfaces.ring.of(vertices[0] as usize).iter().filter(both).copied(), edge, 2)
            }
            _ => true,
        }
    };
    side(0..split, other, -normal) && side(split..4, one, normal)
}
