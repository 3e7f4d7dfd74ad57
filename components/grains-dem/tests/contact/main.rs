//! Tests of the room `contact`.

#[path = "../common/mod.rs"]
mod common;

mod chen;
mod hertz;
mod incline;
mod jkr;
mod lubrication;
mod no_history;
mod restitution;
mod rolling;
mod spinning_drop;
