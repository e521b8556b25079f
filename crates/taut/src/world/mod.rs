//! Cloth for programs: a builder of scenes, a world that steps, and what it tells. Nothing is decided here.

mod bodies;
mod body;
mod builder;
mod cloth;
mod error;
mod motion;
mod pool;
mod report;
mod running;

pub use body::Body;
pub use builder::WorldBuilder;
pub use cloth::Cloth;
pub use error::Error;
pub use pool::Pool;
pub use report::Report;
pub use running::{Contact, World};
