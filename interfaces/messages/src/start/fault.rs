//! Faults of components, and injections: faults committed on purpose in tests.

use serde::{Deserialize, Serialize};

/// A component's failure, with the component that noticed it and the one to blame.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fault {
    /// Kind of the fault.
    pub kind: FaultKind,
    /// Component that noticed.
    pub noticed_by: String,
    /// Component that is to blame, if that is known; else the one that noticed.
    pub blamed: String,
    /// Window in which it happened.
    pub window: u64,
    /// Sentence with the value expected and the value found.
    pub message: String,
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} failed at window {}: {}", self.blamed, self.window, self.message)?;
        if self.noticed_by != self.blamed {
            write!(f, " (noticed by {})", self.noticed_by)?;
        }
        Ok(())
    }
}

/// Kinds of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// A message carries another stamp than the schedule foretells.
    Stamp,
    /// A message holds another number of values, or bodies of other ids, than foretold.
    Count,
    /// A number is not finite.
    NotFinite,
    /// A message was sent, as its sender reports, and never arrived.
    Lost,
    /// A peer's message did not come in time.
    Deadline,
    /// A component made more or fewer substeps than assigned.
    Substeps,
    /// The solver itself failed.
    Solver,
    /// A watched quantity of the physics has passed its limit.
    Physics,
    /// A channel failed.
    Channel,
    /// A component's process ended without a reply.
    Exit,
    /// The start contract was broken.
    Contract,
    /// A state could not be put back: it is damaged, or another's.
    State,
    /// In a run that is replayed, a component sent another message than the recorded one.
    Replay,
    /// An output could not be written, or not all of it: a full disk, for example.
    Output,
}

/// A fault to commit on purpose in one window.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Injection {
    /// Kind of the fault.
    pub kind: InjectionKind,
    /// Window in which the component commits it.
    pub window: u64,
}

/// Faults that a component can be made to commit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InjectionKind {
    /// Do not send.
    Drop,
    /// Send twice.
    Duplicate,
    /// Send with the stamp of the window before.
    Stale,
    /// Send one value too few.
    Count,
    /// Send a value that is not a number.
    Nan,
    /// Stop doing anything, alive.
    Hang,
    /// Exit with code 0 in the middle.
    Exit,
    /// End by SIGKILL.
    Kill,
    /// Make one substep too many.
    SubstepMore,
    /// Make one substep too few.
    SubstepLess,
}

impl InjectionKind {
    /// All kinds, with their names.
    pub const ALL: [(InjectionKind, &'static str); 10] = [
        (InjectionKind::Drop, "drop"),
        (InjectionKind::Duplicate, "duplicate"),
        (InjectionKind::Stale, "stale"),
        (InjectionKind::Count, "count"),
        (InjectionKind::Nan, "nan"),
        (InjectionKind::Hang, "hang"),
        (InjectionKind::Exit, "exit"),
        (InjectionKind::Kill, "kill"),
        (InjectionKind::SubstepMore, "substep-more"),
        (InjectionKind::SubstepLess, "substep-less"),
    ];
}

impl InjectionKind {
    /// True if it is committed in a message to another component.
    pub fn is_of_message(self) -> bool {
        matches!(self, Self::Drop | Self::Duplicate | Self::Stale | Self::Count | Self::Nan)
    }
}

impl std::fmt::Display for InjectionKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let named = Self::ALL.iter().find(|(kind, _)| kind == self);
        f.write_str(named.map_or("", |(_, name)| name))
    }
}
