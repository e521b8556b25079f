//! taut: cloth that does not stretch.
//!
//! A [`scene::Scene`] becomes a [`model::Model`] and its first [`inputs`] ([`prepare`]); [`schedule`] plans a step; [`forces`] make the integrator propose velocities; velocity filters
//! ([`filter`]) make them admissible; positions advance ([`integrate`]); [`health`] tells how it went. [`step::step`]
//! is that sentence in code. The engine knows no files, clocks, randomness or printing, and no globals but
//! the kind of vector registers ([`geometry::choose`]).
//!
//! Mathematics and sources: `docs/equations.md`.

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

rooms! { advance contact filter forces geometry health inputs integrate model prepare schedule state step }

pub mod scene;
