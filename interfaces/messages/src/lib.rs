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
pub mod watch;

pub use body::{BodyEvent, BodyState, Load};
pub use finding::{Finding, Limit, Verdict};
pub use port::PortState;
pub use problem::{Problem, nearest};
pub use role::Role;
pub use stamp::Stamp;
pub use surface::{FacetLoad, SurfaceVertex};
pub use watch::{Place, WatchedQuantity, WatchedSignal};

/// Version of everything in this crate that crosses a process boundary. A component of another
/// version is refused at the handshake, before anything is computed.
pub const INTERFACE_VERSION: u32 = 6;

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

/// Values as they lie in memory.
pub fn bytes_of<T: Message>(values: &[T]) -> &[u8] {
    // SAFETY: `Message` demands that there is no padding: every byte is initialised.
    unsafe { std::slice::from_raw_parts(values.as_ptr().cast(), size_of_val(values)) }
}

/// Values that lay in memory so; `None` if the bytes are no whole number of them.
pub fn values_of<T: Message>(bytes: &[u8]) -> Option<Vec<T>> {
    let (count, rest) = (bytes.len() / size_of::<T>(), bytes.len() % size_of::<T>());
    let mut values: Vec<T> = Vec::with_capacity(count);
    // SAFETY: there is room for `count` values, all of whose bytes are written here; every pattern
    // of bits is a value (contract of `Message`).
    unsafe {
        std::ptr::copy_nonoverlapping(
            bytes.as_ptr(),
            values.as_mut_ptr().cast(),
            bytes.len() - rest,
        );
        values.set_len(count);
    }
    (rest == 0).then_some(values)
}

// SAFETY: plain numbers.
unsafe impl Message for f64 {
    const TYPE_NAME: &'static str = "f64";
}
// SAFETY: plain numbers.
unsafe impl Message for u64 {
    const TYPE_NAME: &'static str = "u64";
}
// SAFETY: plain numbers.
unsafe impl Message for u8 {
    const TYPE_NAME: &'static str = "u8";
}
