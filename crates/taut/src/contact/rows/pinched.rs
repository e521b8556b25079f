//! What has less room than its thickness asks for, as a body presses it against something.
//!
//! Rows of both sides would ask for more than there is, and throw cloth to and fro between them. So they share what there is, each in
//! proportion to its thickness, down to what the certificate leaves: skins and cloth give way, and what is pinched stays in the middle.
//! Both rows are those of bodies, or one is that of a body that had to be held back: else cloth can make room for itself, as a rope that
//! is twisted does, and would only lose what keeps it from being cut.

use glam::Vec3;

use super::{GOOD, Row, Rows};
use crate::contact::Places;

/// Rows share from the start of a step on what is less than this part of their thicknesses [1]; where sweeps do not come to an end,
/// whatever is too little.
const SQUEEZED: f32 = 0.5;
/// They are opposed where the cosine between the ways in which they push a vertex is below this [1].
pub(super) const OPPOSED: f32 = -0.7;
/// Rows that are not kept in the end ask for this part of what they asked for beyond the floor of the certificate [1].
const LEFT: f32 = 0.1;

/// Where rows share; and the workspace.
#[derive(Default)]
pub(super) struct Pinched {
    /// Of each vertex in the workspace: whether its rows are looked at.
    asked: Vec<bool>,
    /// Vertices, and rows that they are in, in rising order.
    list: Vec<(u32, u32)>,
    /// Of each row: whether it is that of a body, and whether that is behind its path there.
    bodies: Vec<(bool, bool)>,
    /// What rows get of what there is [m].
    shares: Vec<f32>,
    /// Whether any have shared in this step.
    pub any: bool,
    /// Of each vertex of bodies: whether it is behind its path.
    behind: Vec<bool>,
}

impl Rows {
    /// Takes which vertices of bodies are behind their paths as the step begins.
    pub fn take_behind(&mut self, behind: impl Iterator<Item = bool>) {
        self.pinched.behind.clear();
        self.pinched.behind.extend(behind);
    }

    /// Finds where bodies would go that what is held cannot make room for: the part of its way [1] that each vertex of theirs may go.
    /// Returns whether there is any that may not go all of it.
    pub fn stop_bodies(&self, places: &Places, factors: &mut [f64]) -> bool {
        factors.fill(1.0);
        let mut any = false;
        for row in self.list.iter().filter(|row| row.give == 0.0) {
            let (mut of_bodies, mut held) = (0.0, 0.0);
            for end in 0..4 {
                let vertex = self.vertices[row.ends[end] as usize] as usize;
                let way = (places.ends[vertex] - places.x[vertex]).dot(row.normal.as_dvec3()) * f64::from(row.parts[end]);
                *if vertex < self.particles { &mut held } else { &mut of_bodies } += way;
            }
            let room = f64::from(row.distance - row.floor) + held;
            if of_bodies < -room.max(0.0) {
                let part = room.max(0.0) / -of_bodies;
                let bodies = row.locals().filter_map(|local| (self.vertices[local] as usize).checked_sub(self.particles));
                bodies.for_each(|vertex| factors[vertex] = factors[vertex].min(part));
                any = true;
            }
        }
        any
    }

    /// Has rows share what room there is where that is far less than they ask for. Returns how many do.
    pub fn share(&mut self) -> usize {
        let squeezed = |rows: &Self, row: &Row| row.give > 0.0 && rows.left(row) < SQUEEZED * row.thickness;
        self.share_where(squeezed, SQUEEZED)
    }

    /// Whether any did in this step.
    pub fn any_shares(&self) -> bool {
        self.pinched.any
    }

    /// Has rows that are not kept share what room there is ..
    pub fn give_way(&mut self) {
        self.share_where(|rows, row| !rows.is_kept(row), 1.0);
    }

    /// .. and, in the end, ask for little more than the certificate does.
    pub fn give_in(&mut self) {
        for index in 0..self.list.len() {
            let row = &self.list[index];
            if self.is_of_body(row) && !self.is_kept(row) {
                let target = row.floor + LEFT * (row.target() - row.floor).max(0.0);
                self.list[index].ask(target);
            }
        }
    }

