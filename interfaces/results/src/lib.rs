//! Finished runs read again, and commands that packages add to the `tremie` program.
//!
//! A package registers two kinds of commands in the orchestrator's `registry`: one that builds a
//! scene (`tremie scene NAME`), and one that reads a [`FinishedRun`]. Both answer with text for
//! standard output, or with a [`CommandError`].

mod charts;
mod colour_map;
mod command;
mod finished_run;
mod profile_tables;
mod signals;
mod text_columns;
mod ticks;

pub use charts::{Area, Chart, Curve, SheetPanel, draw_panels, draw_sheet};
pub use colour_map::ColourMap;
pub use command::{CommandError, key_value};
pub use finished_run::{FinishedRun, NoSignals, run_name, signals_of};
pub use profile_tables::{PROFILES, ProfileTables, UnreadableProfile, profiles_of};
pub use signals::{Cut, SIGNALS, Signals, UnreadableSignals};
pub use text_columns::text_columns;
