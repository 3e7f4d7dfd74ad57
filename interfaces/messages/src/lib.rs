//! Messages and documents that Tremie's components exchange.
//!
//! Two kinds of things live here. *Messages* cross shared memory in every coupling window: plain
//! `repr(C)` values in SI units, world frame, `f64`, without pointers ([`body`], [`surface`],
//! [`port`], [`stamp`], [`control`], [`frame`]). *Documents* cross once, as JSON, when a component
//! starts: the scene and the start contract ([`scene`], [`start`], [`schedule`]). Nothing here
//! knows how they travel.

#![warn(clippy::print_stdout, clippy::print_stderr)]

pub mod body;
pub mod control;
pub mod finding;
pub mod frame;
pub mod port;
pub mod problem;
pub mod role;
pub mod scene;
pub mod schedule;
pub mod stamp;
pub mod start;
pub mod surface;
pub mod units;

pub use body::{BodyEvent, BodyState, Load};
pub use finding::{Finding, Limit, Verdict};
pub use port::PortState;
pub use problem::{Problem, nearest};
pub use role::Role;
pub use stamp::Stamp;
pub use surface::{FacetLoad, SurfaceVertex};

/// Version of everything in this crate that crosses a process boundary. A component of another
/// version is refused at the handshake, before anything is computed.
pub const INTERFACE_VERSION: u32 = 4;

/// A value that may cross shared memory.
///
/// # Safety
/// The type is `repr(C)`, has no padding, holds no pointer, reference or handle, and every bit
/// pattern, all zeros included, is a valid value. Its
/// [`Message::TYPE_NAME`] changes whenever its layout does.
pub unsafe trait Message: Copy + Send + Sync + std::fmt::Debug + 'static {
    /// Name of the type and its layout across processes and languages.
    const TYPE_NAME: &'static str;
}

// SAFETY: plain numbers.
unsafe impl Message for f64 {
    const TYPE_NAME: &'static str = "f64";
}
// SAFETY: plain numbers.
unsafe impl Message for u8 {
    const TYPE_NAME: &'static str = "u8";
}
