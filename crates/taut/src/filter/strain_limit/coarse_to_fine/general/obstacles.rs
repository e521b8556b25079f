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
/// Where bodies grip, rows of which more than this part is held resist nothing [1]: what is left of them would be thrown.
const HELD: f32 = 0.75;

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
    /// What it stands for: a row, or what is kept of one level finer; and its part of what those with its key push [1].
    stands_for: u32,
    share: f32,
    /// If it is kept, the pushes of all with its key so far, and what they have pushed here since that was told the last time [kg m].
    total: f32,
    push: f32,
}

/// The rows of a coarse level: as they came; in the order of their keys; and where those that are alike are in that order.
#[derive(Debug, Default)]
struct Rows {
    list: Vec<Blocked>,
    order: Vec<u32>,
    kept: Vec<Kept>,
}

/// Rows that are alike: the first of them counts.
#[derive(Debug, Clone, Copy)]
struct Kept {
    first: u32,
    count: u32,
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
        for Rows { list, kept, .. } in &mut self.levels {
            list.clear();
            kept.clear();
        }
    }

    /// Takes rows; `places` are those of the cloth's particles on the finest level. `are_gripped` says whether bodies grip any of them.
    pub fn set(&mut self, rows: &[Obstacle], levels: &[GeneralLevel], places: &[u32], are_gripped: bool) {
        self.clear();
        for index in 0..self.levels.len() {
            let (finer, here) = self.levels.split_at_mut(index);
            let here = &mut here[0];
            let mut take = |nodes: Option<Nodes>, normal: Vec4, room: f32, stands_for: u32, share: f32| {
                let nodes = nodes.filter(|nodes| !(are_gripped && is_held(nodes, &levels[index + 1])));
                let row = nodes.and_then(|nodes| Blocked::new(nodes, normal, room, &levels[index + 1]));
                here.list.extend(row.map(|row| Blocked { stands_for, share, ..row }));
            };
            // What counts on a level goes on to the next one.
            match finer.last() {
                None => (0..).zip(rows).for_each(|(number, row)| {
                    let nodes = row.nodes.iter().filter(|node| node.1 != 0.0);
                    let nodes = nodes.map(|&(particle, part)| (places[particle as usize], part));
                    take(raise(nodes, &levels[index]), row.normal.extend(0.0), row.room, number, row.push);
                }),
                Some(finer) => finer.kept.iter().for_each(|kept| {
                    let number = finer.order[kept.first as usize];
                    let row = &finer.list[number as usize];
                    take(raise(row.nodes[..row.count].iter().copied(), &levels[index]), row.normal, row.room, number, row.total);
                }),
            }
            here.keep_nearest();
        }
    }

    /// Takes back what a coarse level has used beyond the room of its rows.
    pub fn resist(&mut self, index: usize, level: &mut GeneralLevel) {
        let GeneralLevel { d, before, .. } = level;
        let Rows { list, order, kept } = &mut self.levels[index - 1];
        for kept in &*kept {
            let row = &mut list[order[kept.first as usize] as usize];
            let nodes = &row.nodes[..row.count];
            let gained: f32 =
                nodes.iter().map(|&(node, part)| (d[node as usize] - before[node as usize]).dot(row.normal) * part).sum();
            let back = (-row.room - gained) * row.give;
            if back > 0.0 {
                row.push += back;
                for &(node, part) in nodes {
                    let d = &mut d[node as usize];
                    *d += row.normal * (back * part * d.w);
                }
            }
        }
    }
}

impl Rows {
    /// Of rows with the same key the one with the least room; the first of equal ones. All with that key have their share of its push.
    fn keep_nearest(&mut self) {
        let Self { list, order, kept } = self;
        order.clear();
        order.extend(0..list.len() as u32);
        let row = |row: u32| &list[row as usize];
        order.sort_unstable_by(|&a, &b| row(a).key.cmp(&row(b).key).then(row(a).room.total_cmp(&row(b).room)).then(a.cmp(&b)));
        let mut first = 0;
        for alike in order.chunk_by(|&a, &b| row(a).key == row(b).key) {
            kept.push(Kept { first, count: alike.len() as u32 });
            first += alike.len() as u32;
        }
        for &Kept { first, count } in &*kept {
            let alike = &order[first as usize..][..count as usize];
            let all: f32 = alike.iter().map(|&row| list[row as usize].share).sum();
            for &row in alike {
                let row = &mut list[row as usize];
                row.share = if all > 0.0 { row.share / all } else { (count as f32).recip() };
            }
            list[alike[0] as usize].total = all;
        }
    }
}

impl Obstacles {
    /// Tells what rows have pushed on all levels since the last time [kg m].
    pub fn tell(&mut self, tell: &mut dyn FnMut(u32, f32)) {
        for index in (0..self.levels.len()).rev() {
            let (finer, here) = self.levels.split_at_mut(index);
            let Rows { list, order, kept } = &mut here[0];
            for &Kept { first, count } in &*kept {
                let alike = &order[first as usize..][..count as usize];
                let all = std::mem::take(&mut list[alike[0] as usize].push);
                for row in alike.iter().filter(|_| all > 0.0).map(|&row| &list[row as usize]) {
                    match finer.last_mut() {
                        None => tell(row.stands_for, all * row.share),
                        Some(finer) => finer.list[row.stands_for as usize].push += all * row.share,
                    }
                }
            }
        }
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

/// Whether most of a row is held.
fn is_held((nodes, count): &Nodes, level: &GeneralLevel) -> bool {
    let squares = |of_all: bool| {
        let own = nodes[..*count].iter().filter(|(node, _)| of_all || level.d[*node as usize].w > 0.0);
        own.map(|(_, part)| part * part).sum::<f32>()
    };
    squares(false) < (1.0 - HELD) * squares(true)
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
        Some(Self { key, nodes, count, normal, room, give: 1.0 / weight, stands_for: 0, share: 0.0, total: 0.0, push: 0.0 })
    }
}
