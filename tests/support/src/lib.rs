//! Allocation counts and processor times for tests and benchmarks of several crates. No run needs
//! them, so the crate stands beside the tests and not among the interfaces.
//!
//! [`Counting`] is the system's allocator, counting. A test that says that something allocates
//! nothing, or how much it keeps, makes it the allocator of its program (`#[global_allocator]`).
//! One such test to a program: others would count with it.
//!
//! [`processor_seconds`] times one thread, whatever other programs do beside it.
//!
//! `observers`, behind a feature of that name, sets an observer up without a run; `interrupted` kills
//! such a one, and lets it go on from a checkpoint. `through_a_file`,
//! behind the feature `state`, takes a component's state to another one.

mod clock;
#[cfg(feature = "observers")]
pub mod interrupted;
#[cfg(feature = "observers")]
pub mod observers;
#[cfg(feature = "state")]
mod through_a_file;

pub use clock::processor_seconds;
#[cfg(feature = "state")]
pub use through_a_file::through_a_file;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);
static LIVE: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator, counting.
#[derive(Clone, Copy, Debug)]
pub struct Counting;

/// Allocations since the start of the program.
pub fn allocations() -> usize {
    ALLOCATIONS.load(Relaxed)
}

/// Memory that is allocated now [bytes].
pub fn live_bytes() -> usize {
    LIVE.load(Relaxed)
}

// SAFETY: hands every call to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Relaxed);
        LIVE.fetch_add(layout.size(), Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: `pointer` came from `System.alloc` above.
        unsafe { System.dealloc(pointer, layout) }
    }
}
