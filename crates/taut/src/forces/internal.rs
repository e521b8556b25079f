//! F_INT = F_s + F_D (paper, section 2.1): the springs and dampers around each particle.
//!
//! Inside a regular grid the neighbours stand at fixed distances in memory, and whole runs of particles are handled
//! with vector instructions; everywhere else each particle gathers along its list of links.

use glam::Vec3;
use pulp::Arch;

use super::{damping, spring};
use crate::geometry::VectorsChunk;
use crate::model::{Lattice, Model, Stencil};
use crate::state::State;

/// Writes F_INT of each particle of the chunk.
pub(super) fn fill(model: &Model, state: &State, chunk: &mut VectorsChunk<'_>) {
    let (first, end) = (chunk.first, chunk.first + chunk.x.len());
    let mut next = first;
    for lattice in &model.lattices {
        for row in 1..lattice.rows - 1 {
            // The interior of the row, as far as it lies in the chunk.
            let left = lattice.first + row * lattice.columns;
            let from = (left + 1).max(next);
            let to = (left + lattice.columns - 1).min(end);
            if from < to {
                gather(model, state, chunk, next, from);
                run(lattice, state, chunk, from, to);
                next = to;
            }
        }
    }
    gather(model, state, chunk, next, end);
}

/// Particle by particle along the lists of links.
fn gather(model: &Model, state: &State, chunk: &mut VectorsChunk<'_>, from: usize, to: usize) {
    for particle in from..to {
        let (position, velocity) = (state.positions.get(particle), state.velocities.get(particle));
        let mut force = Vec3::ZERO;
        for link in model.links.of(particle) {
            let other = link.other as usize;
            force += spring::force(state.positions.get(other) - position, link.rest, link.stiffness);
            force += damping::force(state.velocities.get(other) - velocity, link.damping);
        }
        let place = particle - chunk.first;
        (chunk.x[place], chunk.y[place], chunk.z[place]) = (force.x, force.y, force.z);
    }
}

/// A run of interior particles of one row of a lattice.
fn run(lattice: &Lattice, state: &State, chunk: &mut VectorsChunk<'_>, from: usize, to: usize) {
    let out = from - chunk.first..to - chunk.first;
    let force = [&mut chunk.x[out.clone()], &mut chunk.y[out.clone()], &mut chunk.z[out]];
    Arch::new().dispatch(
        #[inline(always)]
        || {
            let [x, y, z] = force;
            x.fill(0.0);
            y.fill(0.0);
            z.fill(0.0);
            for stencil in &lattice.stencil {
                add(stencil, state, from, [&mut *x, &mut *y, &mut *z]);
            }
        },
    );
}

/// Adds the force of the springs in one direction: `spring::force` and `damping::force` written for vector registers.
#[inline(always)]
fn add(stencil: &Stencil, state: &State, from: usize, [fx, fy, fz]: [&mut [f32]; 3]) {
    let len = fx.len();
    let (fy, fz) = (&mut fy[..len], &mut fz[..len]);
    let there = from.wrapping_add_signed(stencil.offset);
    let (x, y, z) = (&state.positions.x, &state.positions.y, &state.positions.z);
    let (here_x, here_y, here_z) = (&x[from..from + len], &y[from..from + len], &z[from..from + len]);
    let (there_x, there_y, there_z) = (&x[there..there + len], &y[there..there + len], &z[there..there + len]);
    let (u, v, w) = (&state.velocities.x, &state.velocities.y, &state.velocities.z);
    let (here_u, here_v, here_w) = (&u[from..from + len], &v[from..from + len], &w[from..from + len]);
    let (there_u, there_v, there_w) = (&u[there..there + len], &v[there..there + len], &w[there..there + len]);
    let Stencil { rest, stiffness, damping, .. } = *stencil;
    for i in 0..len {
        let (dx, dy, dz) = (there_x[i] - here_x[i], there_y[i] - here_y[i], there_z[i] - here_z[i]);
        let length = (dx * dx + dy * dy + dz * dz).sqrt();
        let factor = if length > 0.0 { stiffness * (1.0 - rest / length) } else { 0.0 };
        fx[i] += dx * factor + (there_u[i] - here_u[i]) * damping;
        fy[i] += dy * factor + (there_v[i] - here_v[i]) * damping;
        fz[i] += dz * factor + (there_w[i] - here_w[i]) * damping;
    }
}
