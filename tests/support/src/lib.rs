//! Allocation counts and processor times for tests and benchmarks of several crates. No run needs
//! them, so the crate stands beside the tests and not among the interfaces.
//!
//! [`Counting`] is the system's allocator, counting. A test that says that something allocates
//! nothing, or how much it keeps, makes it the allocator of its program (`#[global_allocator]`).
//! One such test to a program: others would count with it.
//!
//! [`DamagedInput`] tries a reader of bytes that come from others with damaged ones, by the thousand.
//!
//! [`Random`] draws numbers for tests, the same on every machine.
//!
//! [`processor_seconds`] times one thread, whatever other programs do beside it. [`until`] waits for what another
//! thread or process does.
//!
//! `observers`, behind a feature of that name, sets an observer up without a run; `interrupted` kills
//! such a one, and lets it go on from a checkpoint. `through_a_file`,
//! behind the feature `state`, takes a component's state to another one.

mod clock;
mod damaged;
#[cfg(feature = "observers")]
pub mod interrupted;
mod mutation;
#[cfg(feature = "observers")]
pub mod observers;
mod random;
#[cfg(feature = "state")]
mod through_a_file;

pub use clock::{processor_seconds, until};
pub use damaged::{DamagedInput, inputs};
pub use random::Random;
#[cfg(feature = "state")]
pub use through_a_file::through_a_file;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);
static LIVE: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    /// Memory that this thread has taken and not given back, and the most of it [bytes].
    static OF_THREAD: Cell<[isize; 2]> = const { Cell::new([0; 2]) };
}

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

/// Memory that `work` takes at its most, beyond what this thread had before [bytes]; with [`Counting`] as
/// the program's allocator, else 0.
pub fn most_bytes(work: impl FnOnce()) -> usize {
    let before = OF_THREAD.with(|counts| {
        let [now, _] = counts.get();
        counts.set([now, now]);
        now
    });
    work();
    let [_, most] = OF_THREAD.with(Cell::get);
    usize::try_from(most - before).unwrap_or(0)
}

/// Counts memory that this thread took, or gave back.
fn count_of_thread(bytes: isize) {
    // A thread that ends gives memory back after its counts are gone.
    let _ = OF_THREAD.try_with(|counts| {
        let [now, most] = counts.get();
        counts.set([now + bytes, most.max(now + bytes)]);
    });
}

// SAFETY: hands every call to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Relaxed);
        LIVE.fetch_add(layout.size(), Relaxed);
        count_of_thread(layout.size() as isize);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Relaxed);
        count_of_thread(-(layout.size() as isize));
        // SAFETY: `pointer` came from `System.alloc` above.
        unsafe { System.dealloc(pointer, layout) }
    }
}
