//! A cloth that is asked for.

use super::motion::Motion;
use crate::model::MeshData;
use crate::scene::{self, Axis, Bending, Fabric, Grid, Network, Pin, PointMass, Weight};

/// A cloth: where its vertices are, what it is made of and how it is held.
///
/// What is not said is as [`scene::Cloth`] has it, whose every field [`Self::with`] can set. Nothing is checked before
/// [`WorldBuilder::build`](super::WorldBuilder::build).
///
/// ```
/// use taut::{Cloth, Edge, Fabric, Pin};
///
/// let curtain = Cloth::grid([2.0, 1.5], [64, 48]).fabric(Fabric::Silk).pin(Pin::edge(Edge::Top));
/// let triangle = Cloth::mesh(&[[0.0, 0.0, 1.0], [0.2, 0.0, 1.0], [0.0, 0.0, 1.3]], &[[0, 1, 2]]);
/// # taut::World::builder().cloth(curtain).cloth(triangle).build()?;
/// # Ok::<(), taut::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Cloth {
    pub(super) asked: scene::Cloth,
    pub(super) mesh: Option<MeshData>,
    /// The pins that follow arrays.
    pub(super) motions: Vec<(usize, Motion)>,
}

impl From<scene::Cloth> for Cloth {
    /// A cloth whose mesh, if it names one, is given with [`WorldBuilder::mesh`](super::WorldBuilder::mesh), and what its pins follow with
    /// [`WorldBuilder::frames`](super::WorldBuilder::frames).
    fn from(asked: scene::Cloth) -> Self {
        Self { asked, mesh: None, motions: Vec::new() }
    }
}

impl Cloth {
    /// A rectangle of a width and a height [m] with so many cells along them, and one vertex more each: row by row from its bottom left
    /// corner, which is at the origin. The width goes along x and the height along z unless [`Self::axes`] says otherwise.
    #[must_use]
    pub fn grid(size: [impl Into<f64>; 2], cells: [u32; 2]) -> Self {
        let grid = Grid { size: size.map(Into::into), cells, ..Grid::default() };
        scene::Cloth { grid: Some(grid), ..scene::Cloth::default() }.into()
    }

    /// Triangles between vertices [m]. Both keep their order.
    #[must_use]
    pub fn mesh<T: Copy + Into<f64>>(positions: &[[T; 3]], triangles: &[[u32; 3]]) -> Self {
        Self { mesh: Some(mesh_of(positions, triangles)), ..scene::Cloth::default().into() }
    }

    /// Points [m], each of a mass [kg], and links between pairs of them: ropes and nets.
    #[must_use]
    pub fn network<T: Copy + Into<f64>>(points: &[[T; 3]], links: &[[u32; 2]], mass: f64) -> Self {
        let points = points.iter().map(|point| point.map(Into::into)).collect();
        let network = Network { points, links: links.to_vec(), mass: PointMass::One(mass) };
        scene::Cloth { network: Some(network), ..scene::Cloth::default() }.into()
    }

    /// Directions of the width and the height of a grid. In a world with y up, `[Axis::X, Axis::Y]` hangs.
    #[must_use]
    pub fn axes(self, axes: [Axis; 2]) -> Self {
        self.with(|cloth| cloth.grid.get_or_insert_default().axes = axes)
    }

    /// Holds vertices. Pins are numbered in the order in which they come.
    #[must_use]
    pub fn pin(self, pin: Pin) -> Self {
        self.with(|cloth| cloth.pins.push(pin))
    }

