//! A settled bed advances without a single allocation.

mod common;
use common::*;
use std::{
    alloc::{GlobalAlloc, Layout, System},
    sync::atomic::{AtomicUsize, Ordering},
};
use tremie_messages::scene::Damping;

struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: hands every call to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` came from `System.alloc` above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_substep_allocates_nothing() {
    let mut scene = scene([6e-3, 6e-3, 10e-3], WALLS, law(1e3, 0.5, Damping::Restitution(0.3)));
    scene.gravity = [0.0, 0.0, -9.81];
    scene.bodies = vec![packed([0.0; 3], [6e-3; 3], 0.5, (1e-3, 1e-3), 4)];
    let mut dem = make(&scene, 4e-6);
    dem.advance(20_000, &[]).unwrap();
    let mut loads = vec![tremie_messages::Load::default(); dem.body_count()];
    for (id, load) in (0..).zip(&mut loads) {
        load.id = id;
    }
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    for _ in 0..1000 {
        dem.advance(3, &loads).unwrap();
    }
    assert_eq!(ALLOCATIONS.load(Ordering::Relaxed) - before, 0);
}
