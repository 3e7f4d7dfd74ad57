//! Steering: what a user tells a run in progress, from another terminal.
//!
//! A run listens on a socket in its private folder, which only its user can open. A command is a line of
//! JSON, and so is each answer. The loop of windows obeys commands between its looks at reports; none
//! changes what the physics computes, but for changes of the manifest, which go through a checkpoint.

mod command;
mod living;
mod socket;

pub use command::{Answer, RunState, RunStatus, SteeringCommand};
pub use living::{LivingRun, NotReached, find, living};
pub use socket::{SteeringRequest, SteeringSocket};

/// Name of the socket in the folder of a run.
const SOCKET: &str = "steering";
/// Name of the file that says where the run's outputs are.
const OUTPUTS: &str = "outputs";
/// Longest line of a command [bytes].
const LONGEST: u64 = 64 << 10;
