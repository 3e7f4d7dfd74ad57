//! Bodies placed at random.

pub mod random_packing;
