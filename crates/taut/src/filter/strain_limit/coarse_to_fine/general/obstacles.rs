//! What coarse levels may not do where cloth touches something.
//!
//! A row of contact is pulled back through the interpolation, to the particles of a coarse level that its own follow. There it only
//! resists: what a level adds to the displacements may use up the room that the row has, and no more. Rows that push on coarse levels
//! make cloth rigid; without any, coarse levels push cloth into what it lies on, and the finest level alone cannot carry that back.

use std::ops::Range;

use glam::Vec4;

use super::level::GeneralLevel;
use crate::contact::Obstacle;
use crate::geometry::{Pool, for_each_chunk, put_in_places};

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
    /// The row of the finest level that it is, and what it was before.
    row: u32,
    from: u32,
    /// Which of those that count it stands for.
    alike: Range<usize>,
    /// The pushes of all of these so far, and what they have pushed here since that was told the last time [kg m].
    total: f32,
    push: f32,
}

/// What might count on a level: the row of the finest level that it is, and its key, if it does.
#[derive(Debug, Clone, Copy)]
struct Might {
    row: u32,
    key: Option<[u32; 2]>,
}

/// The rows of a coarse level: all that might count, those that do in the order of their keys, and what is kept of them, with its nodes.
#[derive(Debug, Default)]
struct Rows {
    might: Vec<Might>,
    come: Vec<Come>,
    kept: Vec<Kept>,
    nodes: Vec<(u32, f32)>,
    /// Whether what is kept is of those that count now.
    is_known: bool,
    /// Workspace: where those begin whose first particle is such a one.
    starts: Vec<u32>,
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
        for Rows { come, kept, is_known, .. } in &mut self.levels {
            come.clear();
            kept.clear();
            *is_known = false;
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
            let on = |nodes: Option<Nodes>, normal: Vec4| Blocked::new(nodes.filter(counts)?, normal, level);
            // What counts on a level goes on to the next one.
            match finer.last() {
                None => {
                    let find = |number: usize| {
                        let row = &rows[number];
                        let nodes = row.nodes.iter().filter(|node| node.1 != 0.0);
                        on(raise(nodes.map(|&(particle, part)| (places[particle as usize], part)), below), row.normal.extend(0.0))
                    };
                    here[0].find(rows.len(), level.d.len(), pool, |number| number as u32, find);
                    here[0].keep(|number| (number as u32, rows[number].room, rows[number].push), find);
                }
                Some(Rows { kept, nodes, .. }) => {
                    let find = |number: usize| {
                        let row = &kept[number];
                        on(raise(nodes[row.nodes.clone()].iter().copied(), below), row.normal)
                    };
                    here[0].find(kept.len(), level.d.len(), pool, |number| kept[number].row, find);
                    here[0].keep(|number| (kept[number].row, kept[number].room, kept[number].total), find);
                }
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
    /// Takes which of so many rows count, on a level of so many particles. `row` tells of each which it is, and `find` what it is here.
    fn find(
        &mut self,
        count: usize,
        particles: usize,
        pool: &Pool,
        row: impl Fn(usize) -> u32 + Sync,
        find: impl Fn(usize) -> Option<Blocked> + Sync,
    ) {
        let Self { might, come, starts, is_known, .. } = self;
        // Where there are none, those of the last time are still to go.
        if count > 0 && might.len() == count && might.iter().enumerate().all(|(from, might)| might.row == row(from)) {
            return;
        }
        *is_known = false;
        might.resize(count, Might { row: u32::MAX, key: None });
        for_each_chunk(might, pool, |first, might| {
            for (from, might) in (first..).zip(might).filter(|(from, might)| might.row != row(*from)) {
                *might = Might { row: row(from), key: find(from).map(|found| found.key) };
            }
        });
        // Few share the first particle of their keys.
        let one = |(from, might): (u32, &Might)| might.key.map(|key| (key[0] as usize, Come { key, from, share: 0.0 }));
        put_in_places((0..).zip(&*might).filter_map(one), particles, starts, come);
        for alike in come.chunk_by_mut(|a, b| a.key[0] == b.key[0]) {
            alike.sort_unstable_by_key(|one| (one.key[1], one.from));
        }
    }

    /// Keeps the one with the least room of rows with the same key, the first of equal ones; all with that key have their share of its push.
    /// `of` tells of each which it is, its room, and its push. What is kept already stays as it is but for room and pushes.
    fn keep(&mut self, of: impl Fn(usize) -> (u32, f32, f32), find: impl Fn(usize) -> Option<Blocked>) {
        let Self { come, kept, nodes, is_known, .. } = self;
        if !std::mem::replace(is_known, true) {
            kept.clear();
            nodes.clear();
        }
        let mut first = 0;
        for (number, alike) in come.chunk_by_mut(|a, b| a.key == b.key).enumerate() {
            let (mut total, mut least) = (0.0, (f32::INFINITY, 0, alike[0].from));
            for one in alike.iter_mut() {
                let (row, room, push) = of(one.from as usize);
                one.share = push;
                total += push;
                if room < least.0 {
                    least = (room, row, one.from);
                }
            }
            let equal = (alike.len() as f32).recip();
            alike.iter_mut().for_each(|one| one.share = if total > 0.0 { one.share / total } else { equal });
            let (room, row, from) = least;
            let alike = first..first + alike.len();
            first = alike.end;
            if let Some(known) = kept.get_mut(number).filter(|known| known.from == from) {
                *known = Kept { nodes: known.nodes.clone(), room, row, alike, total, push: 0.0, ..*known };
                continue;
            }
            let Blocked { nodes: (own, count), normal, give, .. } = find(from as usize).unwrap_or(Blocked::NOTHING);
            let start = nodes.len();
            nodes.extend(&own[..count]);
            let one = Kept { nodes: start..nodes.len(), normal, room, give, row, from, alike, total, push: 0.0 };
            match kept.get_mut(number) {
                Some(known) => *known = one,
                None => kept.push(one),
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
    /// One that resists nothing.
    const NOTHING: Self = Self { key: [u32::MAX; 2], nodes: ([(0, 0.0); MOST], 0), normal: Vec4::ZERO, give: 0.0 };

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_no_rows_are_left_none_of_the_last_time_stay() {
        let (mut rows, pool) = (Rows::default(), Pool::new(1));
        let found = |_| Some(Blocked { key: [0, 1], nodes: ([(0, 1.0); MOST], 1), normal: Vec4::X, give: 1.0 });
        rows.find(3, 2, &pool, |number| number as u32, found);
        assert_eq!(rows.come.len(), 3);
        rows.might.clear();
        rows.find(0, 2, &pool, |number| number as u32, found);
        assert!(rows.come.is_empty());
    }
}
