//! Regular grids: neighbours by arithmetic instead of by list.

use super::{Adjacency, ClothRange, Link, Springs};
use crate::scene::Grid;

/// A regular grid among the cloths; particle `(i, j)` (column, row) has number `first + j * columns + i`.
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice {
    /// Its first particle.
    pub first: usize,
    /// Particles in a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// The springs of each particle that is not on the border, all alike.
    pub stencil: [Stencil; 8],
    /// Greatest lengths of all springs to the right, up, up-right and up-left, the least of each kind [m].
    pub limits: [f32; 4],
}

/// A spring from a particle to a neighbour in a fixed direction.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Stencil {
    /// The neighbour's number less the particle's own.
    pub offset: isize,
    /// L [m].
    pub rest: f32,
    /// k_s [N/m].
    pub stiffness: f32,
    /// k_D [kg/s].
    pub damping: f32,
}

impl Lattice {
    /// The lattice of a grid, if it has an interior; `links_of` gives the springs of a particle.
    ///
    /// The stencil is read off one interior particle, so that it cannot differ from the springs themselves.
    pub(super) fn new(grid: &Grid, cloth: &ClothRange, springs: &Springs, links: &Adjacency<Link>) -> Option<Self> {
        let first = cloth.first;
        let [columns, rows] = grid.cells.map(|cells| cells as usize + 1);
        if columns < 3 || rows < 3 {
            return None;
        }
        let middle = first + columns + 1;
        let mut stencil = [Stencil::default(); 8];
        let links = links.of(middle);
        if links.len() != stencil.len() {
            return None; // Type 2 springs reach further.
        }
        for (place, link) in stencil.iter_mut().zip(links) {
            let offset = link.other as isize - middle as isize;
            *place = Stencil { offset, rest: link.rest, stiffness: link.stiffness, damping: link.damping };
        }
        let limits = [1, columns, columns + 1, columns - 1].map(|offset| {
            let kind = cloth.springs.clone().filter(|&spring| {
                let [u, v] = springs.ends[spring];
                u.abs_diff(v) as usize == offset
            });
            kind.map(|spring| springs.greatest_length(spring)).fold(f32::INFINITY, f32::min)
        });
        Some(Self { first, columns, rows, stencil, limits })
    }
}
