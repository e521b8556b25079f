//! A rectangle of cells: the paper's lattice (Choi & Ko 2002), springs as in its Fig. 3.

use glam::DVec3;

use super::SpringKind::{Flexion, Shear, Structural};
use super::part::{Panel, Part, SpringSeed};
use crate::scene::{Corner, Edge, Grid};

/// Builds the lattice; vertex `(i, j)` (column, row from the bottom left) has number `j * columns + i`.
pub(super) fn build(grid: &Grid, flexion: bool) -> Part {
    let [nx, ny] = grid.cells;
    let cell = [grid.size[0] / f64::from(nx), grid.size[1] / f64::from(ny)];
    let [right, up] = grid.axes.map(|axis| DVec3::from_array(axis.direction()));
    let mut part = Part { origin: DVec3::from_array(grid.origin), ..Part::default() };
    part.points.reserve((nx as usize + 1) * (ny as usize + 1));
    for j in 0..=ny {
        for i in 0..=nx {
            part.points.push(right * (cell[0] * f64::from(i)) + up * (cell[1] * f64::from(j)));
        }
    }
    part.triangles = triangles(grid.cells);
    part.panels = cells(grid.cells).map(|(_, _, corners)| Panel { corners }).collect();
    part.springs = springs(grid.cells, cell, flexion);
    part
}

/// 1 inside, 1/2 on the border: how much cloth lies beside a row or column of springs.
fn inner(index: u32, cells: u32) -> f64 {
    if index == 0 || index == cells { 0.5 } else { 1.0 }
}

/// Column and row of each cell and its corners, counter-clockwise from the bottom left.
fn cells([nx, ny]: [u32; 2]) -> impl Iterator<Item = (u32, u32, [u32; 4])> {
    (0..ny).flat_map(move |j| {
        (0..nx).map(move |i| {
            let a = j * (nx + 1) + i;
            (i, j, [a, a + 1, a + nx + 2, a + nx + 1])
        })
    })
}

/// Two triangles a cell, their diagonal alternating so that the cloth shows no grain of its own.
fn triangles(counts: [u32; 2]) -> Vec<[u32; 3]> {
    let halves = |(i, j, [a, b, c, d]): (u32, u32, [u32; 4])| {
        if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    };
    cells(counts).flat_map(halves).collect()
}

/// Structural springs (both directions), then shear springs (both diagonals), then type 2 springs.
///
/// Weights are A_e / L^2 (Van Gelder 1998): 1 inside a square grid, 1/2 on its border and on the diagonals.
fn springs([nx, ny]: [u32; 2], cell: [f64; 2], flexion: bool) -> Vec<SpringSeed> {
    let id = |i: u32, j: u32| j * (nx + 1) + i;
    let mut springs = Vec::with_capacity(if flexion { 6 } else { 4 } * (nx as usize + 1) * (ny as usize + 1));
    let mut add = |a, b, kind, weight| springs.push(SpringSeed { ends: [a, b], kind, weight });
    for j in 0..=ny {
        for i in 0..nx {
            add(id(i, j), id(i + 1, j), Structural, inner(j, ny) * cell[1] / cell[0]);
        }
    }
    for j in 0..ny {
        for i in 0..=nx {
            add(id(i, j), id(i, j + 1), Structural, inner(i, nx) * cell[0] / cell[1]);
        }
    }
    let diagonal = cell[0] * cell[1] / (cell[0] * cell[0] + cell[1] * cell[1]);
    for j in 0..ny {
        for i in 0..nx {
            add(id(i, j), id(i + 1, j + 1), Shear, diagonal);
            add(id(i + 1, j), id(i, j + 1), Shear, diagonal);
        }
    }
    if flexion {
        for j in 0..=ny {
            for i in 0..nx.saturating_sub(1) {
                add(id(i, j), id(i + 2, j), Flexion, inner(j, ny) * cell[1]);
            }
        }
        for j in 0..ny.saturating_sub(1) {
            for i in 0..=nx {
                add(id(i, j), id(i, j + 2), Flexion, inner(i, nx) * cell[0]);
            }
        }
    }
    springs
}

/// The vertex at a corner.
pub(super) fn corner(grid: &Grid, corner: Corner) -> u32 {
    let [nx, ny] = grid.cells;
    let (i, j) = match corner {
        Corner::BottomLeft => (0, 0),
        Corner::BottomRight => (nx, 0),
        Corner::TopLeft => (0, ny),
        Corner::TopRight => (nx, ny),
    };
    j * (nx + 1) + i
}

/// The vertices along an edge.
pub(super) fn edge(grid: &Grid, edge: Edge) -> Vec<u32> {
    let [nx, ny] = grid.cells;
    match edge {
        Edge::Left => (0..=ny).map(|j| j * (nx + 1)).collect(),
        Edge::Right => (0..=ny).map(|j| j * (nx + 1) + nx).collect(),
        Edge::Bottom => (0..=nx).collect(),
        Edge::Top => (0..=nx).map(|i| ny * (nx + 1) + i).collect(),
    }
}
