//! Rows as those see them who solve all of a step at once.

use glam::DVec3;

use super::Rows;
use crate::contact::Places;

/// The square of the sine of the least angle between edges that counts [1].
const PARALLEL: f64 = 0.25;

/// A row.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Support {
    /// Its particles that may move, and their parts; zero where there are fewer.
    pub nodes: [(u32, f64); 4],
    pub normal: DVec3,
    /// The distance beyond the target, and the displacement of the two features along each other, if none of these particles moves [m].
    pub gap: f64,
    pub sideways: DVec3,
    /// An edge that tilts is closest at another place. What half of the square of a sum takes from the distance [1/m]: of the difference of
    /// the ways of two nodes along the normal, and of the way of the closest point along `roll`.
    pub tilt: f64,
    pub edge: [usize; 2],
    pub roll: DVec3,
    /// That sum, if none of these particles moves [m].
    pub tilted: f64,
    /// So much below the target is as good as that [m].
    pub slack: f64,
    pub friction: f64,
    /// What the row pushes, and holds back along it, in this step [kg m].
    pub push: f64,
    pub hold: DVec3,
}

impl Rows {
    /// All rows, with what their bodies and held particles do; `moves` tells which particles may move.
    pub fn supports(&self, places: &Places, list: &mut Vec<Support>, moves: impl Fn(usize) -> bool) {
        list.clear();
        list.extend(self.list.iter().map(|row| {
            let mut support = Support {
                normal: row.normal.as_dvec3().normalize_or_zero(),
                gap: f64::from(row.gap),
                slack: f64::from(row.slack),
                friction: f64::from(row.friction),
                push: f64::from(row.push),
                hold: row.hold.as_dvec3(),
                ..Support::default()
            };
            let (mut relative, mut way) = (DVec3::ZERO, DVec3::ZERO);
            let (mut nodes, mut count) = ([0; 4], 0);
            for end in 0..4 {
                let (local, part) = (row.ends[end] as usize, f64::from(row.parts[end]));
                let vertex = self.vertices[local] as usize;
                way += places.x[vertex] * part;
                if part != 0.0 && vertex < self.particles && self.weights[local] > 0.0 && moves(vertex) {
                    support.nodes[end] = (vertex as u32, part);
                    nodes[count] = end;
                    count += 1;
                } else if part != 0.0 {
                    relative += self.d[local].as_dvec3() * part;
                }
            }
            let is_of_edges = row.parts.iter().all(|part| *part != 0.0) && row.parts[0] * row.parts[1] > 0.0;
            if is_of_edges && (nodes[..count] == [0, 1] || nodes[..count] == [2, 3]) {
                let other = 2 - nodes[0];
                let edge = |first: usize| {
                    let [from, to] = [first, first + 1].map(|end| places.x[self.vertices[row.ends[end] as usize] as usize]);
                    to - from
                };
                let (own, axis) = (edge(nodes[0]), edge(other).normalize_or_zero());
                // Links that touch exactly have no way between them.
                let distance = way.length().max(f64::MIN_POSITIVE);
                let across = own - axis * own.dot(axis);
                // As good as parallel edges are closest anywhere.
                let square = across.length_squared().max(PARALLEL * own.length_squared());
                support.edge = [nodes[0], nodes[1]];
                support.tilt = distance / square;
                support.roll = across / distance;
                support.tilted = support.roll.dot(relative);
            }
            let along = support.normal.dot(relative);
            support.gap += along;
            support.sideways = relative - support.normal * along + row.carried.as_dvec3();
            support
        }));
    }

    /// Takes what rows push and hold, in the order of [`Rows::supports`].
    pub fn take_supports(&mut self, list: &[Support]) {
        for (row, support) in self.list.iter_mut().zip(list) {
            (row.push, row.hold) = (support.push as f32, support.hold.as_vec3());
        }
    }
}
