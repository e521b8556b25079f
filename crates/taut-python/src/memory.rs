//! Large arrays begin at cache lines, so that vector registers are loaded from one line each.

use std::alloc::{GlobalAlloc, Layout, System};

/// The system's memory; what is larger than a page begins at a cache line.
pub struct LineAligned;

/// Whether the system gives so much memory at once now. It goes back before this returns: whoever asks needs it soon after.
pub fn is_there(bytes: u64) -> bool {
    let mut probe = Vec::<u8>::new();
    let given = usize::try_from(bytes).is_ok_and(|bytes| probe.try_reserve_exact(bytes).is_ok());
    // Memory that nobody looks at need never be asked for.
    std::hint::black_box(&mut probe);
    given
}

const LINE: usize = 64;
const LARGE: usize = 4096;

fn aligned(layout: Layout) -> Layout {
    if layout.size() < LARGE { layout } else { layout.align_to(LINE).unwrap_or(layout) }
}

// SAFETY: every call is handed on to the system with a layout of the same size that is at least as aligned, and that depends
// on the caller's layout alone: memory goes back as it came. `realloc` is the default: it asks for new memory and copies.
unsafe impl GlobalAlloc for LineAligned {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: by the caller's promises.
        unsafe { System.alloc(aligned(layout)) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: by the caller's promises.
        unsafe { System.alloc_zeroed(aligned(layout)) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: by the caller's promises.
        unsafe { System.dealloc(pointer, aligned(layout)) }
    }
}
