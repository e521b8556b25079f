//! Many 3-vectors as three arrays.

use std::marker::PhantomData;
use std::ops::Range;

use glam::Vec3;
use pulp::{Simd, WithSimd};

use super::{CHUNK, Pieces, Pool, arch, chunks, for_each_piece, items, sum_of_runs};

/// Many 3-vectors, stored as an array of each coordinate.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Vectors {
    /// First coordinates.
    pub x: Vec<f32>,
    /// Second coordinates.
    pub y: Vec<f32>,
    /// Third coordinates.
    pub z: Vec<f32>,
}

impl Vectors {
    /// `len` zero vectors.
    #[must_use]
    pub fn zeros(len: usize) -> Self {
        Self { x: vec![0.0; len], y: vec![0.0; len], z: vec![0.0; len] }
    }

    /// The number of vectors.
    #[must_use]
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// The vector at `index`.
    ///
    /// # Panics
    /// If `index` is not below [`Self::len`].
    #[inline]
    #[must_use]
    pub fn get(&self, index: usize) -> Vec3 {
        Vec3::new(self.x[index], self.y[index], self.z[index])
    }

    /// Replaces the vector at `index`.
    ///
    /// # Panics
    /// If `index` is not below [`Self::len`].
    #[inline]
    pub fn set(&mut self, index: usize, value: Vec3) {
        self.x[index] = value.x;
        self.y[index] = value.y;
        self.z[index] = value.z;
    }

    /// The three arrays. That they are equally long is in sight here: one check of an index does for all of them.
    #[inline(always)]
    #[must_use]
    pub fn columns(&self) -> [&[f32]; 3] {
        let len = self.x.len();
        [&self.x[..len], &self.y[..len], &self.z[..len]]
    }

    /// Makes this a copy of `other`, without allocating when the lengths agree.
    pub fn copy_from(&mut self, other: &Self) {
        self.x.clone_from(&other.x);
        self.y.clone_from(&other.y);
        self.z.clone_from(&other.z);
    }

    /// As [`Self::copy_from`] between equal lengths, on the pool's threads where that pays.
    pub fn copy_on(&mut self, other: &Self, pool: &Pool) {
        self.for_each_chunk(pool, |chunk| {
            let run = chunk.first..chunk.first + chunk.x.len();
            for (column, other) in [(chunk.x, &other.x), (chunk.y, &other.y), (chunk.z, &other.z)] {
                column.copy_from_slice(&other[run.clone()]);
            }
        });
    }

    /// The vectors in order.
    pub fn iter(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.x.iter().zip(&self.y).zip(&self.z).map(|((&x, &y), &z)| Vec3::new(x, y, z))
    }

