//! Shared-memory channels between the components of a run.
//!
//! This crate is the only one that touches iceoryx2. Everything above it is generic over
//! [`ChannelMedium`]: [`SharedMemory`] for components that are programs of their own, [`InProcess`]
//! for the same components inside one program. Values travel in place: a sender fills the memory
//! that the receiver reads.
//!
//! Rules that iceoryx2 0.10 makes necessary, all kept here:
//! * overflow is off on every lossless channel, and a full channel is an error after a deadline,
//!   never a silent loss and never an endless wait;
//! * shared memory is set aside before it is touched ([`memory`]): touching a page that a full
//!   memory lacks ends the process by a signal;
//! * nodes install no signal handlers;
//! * every run has a folder and a name prefix of its own, so that runs never meet and what a
//!   killed run left can be told apart and swept ([`sweep`]).

#![warn(clippy::print_stdout, clippy::print_stderr)]

mod attachment;
mod bell;
mod error;
pub mod memory;
mod receiver;
mod sender;
mod spin;
pub mod sweep;
mod wire;

pub use attachment::{Attachment, ChannelMedium, ChannelSpec, InProcess, SharedMemory};
pub use bell::{Bell, Ringer, Wait};
pub use error::ChannelError;
pub use receiver::{Received, Receiver};
pub use sender::{Loan, Sender};
pub use spin::{look, spin};
