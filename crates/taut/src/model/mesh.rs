//! Any polygon mesh. Of a cloth: its edges become springs, quads get both diagonals, faults are repaired and reported.

use std::collections::BTreeSet;

use glam::DVec3;

use super::SpringKind::{Flexion, Shear, Structural};
use super::part::{Panel, Part, SpringSeed};
use super::winding;
use crate::geometry::power;
use crate::scene::{FARTHEST, SceneError};

/// A polygon mesh as it came from its file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeshData {
    /// Positions [m], in the file's order.
    pub vertices: Vec<[f64; 3]>,
    /// Vertex numbers of all polygons, one polygon after the other.
    pub corners: Vec<i64>,
    /// Corners of each polygon (3 or more).
    pub counts: Vec<i64>,
}

/// A triangle's area below this part of its longest side squared is taken for zero.
const FLAT: f64 = 1e-9;
/// Two triangles form a rectangle if their diagonals agree in length and middle to this part of the diagonal.
const RECTANGLE: f64 = 0.02;

/// A triangle and what became of its polygon.
struct Face {
    corners: [u32; 3],
    /// The edge `corners[0]`-`corners[1]`, `[1]`-`[2]`, `[2]`-`[0]` runs inside the polygon.
    inside: [bool; 3],
    from_triangle: bool,
    area: f64,
}

/// Use of an edge by a triangle.
#[derive(Clone, Copy)]
struct Side {
    ends: [u32; 2],
    face: u32,
    opposite: u32,
    inside: bool,
}

/// Builds springs and areas; `field` names the mesh in errors.
///
/// # Errors
/// Numbers that are not finite or, times `scale`, too far away; vertex numbers out of range; nothing usable left.
pub(super) fn build(mesh: &MeshData, field: &str, scale: f64, flexion: bool) -> Result<Part, SceneError> {
    let (mut part, faces) = triangles(mesh, field, scale, "a cloth")?;
    part.panels = part.triangles.iter().copied().map(Panel::triangle).collect();
    note_oddities(&mut part);
    springs(&faces, &mut part, flexion);
    Ok(part)
}

/// The points and triangles of the surface of a body, no more; `field` names the mesh in errors.
///
/// # Errors
/// Numbers that are not finite or, times `scale`, too far away; vertex numbers out of range; nothing usable left.
pub(super) fn surface(mesh: &MeshData, field: &str, scale: f64) -> Result<Part, SceneError> {
    triangles(mesh, field, scale, "a body").map(|(part, _)| part)
}

/// The points of a mesh, its triangles, neighbours seen from the same side, and what became of its polygons.
fn triangles(mesh: &MeshData, field: &str, scale: f64, what: &str) -> Result<(Part, Vec<Face>), SceneError> {
    check(mesh, field, scale)?;
    let points: Vec<DVec3> = mesh.vertices.iter().copied().map(DVec3::from_array).collect();
    let mut part = Part { points, ..Part::default() };
    let faces = triangulate(mesh, &part.points, &mut part.notes);
    if faces.is_empty() {
        return Err(SceneError::at(field, format!("has no face with an area; {what} needs at least one triangle")));
    }
    part.triangles = faces.iter().map(|face| face.corners).collect();
    let flipped = winding::make_consistent(&mut part.triangles);
    if flipped > 0 {
        part.notes.push(format!("{flipped} faces were turned round so that all face the same way"));
    }
    Ok((part, faces))
}

fn check(mesh: &MeshData, field: &str, scale: f64) -> Result<(), SceneError> {
    if let Some(index) = mesh.vertices.iter().position(|vertex| vertex.iter().any(|part| !part.is_finite())) {
        return Err(SceneError::at(field, format!("vertex {index} has a coordinate that is not a finite number")));
    }
    let far = |vertex: &[f64; 3]| vertex.iter().any(|part| (part * scale).abs() > FARTHEST);
    if let Some(index) = mesh.vertices.iter().position(far) {
        let [x, y, z] = mesh.vertices[index];
        let problem = format!(
            "vertex {index} is at [{x}, {y}, {z}], times scale = {scale}: coordinates must be in [-{FARTHEST}, {FARTHEST}] m; is the mesh in \
             millimetres? then {} = 0.001",
            field.replace(".mesh", ".scale")
        );
        return Err(SceneError::at(field, problem));
    }
    let count = mesh.vertices.len();
    if let Some(&corner) = mesh.corners.iter().find(|&&corner| usize::try_from(corner).map_or(true, |corner| corner >= count)) {
        return Err(SceneError::at(field, format!("a face names vertex {corner}; there are {count}, numbered from 0")));
    }
    let total: i128 = mesh.counts.iter().map(|&count| i128::from(count.max(0))).sum();
    if total != mesh.corners.len() as i128 || mesh.counts.iter().any(|&count| count < 0) {
        return Err(SceneError::at(field, "the corner counts of its faces do not add up to the number of corners"));
    }
    Ok(())
}

/// Polygons to triangles: quads along their shorter diagonal, larger ones as a fan.
fn triangulate(mesh: &MeshData, points: &[DVec3], notes: &mut Vec<String>) -> Vec<Face> {
    let (mut faces, mut seen) = (Vec::new(), BTreeSet::new());
    let (mut degenerate, mut duplicate) = (0, 0);
    let mut rest = &mesh.corners[..];
    for &count in &mesh.counts {
        let (polygon, tail) = rest.split_at(count as usize);
        rest = tail;
        let polygon: Vec<u32> = polygon.iter().map(|&corner| corner as u32).collect();
        for face in split(&polygon, points) {
            let [a, b, c] = face.corners.map(|corner| points[corner as usize]);
            let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
            let mut key = face.corners;
            key.sort_unstable();
            if face.area.is_nan() || face.area <= FLAT * longest {
                degenerate += 1;
            } else if seen.insert(key) {
                faces.push(face);
            } else {
                duplicate += 1;
            }
        }
    }
    if degenerate > 0 {
        notes.push(format!("{degenerate} faces without area were left out"));
    }
    if duplicate > 0 {
        notes.push(format!("{duplicate} faces that stand there twice were left out"));
    }
    faces
}

