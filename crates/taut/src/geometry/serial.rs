//! What loops ask of rayon, one after the other: for builds without threads, in which no loop is worth handing to several of them.

use std::ops::Range;
use std::slice::{Chunks, ChunksMut, IterMut};

/// An iterator with rayon's methods.
pub struct Serial<I>(I);

impl<I: Iterator> Serial<I> {
    pub fn enumerate(self) -> Serial<std::iter::Enumerate<I>> {
        Serial(self.0.enumerate())
    }

    pub fn zip<J: IntoIterator>(self, other: J) -> Serial<std::iter::Zip<I, J::IntoIter>> {
        Serial(self.0.zip(other))
    }

    pub fn map<R>(self, work: impl FnMut(I::Item) -> R) -> Serial<impl Iterator<Item = R>> {
        Serial(self.0.map(work))
    }

    pub fn with_max_len(self, _: usize) -> Self {
        self
    }

    pub fn all(mut self, is: impl FnMut(I::Item) -> bool) -> bool {
        self.0.all(is)
    }

    pub fn reduce(self, start: impl FnOnce() -> I::Item, add: impl FnMut(I::Item, I::Item) -> I::Item) -> I::Item {
        self.0.fold(start(), add)
    }

    pub fn for_each(self, work: impl FnMut(I::Item)) {
        self.0.for_each(work);
    }
}

impl<I: Iterator> IntoIterator for Serial<I> {
    type Item = I::Item;
    type IntoIter = I;

    fn into_iter(self) -> I {
        self.0
    }
}

/// Rayon's ways to begin.
pub trait Slices<T> {
    fn par_iter_mut(&mut self) -> Serial<IterMut<'_, T>>;
    fn par_chunks(&self, length: usize) -> Serial<Chunks<'_, T>>;
    fn par_chunks_mut(&mut self, length: usize) -> Serial<ChunksMut<'_, T>>;
}

impl<T> Slices<T> for [T] {
    fn par_iter_mut(&mut self) -> Serial<IterMut<'_, T>> {
        Serial(self.iter_mut())
    }

    fn par_chunks(&self, length: usize) -> Serial<Chunks<'_, T>> {
        Serial(self.chunks(length))
    }

    fn par_chunks_mut(&mut self, length: usize) -> Serial<ChunksMut<'_, T>> {
        Serial(self.chunks_mut(length))
    }
}

/// Rayon's way to begin with numbers.
pub trait Numbers: Sized {
    fn into_par_iter(self) -> Serial<Self>;
}

impl Numbers for Range<usize> {
    fn into_par_iter(self) -> Serial<Self> {
        Serial(self)
    }
}
