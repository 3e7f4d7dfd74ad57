//! Writes the profiles of grains of a run (`[[scene.profiles]]`) as tables: text for eyes and
//! spreadsheets, arrays for NumPy.
//!
//! [`ProfileWriter`] is an observer; profiles in a scene start it. It fills `OUT/profiles`, with
//! two files for each profile:
//!
//! | file | what it holds |
//! | --- | --- |
//! | `NAME.csv` | a row for each bin of each table; names of columns with SI units in the first row |
//! | `NAME.npz` | the same as arrays by these names, without units: shape (tables, bins) or (tables, bins, bins of the second axis) |
//!
//! The first columns are `begin`, `end` and `samples` of the table, then the middle of the bin
//! along each binned axis: `x`, `y` or `z`. In the `.npz` the former have a value for each table,
//! the latter for each bin along their axis. The others are those of
//! [`ProfileBin::COLUMNS`](tremie_messages::frame::ProfileBin::COLUMNS). What is not known stands
//! as `NaN`: the velocity of a bin without grains.
//!
//! ```python
//! import numpy
//! profile = numpy.load("profiles/channel.npz")
//! profile["x"], profile["velocity_z"][-1]     # the last table
//! ```
//!
//! Tables of the CSV file are there as soon as they have ended; the arrays come when the run ends.
//! No file depends on the wall clock or the run's id: identical runs give identical bytes, also one
//! that goes on from a checkpoint. The state has the tables so far, and the lengths of the rows:
//! what was written after that is cut off.

#![warn(clippy::print_stdout, clippy::print_stderr)]

mod arrays;
mod columns;
mod parameters;
mod writer;

pub use parameters::Parameters;
pub use writer::{ProfileWriter, run};
