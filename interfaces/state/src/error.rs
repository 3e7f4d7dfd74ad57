//! Why a state could not be kept or put back.

use std::path::PathBuf;

/// Why a state could not be kept or put back.
#[derive(Debug, thiserror::Error)]
pub enum StateError {
    /// An entry that a component asks for is not there.
    #[error("the state has no `{name}`: it was kept by another version of the program")]
    Missing {
        /// Name of the entry.
        name: String,
    },
    /// Entries that no component asked for.
    #[error(
        "the state holds `{name}`, which this program does not know: it was kept by another version"
    )]
    Unknown {
        /// Name of the first of these entries.
        name: String,
    },
    /// A component names two entries alike.
    #[error("the state has two entries `{name}`")]
    Twice {
        /// Name of the entries.
        name: String,
    },
    /// An array holds other numbers than expected.
    #[error(
        "`{name}` of the state holds {found}, expected {expected}: is it the state of another scene?"
    )]
    Shape {
        /// Name of the entry.
        name: String,
        /// Type and lengths that were found.
        found: String,
        /// Type and lengths that were expected.
        expected: String,
    },
    /// The content of an entry makes no sense.
    #[error("`{name}` of the state is damaged: {why}")]
    Damaged {
        /// Name of the entry.
        name: String,
        /// What is wrong with it.
        why: String,
    },
    /// The state is another's.
    #[error("the state is that of {found}, expected {expected}")]
    Foreign {
        /// Program and version of the state that was found.
        found: String,
        /// Those that were expected.
        expected: String,
    },
    /// A component says that what was put back does not fit it.
    #[error("{0}")]
    Unfit(String),
    /// There is no memory for the copy of an array.
    #[error("there is no memory for a copy of `{name}`, {bytes} bytes")]
    Memory {
        /// Name of the array.
        name: String,
        /// Its length [bytes].
        bytes: usize,
    },
    /// The disk refuses.
    #[error("{}: {error}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Its error.
        error: std::io::Error,
    },
}
