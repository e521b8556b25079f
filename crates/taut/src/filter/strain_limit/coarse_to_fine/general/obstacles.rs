//! What coarse levels may not do where cloth touches something.
//!
//! A row of contact is pulled back through the interpolation, to the particles of a coarse level that its own follow. There it only
//! resists: what a level adds to the displacements may use up the room that the row has, and no more. Rows that push on coarse levels
//! make cloth rigid; without any, coarse levels push cloth into what it lies on, and the finest level alone cannot carry that back.

use std::ops::Range;

use glam::Vec4;

use super::level::GeneralLevel;
use crate::contact::Obstacle;
use crate::geometry::{Pool, for_each_chunk};

/// Particles of a level that a row may have; those of rows with more resist nothing there, nor on coarser levels.
const MOST: usize = 16;
/// Sums of squared parts below this are what is left of sides that move alike.
const ALIKE: f32 = 0.02;
/// Where bodies grip, rows of which more than this part is held resist nothing [1]: what is left of them would be thrown.
const HELD: f32 = 0.75;

/// Particles of a level with their parts of a row.
type Nodes = ([(u32, f32); MOST], usize);

/// What a row is on one level.
#[derive(Debug, Clone, Copy)]
struct Blocked {
    /// The particles with the largest part on either side: of rows that share both the one with the least room is enough.
    key: [u32; 2],
    nodes: Nodes,
    normal: Vec4,
    give: f32,
}

/// A row that counts on a level.
#[derive(Debug, Clone, Copy)]
struct Come {
    key: [u32; 2],
    room: f32,
    /// What it was before: a row, or what is kept of one level finer.
    from: u32,
    /// Its part of what those with its key push [1].
    share: f32,
}

/// The first of rows that are alike, in place of all.
#[derive(Debug, Clone)]
struct Kept {
    nodes: Range<usize>,
    normal: Vec4,
    room: f32,
    give: f32,
    /// The row of the finest level that it is.
    row: u32,
    /// Which of those that count it stands for.
    alike: Range<usize>,
    /// The pushes of all of these so far, and what they have pushed here since that was told the last time [kg m].
    total: f32,
    push: f32,
}

/// What might count on a level: the row of the finest level that it is, and what it is here, if it does.
#[derive(Debug, Clone, Copy)]
struct Might {
    row: u32,
    here: Option<Blocked>,
}

