//! Vectors as structure of arrays, the thread pool that walks over them, functions with the same bits everywhere, what steps spend their
//! time on. Knows nothing of cloth.

mod functions;
mod parallel;
mod pieces;
mod places;
mod pool;
mod quads;
mod registers;
mod rows;
mod rsqrt;
mod sine;
#[cfg(feature = "threads")]
mod team;
mod vectors;
mod watch;

pub use functions::{cbrt, exp2, hypot, power, turn, turn_about, turn_between};
pub use parallel::{
    CHUNK, for_each_chunk, for_each_of_both, for_each_part, for_each_piece, for_each_two_chunks, sum_in_any_order, sum_of_chunks,
    sum_of_runs, sum_over_chunks,
};
pub use pieces::{Pieces, chunks, items};
pub use places::put_in_places;
pub use pool::Pool;
pub use quads::{by_axis, by_vector, differences, fill_quads, roots};
pub use registers::{Registers, RegistersError, arch, choose, lanes};
pub use rows::{Block, LINE, Rows, fill_column, register, registers, set_registers};
pub use rsqrt::{reciprocal_sqrt, reciprocal_sqrts};
pub use sine::sine_of_turns;
pub use vectors::{SharedVectors, Vectors, VectorsChunk};
pub use watch::{Times, Watch};
