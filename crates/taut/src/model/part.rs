//! What every source (grid, mesh, network) delivers: points, areas and springs before material is put in.

use glam::DVec3;

use super::SpringKind;

/// One cloth's geometry in its rest shape, vertices in the user's order.
#[derive(Debug, Default)]
pub(super) struct Part {
    /// Rest positions [m].
    pub points: Vec<DVec3>,
    /// Area that each point stands for [m^2]; zero in networks and for isolated vertices.
    pub area: Vec<f64>,
    /// Triangles, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Springs in the order in which they are reported.
    pub springs: Vec<SpringSeed>,
    /// Repairs and oddities, one sentence each.
    pub notes: Vec<String>,
}

/// A spring without its material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SpringSeed {
    /// The two points.
    pub ends: [u32; 2],
    /// Structural, shear or flexion.
    pub kind: SpringKind,
    /// Factor from the fabric's stiffness to the spring's constant [1] (docs/equations.md, "Spring constants").
    pub weight: f64,
}

impl Part {
    /// Distance between two points at rest [m].
    pub fn rest_length(&self, ends: [u32; 2]) -> f64 {
        self.points[ends[0] as usize].distance(self.points[ends[1] as usize])
    }
}
