//! The program: its command line, and each of its commands.

pub mod cli;
pub mod commands;
pub mod steer_args;
