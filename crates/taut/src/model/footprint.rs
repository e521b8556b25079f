//! How much memory a scene needs, before anything of it is built: what does not fit must be refused, as memory that is not there ends
//! the process.

use std::collections::BTreeMap;

use super::MeshData;
use crate::scene::{BendingModel, Body, Cloth, FilterKind, Scene, Selector, Solver, Source};

/// What a scene needs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Footprint {
    /// Its vertices [1].
    pub vertices: u64,
    /// Its springs, about [1].
    pub springs: u64,
    /// Memory of a simulation of it while it is built, which is when it takes most, about [bytes].
    pub memory: u64,
    /// What a frame of it holds [bytes], as far as it changes: positions, velocities and what a run needs to go on.
    pub frame: u64,
}

/// Of a vertex [bytes]. These figures are measured: `tests/test_memory.py` compares them with what processes take.
const VERTEX: u64 = 90;
/// Of a spring, in its lists and in those that it comes from.
const SPRING: u64 = 150;
/// Of a triangle of a mesh: its edges are sorted to find springs.
const TRIANGLE: u64 = 230;
/// Of a point of a network: its scene is kept with it.
const POINT: u64 = 790;
/// Of a spring in the levels of "coarse_to_fine", but for grids that hold single vertices and whole borders.
const LEVELS: u64 = 230;
/// Of a vertex that can touch something: its neighbours, its trees, its charts and the pairs of a step; grids have levels of their own then.
const CONTACT: u64 = 2500;
/// The same of a point of a network, which has no charts.
const CONTACT_OF_POINT: u64 = 600;
/// Of a spring, in the matrix of an implicit method.
const MATRIX: u64 = 150;
/// Of a spring, as a constraint of "xpbd".
const COMPLIANCE: u64 = 40;
/// Of a spring, in the factors of "fast_projection".
const FACTORS: u64 = 320;
/// Of a spring that follows a curve.
const CURVED: u64 = 60;
/// Of a vertex of a grid, of a triangle of a mesh and of a link of a network that resist bending; with springs that buckle, of a vertex.
const BENDING: [u64; 4] = [410, 1200, 150, 200];
/// Of three numbers in single precision.
const VECTOR: u64 = 12;

impl Footprint {
    /// That of a scene; `meshes` holds the geometry of the meshes that it names.
    #[must_use]
    pub fn of(scene: &Scene, meshes: &BTreeMap<String, MeshData>) -> Self {
        let cloths = scene.cloth.iter().map(|cloth| Self::of_cloth(cloth, &scene.solver, meshes));
        cloths.chain(scene.body.iter().map(|body| Self::of_body(body, meshes))).fold(Self::default(), |sum, one| Self {
            vertices: sum.vertices + one.vertices,
            springs: sum.springs + one.springs,
            memory: sum.memory + one.memory,
            frame: sum.frame + one.frame,
        })
    }

    /// That of one of the bodies of a scene: memory alone.
    #[must_use]
    pub fn of_body(body: &Body, meshes: &BTreeMap<String, MeshData>) -> Self {
        let mesh = body.mesh.as_ref().and_then(|name| meshes.get(name));
        Self {
            memory: mesh.map_or(0, |mesh| VERTEX * mesh.vertices.len() as u64 + TRIANGLE * triangles(mesh)),
            ..Self::default()
        }
    }

    /// That of one of the cloths of a scene with this solver.
    #[must_use]
    pub fn of_cloth(cloth: &Cloth, solver: &Solver, meshes: &BTreeMap<String, MeshData>) -> Self {
        let (vertices, springs, triangles, bending) = match cloth.sources().first() {
            Some(Source::Grid(grid)) => {
                let [columns, rows] = grid.cells.map(u64::from);
                let vertices = (columns + 1) * (rows + 1);
                (vertices, 4 * columns * rows + columns + rows, 0, BENDING[0] * vertices)
            }
            Some(Source::Mesh(name)) => {
                let Some(mesh) = meshes.get(*name) else { return Self::default() };
                let triangles = triangles(mesh);
                // Two triangles share an edge; a quad has its second diagonal as well.
                let diagonals = mesh.counts.iter().filter(|&&count| count == 4).count() as u64;
                (mesh.vertices.len() as u64, 3 * triangles / 2 + diagonals, triangles, BENDING[1] * triangles)
            }
            Some(Source::Network(network)) => {
                let links = network.links.len() as u64;
                (network.points.len() as u64, links, 0, BENDING[2] * links)
            }
            None => return Self::default(),
        };
        let buckles = cloth.bending_model == BendingModel::ChoiKo;
        let bends = cloth.bending() > 0.0 || cloth.curves.as_ref().is_some_and(|curves| curves.bending.is_some());
        let bending = if buckles { BENDING[3] * vertices } else { bending };
        let flexion = if cloth.flexion_stiffness > 0.0 { 2 * vertices } else { 0 };
        // What can touch anything has been given a thickness.
        let touches = cloth.thickness.is_some();
        let contact = if cloth.network.is_some() { CONTACT_OF_POINT } else { CONTACT };
        let mut selectors = cloth.pins.iter().flat_map(|pin| pin.selectors());
        let may_hold_neighbours = selectors.any(|selector| matches!(selector, Selector::Box(_) | Selector::Vertices([_, _, ..])));
        let has_hierarchy = cloth.grid.is_none() || touches || may_hold_neighbours;
        let each = |applies: bool, bytes: u64| if applies { bytes } else { 0 };
        let of_spring = SPRING
            + each(solver.filter == FilterKind::CoarseToFine && has_hierarchy, LEVELS)
            + each(solver.integrator.is_implicit(), MATRIX)
            + each(solver.filter == FilterKind::Xpbd, COMPLIANCE)
            + each(solver.filter == FilterKind::FastProjection, FACTORS)
            + each(cloth.curves.is_some(), CURVED);
        let springs = springs + flexion;
        let rows = 2 + u64::from(solver.tells_motion_apart()) + 2 * u64::from(solver.integrator.remembers());
        Self {
            vertices,
            springs,
            memory: (VERTEX + each(cloth.network.is_some(), POINT) + each(touches, contact)) * vertices
                + of_spring * springs
                + TRIANGLE * triangles
                + each(bends, bending),
            frame: VECTOR * rows * vertices,
        }
    }
}

/// Triangles that the faces of a mesh make.
fn triangles(mesh: &MeshData) -> u64 {
    (mesh.corners.len() as u64).saturating_sub(2 * mesh.counts.len() as u64)
}
