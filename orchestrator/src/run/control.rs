//! The orchestrator's end of shared memory: credit to components, reports from them, log lines and
//! timings to observers.

use crate::manifest::ORCHESTRATOR;
use crate::run::launch::Peer;
use std::cell::Cell;
use tremie_channels::{Attachment, ChannelError, ChannelMedium, Receiver, Ringer, Sender};
use tremie_messages::Stamp;
use tremie_messages::control::{Credit, Report};
use tremie_messages::frame::{ComponentTiming, LogHeader, TimingHeader};
use tremie_messages::start::{Assignment, FrameContent, FrameStream};
use tremie_sdk::{credit_spec, frame_spec, report_spec};

struct End<S: ChannelMedium> {
    credit: Sender<S, Stamp, Credit>,
    /// The last word that was sent on it.
    said: Cell<Credit>,
    report: Receiver<S, Report, f64>,
    ringer: Ringer<S>,
}

/// Lines to one observer; `capacity` bytes at most.
struct LogEnd<S: ChannelMedium> {
    sender: Sender<S, LogHeader, u8>,
    ringer: Ringer<S>,
    capacity: usize,
}

/// Timings to one observer.
struct TimingEnd<S: ChannelMedium> {
    sender: Sender<S, TimingHeader, ComponentTiming>,
    ringer: Ringer<S>,
    /// Windows between frames.
    every: u64,
    /// Window from which on the next one is due.
    due: Cell<u64>,
}

/// The orchestrator's ends of the channels to all components, in the order of the peers.
pub struct Control<S: ChannelMedium> {
    run: u64,
    ends: Vec<End<S>>,
    logs: Vec<LogEnd<S>>,
    timings: Vec<TimingEnd<S>>,
    attachment: Attachment<S>,
    checkpoint: Cell<u64>,
    kept: Cell<u64>,
}

impl<S: ChannelMedium> Control<S> {
    /// Opens the ends to all `peers`, which got `assignments` with `signals` signals each.
    ///
    /// # Errors
    /// [`ChannelError::Open`].
    pub fn open(
        run: u64,
        peers: &[Peer],
        assignments: &[Assignment],
        signals: &[usize],
    ) -> Result<Self, ChannelError> {
        let transport = &assignments[0].transport;
        // Nothing that the orchestrator sends may make it wait. So credit overflows, and log lines
        // may be lost.
        let patience = std::time::Duration::ZERO;
        let attachment =
            Attachment::open(&transport.root, &transport.prefix, ORCHESTRATOR, patience)?;
        let mut ends = Vec::new();
        let (mut logs, mut timings) = (Vec::new(), Vec::new());
        for ((peer, assignment), signals) in peers.iter().zip(assignments).zip(signals) {
            let report = report_spec(&assignment.transport, *signals);
            ends.push(End {
                credit: attachment.sender(credit_spec(&assignment.transport.credit_service))?,
                said: Cell::default(),
                report: attachment.receiver(report)?,
                ringer: Ringer::of(&attachment, &peer.name)?,
            });
            let own = |s: &&FrameStream| s.to == peer.name && s.content.is_of_orchestrator();
            for stream in assignment.frames.iter().filter(own) {
                let spec = frame_spec(stream);
                let ringer = Ringer::of(&attachment, &peer.name)?;
                if stream.content == FrameContent::Log {
                    let (sender, capacity) = (attachment.sender(spec)?, stream.capacity as usize);
                    logs.push(LogEnd { sender, ringer, capacity });
                } else {
                    let (sender, every) = (attachment.sender(spec)?, stream.every.max(1));
                    timings.push(TimingEnd { sender, ringer, every, due: Cell::new(0) });
                }
            }
        }
        let (checkpoint, kept) = Default::default();
        Ok(Self { run, ends, logs, timings, attachment, checkpoint, kept })
    }

    /// Names the window of the next checkpoint, in all words from now on.
    pub fn name_checkpoint(&self, window: u64) {
        self.checkpoint.set(window);
    }

    /// Says, in all words from now on, that all physics has kept its state for the last checkpoint.
    pub fn all_have_kept(&self) {
        self.kept.set(self.checkpoint.get());
    }

    /// Sends component `index` a command, and wakes it if it sleeps.
    ///
    /// # Errors
    /// [`ChannelError::Failed`].
    pub fn say(&self, index: usize, command: u64, window: u64) -> Result<(), ChannelError> {
        let end = &self.ends[index];
        let (checkpoint, kept) = (self.checkpoint.get(), self.kept.get());
        let word = Credit { run: self.run, window, command, checkpoint, kept };
        let word = word.after(end.said.get());
        end.said.set(word);
        end.credit.send_copy(Stamp::default(), &[word])?;
        end.ringer.ring()
    }

    /// Takes all reports of component `index` that have arrived.
    ///
    /// # Errors
    /// [`ChannelError::Failed`], or whatever `take` fails with.
    pub fn reports<E: From<ChannelError>>(
        &self,
        index: usize,
        mut take: impl FnMut(&Report, &[f64]) -> Result<(), E>,
    ) -> Result<usize, E> {
        let mut count = 0;
        while let Some(message) = self.ends[index].report.take()? {
            take(message.header(), message.values())?;
            count += 1;
        }
        Ok(count)
    }

    /// Sends a line to all observers. An observer without room loses it: the log file has it.
    pub fn log(&self, header: LogHeader, text: &str) {
        for LogEnd { sender, ringer, capacity } in &self.logs {
            // Cut at a whole character: an observer reads UTF-8.
            let bytes = &text.as_bytes()[..text.floor_char_boundary(*capacity)];
            if sender.send_copy(header, bytes).is_ok() {
                let _ = ringer.ring();
            }
        }
    }

    /// True if an observer is to see timings of a window.
    pub fn shows_timings(&self, window: u64) -> bool {
        self.timings.iter().any(|end| window >= end.due.get())
    }

    /// Sends timings to observers. One without room loses the oldest, or these: the next ones are sums
    /// over the whole run again.
    pub fn show_timings(&self, header: TimingHeader, timings: &[ComponentTiming]) {
        let window = header.stamp.window;
        for end in &self.timings {
            end.due.set((window / end.every + 1) * end.every);
            if end.sender.send_copy(header, timings).is_ok() {
                let _ = end.ringer.ring();
            }
        }
    }

    /// Frees the shared memory of components that died, so that no sender waits for them.
    pub fn clean_after_dead(&self) {
        self.attachment.clean_after_dead();
    }
}
