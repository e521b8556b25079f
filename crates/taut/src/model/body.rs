//! What stands in the way of cloths, as it is at the start.

use std::collections::BTreeMap;
use std::ops::Range;

use glam::DVec3;

use super::{MeshData, mesh};
use crate::geometry::turn;
use crate::scene::{Body as Asked, Cuboid, Scene, SceneError, Shape};

/// Vertices are numbered with 32 bits.
const MOST_VERTICES: usize = i32::MAX as usize;

/// What cloth collides with.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Its name.
    pub name: String,
    /// What its vertices mean.
    pub shape: BodyShape,
    /// Its vertices, among those of all bodies.
    pub vertices: Range<usize>,
    /// Its triangles, among those of all bodies; none unless it is a surface.
    pub triangles: Range<usize>,
    /// Of a sphere or a capsule [m]; otherwise 0.
    pub radius: f64,
    /// Coulomb's coefficient of the friction of cloth on it [1].
    pub friction: f64,
    /// The skin around it [m].
    pub thickness: f64,
}

/// What the vertices of a body mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BodyShape {
    /// One vertex: its middle.
    Sphere,
    /// Two: the ends of its line.
    Capsule,
    /// Two: a point of it, and the point 1 m from there along its normal.
    Plane,
    /// The corners of triangles, counter-clockwise seen from outside. A box is one of 8 vertices and 12 triangles; a mesh has the
    /// vertices and the sides of its file.
    Surface,
}

/// All bodies of a scene.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bodies {
    /// The bodies, in the scene's order.
    pub list: Vec<Body>,
    /// Places of the vertices of all of them in the world, at time 0 [m].
    pub rest: Vec<DVec3>,
    /// Triangles of the surfaces among them: numbers of vertices, counted over all bodies.
    pub triangles: Vec<[u32; 3]>,
}

impl Bodies {
    /// Those of a scene; `warnings` hears what is repaired in their meshes.
    pub(super) fn build(
        scene: &Scene,
        meshes: &BTreeMap<String, MeshData>,
        warnings: &mut Vec<String>,
    ) -> Result<Self, SceneError> {
        let mut bodies = Self::default();
        for (index, asked) in scene.body.iter().enumerate() {
            bodies.add(asked, &format!("body[{index}]"), meshes, warnings)?;
        }
        Ok(bodies)
    }

    fn add(
        &mut self,
        asked: &Asked,
        at: &str,
        meshes: &BTreeMap<String, MeshData>,
        warnings: &mut Vec<String>,
    ) -> Result<(), SceneError> {
        let (first, first_triangle) = (self.rest.len(), self.triangles.len());
        let mut radius = 0.0;
        let mut triangles = Vec::new();
        let shape = match asked.shapes().first() {
            Some(Shape::Sphere(sphere)) => {
                self.rest.push(sphere.center.into());
                radius = sphere.radius;
                BodyShape::Sphere
            }
            Some(Shape::Capsule(capsule)) => {
                self.rest.extend([capsule.from, capsule.to].map(DVec3::from_array));
                radius = capsule.radius;
                BodyShape::Capsule
            }
            Some(Shape::Plane(plane)) => {
                let point = DVec3::from_array(plane.point);
                self.rest.extend([point, point + DVec3::from_array(plane.normal).normalize()]);
                BodyShape::Plane
            }
            Some(Shape::Cuboid(cuboid)) => {
                self.rest.extend(corners(cuboid));
                triangles = SIDES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
                BodyShape::Surface
            }
            Some(Shape::Mesh(path)) => {
                let field = format!("{at}.mesh");
                let missing = || SceneError::with_value(field.as_str(), format!("{path:?}"), "its geometry was not given");
                let surface = mesh::surface(meshes.get(*path).ok_or_else(missing)?, &field, asked.scale)?;
                warnings.extend(surface.notes.iter().map(|note| format!("{} ({at}): {note}", asked.name)));
                let turn = turn(asked.rotate);
                let placed = |point: DVec3| turn * (point * asked.scale) + DVec3::from_array(asked.translate);
                let is_placed = asked.is_placed();
                self.rest.extend(surface.points.iter().map(|&point| if is_placed { placed(point) } else { point }));
                triangles = surface.triangles;
                BodyShape::Surface
            }
            None => return Err(SceneError::at(at, "needs one of sphere, capsule, box, plane, mesh")),
        };
        if self.rest.len() > MOST_VERTICES {
            return Err(SceneError::at(at, format!("more than {MOST_VERTICES} vertices in all bodies; take a coarser mesh")));
        }
        self.triangles.extend(triangles.into_iter().map(|corners| corners.map(|corner| corner + first as u32)));
        self.list.push(Body {
            name: asked.name.clone(),
            shape,
            vertices: first..self.rest.len(),
            triangles: first_triangle..self.triangles.len(),
            radius,
            friction: asked.friction,
            thickness: asked.thickness,
        });
        Ok(())
    }
}

/// The sides of a box, counter-clockwise seen from outside. Its corner number i is at the end of x, y, z where bit 0, 1, 2 of i is set.
const SIDES: [[u32; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

fn corners(cuboid: &Cuboid) -> impl Iterator<Item = DVec3> {
    let (turn, center) = (turn(cuboid.rotate), DVec3::from_array(cuboid.center));
    let half = 0.5 * DVec3::from_array(cuboid.size);
    (0..8).map(move |number: u32| {
        let side = |bit: u32| if number >> bit & 1 == 1 { 1.0 } else { -1.0 };
        center + turn * (half * DVec3::new(side(0), side(1), side(2)))
    })
}
