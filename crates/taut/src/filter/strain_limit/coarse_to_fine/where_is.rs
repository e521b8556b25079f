//! Where the particles are that rows of contact move: in the levels of which cloth, or in none.

use std::ops::Range;

use glam::Vec3;

use super::unit::Unit;
use crate::contact::Rows;
use crate::geometry::{Pool, Vectors};

/// What has no unit.
pub(super) const NONE: u32 = u32::MAX;

/// The unit of each particle, and the particle's number in its cloth; and the particles that no spring is tied to, with how far each
/// particle goes so far if there are any [m].
pub(super) struct WhereIs {
    places: Vec<(u32, u32)>,
    loose: Vec<u32>,
    ways: Vec<Vec3>,
    /// The vertices in rows in runs of particles of one unit, or of none: the unit, and which they are; and of each its number in the cloth,
    /// or of all if it has no unit.
    runs: Vec<(u32, Range<usize>)>,
    in_rows: Vec<u32>,
}

impl WhereIs {
    pub fn new(places: Vec<(u32, u32)>) -> Self {
        let loose: Vec<u32> = (0..).zip(&places).filter(|(_, place)| place.0 == NONE).map(|(particle, _)| particle).collect();
        let ways = if loose.is_empty() { Vec::new() } else { vec![Vec3::ZERO; places.len()] };
        Self { places, loose, ways, runs: Vec::new(), in_rows: Vec::new() }
    }

    /// Takes where particles that no spring is tied to are proposed to go.
    pub fn load(&mut self, positions: &Vectors, ends: &Vectors) {
        for particle in self.loose.iter().map(|&particle| particle as usize) {
            self.ways[particle] = ends.get(particle) - positions.get(particle);
        }
    }

    /// Tells where particles end up as the levels have them.
    pub fn tell(&self, positions: &Vectors, units: &[Unit], ends: &mut Vectors, pool: &Pool) {
        ends.for_each_chunk(pool, |ends| {
            ends.map(|particle, end| match self.of(particle) {
                Some((unit, own)) => positions.get(particle) + units[unit].levels().displacement(own),
                None => end,
            });
        });
    }

    /// Particles that no spring is tied to, and how far they go so far [m].
    pub fn loose(&self) -> impl Iterator<Item = (usize, Vec3)> {
        self.loose.iter().map(|&particle| (particle as usize, self.ways[particle as usize]))
    }

    /// The unit of a particle, if it has one, and its number in the cloth.
    pub fn of(&self, particle: usize) -> Option<(usize, usize)> {
        let (unit, own) = self.places[particle];
        (unit != NONE).then_some((unit as usize, own as usize))
    }

    /// Has a held particle go such a way [m].
    pub fn hold(&mut self, units: &mut [Unit], particle: usize, way: Vec3) {
        match self.of(particle) {
            Some((unit, own)) => units[unit].grip(own, way),
            None => self.ways[particle] = way,
        }
    }

    /// Moves a particle [m].
    pub fn shift(&mut self, units: &mut [Unit], particle: usize, way: Vec3) {
        match self.of(particle) {
            Some((unit, own)) => units[unit].levels_mut().shift(own, way),
            None => self.ways[particle] += way,
        }
    }

    /// Takes which vertices are in rows.
    pub fn take(&mut self, rows: &Rows) {
        self.runs.clear();
        self.in_rows.clear();
        for (local, &vertex) in rows.vertices().iter().enumerate() {
            // Those of bodies come after all particles.
            let place = self.places.get(vertex as usize).copied();
            self.in_rows.push(place.map_or(NONE, |(unit, own)| if unit == NONE { vertex } else { own }));
            let Some((unit, _)) = place else { continue };
            match self.runs.last_mut() {
                Some((last, run)) if *last == unit && run.end == local => run.end += 1,
                _ => self.runs.push((unit, local..local + 1)),
            }
        }
    }

    /// Gives rows the displacements that the levels have.
    pub fn gather(&self, rows: &mut Rows, units: &[Unit], pool: &Pool) {
        for (unit, run) in &self.runs {
            rows.take(run.clone(), pool, |part, ways| {
                let own = &self.in_rows[part];
                match units.get(*unit as usize) {
                    Some(unit) => unit.levels().displacements(own, ways),
                    None => own.iter().zip(ways).for_each(|(&particle, way)| *way = self.ways[particle as usize]),
                }
            });
        }
    }

    /// Projects rows, and tells the levels.
    pub fn sweep(&mut self, rows: &mut Rows, units: &mut [Unit], pool: &Pool) {
        rows.sweep(pool);
        for (unit, run) in &self.runs {
            let (own, [before, now]) = (&self.in_rows[run.clone()], rows.ways(run.clone()));
            match units.get_mut(*unit as usize) {
                Some(unit) => unit.levels_mut().shift_all(own, [before, now]),
                None => own.iter().zip(now).for_each(|(&particle, now)| self.ways[particle as usize] = *now),
            }
        }
    }
}
