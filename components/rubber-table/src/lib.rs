//! A rubber seal that is pressed on a seat: its force and its shapes over one number, the
//! compression.
//!
//! The section of the seal is meshed ([`mesh`]), made a model of its material and of what holds it,
//! and compressed frame by frame ([`fem`]). What comes out is a [`table`], which can also come from
//! another program's results ([`import`]). [`make::make`] does all this from a [`spec`],
//! [`picture`] draws it, and [`runtime`] is what a run does with it, as a component of the role
//! rubber.
//!
//! Directions: r is the distance from the seal's axis and z points along it, away from the seat. SI
//! units throughout; forces are those all round.

#![warn(clippy::print_stdout, clippy::print_stderr)]

#[cfg(feature = "component")]
pub mod commands;
#[cfg(feature = "component")]
pub mod component;
pub mod fem;
pub mod import;
pub mod make;
pub mod mesh;
mod parameters;
pub mod picture;
pub mod runtime;
pub mod spec;
pub mod table;

pub use parameters::{ForceForm, Parameters};
