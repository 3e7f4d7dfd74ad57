//! The line on which rank 0 tells the run that it gives up.
//!
//! The launcher cannot be relied on for that: it may wait for a host that is out of reach, and nothing of the component
//! ends until it does.

use tremie_sdk::line::Replier;
use tremie_sdk::messages::start::{Fault, FaultKind, Reply};

/// The way for replies, and what a fault says of its place in the run.
pub struct FaultLine {
    replier: Replier,
    component: String,
    window: u64,
}

impl FaultLine {
    /// The line of a component that has no name yet.
    pub fn new(replier: Replier) -> Self {
        Self { replier, component: String::new(), window: 0 }
    }

    /// Gives it the component's name in the run, and the window after which that begins.
    pub fn begin(&mut self, component: &str, window: u64) {
        (self.component, self.window) = (component.into(), window);
    }

    /// Another window begins.
    pub fn next_window(&mut self) {
        self.window += 1;
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
