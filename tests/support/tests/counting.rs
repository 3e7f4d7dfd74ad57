//! Counts of the counting allocator.

use std::hint::black_box;
use tremie_test_support::{Counting, allocations, live_bytes};

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn allocations_and_what_lives_are_counted() {
    let (before, live) = (allocations(), live_bytes());
    let kept = black_box(vec![1_u8; 1000]);
    assert_eq!((allocations() - before, live_bytes() - live), (1, 1000));
    drop(kept);
    assert_eq!((allocations() - before, live_bytes() - live), (1, 0));
}
