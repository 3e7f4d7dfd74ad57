//! Components in C and C++: a table of functions for each role, behind the traits of the sdk.
//!
//! `include/tremie.h` is made from this crate. [`fluid`], [`grains`] and [`observer`] have the tables,
//! [`setup`], [`description`] and [`state`] what their functions get, and [`failure`] how they say what went
//! wrong. One process is one component, so the table is a value of the process.

mod component;
pub mod description;
pub mod failure;
pub mod fluid;
pub mod grains;
pub mod observer;
pub mod setup;
pub mod state;
mod text;
