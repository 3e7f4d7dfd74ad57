//! The orchestrator: from a manifest to a validated plan, a schedule, and supervised components.
//!
//! Rooms; each imports only rooms named before it. [`registry`] names the components and commands
//! of the executable, and [`terminal`] prints to the user. [`manifest`] reads the input, [`plan`]
//! assigns steps and the order of work, [`outputs`] writes the results, and [`preflight`] judges
//! the numbers of a run. [`steering`] carries commands to a run in progress. [`run`] starts the components, asks each for its description, hands out
//! the assignments and runs the windows. [`tools`] work around runs, and [`program`] is the command
//! line.

#![warn(clippy::print_stdout, clippy::print_stderr)]

pub mod manifest;
pub mod outputs;
pub mod plan;
pub mod preflight;
pub mod program;
pub mod registry;
pub mod run;
pub mod steering;
pub mod terminal;
pub mod tools;
