//! The line on which rank 0 tells the run what the sdk knows nothing of: the times of the ranks, and that it gives up.
//!
//! The launcher cannot be relied on for the latter: it may wait for a host that is out of reach, and nothing of the component
//! ends until it does.

use tremie_sdk::line::Replier;
use tremie_sdk::messages::start::{Fault, FaultKind, RankTime, Reply};

/// The way for replies, and what they say of their place in the run.
pub struct RunLine {
    replier: Replier,
    component: String,
    window: u64,
    /// First and last window whose times are told.
    timed: Option<(u64, u64)>,
}

impl RunLine {
    /// The line of a component that has no name yet.
    pub fn new(replier: Replier) -> Self {
        Self { replier, component: String::new(), window: 0, timed: None }
    }

    /// Gives it the component's name in the run, the window after which that begins, and those whose times are told.
    pub fn begin(&mut self, component: &str, window: u64, timed: Option<(u64, u64)>) {
        (self.component, self.window, self.timed) = (component.into(), window, timed);
    }

    /// Another window begins; true if its times are told.
    pub fn next_window(&mut self) -> bool {
        self.window += 1;
        self.timed.is_some_and(|(first, last)| (first..=last).contains(&self.window))
    }

    /// Tells the run the times of all ranks in this window, which they began to compute at `begin`.
    pub fn tell_times(&self, begin: u64, ranks: Vec<RankTime>) {
        let _ = self.replier.reply(&Reply::Ranks { window: self.window, begin, ranks });
    }

    /// Tells the run that a rank does not answer. Where nobody listens any longer, the run has ended.
    pub fn tell(&self, message: &str) {
        let fault = Fault {
            kind: FaultKind::Deadline,
            noticed_by: self.component.clone(),
            blamed: self.component.clone(),
            window: self.window,
            message: message.into(),
        };
        let _ = self.replier.reply(&Reply::Fault(fault));
    }
}
