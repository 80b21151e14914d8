//! A global allocator that counts, for tests of "no allocation in the cycle".

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

/// Counts allocations per thread and passes them on to the system's allocator.
///
/// ```
/// #[global_allocator]
/// static ALLOCATOR: cell_rt::alloc::Counting = cell_rt::alloc::Counting;
///
/// let before = cell_rt::alloc::count();
/// let boxed = std::hint::black_box(Box::new(1));
/// assert_eq!(cell_rt::alloc::count() - before, 1);
/// # drop(boxed);
/// ```
#[derive(Debug)]
pub struct Counting;

/// Allocations of the calling thread so far; stays 0 unless [`Counting`] is
/// the program's global allocator.
pub fn count() -> u64 {
    COUNT.try_with(Cell::get).unwrap_or(0)
}

fn add_one() {
    // A thread that is ending has no counter any more and needs
    // none, so that error does not matter.
    COUNT
        .try_with(|count| count.set(count.get() + 1))
        .unwrap_or_default();
}

// SAFETY: every call goes to the system's allocator with the same arguments;
// the counter is a plain thread-local that allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        add_one();
        // SAFETY: contract of the caller, passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: contract of the caller, passed on.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        add_one();
        // SAFETY: contract of the caller, passed on.
        unsafe { System.realloc(pointer, layout, size) }
    }
}
