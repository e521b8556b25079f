#![doc = include_str!("../README.md")]
// The rooms: a `scene` becomes a `model` and its first `inputs` (`prepare`); `schedule` plans a step; `forces` make the integrator propose
// velocities; velocity filters (`filter`) make them admissible; positions advance (`integrate`); `diagnostics` tell how it went.
// `step::step` is that sentence in code, and `world` is what programs see of it. The engine knows no files, clocks, randomness or
// printing, and no globals but the kind of vector registers (`geometry::choose`). Mathematics and sources: docs/equations.md.

// Units stand in brackets: [m] is no link.
#![allow(rustdoc::broken_intra_doc_links)]
// Hosts use the rooms, and so do tests; the facade uses a part of them.
#![cfg_attr(not(feature = "internals"), allow(dead_code, unused_imports))]

/// The rooms of the engine: for hosts in this repository and for tests. What is in them changes without notice.
macro_rules! rooms {
    ($($room:ident)*) => {
        $(
            #[cfg(feature = "internals")]
            pub mod $room;
            #[cfg(not(feature = "internals"))]
            mod $room;
        )*
    };
}

rooms! { advance contact diagnostics filter forces geometry inputs integrate model prepare schedule state step }

pub mod scene;
mod world;

pub use scene::{Axis, Bending, Corner, Edge, Fabric, Gust, Keyframe, Pin, SceneError, Turn, Up, Weight, Wind};
pub use state::SnapshotError;
pub use world::{Body, Cloth, Contact, Error, Pool, Report, World, WorldBuilder};
