//! Tests of the room `gaps`.

#[path = "../common/mod.rs"]
mod common;

mod declared_gaps;
mod gaps;
mod near_contact;
mod pinched;
