//! One program of most tests, since linking many takes longer than running them; each file here is a module of it. Programs of their
//! own are what needs an allocator or a compiler of its own (`determinism.rs`, `sanitizers.rs`) and what is tested without features
//! (`world.rs`).

mod common;

mod bending;
mod bodies;
mod body_parts;
mod capstan;
mod certificate;
mod closed_forms;
mod contact;
mod curves;
mod examination;
mod flow;
mod hands;
mod hard_limit;
mod holds;
mod hostile;
mod integrators;
mod integrators_and_filters;
mod keyframes;
mod limiters;
mod models;
mod nets_start;
mod nets_touch;
mod odd_bodies;
mod origin;
mod parts;
mod properties;
mod scales;
mod scenes;
mod starts;
mod symmetries;
mod times;
mod touching;
mod untangle;
mod velocities;
mod wind;
