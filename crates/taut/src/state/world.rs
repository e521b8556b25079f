//! Between the local positions of cloths and their places in the world.

use glam::{DVec3, Vec3};

use super::{Clock, State};
use crate::geometry::{Pool, Vectors};
use crate::model::{ClothRange, Model, Origin};

impl State {
    /// A state of particles at places in the world [m]; a two-step integrator starts anew. Cloths that are far from where they were
    /// built get origins near them.
    #[must_use]
    pub fn in_world(model: &Model, place: impl Fn(usize) -> DVec3, velocities: Vectors, clock: Clock) -> Self {
        let mut state = Self::new(model);
        for (Origin { at, pitch, guide }, origin) in model.origins.iter().zip(&mut state.origins) {
            // A cloth without particles has no guide.
            if (*guide as usize) < model.particle_count() {
                let local = place(*guide as usize) - *at;
                *origin += Origin { at: *at, pitch: *pitch, guide: *guide }.way(local.as_vec3());
            }
        }
        for (cloth, origin) in model.cloths.iter().zip(&state.origins) {
            for particle in cloth.particles() {
                state.positions.set(particle, (place(particle) - *origin).as_vec3());
            }
        }
        state.set_velocities(velocities);
        Self { clock, ..state }
    }

    /// Where a particle of a cloth is in the world [m].
    #[must_use]
    pub fn place(&self, cloth: usize, particle: usize) -> DVec3 {
        self.origins[cloth] + self.positions.get(particle).as_dvec3()
    }

    /// Displaces a cloth as a whole [m], and the paths of its pins. All but its origin is told from there, and stays as it is.
    pub fn translate(&mut self, model: &Model, cloth: usize, offset: DVec3) {
        self.origins[cloth] += offset;
        for (_, own) in model.pins.iter().zip(&mut self.offsets).filter(|(pins, _)| pins.cloth == cloth) {
            own.now += offset;
            own.target += offset;
        }
        self.may_cross = model.contact.untangles;
        self.wake();
    }

    /// Lays origins elsewhere where cloths have travelled; their places in the world stay but for rounding.
    pub fn follow(&mut self, model: &Model, pool: &Pool) {
        for ((cloth, origin), at) in model.cloths.iter().zip(&model.origins).zip(&mut self.origins) {
            if cloth.count == 0 {
                continue;
            }
            let way = origin.way(self.positions.get(origin.guide as usize));
            if way != DVec3::ZERO {
                *at += way;
                shift(&mut self.positions, cloth, way.as_vec3(), pool);
            }
        }
    }

    /// Places of all particles in the world [m].
    #[must_use]
    pub fn places(&self, model: &Model) -> Vec<DVec3> {
        let of = |cloth: &ClothRange, origin: DVec3| cloth.particles().map(move |at| origin + self.positions.get(at).as_dvec3());
        model.cloths.iter().zip(&self.origins).flat_map(|(cloth, origin)| of(cloth, *origin)).collect()
    }

    /// Writes the places of all vertices in the world [m], in the order of the vertices, as rows.
    ///
    /// # Panics
    /// If there are not as many rows as vertices.
    pub fn write_places(&self, model: &Model, rows: &mut [[f32; 3]], pool: &Pool) {
        for (cloth, origin) in model.cloths.iter().zip(&self.origins) {
            let rows = &mut rows[cloth.particles()];
            if *origin == DVec3::ZERO {
                model.numbering.write_rows(&self.positions, cloth.first, rows, pool, |local| local.to_array());
            } else {
                model.numbering.write_rows(&self.positions, cloth.first, rows, pool, |local| rounded(*origin, local));
            }
        }
    }
}

/// The place in the world in single precision; along an axis where the origin is zero the very same bits.
fn rounded(origin: DVec3, local: Vec3) -> [f32; 3] {
    let (origin, local) = (origin.to_array(), local.to_array());
    [0, 1, 2].map(|axis| if origin[axis] == 0.0 { local[axis] } else { (origin[axis] + f64::from(local[axis])) as f32 })
}

fn shift(positions: &mut Vectors, cloth: &ClothRange, way: Vec3, pool: &Pool) {
    positions.for_each_chunk_of(cloth.particles(), pool, |chunk| {
        for (column, way) in [(chunk.x, way.x), (chunk.y, way.y), (chunk.z, way.z)] {
            // What is not moved keeps its bits, the sign of zero too.
            if way != 0.0 {
                column.iter_mut().for_each(|value| *value -= way);
            }
        }
    });
}
