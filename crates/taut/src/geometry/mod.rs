//! Vectors as structure of arrays, and the thread pool that walks over them. Knows nothing of cloth.

mod parallel;
mod sine;
mod vectors;

pub use parallel::{CHUNK, Pool};
pub use sine::sine_of_turns;
pub use vectors::{SharedVectors, Vectors, VectorsChunk};
