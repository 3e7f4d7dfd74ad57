//! The run's log: lines of components, and notes of the orchestrator.

use super::{EndReason, LoopState, RunLoop};
use crate::manifest::ORCHESTRATOR;
use crate::outputs::{LogLevel, OutputError};
use tremie_channels::ChannelMedium;
use tremie_messages::Role;
use tremie_messages::frame::LogHeader;

impl<S: ChannelMedium> RunLoop<'_, S> {
    /// Writes the startup log into the run's log.
    pub(super) fn write_startup_log(&mut self, state: &mut LoopState) -> Result<(), EndReason> {
        let bodies: u64 = self.descriptions.iter().map(|description| description.bodies).sum();
        let (windows, window) = (self.windows, self.clock.window());
        // With inlets the descriptions give room for bodies, not their number.
        let room = if self.changing_bodies().is_some() { "room for " } else { "" };
        let text = format!("{windows} windows of {window:.4e} s begin, with {room}{bodies} bodies");
        if self.first == 0 {
            self.note_at(0, LogLevel::Info, ORCHESTRATOR, &text)?;
        } else {
            // Into the file only: the recording shall be that of a run that was never interrupted.
            let first = self.first;
            let text = format!("the run goes on from the end of window {first} of {windows}");
            self.write_line(LogLevel::Info, ORCHESTRATOR, first, &text)?;
        }
        for (index, text) in std::mem::take(&mut self.early).into_lines() {
            self.write_log(state, index, &text)?;
        }
        Ok(())
    }

    /// A component's line on standard error: JSON from the sdk's logger, or anything else.
    pub(super) fn write_log(
        &mut self,
        state: &mut LoopState,
        index: usize,
        text: &str,
    ) -> Result<(), OutputError> {
        let parsed: Option<serde_json::Value> = serde_json::from_str(text).ok();
        let field = |name: &str| parsed.as_ref()?.get(name)?.as_str().map(str::to_string);
        let message = field("message").unwrap_or_else(|| text.to_string());
        let level = match field("level").as_deref() {
            Some("ERROR") => LogLevel::Error,
            Some("WARN") => LogLevel::Warning,
            _ => LogLevel::Info,
        };
        let name = self.peers[index].name.clone();
        match level {
            LogLevel::Info if self.peers[index].role == Role::Observer => {
                self.terminal.say(&message)
            }
            LogLevel::Info => {}
            _ => self.terminal.warn(&format!("{name}: {message}")),
        }
        state.words[index].hear(&message, level == LogLevel::Error);
        // Into the file only. Such lines differ from run to run (the port of a server, say), and
        // recordings of equal runs must be equal.
        let window = self.monitor.common_window().unwrap_or(0);
        self.write_line(level, &name, window, &message)
    }

    /// Writes a line to the log, and shows it to observers.
    pub(super) fn note(
        &mut self,
        level: LogLevel,
        from: &str,
        message: &str,
    ) -> Result<(), OutputError> {
        let window = self.monitor.common_window().unwrap_or(0);
        // What has no place in a run that goes on from a checkpoint under way comes after it: observers
        // hold it back until they have kept their states.
        let after = self.checkpoints.under_way.as_ref().map_or(0, |it| it.window() + 1);
        self.show(window.max(after), level, from, message);
        self.write_line(level, from, window, message)
    }

    /// As [`RunLoop::note`], for a given window: a line that depends on the physics alone must not
    /// depend on the time of the orchestrator's look.
    pub(super) fn note_at(
        &mut self,
        window: u64,
        level: LogLevel,
        from: &str,
        message: &str,
    ) -> Result<(), OutputError> {
        self.show(window, level, from, message);
        self.write_line(level, from, window, message)
    }

    /// Writes a line into the log's file only.
    pub(super) fn write_line(
        &mut self,
        level: LogLevel,
        from: &str,
        window: u64,
        message: &str,
    ) -> Result<(), OutputError> {
        let time = self.clock.seconds(window * self.clock.ticks_per_window);
        self.log.write(level, from, window, time, message)
    }

    /// Shows a line to observers.
    fn show(&self, window: u64, level: LogLevel, from: &str, message: &str) {
        let code = match level {
            LogLevel::Info => LogHeader::INFO,
            LogLevel::Warning => LogHeader::WARNING,
            LogLevel::Error => LogHeader::ERROR,
        };
        let mut header = LogHeader { level: code, ..LogHeader::default() };
        header.stamp.window = window;
        header.stamp.ticks = window * self.clock.ticks_per_window;
        self.control.log(header, &format!("{from}: {message}"));
    }
}
