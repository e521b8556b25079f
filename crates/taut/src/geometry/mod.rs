//! Vectors as structure of arrays, and the thread pool that walks over them. Knows nothing of cloth.

mod parallel;
mod rsqrt;
mod sine;
mod vectors;

pub use parallel::{CHUNK, Pool};
pub use rsqrt::reciprocal_sqrt;
pub use sine::sine_of_turns;
pub use vectors::{SharedVectors, Vectors, VectorsChunk};