    /// Calls `work` for every chunk of [`CHUNK`] vectors, on the pool's threads where that pays.
    pub fn for_each_chunk(&mut self, pool: &Pool, work: impl Fn(VectorsChunk<'_>) + Sync) {
        self.for_each_chunk_of(0..self.len(), pool, work);
    }

    /// As [`Self::for_each_chunk`], for the vectors of a range.
    pub fn for_each_chunk_of(&mut self, range: Range<usize>, pool: &Pool, work: impl Fn(VectorsChunk<'_>) + Sync) {
        let len = range.len();
        self.for_each_part(range, if pool.pays_for(len) { CHUNK } else { len.max(1) }, pool, work);
    }

    /// Calls `work` for every `length` vectors of a range, on the pool's threads where that pays.
    pub fn for_each_part(&mut self, range: Range<usize>, length: usize, pool: &Pool, work: impl Fn(VectorsChunk<'_>) + Sync) {
        let (first, in_parallel) = (range.start, pool.pays_for(range.len()));
        for_each_piece(self.pieces(range, length), in_parallel, |index, columns| {
            work(VectorsChunk::new(first + index * length, columns));
        });
    }

    /// As [`Self::for_each_part`], each part with a workspace of its own.
    pub fn for_each_band<T: Send>(
        &mut self,
        range: Range<usize>,
        length: usize,
        workspaces: &mut [T],
        pool: &Pool,
        work: impl Fn(VectorsChunk<'_>, &mut T) + Sync,
    ) {
        let (first, in_parallel) = (range.start, pool.pays_for(range.len()));
        for_each_piece((self.pieces(range, length), items(workspaces)), in_parallel, |index, (columns, workspace)| {
            work(VectorsChunk::new(first + index * length, columns), workspace);
        });
    }

    /// As [`Self::for_each_part`], for the same range of two.
    pub fn for_each_part_of_two(
        &mut self,
        other: &mut Self,
        range: Range<usize>,
        length: usize,
        pool: &Pool,
        work: impl Fn(VectorsChunk<'_>, VectorsChunk<'_>) + Sync,
    ) {
        let (first, in_parallel) = (range.start, pool.pays_for(range.len()));
        let both = (self.pieces(range.clone(), length), other.pieces(range, length));
        for_each_piece(both, in_parallel, |index, (columns, others)| {
            let first = first + index * length;
            work(VectorsChunk::new(first, columns), VectorsChunk::new(first, others));
        });
    }

    /// The columns of every `length` vectors of a range.
    fn pieces(&mut self, range: Range<usize>, length: usize) -> impl Pieces<Piece = Columns<'_>> {
        let [x, y, z] = [&mut self.x, &mut self.y, &mut self.z].map(|column| chunks(&mut column[range.clone()], length));
        ((x, y), z)
    }

    /// `self[range] = base + factor change`.
    pub fn set_scaled(&mut self, range: Range<usize>, base: &Self, change: &Self, factor: f32, pool: &Pool) {
        self.for_each_chunk_of(range, pool, |chunk| {
            let run = chunk.first..chunk.first + chunk.x.len();
            let columns = [(chunk.x, &base.x, &change.x), (chunk.y, &base.y, &change.y), (chunk.z, &base.z, &change.z)];
            for (column, base, change) in columns {
                arch().dispatch(SetScaled { column, base: &base[run.clone()], change: &change[run.clone()], factor });
            }
        });
    }

    /// `self[range] += factor change`.
    pub fn add_scaled(&mut self, range: Range<usize>, change: &Self, factor: f32, pool: &Pool) {
        self.for_each_chunk_of(range, pool, |chunk| {
            let run = chunk.first..chunk.first + chunk.x.len();
            for (column, change) in [(chunk.x, &change.x), (chunk.y, &change.y), (chunk.z, &change.z)] {
                arch().dispatch(AddScaled { column, change: &change[run.clone()], factor });
            }
        });
    }

    /// The largest coordinate of some vectors, whatever its sign; what is not a number does not count.
    #[must_use]
    pub fn reach(&self, range: Range<usize>, pool: &Pool) -> f32 {
        let largest = |run: &[f32]| arch().dispatch(Largest(run));
        let of = |column: &Vec<f32>| {
            // The largest of all is the same in any order.
            sum_of_runs(&column[range.clone()], pool, 0.0, largest, f32::max)
        };
        [&self.x, &self.y, &self.z].map(of).into_iter().fold(0.0, f32::max)
    }

    /// Access from several threads that promise to touch different vectors.
    pub fn shared(&mut self) -> SharedVectors<'_> {
        SharedVectors {
            x: self.x.as_mut_ptr(),
            y: self.y.as_mut_ptr(),
            z: self.z.as_mut_ptr(),
            len: self.len(),
            owner: PhantomData,
        }
    }
}

struct SetScaled<'a> {
    column: &'a mut [f32],
    base: &'a [f32],
    change: &'a [f32],
    factor: f32,
}

impl WithSimd for SetScaled<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let terms = self.base.iter().zip(self.change);
        self.column.iter_mut().zip(terms).for_each(|(value, (base, change))| *value = base + change * self.factor);
    }
}

struct Largest<'a>(&'a [f32]);

impl WithSimd for Largest<'_> {
    type Output = f32;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f32 {
        const LANES: usize = 16;
        let mut lanes = [0.0_f32; LANES];
        for values in self.0.chunks(LANES) {
            for (lane, value) in lanes.iter_mut().zip(values) {
                *lane = if value.abs() > *lane { value.abs() } else { *lane };
            }
        }
        lanes.into_iter().fold(0.0, f32::max)
    }
}

struct AddScaled<'a> {
    column: &'a mut [f32],
    change: &'a [f32],
    factor: f32,
}

impl WithSimd for AddScaled<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.column.iter_mut().zip(self.change).for_each(|(value, change)| *value += change * self.factor);
    }
}

impl FromIterator<Vec3> for Vectors {
    fn from_iter<I: IntoIterator<Item = Vec3>>(values: I) -> Self {
        let mut vectors = Self::default();
        for value in values {
            vectors.x.push(value.x);
            vectors.y.push(value.y);
            vectors.z.push(value.z);
        }
        vectors
    }
}

