//! Minimal fluid.
fn main() {}
