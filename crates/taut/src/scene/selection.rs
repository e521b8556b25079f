//! Which particles of a cloth are meant.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{FrameFiles, Turn};

/// What a selection chooses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Selector<'a> {
    /// A corner of a grid.
    Corner(Corner),
    /// An edge of a grid.
    Edge(Edge),
    /// Vertex numbers within the cloth.
    Vertices(&'a [u32]),
    /// Lowest and highest corner of a box [m].
    Box([[f64; 3]; 2]),
    /// The vertex nearest to a point [m].
    Nearest([f64; 3]),
}

/// Defines a struct whose fields are those that select particles, and its own.
macro_rules! selection {
    ($(#[$about:meta])* pub struct $name:ident { $($(#[$field:meta])* pub $own:ident: $kind:ty,)* }) => {
        $(#[$about])*
        #[cfg_attr(feature = "schema", derive(JsonSchema))]
        #[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            /// A corner of a grid, as seen from its front (first axis to the right, second axis up).
            #[serde(skip_serializing_if = "Option::is_none")]
            pub corner: Option<Corner>,
            /// A whole edge of a grid, as seen from its front.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub edge: Option<Edge>,
            /// Vertex numbers within this cloth, from 0.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub vertices: Option<Vec<u32>>,
            /// All vertices inside a box: its lowest and its highest corner [m].
            #[serde(rename = "box", skip_serializing_if = "Option::is_none")]
            pub inside: Option<[[f64; 3]; 2]>,
            /// The vertex nearest to a point [m]; the lowest number where several are as near.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub nearest: Option<[f64; 3]>,
            $($(#[$field])* pub $own: $kind,)*
        }

        impl $name {
            /// Chooses a corner of a grid.
            #[must_use]
            pub fn corner(corner: Corner) -> Self {
                Self { corner: Some(corner), ..Self::default() }
            }

            /// Chooses an edge of a grid.
            #[must_use]
            pub fn edge(edge: Edge) -> Self {
                Self { edge: Some(edge), ..Self::default() }
            }

            /// Chooses vertices by their numbers.
            #[must_use]
            pub fn vertices(vertices: impl Into<Vec<u32>>) -> Self {
                Self { vertices: Some(vertices.into()), ..Self::default() }
            }

            /// Chooses all vertices in a box between its lowest and its highest corner [m].
            #[must_use]
            pub fn inside(low: [impl Into<f64>; 3], high: [impl Into<f64>; 3]) -> Self {
                Self { inside: Some([low.map(Into::into), high.map(Into::into)]), ..Self::default() }
            }

            /// Chooses the vertex nearest to a point [m].
            #[must_use]
            pub fn nearest(point: [impl Into<f64>; 3]) -> Self {
                Self { nearest: Some(point.map(Into::into)), ..Self::default() }
            }

            /// The selectors that are given; a valid selection has exactly one.
            #[must_use]
            pub fn selectors(&self) -> Vec<Selector<'_>> {
                let mut given = Vec::new();
                given.extend(self.corner.map(Selector::Corner));
                given.extend(self.edge.map(Selector::Edge));
                given.extend(self.vertices.as_deref().map(Selector::Vertices));
                given.extend(self.inside.map(Selector::Box));
                given.extend(self.nearest.map(Selector::Nearest));
                given
            }
        }
    };
}

selection! {
    /// Particles that are held: exactly one of `corner`, `edge`, `vertices`, `box`, `nearest`; with `move` and `turn`, or with `follow`, they travel.
    pub struct Pin {
        /// How they turn about a straight line, before `move` displaces them; not at all when left out.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub turn: Option<Turn>,
        /// Keyframes `[time [s], [dx, dy, dz] [m]]` of the displacement from the start, joined by straight lines.
        #[serde(rename = "move", skip_serializing_if = "Vec::is_empty")]
        pub keyframes: Vec<Keyframe>,
        /// Where they are in every frame [m], joined by straight lines; in place of `move` and `turn`: an array file, .npy of shape (frames, pinned vertices, 3) or .pc2, or a list of .obj files, one for each frame, or "hem_*.obj" for those that are numbered so. After its last frame they stay there.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub follow: Option<FrameFiles>,
    }
}

impl Pin {
    /// Turns what it holds about a straight line. What displaces it, the field `keyframes`, does so after that.
    ///
    /// ```
    /// use taut::{Cloth, Edge, Pin, Turn};
    ///
    /// // A hanging sheet whose upper edge goes round by half a turn in 3 s.
    /// let edge = Pin::edge(Edge::Top).turn(Turn::about([0, 0, 1], [0.5, 0.0, 1.0]).at(3.0, 180.0));
    /// let sheet = Cloth::grid([1, 1], [16, 16]).pin(edge);
    /// # taut::World::builder().cloth(sheet).build()?;
    /// # Ok::<(), taut::Error>(())
    /// ```
    #[must_use]
    pub fn turn(mut self, turn: Turn) -> Self {
        self.turn = Some(turn);
        self
    }

    /// Whether it goes the same way as another, by keyframes. Arrays tell where each vertex is: no two of them are the same.
    #[must_use]
    pub fn travels_like(&self, other: &Self) -> bool {
        let by_keyframes = self.follow.is_none() && other.follow.is_none();
        by_keyframes && self.keyframes == other.keyframes && self.turn == other.turn
    }
}

/// Time [s] and displacement from the start [m].
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Keyframe(pub f64, pub [f64; 3]);

/// Time [s] and strain limit [1].
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LimitKeyframe(pub f64, pub f64);

selection! {
    /// A mass on top of the cloth's own: exactly one of `corner`, `edge`, `vertices`, `box`, `nearest`, and `mass`.
    pub struct Weight {
        /// Mass in all [kg], spread evenly over the particles chosen.
        pub mass: f64,
    }
}

impl Weight {
    /// Sets its mass [kg].
    #[must_use]
    pub fn of(mut self, mass: f64) -> Self {
        self.mass = mass;
        self
    }
}

/// A corner of a grid, as seen from its front.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Corner {
    /// First axis at its start, second at its end.
    TopLeft,
    /// Both axes at their end.
    TopRight,
    /// Both axes at their start.
    BottomLeft,
    /// First axis at its end, second at its start.
    BottomRight,
}

/// An edge of a grid, as seen from its front.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Edge {
    /// First axis at its start.
    Left,
    /// First axis at its end.
    Right,
    /// Second axis at its end.
    Top,
    /// Second axis at its start.
    Bottom,
}
