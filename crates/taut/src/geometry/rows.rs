//! Rows of several columns of numbers, block by block: a cache line of the first column, one of the second and so on, then
//! the next block. All that is known of one particle is found from one address, and every vector register is within a line.

use pulp::Simd;

/// Numbers in a cache line, and in the longest vector register.
pub const LINE: usize = 16;

/// A line of each of `N` columns.
pub type Block<const N: usize> = [[f32; LINE]; N];

/// Rows of `N` columns each.
#[derive(Debug)]
pub struct Rows<const N: usize> {
    data: Vec<f32>,
    /// Where the first row begins: at a cache line, for speed only.
    offset: usize,
    /// Blocks in a row.
    blocks: usize,
}

/// Register `i` of a column: numbers `i LANES` and following.
#[inline(always)]
#[must_use]
pub fn register<S: Simd, const N: usize>(row: &[Block<N>], column: usize, i: usize) -> S::f32s {
    let per_line = LINE / S::F32_LANES;
    S::as_simd_f32s(&row[i / per_line][column]).0[i % per_line]
}

/// As [`register`], to be written.
#[inline(always)]
pub fn register_mut<S: Simd, const N: usize>(row: &mut [Block<N>], column: usize, i: usize) -> &mut S::f32s {
    let per_line = LINE / S::F32_LANES;
    &mut S::as_mut_simd_f32s(&mut row[i / per_line][column]).0[i % per_line]
}

/// Registers of three columns, from `first` on.
#[inline(always)]
#[must_use]
pub fn registers<S: Simd, const N: usize>(row: &[Block<N>], first: usize, i: usize) -> [S::f32s; 3] {
    [register::<S, N>(row, first, i), register::<S, N>(row, first + 1, i), register::<S, N>(row, first + 2, i)]
}

/// Writes registers of three columns, from `first` on.
#[inline(always)]
pub fn set_registers<S: Simd, const N: usize>(row: &mut [Block<N>], first: usize, i: usize, [x, y, z]: [S::f32s; 3]) {
    *register_mut::<S, N>(row, first, i) = x;
    *register_mut::<S, N>(row, first + 1, i) = y;
    *register_mut::<S, N>(row, first + 2, i) = z;
}

/// Copies numbers into a column; what is left of the row stays.
#[inline(always)]
pub fn fill_column<const N: usize>(row: &mut [Block<N>], column: usize, numbers: &[f32]) {
    let (lines, rest) = numbers.as_chunks::<LINE>();
    let (full, partial) = row.split_at_mut(lines.len());
    full.iter_mut().zip(lines).for_each(|(block, line)| block[column] = *line);
    if let Some(block) = partial.first_mut() {
        block[column][..rest.len()].copy_from_slice(rest);
    }
}

impl<const N: usize> Rows<N> {
    /// So many rows of zeros, for so many numbers in a column.
    #[must_use]
    pub fn zeros(rows: usize, columns: usize) -> Self {
        let blocks = columns.div_ceil(LINE);
        let data = vec![0.0; rows * blocks * N * LINE + LINE - 1];
        let offset = data.as_ptr().align_offset(LINE * size_of::<f32>()).min(LINE - 1);
        Self { data, offset, blocks }
    }

    /// A row.
    ///
    /// # Panics
    /// If there are not so many.
    #[inline(always)]
    #[must_use]
    pub fn row(&self, row: usize) -> &[Block<N>] {
        let length = self.blocks * N * LINE;
        self.data[self.offset + row * length..][..length].as_chunks::<LINE>().0.as_chunks::<N>().0
    }

    /// A row, to be written.
    ///
    /// # Panics
    /// If there are not so many.
    #[inline(always)]
    pub fn row_mut(&mut self, row: usize) -> &mut [Block<N>] {
        let length = self.blocks * N * LINE;
        self.data[self.offset + row * length..][..length].as_chunks_mut::<LINE>().0.as_chunks_mut::<N>().0
    }

    /// The first `K` rows, to be written.
    ///
    /// # Panics
    /// If there are not so many.
    #[inline(always)]
    pub fn first_mut<const K: usize>(&mut self) -> [&mut [Block<N>]; K] {
        let mut rows = self.data[self.offset..].chunks_exact_mut(self.blocks * N * LINE);
        std::array::from_fn(|_| rows.next().expect("so many rows").as_chunks_mut::<LINE>().0.as_chunks_mut::<N>().0)
    }
}
