//! What is known of hard spheres: gases, cooling, balls on floors, rough ones.

#[path = "../common/mod.rs"]
mod common;

mod bad_input;
mod collapse;
mod conserved;
mod cooling;
mod equilibrium;
mod kept_state;
mod missed;
mod obstacles;
mod rough;
mod same_bits;
