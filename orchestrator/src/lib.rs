//! The orchestrator: from a manifest to a validated plan, a schedule, and supervised components.
//!
//! A run goes through these rooms: [`manifest`] reads what the user wants; [`introduction`] starts the
//! components ([`launch`]) and asks each what it is, in a [`round`]; [`plan`] assigns steps and [`schedule`] the order of
//! work; [`doctor`] says which numbers are doubtful; [`mod@run`] hands out the assignments; [`drive`] lets the
//! windows go by over [`control`], with [`monitor`] watching; [`outputs`] keeps what a user reads afterwards.
//! [`mod@report`] draws what a finished run kept, with [`charts`], and [`mod@valve`] reads a valve out of it; [`validation`] makes runs whose results are known;
//! [`scenes`] builds scenes from numbers; [`bench`] says how fast all that is.

#![warn(clippy::print_stdout, clippy::print_stderr)]

pub mod ask_all;
pub mod bench;
pub mod charts;
pub mod cli;
pub mod commands;
pub mod conform;
pub mod control;
pub mod handshake;
pub mod launch;
pub mod limits;
pub mod manifest;
pub mod monitor;
pub mod outputs;
pub mod plan;
pub mod preflight;
pub mod registry;
pub mod report;
pub mod run;
pub mod run_loop;
pub mod scenes;
pub mod schedule;
pub mod schedule_timing;
pub mod standard;
pub mod startup_log;
pub mod stop_conditions;
pub mod terminal;
pub mod validation;
pub mod valve;
