//! State of a component, kept so that a run goes on from it bit for bit.
//!
//! A component tells its state once, for both directions: [`KeepsState::exchange_state`] names each array
//! and each value, and a [`StateExchange`] either keeps them or puts back what was kept.
//!
//! ```
//! use tremie_state::{KeepsState, SavedState, StateError, StateExchange};
//!
//! #[derive(Default)]
//! struct Pendulum {
//!     angles: Vec<f64>,
//!     steps: u64,
//! }
//!
//! impl KeepsState for Pendulum {
//!     const STATE_VERSION: u32 = 1;
//!
//!     fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
//!         state.list("angles", &mut self.angles)?;
//!         state.value("steps", &mut self.steps)
//!     }
//! }
//!
//! let mut before = Pendulum { angles: vec![0.1, -0.0], steps: 7 };
//! let saved = SavedState::of(&mut before)?;
//! let mut after = Pendulum::default();
//! saved.restore(&mut after)?;
//! assert_eq!((after.angles, after.steps), (before.angles, before.steps));
//! # Ok::<(), StateError>(())
//! ```
//!
//! A file of a state is an archive that NumPy reads (`numpy.load("grains.npz")`): each array is an
//! entry `name.npy`, as it lies in memory. Values that are no arrays are entries `name.postcard`,
//! and `about.json` says whose state it is. The archive has a checksum of each entry.
//!
//! A component of several processes has a file of each: `fluid.npz`, `fluid.part-1.npz`, and so on. Arrays and lists
//! that are shared ([`StateExchange::shared_array`]) go on from part to part; all else is in the first. Any number of
//! processes can put them back.

mod archive;
mod error;
mod exchange;
mod file_content;
mod number;
pub mod numpy;
mod parts;
mod reliances;
mod saved;
mod whole_file;

pub use archive::{StateArchive, StateHeader};
pub use error::StateError;
pub use exchange::{KeepsState, StateExchange};
pub use file_content::have_same_content;
pub use number::StateNumber;
pub use parts::{SharedRows, StatePart, StatePlace, bytes_on_disk};
pub use reliances::Reliances;
pub use saved::SavedState;
pub use whole_file::{PreparedFile, write_whole};
