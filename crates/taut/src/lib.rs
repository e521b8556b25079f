//! taut: cloth that does not stretch.
//!
//! A [`scene::Scene`] becomes a [`model::Model`] and its first [`inputs`] ([`prepare`]); [`schedule`] plans a step; [`forces`] make the integrator propose velocities; velocity filters
//! ([`filter`]) make them admissible; positions advance ([`integrate`]); [`health`] tells how it went. [`step::step`]
//! is that sentence in code. The engine knows no files, clocks, randomness or printing, and no globals but
//! the kind of vector registers ([`geometry::choose`]).
//!
//! Mathematics and sources: `docs/equations.md`.

pub mod advance;
pub mod contact;
pub mod filter;
pub mod forces;
pub mod geometry;
pub mod health;
pub mod inputs;
pub mod integrate;
pub mod model;
pub mod prepare;
pub mod scene;
pub mod schedule;
pub mod state;
pub mod step;
