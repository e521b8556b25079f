//! The order of rows. First come those that are alone with their vertex: beside a body such a row has one particle, and no other row has that.
//!
//! Their vertices come first as well, in the same order: row and vertex have the same number. So any number of threads may
//! sweep them with the same result (lanes.rs). Most rows of cloth on a ball, a capsule or a plane are such (vertices.rs).

use super::{NONE, Places, Row, Rows};
use crate::geometry::{Pool, for_each_chunk, put_in_places};

/// How many there are, and the workspace.
#[derive(Debug, Default)]
pub(super) struct Alone {
    pub count: usize,
    /// Of each vertex in the workspace: in how many rows it is, and its number from now on.
    counts: Vec<u32>,
    numbers: Vec<u32>,
    /// What is put in order; the numbers that rows had, those that come last apart; and the first corners of rows with their numbers.
    rows: Vec<Row>,
    sources: Vec<u32>,
    others: Vec<u32>,
    order: Vec<(u64, u32)>,
    starts: Vec<u32>,
    vertices: Vec<u32>,
}

impl Rows {
    /// Puts rows in an order that does not depend on how they were found, and leaves one of those that are alike; and arranges them.
    pub fn sort(&mut self, places: &Places, pool: &Pool) {
        let Self { list, locals, alone, .. } = self;
        let mut order = std::mem::take(&mut alone.order);
        let row = |index: u32| &list[index as usize];
        // The first corners tell nearly all rows apart, and few share one.
        let of = |(index, row): (u32, &Row)| {
            let [one, other] = [row.key[0][0], row.key[1][0]];
            (one as usize, (u64::from(one) << 32 | u64::from(other), index))
        };
        put_in_places((0..).zip(&*list).map(of), locals.len(), &mut alone.starts, &mut order);
        order.chunk_by_mut(|one, other| one.0 >> 32 == other.0 >> 32).for_each(|alike| alike.sort_unstable());
        for alike in order.chunk_by_mut(|one, other| one.0 == other.0).filter(|alike| alike.len() > 1) {
            alike.sort_unstable_by(|&(_, a), &(_, b)| {
                let (one, two) = (row(a), row(b));
                one.key.cmp(&two.key).then(one.gap.total_cmp(&two.gap)).then(a.cmp(&b))
            });
        }
        order.dedup_by(|(_, a), (_, b)| row(*a).key == row(*b).key);
        self.put_first(order.iter().map(|(_, row)| *row), pool);
        self.alone.order = order;
        self.load_bodies(places);
    }

    /// Puts those that are alone first, all others in the order that they have; and gives bodies their displacements in this step.
    pub fn arrange(&mut self, places: &Places, pool: &Pool) {
        self.put_first(0..self.list.len() as u32, pool);
        self.load_bodies(places);
    }

    /// Puts rows in such an order, but those that are alone first.
    fn put_first(&mut self, of: impl Iterator<Item = u32> + Clone, pool: &Pool) {
        let Self { list, vertices, locals, weights, alone, index, .. } = self;
        let Alone { count, counts, numbers, rows, sources, others, vertices: order, .. } = alone;
        index.forget();
        counts.clear();
        counts.resize(vertices.len(), 0);
        of.clone().flat_map(|index| list[index as usize].locals()).for_each(|local| counts[local] += 1);
        // Its only particle, if that is in no other row. Particles that are held go their own ways, which are not known yet.
        let own = |row: &Row| {
            let mut particles = row.locals().filter(|&local| (vertices[local] as usize) < self.particles);
            let first = particles.next().filter(|&local| counts[local] == 1);
            first.filter(|_| particles.next().is_none())
        };
        numbers.clear();
        numbers.resize(vertices.len(), NONE);
        order.clear();
        sources.clear();
        others.clear();
        for (index, row) in of.map(|index| (index, &list[index as usize])) {
            match own(row) {
                Some(local) => {
                    numbers[local] = order.len() as u32;
                    order.push(vertices[local]);
                    sources.push(index);
                }
                None => others.push(index),
            }
        }
        *count = sources.len();
        sources.append(others);
        for (number, &vertex) in numbers.iter_mut().zip(&*vertices).filter(|(number, _)| **number == NONE) {
            *number = order.len() as u32;
            order.push(vertex);
        }
        match list.first() {
            Some(&row) => rows.resize(sources.len(), row),
            None => rows.clear(),
        }
        for_each_chunk(rows, pool, |first, rows| {
            for (row, &source) in rows.iter_mut().zip(&sources[first..]) {
                *row = list[source as usize];
                row.ends = row.ends.map(|end| numbers[end as usize]);
            }
        });
        std::mem::swap(list, rows);
        std::mem::swap(vertices, order);
        for ((local, &vertex), weight) in (0..).zip(&*vertices).zip(weights) {
            locals[vertex as usize] = local;
            *weight = self.all_weights[vertex as usize];
        }
    }
}
