//! The orchestrator: from a manifest to a validated plan, a schedule, and supervised components.
//!
//! Rooms, each of which imports only rooms named before it: [`registry`] names what the program carries in itself, and
//! [`terminal`] speaks to the user. [`manifest`] reads what the user wants, [`plan`] assigns steps and the order of work,
//! [`outputs`] keeps what a user reads afterwards, [`preflight`] says which numbers are doubtful. [`run`] starts the
//! components, asks each what it is, hands out the assignments and lets the windows go by. [`tools`] work around runs, and
//! [`program`] is the command line.

#![warn(clippy::print_stdout, clippy::print_stderr)]

pub mod manifest;
pub mod outputs;
pub mod plan;
pub mod preflight;
pub mod program;
pub mod registry;
pub mod run;
pub mod terminal;
pub mod tools;