    /// Holds vertices that follow an array: where they are in every frame in the world [m], joined by straight lines. The first frame is
    /// where the cloth has them; after the last one they stay there. A frame has one place for each vertex, in the order in which
    /// [`World::pinned`](super::World::pinned) tells them: those of [`Pin::vertices`] in theirs, others by rising numbers.
    ///
    /// ```
    /// use taut::{Cloth, Pin, World};
    ///
    /// // A hanging sheet, 1 m wide, whose upper corners come 0.2 m closer in 0.1 s.
    /// let apart = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
    /// let closer = [[0.1, 0.0, 1.0], [0.9, 0.0, 1.0]];
    /// let sheet = Cloth::grid([1, 1], [8, 8]).pin_along(Pin::vertices([72, 80]), &[apart, closer], 10.0);
    /// let mut world = World::builder().cloth(sheet).build()?;
    /// world.step(0.1)?;
    /// assert!((world.positions(0)?[80][0] - 0.9).abs() < 1e-6);
    /// # Ok::<(), taut::Error>(())
    /// ```
    #[must_use]
    pub fn pin_along<T: Copy + Into<f64>>(mut self, pin: Pin, frames: &[impl AsRef<[[T; 3]]>], frames_per_second: f64) -> Self {
        self.motions.push((self.asked.pins.len(), Motion::new(frames, frames_per_second)));
        self.pin(pin)
    }

    /// Hangs a mass on vertices.
    #[must_use]
    pub fn weight(self, weight: Weight) -> Self {
        self.with(|cloth| cloth.weights.push(weight))
    }

    /// Sets any field of its description.
    ///
    /// ```
    /// # use taut::Cloth;
    /// let taffeta = Cloth::grid([1.0, 1.0], [32, 32]).with(|cloth| cloth.shear_stiffness = Some(4.0));
    /// ```
    #[must_use]
    pub fn with(mut self, set: impl FnOnce(&mut scene::Cloth)) -> Self {
        set(&mut self.asked);
        self
    }
}

/// Defines methods that set a field of the description.
macro_rules! setters {
    ($($(#[$about:meta])* $field:ident($given:ty) => $value:expr;)*) => {
        impl Cloth {
            $($(#[$about])*
            #[must_use]
            pub fn $field(self, $field: $given) -> Self {
                self.with(|cloth| cloth.$field = $value)
            })*
        }
    };
}

setters! {
    /// A preset for its material: cotton unless another one is chosen.
    fabric(Fabric) => fabric;
    /// No spring grows beyond (1 + `strain_limit`) of its rest length [1]; that of the fabric unless it is given.
    strain_limit(f64) => Some(strain_limit);
    /// Mass per area [kg/m^2]; that of the fabric unless it is given.
    density(f64) => Some(density);
    /// Stiffness of warp and weft [N/m]; in a network that of each link.
    stiffness(f64) => Some(stiffness);
    /// Resistance to bending [N m]; `Bending::Fabric` for that of the fabric. None unless it is given.
    bending(Bending) => bending;
    /// Turns on contact of cloth with itself and with other cloth, whose middles are kept this far apart [m].
    thickness(f64) => Some(thickness);
    /// Coulomb's coefficient of the friction of cloth on cloth [1].
    friction(f64) => Some(friction);
    /// Of two cloths that intersect at the start, the one of the higher layer goes to the outside [1].
    layer(u32) => layer;
    /// Factor on all coordinates, applied first [1].
    scale(f64) => scale;
}

impl Cloth {
    /// Its name in reports.
    #[must_use]
    pub fn name(self, name: impl Into<String>) -> Self {
        self.with(|cloth| cloth.name = name.into())
    }

    /// Rotation about the x, then the y, then the z axis, applied second [degrees].
    #[must_use]
    pub fn rotate(self, rotate: [impl Into<f64>; 3]) -> Self {
        self.with(|cloth| cloth.rotate = rotate.map(Into::into))
    }

    /// Displacement, applied last [m].
    #[must_use]
    pub fn translate(self, translate: [impl Into<f64>; 3]) -> Self {
        self.with(|cloth| cloth.translate = translate.map(Into::into))
    }
}

/// Triangles as a mesh file would have them.
pub(super) fn mesh_of<T: Copy + Into<f64>>(positions: &[[T; 3]], triangles: &[[u32; 3]]) -> MeshData {
    MeshData {
        vertices: positions.iter().map(|place| place.map(Into::into)).collect(),
        corners: triangles.iter().flatten().map(|&corner| i64::from(corner)).collect(),
        counts: vec![3; triangles.len()],
    }
}