    /// Whether one of its features is a body's.
    pub(super) fn is_of_body(&self, row: &Row) -> bool {
        row.locals().any(|local| self.vertices[local] as usize >= self.particles)
    }

    /// Whether one of its features is a body's that is behind its path there.
    fn is_behind(&self, row: &Row, behind: &[bool]) -> bool {
        let body = |local: usize| (self.vertices[local] as usize).checked_sub(self.particles);
        row.locals().filter_map(body).any(|vertex| behind[vertex])
    }

    /// What is left of the distance of a row when bodies have moved and cloth has not [m].
    pub(super) fn left(&self, row: &Row) -> f32 {
        let of_body = |end: &usize| self.vertices[row.ends[*end] as usize] as usize >= self.particles;
        let moved: Vec3 = (0..4).filter(of_body).map(|end| self.d[row.ends[end] as usize] * row.parts[end]).sum();
        row.distance + row.normal.dot(moved)
    }

    fn share_where(&mut self, is_asked: impl Fn(&Self, &Row) -> bool, part: f32) -> usize {
        let mut pinched = std::mem::take(&mut self.pinched);
        let count = pinched.run(self, is_asked, part);
        self.pinched = pinched;
        count
    }
}

impl Pinched {
    fn run(&mut self, rows: &mut Rows, is_asked: impl Fn(&Rows, &Row) -> bool, part: f32) -> usize {
        let Self { asked, list, bodies, shares, any: any_shares, behind } = self;
        asked.clear();
        asked.resize(rows.vertices.len(), false);
        let mut any = false;
        for row in rows.list.iter().filter(|row| is_asked(rows, row)) {
            row.locals().for_each(|local| asked[local] = true);
            any = true;
        }
        if !any {
            return 0;
        }
        list.clear();
        for (index, row) in (0..).zip(&rows.list) {
            let movable = row.locals().filter(|&local| asked[local] && rows.weights[local] > 0.0);
            list.extend(movable.map(|local| (local as u32, index)));
        }
        list.sort_unstable();
        bodies.clear();
        bodies.extend(rows.list.iter().map(|row| (rows.is_of_body(row), rows.is_behind(row, behind))));
        shares.clear();
        shares.resize(rows.list.len(), f32::INFINITY);
        for of_vertex in list.chunk_by(|a, b| a.0 == b.0) {
            // One of both is that of a body. What goes far in a step has many more rows with cloth.
            for &(local, one) in of_vertex.iter().filter(|(_, one)| bodies[*one as usize].0) {
                let (a, (_, is_behind)) = (&rows.list[one as usize], bodies[one as usize]);
                let way = a.way_of(local);
                for &(_, other) in of_vertex {
                    let (b, (is_of_body, is_other_behind)) = (&rows.list[other as usize], bodies[other as usize]);
                    let is_seen_once = !is_of_body || one < other;
                    let are_pressed = is_of_body || is_behind || is_other_behind;
                    if !is_seen_once || !are_pressed || way.dot(b.way_of(local)) > OPPOSED {
                        continue;
                    }
                    let (room, both) = (rows.left(a) + rows.left(b), a.thickness + b.thickness);
                    if room < part * both && room < a.target() + b.target() {
                        for (index, row) in [(one, a), (other, b)] {
                            let share = &mut shares[index as usize];
                            *share = share.min(room * row.thickness / both);
                        }
                    }
                }
            }
        }
        let mut count = 0;
        for (row, &share) in rows.list.iter_mut().zip(&*shares).filter(|(row, share)| **share < row.target()) {
            row.ask(share.max(row.floor));
            count += 1;
        }
        *any_shares |= count > 0;
        count
    }
}

impl Row {
    /// The distance that it asks for [m].
    fn target(&self) -> f32 {
        self.distance - self.gap
    }

    fn ask(&mut self, target: f32) {
        self.gap = self.distance - target;
        self.slack = GOOD as f32 * (target - self.floor).max(0.0);
    }

    /// The way in which it pushes one of its vertices.
    fn way_of(&self, local: u32) -> Vec3 {
        let end = self.ends.iter().zip(&self.parts).find(|(end, part)| **end == local && **part != 0.0);
        self.normal * end.map_or(0.0, |(_, part)| part.signum())
    }
}
