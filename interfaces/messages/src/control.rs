//! Credit and reports: messages between the orchestrator and a component while windows run.

use crate::{Message, Stamp};

/// Credit: the last window that a component may advance through, or an order to end.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Credit {
    /// Id of the run.
    pub run: u64,
    /// Last window that the component may advance through.
    pub window: u64,
    /// [`Credit::ADVANCE`], [`Credit::FINISH`] or [`Credit::ABORT`].
    pub command: u64,
    /// The newest window at whose end components keep their states for a checkpoint; 0 before the
    /// first. No component has begun this window when it is named.
    pub checkpoint: u64,
    /// The newest of these windows at whose end all physics has kept its state, and has sent the
    /// window's frames before. Observers keep theirs then.
    pub kept: u64,
}

impl Credit {
    /// Windows up to and including `window` may be advanced.
    pub const ADVANCE: u64 = 0;
    /// `window` is the last: end in good order after it.
    pub const FINISH: u64 = 1;
    /// End at once; another component failed or the user asked for it.
    pub const ABORT: u64 = 2;

    /// This word where `earlier` was said before. The channel keeps the newest word only, which may be the
    /// first that a component reads: nothing that was said before may be missing in it.
    pub fn after(self, earlier: Self) -> Self {
        Self {
            run: self.run,
            window: self.window.max(earlier.window),
            command: self.command.max(earlier.command),
            checkpoint: self.checkpoint.max(earlier.checkpoint),
            kept: self.kept.max(earlier.kept),
        }
    }
}

/// A component's account of one window, sent to the orchestrator with its signals as payload, and the
/// places of watched ones after them, where its description says so.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// The window that it accounts for, with the substeps really made.
    pub stamp: Stamp,
    /// When its work on the window began, by the machine's clock: nanoseconds since the Unix epoch.
    pub begin: u64,
    /// Wall time spent computing [ns].
    pub compute: u64,
    /// Wall time spent waiting for peers [ns].
    pub wait: u64,
    /// Wall time spent in sending and bookkeeping [ns].
    pub exchange: u64,
    /// Cells, grains or whatever the component counts as its work in this window, times substeps.
    pub work: u64,
}

// SAFETY: five words, no padding.
unsafe impl Message for Credit {
    const TYPE_NAME: &'static str = "tremie.Credit.2";
}
// SAFETY: a stamp of 40 bytes and five words, no padding.
unsafe impl Message for Report {
    const TYPE_NAME: &'static str = "tremie.Report.2";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_word_takes_back_what_was_said_before() {
        let run = 7;
        let finish = Credit { run, window: 40, command: Credit::FINISH, checkpoint: 30, kept: 20 };
        let kept = Credit { run, window: 0, command: Credit::ADVANCE, checkpoint: 30, kept: 30 };
        assert_eq!(kept.after(finish), Credit { kept: 30, ..finish });
        assert_eq!(finish.after(Credit::default()), finish);
        let abort = Credit { command: Credit::ABORT, ..kept };
        assert_eq!(abort.after(finish).command, Credit::ABORT);
    }
}
