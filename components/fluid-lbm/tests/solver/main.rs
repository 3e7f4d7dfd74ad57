//! Tests of the room `solver`.

#[path = "../common/mod.rs"]
mod common;

mod axes;
mod conservation;
mod force_lag;
mod kept_mass;
mod mass;
mod ports;
mod probes;