/// The rows of a coarse level: all that might count, those that do in the order of their keys, and what is kept of them, with its nodes.
#[derive(Debug, Default)]
struct Rows {
    might: Vec<Might>,
    come: Vec<Come>,
    kept: Vec<Kept>,
    nodes: Vec<(u32, f32)>,
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
        for Rows { come, kept, .. } in &mut self.levels {
            come.clear();
            kept.clear();
        }
    }

    /// Takes rows; `places` are those of the cloth's particles on the finest level. `are_gripped` says whether bodies grip any of them,
    /// `anew` whether anything but room and pushes has changed since the last time.
    pub fn set(
        &mut self,
        rows: &[Obstacle],
        levels: &[GeneralLevel],
        places: &[u32],
        are_gripped: bool,
        anew: bool,
        pool: &Pool,
    ) {
        if anew {
            self.levels.iter_mut().for_each(|level| level.might.clear());
        }
        for index in 0..self.levels.len() {
            let (finer, here) = self.levels.split_at_mut(index);
            let [below, level] = [&levels[index], &levels[index + 1]];
            let counts = |nodes: &Nodes| !(are_gripped && is_held(nodes, level));
            // What counts on a level goes on to the next one.
            match finer.last() {
                None => here[0].take(rows.len(), pool, |number| {
                    let row = &rows[number];
                    let nodes = || {
                        let nodes = row.nodes.iter().filter(|node| node.1 != 0.0);
                        raise(nodes.map(|&(particle, part)| (places[particle as usize], part)), below).filter(counts)
                    };
                    (number as u32, [row.room, row.push], move || Blocked::new(nodes()?, row.normal.extend(0.0), level))
                }),
                Some(Rows { kept, nodes, .. }) => here[0].take(kept.len(), pool, |number| {
                    let row = &kept[number];
                    let nodes = || raise(nodes[row.nodes.clone()].iter().copied(), below).filter(counts);
                    (row.row, [row.room, row.total], move || Blocked::new(nodes()?, row.normal, level))
                }),
            }
        }
    }

    /// Takes back what a coarse level has used beyond the room of its rows.
    pub fn resist(&mut self, index: usize, level: &mut GeneralLevel) {
        let GeneralLevel { d, before, .. } = level;
        let Rows { kept, nodes, .. } = &mut self.levels[index - 1];
        for row in kept {
            let nodes = &nodes[row.nodes.clone()];
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

    /// Tells what rows have pushed on all levels since the last time [kg m].
    pub fn tell(&mut self, tell: &mut dyn FnMut(u32, f32)) {
        for index in (0..self.levels.len()).rev() {
            let (finer, here) = self.levels.split_at_mut(index);
            let Rows { come, kept, .. } = &mut here[0];
            for row in kept.iter_mut().filter(|row| row.push > 0.0) {
                let all = std::mem::take(&mut row.push);
                for one in &come[row.alike.clone()] {
                    match finer.last_mut() {
                        None => tell(one.from, all * one.share),
                        Some(finer) => finer.kept[one.from as usize].push += all * one.share,
                    }
                }
            }
        }
    }
}

impl Rows {
    /// Takes so many rows. `of` tells of each which it is, its room and push, and how to find what it is here. Of rows with the same key it
    /// keeps the one with the least room, the first of equal ones; all with that key have their share of its push.
    fn take<F: FnOnce() -> Option<Blocked>>(
        &mut self,
        count: usize,
        pool: &Pool,
        of: impl Fn(usize) -> (u32, [f32; 2], F) + Sync,
    ) {
        let Self { might, come, kept, nodes } = self;
        might.resize(count, Might { row: u32::MAX, here: None });
        for_each_chunk(might, pool, |first, might| {
            for (from, might) in (first..).zip(might) {
                let (row, _, find) = of(from);
                if might.row != row {
                    *might = Might { row, here: find() };
                }
            }
        });
        come.clear();
        for (from, might) in might.iter().enumerate() {
            if let Some(Blocked { key, .. }) = might.here {
                let (_, [room, push], _) = of(from);
                come.push(Come { key, room, from: from as u32, share: push });
            }
        }
        come.sort_unstable_by(|a, b| a.key.cmp(&b.key).then(a.room.total_cmp(&b.room)).then(a.from.cmp(&b.from)));
        kept.clear();
        nodes.clear();
        let mut first = 0;
        for alike in come.chunk_by_mut(|a, b| a.key == b.key) {
            let total: f32 = alike.iter().map(|one| one.share).sum();
            let equal = (alike.len() as f32).recip();
            alike.iter_mut().for_each(|one| one.share = if total > 0.0 { one.share / total } else { equal });
            let (one, alike) = (&alike[0], first..first + alike.len());
            first = alike.end;
            if let Might { row, here: Some(Blocked { nodes: (own, count), normal, give, .. }) } = might[one.from as usize] {
                let from = nodes.len();
                nodes.extend(&own[..count]);
                let (nodes, room, push) = (from..nodes.len(), one.room, 0.0);
                kept.push(Kept { nodes, normal, room, give, row, alike, total, push });
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
    /// A row on a level; none where too little is left of it there.
    fn new(nodes: Nodes, normal: Vec4, level: &GeneralLevel) -> Option<Self> {
        let own = &nodes.0[..nodes.1];
        let squares: f32 = own.iter().map(|node| node.1 * node.1).sum();
        let weight: f32 = own.iter().map(|&(node, part)| part * part * level.d[node as usize].w).sum();
        if squares < ALIKE || weight <= 0.0 {
            return None;
        }
        let largest = |sign: f32| {
            let with = own.iter().filter(|node| node.1 * sign > 0.0);
            with.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()).then(b.0.cmp(&a.0))).map_or(u32::MAX, |node| node.0)
        };
        Some(Self { key: [largest(1.0), largest(-1.0)], nodes, normal, give: 1.0 / weight })
    }
}
