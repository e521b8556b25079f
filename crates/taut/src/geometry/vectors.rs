//! Many 3-vectors as three arrays.

use std::marker::PhantomData;

use glam::Vec3;
use rayon::prelude::*;

use super::parallel::{CHUNK, Pool};

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

    /// Makes this a copy of `other`, without allocating when the lengths agree.
    pub fn copy_from(&mut self, other: &Self) {
        self.x.clone_from(&other.x);
        self.y.clone_from(&other.y);
        self.z.clone_from(&other.z);
    }

    /// The vectors in order.
    pub fn iter(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.x.iter().zip(&self.y).zip(&self.z).map(|((&x, &y), &z)| Vec3::new(x, y, z))
    }

    /// Calls `work` for every chunk of [`CHUNK`] vectors, on the pool's threads where that pays.
    pub fn for_each_chunk(&mut self, pool: &Pool, work: impl Fn(VectorsChunk<'_>) + Sync) {
        let len = self.len();
        if pool.pays_for(len) {
            let chunks = self.x.par_chunks_mut(CHUNK).zip(self.y.par_chunks_mut(CHUNK)).zip(self.z.par_chunks_mut(CHUNK));
            chunks.enumerate().for_each(|(chunk, ((x, y), z))| work(VectorsChunk { first: chunk * CHUNK, x, y, z }));
        } else {
            work(VectorsChunk { first: 0, x: &mut self.x, y: &mut self.y, z: &mut self.z });
        }
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

impl VectorsChunk<'_> {
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
    #[inline]
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
    #[inline]
    pub unsafe fn set(&self, index: usize, value: Vec3) {
        debug_assert!(index < self.len);
        // SAFETY: the caller keeps `index` in range and all others away.
        unsafe {
            *self.x.add(index) = value.x;
            *self.y.add(index) = value.y;
            *self.z.add(index) = value.z;
        }
    }
}
