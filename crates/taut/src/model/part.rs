//! What every source (grid, mesh, network) delivers: points, areas and springs before material is put in.

use glam::DVec3;

use super::SpringKind;

/// One cloth's geometry in its rest shape; vertices in the user's order until they are renumbered.
#[derive(Debug, Default)]
pub(super) struct Part {
    /// Where the cloth's own coordinates begin [m].
    pub origin: DVec3,
    /// Rest positions from there [m].
    pub points: Vec<DVec3>,
    /// Triangles, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// The same surface as masses and wind see it.
    pub panels: Vec<Panel>,
    /// Springs in the order in which they are reported.
    pub springs: Vec<SpringSeed>,
    /// Repairs and oddities, one sentence each.
    pub notes: Vec<String>,
}

/// A triangle or a cell of a grid; all its corners have the same share in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Panel {
    /// Its corners, counter-clockwise seen from the front; a triangle has its last one twice.
    pub corners: [u32; 4],
}

impl Panel {
    /// A triangle.
    pub fn triangle([a, b, c]: [u32; 3]) -> Self {
        Self { corners: [a, b, c, c] }
    }

    /// Its corners, each once.
    pub fn distinct(&self) -> &[u32] {
        let count = if self.corners[2] == self.corners[3] { 3 } else { 4 };
        &self.corners[..count]
    }
}

/// A spring without its material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SpringSeed {
    /// The two points.
    pub ends: [u32; 2],
    /// Structural, shear or flexion.
    pub kind: SpringKind,
    /// Type 1: factor from the fabric's stiffness to the spring's constant [1] (docs/equations.md, "Spring constants"). Type 2:
    /// breadth of the cloth that it stands for [m], 1 in a network.
    pub weight: f64,
}

impl Part {
    /// Where the points are in the world [m].
    pub fn places(&self) -> impl Iterator<Item = DVec3> {
        self.points.iter().map(|&point| self.origin + point)
    }

    /// Has coordinates begin at another place [m]; the points stay where they are.
    pub fn begin_at(&mut self, origin: DVec3) {
        let way = self.origin - origin;
        if way != DVec3::ZERO {
            self.points.iter_mut().for_each(|point| *point += way);
        }
        self.origin = origin;
    }

    /// Distance between two points at rest [m].
    pub fn rest_length(&self, ends: [u32; 2]) -> f64 {
        self.points[ends[0] as usize].distance(self.points[ends[1] as usize])
    }

    /// With vertex v as point `numbers[v]`; springs and panels stand in the order of their points then.
    pub fn renumbered(mut self, numbers: &[u32]) -> Self {
        let number = |vertex: u32| numbers[vertex as usize];
        let mut points = self.points.clone();
        for (point, &number) in self.points.iter().zip(numbers) {
            points[number as usize] = *point;
        }
        self.points = points;
        self.triangles.iter_mut().for_each(|corners| *corners = corners.map(number));
        self.panels.iter_mut().for_each(|panel| panel.corners = panel.corners.map(number));
        self.panels.sort_by_key(|panel| panel.corners.iter().copied().min());
        for spring in &mut self.springs {
            spring.ends = spring.ends.map(number);
            spring.ends.sort_unstable();
        }
        self.springs.sort_by_key(|spring| spring.ends);
        self
    }

    /// Area that each point stands for: its share of the panels [m^2]; zero in networks and for isolated vertices.
    ///
    /// Wind is shared out the same way, so that a flat cloth in a steady wind moves as one.
    pub fn areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.points.len()];
        for panel in &self.panels {
            let [a, b, c, d] = panel.corners.map(|corner| self.points[corner as usize]);
            let area = 0.5 * (c - a).cross(d - b).length();
            let corners = panel.distinct();
            corners.iter().for_each(|&corner| areas[corner as usize] += area / corners.len() as f64);
        }
        areas
    }
}
