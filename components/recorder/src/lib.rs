//! Writes a Tremie run to MCAP, and plays it back.
//!
//! [`Recorder`] is an observer that writes `run.mcap`; [`Recording`] reads such a file and feeds
//! any observer with the very frames that the recorder was given, bit for bit.
//!
//! # Channels
//!
//! All messages are protobuf, which is the encoding of Foxglove's schemas that both Foxglove and
//! Rerun decode. Foxglove and Rerun (0.36) open the file without a plug-in.
//!
//! | topic | schema | content |
//! | --- | --- | --- |
//! | `/bodies/<component>` | `foxglove.PointCloud` | one point for each body: [`tremie_messages::frame::BodySample`] as it is in memory (144 bytes, little endian), then `speed` (f32) for colouring |
//! | `/surfaces/<component>` | `foxglove.PointCloud` | one point for each vertex of the deformable surfaces: [`tremie_messages::frame::SurfaceSample`] as it is in memory (56 bytes) |
//! | `/cuts/<component>/<name>` | `foxglove.PointCloud` | one point for each node: `x`, `y`, `z` (f32), [`tremie_messages::frame::SliceNode`] as it is in memory (32 bytes), then `speed` (f32) |
//! | `/signals/<component>` | `tremie.signals.<component>` | one `double` field for each signal, by its name; units in the channel's metadata |
//! | `/hashes/<component>` | `tremie.hashes.<component>` | a list of windows, and for each channel on which the component sends a list of the hashes of its messages ([`tremie_messages::start::FrameContent::Hashes`]) |
//! | `/messages/<from>/<content>/<to>` | `tremie.Message` | with the setting `messages`: every message of that channel, its values as they are in memory ([`tremie_messages::schedule::Content`]) |
//! | `/log` | `foxglove.Log` | lines of the log |
//! | `/frames` | `tremie.Frame` | before each of the messages above: its topic, stamp and exact time; of a cut, its exact grid; of a line, its level |
//!
//! Bodies, surfaces and cuts are stored once, in a form that is exact and that viewers show: a
//! point cloud whose stride is the message's own layout. `/frames` adds what Foxglove's schemas
//! have no place for.
//!
//! # Time
//!
//! `log_time` and `publish_time` are simulated nanoseconds. Nothing in the file depends on the wall
//! clock, the run's id, the output folder or the order in which frames of a window happen to
//! arrive: identical runs give identical bytes.
//!
//! # Whole windows
//!
//! Frames wait until their window is whole: until every lossless stream that is due has
//! arrived, and some component is [`HOLD`](windows::HOLD) windows ahead, which in a coupled run
//! means that all have completed it. Should a stream end while others go on, at most 64 windows
//! wait, then the oldest is written as it is, and the recorder's note says so. The end of a run
//! drops what lies beyond its last common window. The log is written last and whole: what was said
//! about the end belongs to the record.
//!
//! # Ends
//!
//! Chunks reach the file at fixed amounts of data and of windows. Of a recorder that is killed,
//! everything up to the last chunk can be read; [`Recording::end`] then says that the end is
//! missing.
//!
//! # Checkpoints
//!
//! A run that goes on from a checkpoint gets the file that it would have without interruption. The
//! state of the recorder says how many chunks were in the file, and holds what was not yet: messages
//! of the open chunk, of windows that are not whole, and the log. The chunks are written again into
//! a file beside the old one, which takes its name when it is as far as that was.
//!
//! # Metadata
//!
//! `tremie.run` holds, as JSON texts, `scene`, `clock`, `windows`, `streams`, and the versions of
//! this crate and of its format; `tremie.end` the last common window. Files of the scene are told from the
//! folder of the run (`inputs/frame.stl`): a recording is watched in its place there.

#![warn(clippy::print_stdout, clippy::print_stderr)]

mod codec;
mod comparison;
mod differences;
mod document;
mod entry;
mod file;
mod hashes;
mod item;
mod parameters;
mod player;
mod proto;
mod recorder;
mod recording;
mod records;
mod resumption;
mod schema;
mod signals;
pub mod windows;
mod write_behind;

pub use comparison::{Channel, Comparison, HashComparison, Place, compare};
pub use differences::{Differences, FieldDifference, Number};
pub use item::Item;
pub use parameters::Parameters;
pub use player::run_player;
pub use recorder::{Recorder, run};
pub use recording::{End, Items, ReadError, Recording};
