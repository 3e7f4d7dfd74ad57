//! The `tremie` program.
fn main() {}
