//! Bending as the levels of a cloth see it.
//!
//! A displacement q of the particles of a level bends the cloth with the energy `q^T P^T Q P q / 2` at most, Q being the matrix of its
//! bending where that is stiffest. A level shows hardly any curvature: from one to the next, twice as coarse, `P^T Q P` over the masses falls
//! to an eighth or less, where springs fall to a quarter.

use super::HierarchyLevel;
use crate::model::{Adjacency, Bending, ClothRange};

/// A symmetric matrix over the free particles of a level [N/m], row by row.
#[derive(Debug)]
pub(super) struct Plate {
    rows: Adjacency<(u32, f64)>,
}

impl Plate {
    /// Of a cloth, over the particles of its finest level.
    pub fn new(bending: &Bending, cloth: &ClothRange, finest: &HierarchyLevel) -> Self {
        let mut place = vec![None; cloth.count];
        for (index, (&node, &mass)) in (0..).zip(finest.nodes.iter().zip(&finest.masses)) {
            place[node as usize] = Some(index).filter(|_| mass > 0.0);
        }
        let place = |particle: u32| place[particle as usize - cloth.first];
        Self::of_rows(finest.nodes.len(), |own, row| {
            let particle = cloth.first + finest.nodes[own] as usize;
            if place(particle as u32).is_none() {
                return;
            }
            let curved = &bending.curved;
            let bends = bending.quadratic.of(particle).iter().map(|bend| (bend.other, f64::from(bend.weight)));
            let buckles = bending.buckling.of(particle).iter().map(|spring| (spring.other, spring.steepest()));
            for (other, pull) in bends.chain(buckles) {
                row.add(own as u32, pull);
                place(other).into_iter().for_each(|other| row.add(other, -pull));
            }
            for share in curved.rows.of(particle) {
                let of_row = share.index as usize;
                let stiffness = curved.curves[curved.curve[of_row] as usize].steepest() * f64::from(share.weight);
                for other in curved.particles.of(of_row) {
                    place(other.index).into_iter().for_each(|place| row.add(place, stiffness * f64::from(other.weight)));
                }
            }
        })
    }

    /// `P^T Q P`: the same over the particles of the next coarser level.
    pub fn carried(&self, fine: usize, coarse: &HierarchyLevel) -> Self {
        let parents =
            |place: u32| coarse.parents[place as usize].iter().filter(|(above, _)| coarse.masses[*above as usize] > 0.0);
        let columns = Self::of_rows_into(fine, coarse.nodes.len(), |place, row| {
            for &(other, entry) in self.rows.of(place) {
                parents(other).for_each(|(above, part)| row.add(above, f64::from(part) * entry));
            }
        });
        let follow = (0..fine as u32).flat_map(|place| parents(place).map(move |(above, part)| (above, (place, part))));
        let children = Adjacency::new(coarse.nodes.len(), follow);
        Self::of_rows(coarse.nodes.len(), |above, row| {
            for &(place, part) in children.of(above) {
                columns.of(place as usize).iter().for_each(|&(other, entry)| row.add(other, f64::from(part) * entry));
            }
        })
    }

    /// Absolute sum of a row [N/m].
    pub fn row_sum(&self, place: usize) -> f64 {
        self.rows.of(place).iter().map(|(_, entry)| entry.abs()).sum()
    }

    fn of_rows(count: usize, fill: impl FnMut(usize, &mut Row)) -> Self {
        Self { rows: Self::of_rows_into(count, count, fill) }
    }

    /// The entries that `fill` adds to each row, those of one column summed up.
    fn of_rows_into(rows: usize, columns: usize, mut fill: impl FnMut(usize, &mut Row)) -> Adjacency<(u32, f64)> {
        let mut row = Row { sums: vec![0.0; columns], is_there: vec![false; columns], there: Vec::new() };
        let mut entries: Vec<(u32, (u32, f64))> = Vec::new();
        for place in 0..rows {
            fill(place, &mut row);
            for column in row.there.drain(..) {
                entries.push((place as u32, (column, std::mem::take(&mut row.sums[column as usize]))));
                row.is_there[column as usize] = false;
            }
        }
        Adjacency::new(rows, entries.into_iter())
    }
}

/// A row in the making.
struct Row {
    sums: Vec<f64>,
    is_there: Vec<bool>,
    there: Vec<u32>,
}

impl Row {
    fn add(&mut self, column: u32, entry: f64) {
        self.sums[column as usize] += entry;
        if !std::mem::replace(&mut self.is_there[column as usize], true) {
            self.there.push(column);
        }
    }
}
