//! What coarse levels may not do where cloth touches something.
//!
//! A row of contact is pulled back through the interpolation, to the particles of a coarse level that its own follow. There it only
//! resists: what a level adds to the displacements may use up the room that the row has, and no more. Rows that push on coarse levels
//! make cloth rigid; without any, coarse levels push cloth into what it lies on, and the finest level alone cannot carry that back.

use glam::Vec4;

use super::level::GeneralLevel;
use crate::contact::Obstacle;

/// Particles of a level that a row may have; those of rows with more resist nothing there, nor on coarser levels.
const MOST: usize = 16;
/// Sums of squared parts below this are what is left of sides that move alike.
const ALIKE: f32 = 0.02;

/// Particles of a level with their parts of a row.
type Nodes = ([(u32, f32); MOST], usize);

/// A row on one level.
#[derive(Debug, Clone, Copy)]
struct Blocked {
    /// The particles with the largest part on either side: of rows that share both the one with the least room is enough.
    key: [u32; 2],
    nodes: [(u32, f32); MOST],
    count: usize,
    normal: Vec4,
    room: f32,
    give: f32,
}

/// The rows of a coarse level: as they came, and those that count, in the order of their keys.
#[derive(Debug, Default)]
struct Rows {
    list: Vec<Blocked>,
    kept: Vec<u32>,
}

/// The rows of all coarse levels, from the second finest on.
#[derive(Debug, Default)]
pub(super) struct Obstacles {
    levels: Vec<Rows>,
}

impl Obstacles {
    pub fn new(levels: usize) -> Self {
        Self { levels: (1..levels).map(|_| Rows::default()).collect() }
    }

    pub fn clear(&mut self) {
        for Rows { list, kept } in &mut self.levels {
            list.clear();
            kept.clear();
        }
    }

    /// Takes rows; `places` are those of the cloth's particles on the finest level.
    pub fn set(&mut self, rows: &[Obstacle], levels: &[GeneralLevel], places: &[u32]) {
        self.clear();
        for index in 0..self.levels.len() {
            let (finer, here) = self.levels.split_at_mut(index);
            let here = &mut here[0];
            let mut take = |nodes: Option<Nodes>, normal: Vec4, room: f32| {
                here.list.extend(nodes.and_then(|nodes| Blocked::new(nodes, normal, room, &levels[index + 1])));
            };
            // What counts on a level goes on to the next one.
            match finer.last() {
                None => rows.iter().for_each(|row| {
                    let nodes = row.nodes.iter().filter(|node| node.1 != 0.0);
                    let nodes = nodes.map(|&(particle, part)| (places[particle as usize], part));
                    take(raise(nodes, &levels[index]), row.normal.extend(0.0), row.room);
                }),
                Some(finer) => finer.kept.iter().for_each(|&row| {
                    let row = &finer.list[row as usize];
                    take(raise(row.nodes[..row.count].iter().copied(), &levels[index]), row.normal, row.room);
                }),
            }
            here.keep_nearest();
        }
    }

    /// Takes back what a coarse level has used beyond the room of its rows.
    pub fn resist(&self, index: usize, level: &mut GeneralLevel) {
        let GeneralLevel { d, before, .. } = level;
        let Rows { list, kept } = &self.levels[index - 1];
        for row in kept.iter().map(|&row| &list[row as usize]) {
            let nodes = &row.nodes[..row.count];
            let gained: f32 =
                nodes.iter().map(|&(node, part)| (d[node as usize] - before[node as usize]).dot(row.normal) * part).sum();
            let back = (-row.room - gained) * row.give;
            if back > 0.0 {
                for &(node, part) in nodes {
                    let d = &mut d[node as usize];
                    *d += row.normal * (back * part * d.w);
                }
            }
        }
    }
}

impl Rows {
    /// Of rows with the same key the one with the least room; the first of equal ones.
    fn keep_nearest(&mut self) {
        let Self { list, kept } = self;
        kept.extend(0..list.len() as u32);
        let row = |row: u32| &list[row as usize];
        kept.sort_unstable_by(|&a, &b| row(a).key.cmp(&row(b).key).then(row(a).room.total_cmp(&row(b).room)).then(a.cmp(&b)));
        kept.dedup_by_key(|at| row(*at).key);
    }
}

/// The particles that those of a level follow, with their parts of a row; none if there are too many.
fn raise(nodes: impl Iterator<Item = (u32, f32)>, level: &GeneralLevel) -> Option<Nodes> {
    let (mut above, mut count) = ([(0, 0.0); MOST], 0_usize);
    for (node, part) in nodes {
        for (parent, share) in level.parents[node as usize].iter() {
            match above[..count].iter_mut().find(|other| other.0 == parent) {
                Some(other) => other.1 += part * share,
                None if count == MOST => return None,
                None => {
                    above[count] = (parent, part * share);
                    count += 1;
                }
            }
        }
    }
    Some((above, count))
}

impl Blocked {
    fn new((nodes, count): Nodes, normal: Vec4, room: f32, level: &GeneralLevel) -> Option<Self> {
        let own = &nodes[..count];
        let squares: f32 = own.iter().map(|node| node.1 * node.1).sum();
        let weight: f32 = own.iter().map(|&(node, part)| part * part * level.d[node as usize].w).sum();
        if squares < ALIKE || weight <= 0.0 {
            return None;
        }
        let largest = |sign: f32| {
            let with = own.iter().filter(|node| node.1 * sign > 0.0);
            with.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()).then(b.0.cmp(&a.0))).map_or(u32::MAX, |node| node.0)
        };
        let key = [largest(1.0), largest(-1.0)];
        Some(Self { key, nodes, count, normal, room, give: 1.0 / weight })
    }
}
