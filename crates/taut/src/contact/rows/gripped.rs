//! What two bodies grip: cloth between them, with less room than it is thick, goes with them where they move as one.
//!
//! Bodies follow their paths whatever that takes, so there is no end to what they press, nor to what friction holds there. It is a pin that
//! lasts as long as they press. Sweeps over rows would have to find the weight of all that hangs on it, impulse by impulse.

use glam::Vec3;

use super::pinched::OPPOSED;
use super::{Row, Rows};

/// Bodies move as one where what they grip would slide along one of them by less than this part of its way [1].
const AS_ONE: f32 = 0.1;
/// A vertex has at least this part of what is gripped [1].
const PART: f32 = 0.3;
/// Rows that would give more than this times what they do where nothing is gripped push no more [1].
const MOST: f32 = 4.0;

/// A particle that is gripped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Grip {
    pub particle: u32,
    /// How far it goes in the step [m].
    pub way: Vec3,
}

/// What is gripped in a step; and workspace: vertices with a row each that a body presses them by, and which of its ends they are.
#[derive(Debug, Default)]
pub(super) struct Gripped {
    pub list: Vec<Grip>,
    pressed: Vec<(u32, u32, usize)>,
}

impl Rows {
    /// Finds what is gripped, of the particles that `may` be, and holds it from now on.
    pub fn grip(&mut self, may: impl Fn(u32) -> bool) -> &[Grip] {
        let Gripped { mut list, mut pressed } = std::mem::take(&mut self.gripped);
        list.clear();
        pressed.clear();
        for (index, row) in (0..).zip(&self.list).skip(self.alone.count) {
            if row.friction > 0.0 && self.is_of_body(row) && self.left(row) < row.thickness {
                let ends = (0..4).filter(|&end| row.parts[end].abs() >= PART);
                let ends =
                    ends.filter(|&end| self.weights[row.ends[end] as usize] > 0.0 && may(self.vertices[row.ends[end] as usize]));
                pressed.extend(ends.map(|end| (row.ends[end], index, end)));
            }
        }
        pressed.sort_unstable();
        for of_vertex in pressed.chunk_by(|a, b| a.0 == b.0) {
            let pairs =
                of_vertex.iter().enumerate().flat_map(|(at, one)| of_vertex[at + 1..].iter().map(move |other| [one, other]));
            let found = pairs
                .filter_map(|pair| Some((pair, self.gripped_by(pair.map(|&(_, row, end)| (&self.list[row as usize], end)))?)));
            let Some((pair, (_, way))) = found.min_by(|a, b| a.1.0.total_cmp(&b.1.0)) else { continue };
            list.push(Grip { particle: self.vertices[of_vertex[0].0 as usize], way });
            for &(_, row, _) in pair {
                let row = &mut self.list[row as usize];
                row.grips = row.give * row.thickness;
            }
        }
        self.gripped = Gripped { list, pressed };
        self.hold_gripped();
        &self.gripped.list
    }

    /// Holds what is gripped where vertices have been put in another order.
    pub fn hold_gripped(&mut self) {
        if self.gripped.list.is_empty() {
            return;
        }
        for grip in &self.gripped.list {
            self.weights[self.locals[grip.particle as usize] as usize] = 0.0;
        }
        for index in 0..self.list.len() {
            let Row { ends, parts, .. } = self.list[index];
            let give = self.give(ends, parts);
            // What hardly counts in a row must not be thrown for what is gripped.
            self.list[index].give = if give > MOST * self.give_of_all(&self.list[index]) { 0.0 } else { give };
        }
    }

    /// What a row gives where nothing is gripped [kg].
    fn give_of_all(&self, row: &Row) -> f32 {
        let weight: f32 = (0..4)
            .map(|end| row.parts[end] * row.parts[end] * self.all_weights[self.vertices[row.ends[end] as usize] as usize])
            .sum();
        if weight > 0.0 { 1.0 / weight } else { 0.0 }
    }

    /// The particles.
    pub fn gripped(&self) -> impl Iterator<Item = usize> {
        self.gripped.list.iter().map(|grip| grip.particle as usize)
    }

    /// Where a vertex goes that two rows press from opposite sides, each being one of its ends, if their bodies grip it; and what room they leave [m].
    fn gripped_by(&self, [(one, end), (other, end_of_other)]: [(&Row, usize); 2]) -> Option<(f32, Vec3)> {
        let both = [(one, end), (other, end_of_other)];
        let normals = both.map(|(row, end)| row.normal * row.parts[end].signum());
        if normals[0].dot(normals[1]) > OPPOSED {
            return None;
        }
        let left = both.map(|(row, _)| self.left(row));
        let ways = both.map(|(row, end)| self.way_of_body(row) * -row.parts[end].signum());
        let apart = ways[0] - ways[1];
        let along = apart - normals[0] * normals[0].dot(apart);
        let as_one = along.length() <= AS_ONE * ways[0].length().max(ways[1].length());
        // It goes with both, and stays as far between them as it was.
        let way = (ways[0] + ways[1]) * 0.5;
        let [near, far] = [0, 1].map(|which| left[which] + normals[which].dot(way));
        let [from, to] = [one, other].map(|row| row.distance.max(row.floor));
        let across = (near + far) * (from / (from + to)) - near;
        // Where there is not even that much room, bodies will not get where they go.
        let room = left[0] + left[1];
        let is_gripped = as_one && room < one.thickness + other.thickness && room >= one.floor + other.floor;
        is_gripped.then(|| (room, way + normals[0] * across))
    }

    /// How far the surface of its body goes, as its relative displacement counts [m].
    fn way_of_body(&self, row: &Row) -> Vec3 {
        let of_body = |end: &usize| self.vertices[row.ends[*end] as usize] as usize >= self.particles;
        let moved: Vec3 = (0..4).filter(of_body).map(|end| self.d[row.ends[end] as usize] * row.parts[end]).sum();
        moved + row.carried
    }
}
