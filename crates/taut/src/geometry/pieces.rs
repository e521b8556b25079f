//! What loops are cut into: pieces that have nothing in common, so that several threads may have one each.

use std::marker::PhantomData;
use std::ops::Range;
use std::slice::from_raw_parts_mut;

/// What falls into pieces.
///
/// # Safety
/// Pieces of different indices have nothing in common.
pub unsafe trait Pieces: Sync {
    /// One of them.
    type Piece;

    /// How many there are.
    fn count(&self) -> usize;

    /// One of them.
    ///
    /// # Safety
    /// `index` is below [`Self::count`], and each is taken once.
    unsafe fn piece(&self, index: usize) -> Self::Piece;
}

/// A slice in pieces of a length; the last one may be shorter.
pub struct Chunks<'a, T> {
    first: *mut T,
    len: usize,
    length: usize,
    owner: PhantomData<&'a mut [T]>,
}

/// A slice in pieces of `length`; the last one may be shorter.
pub fn chunks<T>(items: &mut [T], length: usize) -> Chunks<'_, T> {
    Chunks { first: items.as_mut_ptr(), len: items.len(), length, owner: PhantomData }
}

// SAFETY: all that it lets threads do at the same time is to take different pieces, which needs what sending them needs.
unsafe impl<T: Send> Sync for Chunks<'_, T> {}

// SAFETY: runs of `length` from multiples of it do not overlap.
unsafe impl<'a, T: Send> Pieces for Chunks<'a, T> {
    type Piece = &'a mut [T];

    fn count(&self) -> usize {
        self.len.div_ceil(self.length)
    }

    unsafe fn piece(&self, index: usize) -> &'a mut [T] {
        let from = index * self.length;
        debug_assert!(from < self.len);
        // SAFETY: it lies in the slice, which 'a borrows mutably, and the caller takes it once.
        unsafe { from_raw_parts_mut(self.first.add(from), self.length.min(self.len - from)) }
    }
}

/// The items of a slice, one by one.
pub struct Items<'a, T>(Chunks<'a, T>);

/// The items of a slice, one by one.
pub fn items<T>(items: &mut [T]) -> Items<'_, T> {
    Items(chunks(items, 1))
}

// SAFETY: they are chunks of one item.
unsafe impl<'a, T: Send> Pieces for Items<'a, T> {
    type Piece = &'a mut T;

    fn count(&self) -> usize {
        self.0.len
    }

    unsafe fn piece(&self, index: usize) -> &'a mut T {
        // SAFETY: as the caller promises; each chunk has one item.
        unsafe { &mut self.0.piece(index)[0] }
    }
}

// SAFETY: numbers are copies.
unsafe impl Pieces for Range<usize> {
    type Piece = usize;

    fn count(&self) -> usize {
        self.len()
    }

    unsafe fn piece(&self, index: usize) -> usize {
        self.start + index
    }
}

/// Two side by side, as many as both have.
// SAFETY: pieces of each have nothing in common, and both are borrowed mutably at the same time.
unsafe impl<A: Pieces, B: Pieces> Pieces for (A, B) {
    type Piece = (A::Piece, B::Piece);

    fn count(&self) -> usize {
        self.0.count().min(self.1.count())
    }

    unsafe fn piece(&self, index: usize) -> Self::Piece {
        // SAFETY: `index` is below the count of both.
        unsafe { (self.0.piece(index), self.1.piece(index)) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::for_each_piece;
    use super::*;

    #[test]
    fn every_item_is_in_one_piece_of_its_place() {
        for in_parallel in [false, true] {
            for len in [0, 1, 2, 7, 8, 9, 1000] {
                let (mut runs, mut places) = (vec![0; len], vec![0; len.div_ceil(3)]);
                for_each_piece((chunks(&mut runs, 3), items(&mut places)), in_parallel, |index, (run, place)| {
                    *place = run.len();
                    run.iter_mut().for_each(|item| *item += index + 1);
                });
                assert_eq!(runs, (0..len).map(|item| item / 3 + 1).collect::<Vec<_>>());
                assert_eq!(places.iter().sum::<usize>(), len);
            }
        }
    }
}