/// A run of consecutive vectors.
pub struct VectorsChunk<'a> {
    /// Index of the first of them.
    pub first: usize,
    /// First coordinates.
    pub x: &'a mut [f32],
    /// Second coordinates.
    pub y: &'a mut [f32],
    /// Third coordinates.
    pub z: &'a mut [f32],
}

/// The three columns of a run.
type Columns<'a> = ((&'a mut [f32], &'a mut [f32]), &'a mut [f32]);

impl<'a> VectorsChunk<'a> {
    fn new(first: usize, ((x, y), z): Columns<'a>) -> Self {
        Self { first, x, y, z }
    }

    /// The vector of an index that lies in the run.
    ///
    /// # Panics
    /// If it does not.
    #[inline]
    #[must_use]
    pub fn get(&self, index: usize) -> Vec3 {
        let place = index - self.first;
        Vec3::new(self.x[place], self.y[place], self.z[place])
    }

    /// Replaces the vector of an index that lies in the run.
    ///
    /// # Panics
    /// If it does not.
    #[inline]
    pub fn set(&mut self, index: usize, value: Vec3) {
        let place = index - self.first;
        (self.x[place], self.y[place], self.z[place]) = (value.x, value.y, value.z);
    }

    /// Replaces each vector by `value(index, old)`.
    #[inline]
    pub fn map(self, mut value: impl FnMut(usize, Vec3) -> Vec3) {
        let first = self.first;
        for (offset, ((x, y), z)) in self.x.iter_mut().zip(self.y).zip(self.z).enumerate() {
            let new = value(first + offset, Vec3::new(*x, *y, *z));
            (*x, *y, *z) = (new.x, new.y, new.z);
        }
    }
}

/// [`Vectors`] that several threads write to at once, each to different ones.
#[derive(Clone, Copy)]
pub struct SharedVectors<'a> {
    x: *mut f32,
    y: *mut f32,
    z: *mut f32,
    len: usize,
    owner: PhantomData<&'a mut Vectors>,
}

// SAFETY: the pointers are valid for as long as 'a borrows the vectors mutably; that no two threads touch the same
// vector is the condition under which `get` and `set` may be called.
unsafe impl Send for SharedVectors<'_> {}
// SAFETY: as above.
unsafe impl Sync for SharedVectors<'_> {}

impl SharedVectors<'_> {
    /// The vector at `index`.
    ///
    /// # Safety
    /// `index` is below the length, and no other thread writes this vector meanwhile.
    #[inline(always)]
    #[must_use]
    pub unsafe fn get(&self, index: usize) -> Vec3 {
        debug_assert!(index < self.len);
        // SAFETY: the caller keeps `index` in range and other writers away.
        unsafe { Vec3::new(*self.x.add(index), *self.y.add(index), *self.z.add(index)) }
    }

    /// Replaces the vector at `index`.
    ///
    /// # Safety
    /// `index` is below the length, and no other thread touches this vector meanwhile.
    #[inline(always)]
    pub unsafe fn set(&self, index: usize, value: Vec3) {
        debug_assert!(index < self.len);
        // SAFETY: the caller keeps `index` in range and all others away.
        unsafe {
            *self.x.add(index) = value.x;
            *self.y.add(index) = value.y;
            *self.z.add(index) = value.z;
        }
    }

    /// The columns of `len` vectors from the one at `first`.
    ///
    /// # Safety
    /// They are all there, and no other thread writes them as long as the slices live.
    #[inline(always)]
    #[must_use]
    pub unsafe fn run<'b>(&self, first: usize, len: usize) -> [&'b [f32]; 3] {
        debug_assert!(first + len <= self.len);
        // SAFETY: the caller keeps the run in range and writers away.
        unsafe {
            [
                std::slice::from_raw_parts(self.x.add(first), len),
                std::slice::from_raw_parts(self.y.add(first), len),
                std::slice::from_raw_parts(self.z.add(first), len),
            ]
        }
    }

    /// The columns of `len` vectors from the one at `first`, to be written.
    ///
    /// # Safety
    /// They are all there, and nobody else touches them as long as the slices live.
    #[inline(always)]
    #[must_use]
    pub unsafe fn run_mut<'b>(&self, first: usize, len: usize) -> [&'b mut [f32]; 3] {
        debug_assert!(first + len <= self.len);
        // SAFETY: the caller keeps the run in range and all others away.
        unsafe {
            [
                std::slice::from_raw_parts_mut(self.x.add(first), len),
                std::slice::from_raw_parts_mut(self.y.add(first), len),
                std::slice::from_raw_parts_mut(self.z.add(first), len),
            ]
        }
    }
}
