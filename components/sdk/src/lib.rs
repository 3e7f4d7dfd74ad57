//! What the author of a Tremie component needs.

pub mod observer;
pub mod parameters;
pub mod setup;

pub use observer::{Moment, Observer, ObserverError};
pub use setup::Setup;
pub use tremie_messages as messages;
