//! Tests of the room `solver`.

#[path = "../common/mod.rs"]
mod common;

mod clumps;
mod conservation;
mod drag_bands;
mod exchange;
mod impulse;
mod integrators;
mod kept_state;
mod kept_surfaces;
mod order;
mod pile;
mod ports;
mod probes;
mod profiles;
mod same_bits;
