//! The last few rows that are not kept and springs that are over their limit, put right one by one, with what that moves.
//!
//! Rounds over all rows and springs bring nearly all of them where they should be soon, and then go on for the sake of a few: a corner
//! that bears the whole cloth, places of a crumpled one where layers press each other. So the vertices of these are visited. At each the rows
//! that are not kept are projected, then the springs that are over; both ends of what was projected are visited the next time. That is
//! the sweep of a round where there is something to do. It dies out, since springs are pulled below their limit by the back-off and rows
//! have their slack; where it goes on for too long, another round helps more.

use super::descent::Descent;
use super::unit::Unit;
use super::where_is::WhereIs;
use crate::contact::Rows;
use crate::geometry::Pool;

/// So few rows, as a part of all, are put right one by one [1].
const FEW: f32 = 0.06;
/// .. with at most so many visits, as a part of all particles: about what a round costs.
const VISITS: f32 = 0.5;
/// .. and in small cloths.
const VISITS_AT_LEAST: usize = 100;

/// The vertices that are visited, and those that will be the next time; by their numbers among all.
#[derive(Debug, Default)]
pub(super) struct Worklist {
    list: Vec<u32>,
    next: Vec<u32>,
    is_in: Vec<bool>,
}

impl Worklist {
    /// Of so many particles.
    pub fn new(particles: usize) -> Self {
        Self { is_in: vec![false; particles], ..Self::default() }
    }

    /// Puts right what is left; rows must know the displacements that the levels have, and do so after it. Returns whether that was done:
    /// not where much is left, and not wholly where it does not die out.
    pub fn run(
        &mut self,
        where_is: &mut WhereIs,
        rows: &mut Rows,
        units: &mut [Unit],
        descents: &[Descent],
        pool: &Pool,
    ) -> bool {
        if !self.begin(rows, units, descents) {
            return false;
        }
        let mut visits = VISITS_AT_LEAST + (VISITS * self.is_in.len() as f32) as usize;
        if !self.list.is_empty() {
            rows.index();
        }
        while !self.list.is_empty() {
            if self.list.len() > visits {
                where_is.gather(rows, units, pool);
                return false;
            }
            visits -= self.list.len();
            for index in 0..self.list.len() {
                let vertex = self.list[index] as usize;
                rows.put_right(vertex, |moved, way| {
                    where_is.shift(units, moved, way);
                    self.put(moved);
                });
                if let Some((unit, own)) = where_is.of(vertex) {
                    let first = units[unit].cloth().first;
                    units[unit].put_right(own, &descents[unit], |moved, way| {
                        rows.shift(first + moved, way);
                        self.put(first + moved);
                    });
                }
            }
            self.turn();
        }
        true
    }

    /// Begins with the particles of rows that are not kept and of springs that are over. Returns whether these are few.
    fn begin(&mut self, rows: &Rows, units: &[Unit], descents: &[Descent]) -> bool {
        let mut are_few = rows.unkept(1 + (FEW * rows.len() as f32) as usize, |particle| self.put(particle));
        for (unit, descent) in units.iter().zip(descents) {
            are_few = are_few && unit.over(descent, |own| self.put(unit.cloth().first + own));
        }
        self.turn();
        are_few
    }

    /// Has a particle visited the next time.
    fn put(&mut self, particle: usize) {
        if !std::mem::replace(&mut self.is_in[particle], true) {
            self.next.push(particle as u32);
        }
    }

    /// Goes on to those of the next time.
    fn turn(&mut self) {
        std::mem::swap(&mut self.list, &mut self.next);
        self.next.clear();
        self.list.iter().for_each(|&particle| self.is_in[particle as usize] = false);
    }
}