fn split(polygon: &[u32], points: &[DVec3]) -> Vec<Face> {
    let at = |index: usize| points[polygon[index] as usize];
    let turn = usize::from(polygon.len() == 4 && at(1).distance_squared(at(3)) < at(0).distance_squared(at(2)));
    let corner = |index: usize| polygon[(index + turn) % polygon.len()];
    let last = polygon.len().saturating_sub(1);
    (1..last)
        .map(|index| {
            let corners = [corner(0), corner(index), corner(index + 1)];
            let [a, b, c] = corners.map(|corner| points[corner as usize]);
            Face {
                corners,
                inside: [index > 1, false, index + 1 < last],
                from_triangle: polygon.len() == 3,
                area: 0.5 * (b - a).cross(c - a).length(),
            }
        })
        .collect()
}

fn note_oddities(part: &mut Part) {
    let isolated = part.areas().iter().filter(|&&area| area == 0.0).count();
    if isolated > 0 {
        part.notes.push(format!("{isolated} vertices belong to no face; they stay where they are"));
    }
    let mut places: Vec<[u64; 3]> = part.points.iter().map(|point| point.to_array().map(f64::to_bits)).collect();
    places.sort_unstable();
    let coincident = places.windows(2).filter(|pair| pair[0] == pair[1]).count();
    if coincident > 0 {
        part.notes
            .push(format!("{coincident} vertices lie exactly on others and are not joined to them; merge them if it is a seam"));
    }
}

fn springs(faces: &[Face], part: &mut Part, flexion: bool) {
    let mut sides: Vec<Side> = faces.iter().enumerate().flat_map(|(index, face)| sides_of(index, face)).collect();
    sides.sort_by_key(|side| (side.ends, side.face));
    let edges: Vec<&[Side]> = sides.chunk_by(|a, b| a.ends == b.ends).collect();
    let crowded = edges.iter().filter(|edge| edge.len() > 2).count();
    if crowded > 0 {
        part.notes.push(format!("{crowded} edges belong to more than two faces (non-manifold); they are simulated as they are"));
    }
    let is_edge = |ends: [u32; 2]| edges.binary_search_by_key(&ends, |edge| edge[0].ends).is_ok();
    let (mut structural, mut shear, mut flexed) = (Vec::new(), Vec::new(), Vec::new());
    for edge in &edges {
        let ends = edge[0].ends;
        let area: f64 = edge.iter().map(|side| faces[side.face as usize].area).sum();
        let weight = |ends: [u32; 2]| area / power(part.rest_length(ends), 2);
        let across = match edge {
            [one, other] if one.opposite != other.opposite => {
                Some([one.opposite.min(other.opposite), one.opposite.max(other.opposite)]).filter(|&pair| !is_edge(pair))
            }
            _ => None,
        };
        let diagonal = across.filter(|&pair| edge[0].inside || is_rectangle(part, faces, edge, pair));
        if edge[0].inside || diagonal.is_some() {
            shear.push(SpringSeed { ends, kind: Shear, weight: weight(ends) });
        } else {
            structural.push(SpringSeed { ends, kind: Structural, weight: weight(ends) });
        }
        if let Some(pair) = diagonal {
            shear.push(SpringSeed { ends: pair, kind: Shear, weight: weight(pair) });
        } else if let Some(pair) = across.filter(|_| flexion) {
            // In an equilateral mesh the three directions together are then as stiff as a plate in every direction.
            let breadth = 16.0 / 9.0 * area / part.rest_length(pair).max(f64::MIN_POSITIVE);
            flexed.push(SpringSeed { ends: pair, kind: Flexion, weight: breadth });
        }
    }
    part.springs = [structural, shear, flexed].concat();
    drop_coincident(part);
}

fn sides_of(index: usize, face: &Face) -> [Side; 3] {
    let [a, b, c] = face.corners;
    [(a, b, c, 0), (b, c, a, 1), (c, a, b, 2)].map(|(from, to, opposite, side)| Side {
        ends: [from.min(to), from.max(to)],
        face: index as u32,
        opposite,
        inside: face.inside[side],
    })
}

/// Two plain triangles that together are a rectangle: a grid that came in as a mesh.
fn is_rectangle(part: &Part, faces: &[Face], edge: &[Side], across: [u32; 2]) -> bool {
    let at = |index: u32| part.points[index as usize];
    let [a, b] = edge[0].ends.map(at);
    let [c, d] = across.map(at);
    let length = a.distance(b);
    edge.iter().all(|side| faces[side.face as usize].from_triangle)
        && (c.distance(d) - length).abs() <= RECTANGLE * length
        && (a + b).distance(c + d) <= 2.0 * RECTANGLE * length
}

/// A flexion or diagonal pair can fall on one place when a mesh is folded flat on itself; a spring needs a length.
fn drop_coincident(part: &mut Part) {
    let springs = std::mem::take(&mut part.springs);
    part.springs = springs.into_iter().filter(|spring| part.rest_length(spring.ends) > 0.0).collect();
}
