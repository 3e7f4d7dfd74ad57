//! The plan as text for a person and as JSON for programs.

use super::{Plan, PlannedComponent, PlannedWatch, REPORT_DEPTH, watches};
use serde_json::{Value, json};
use std::fmt;
use tremie_channels::memory;
use tremie_messages::control::{Credit, Report};
use tremie_messages::finding::short;
use tremie_messages::schedule::{Edge, Schedule};
use tremie_messages::start::{FrameContent, FrameStream, Transport};
use tremie_messages::{Stamp, frame};
use tremie_results::text_columns;
use tremie_sdk::{credit_spec, edge_spec, frame_spec, report_spec};

impl Plan {
    /// The plan in lines: time, components, edges, frames, notes. Warnings are apart, in
    /// [`Plan::warnings`].
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![self.time()];
        lines.extend(text_columns(
            &["component", "role", "program", "substeps", "step", "threads"],
            self.components.iter().map(row).collect(),
        ));
        for component in &self.components {
            lines
                .extend(component.notes.iter().map(|note| format!("  {}: {note}", component.name)));
        }
        lines.extend(text_columns(
            &["edge", "values", "depth", "memory"],
            self.edges.iter().map(edge_row).collect(),
        ));
        lines.extend(text_columns(
            &["frames", "every", "values", "depth", "kept", "memory"],
            self.frames.iter().map(frame_row).collect(),
        ));
        if !self.watches.is_empty() {
            let rows = self.watches.iter().map(PlannedWatch::row).collect();
            lines.extend(text_columns(&watches::HEADS, rows));
        }
        lines.push(format!("shared memory: {}", bytes(self.shared_memory())));
        lines.extend(self.notes.iter().map(|note| format!("note: {note}")));
        lines
    }

    /// The plan for programs.
    pub fn document(&self) -> Value {
        let component = |c: &PlannedComponent| {
            json!({
                "name": c.name, "role": c.role, "program": c.program, "substeps": c.substeps,
                "step": c.step, "largest_step": c.largest_step, "threads": c.threads, "notes": c.notes,
            })
        };
        let watch = |watch: &PlannedWatch| {
            json!({
                "signal": watch.name(), "quantity": watch.quantity, "from": watch.watched.from,
                "limit": watch.watched.limit,
            })
        };
        json!({
            "window": self.window,
            "windows": self.windows,
            "tick": self.clock.tick,
            "ticks_per_window": self.clock.ticks_per_window,
            "schedule": self.schedule,
            "frames_every": self.frames_every,
            "signal_rows_every": self.signal_rows_every,
            "shared_memory": self.shared_memory(),
            "components": self.components.iter().map(component).collect::<Vec<_>>(),
            "watches": self.watches.iter().map(watch).collect::<Vec<_>>(),
            "notes": self.notes,
        })
    }

    /// Shared memory of all channels and bells between processes, in bytes: all that a run sets
    /// aside before its first message.
    pub fn shared_memory(&self) -> u64 {
        let bells = self.components.len() as u64 * memory::of_bell();
        self.channels().fold(bells, u64::saturating_add)
    }

    /// Shared memory of the channel that takes most, in bytes.
    pub fn largest_channel(&self) -> u64 {
        self.channels().max().unwrap_or(0)
    }

    fn channels(&self) -> impl Iterator<Item = u64> {
        let edges = self.edges.iter().map(edge_memory);
        let all = edges.chain(self.frames.iter().map(frame_memory));
        let reported = |component: &PlannedComponent| {
            control_memory(component.signals + component.values_of_places())
        };
        all.chain(self.components.iter().flat_map(reported))
    }

    fn time(&self) -> String {
        let schedule = match self.schedule {
            Schedule::Serial => "serial",
            Schedule::Parallel => "parallel",
        };
        format!(
            "{} s in {} windows of {} s ({} tick{} each), schedule {schedule}",
            short(self.window * self.windows as f64),
            self.windows,
            short(self.window),
            self.clock.ticks_per_window,
            if self.clock.ticks_per_window == 1 { "" } else { "s" },
        )
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for line in self.lines() {
            writeln!(f, "{line}")?;
        }
        for warning in &self.warnings {
            writeln!(f, "warning: {warning}")?;
        }
        Ok(())
    }
}

fn row(component: &PlannedComponent) -> Vec<String> {
    let physics = component.role != tremie_messages::Role::Observer;
    let if_physics = |text: String| if physics { text } else { "-".into() };
    vec![
        component.name.clone(),
        component.role.to_string(),
        component.program.clone(),
        if_physics(component.substeps.to_string()),
        if_physics(format!("{} s", short(component.step))),
        component.threads.map_or("auto".into(), |threads| threads.to_string()),
    ]
}

fn edge_row(edge: &Edge) -> Vec<String> {
    vec![edge.label(), edge.capacity.to_string(), edge.depth.to_string(), bytes(edge_memory(edge))]
}

fn frame_row(stream: &FrameStream) -> Vec<String> {
    let content = match &stream.content {
        FrameContent::Bodies => "bodies".to_string(),
        FrameContent::Surfaces => "surfaces".to_string(),
        FrameContent::Loads => "loads".to_string(),
        FrameContent::Timings(_) => "timings".to_string(),
        FrameContent::Slice(name) => format!("slice {name}"),
        FrameContent::Volume(grid) => format!("volume {}", grid.name),
        FrameContent::Profile(name) => format!("profile {name}"),
        FrameContent::Signals(_) => "signals".to_string(),
        FrameContent::Hashes(_) => "hashes".to_string(),
        FrameContent::Messages(_) => "messages".to_string(),
        FrameContent::Log => "log".to_string(),
    };
    let every = match stream.content {
        FrameContent::Log => "line".to_string(),
        _ if stream.every == 1 => "window".to_string(),
        _ => format!("{} windows", stream.every),
    };
    vec![
        format!("{} -> {}, {content}", stream.from, stream.to),
        every,
        stream.capacity.to_string(),
        stream.depth.to_string(),
        if stream.lossless { "all" } else { "newest" }.to_string(),
        bytes(frame_memory(stream)),
    ]
}

fn edge_memory(edge: &Edge) -> u64 {
    let (_, value) = edge.content.value_type();
    memory::of_channel(size_of::<Stamp>(), value, edge_spec(edge))
}

/// Credit to a component, and its reports.
fn control_memory(signals: usize) -> [u64; 2] {
    let transport = Transport { report_depth: REPORT_DEPTH, ..Transport::default() };
    let reports = report_spec(&transport, signals);
    [
        memory::of_channel(size_of::<Stamp>(), size_of::<Credit>(), credit_spec("")),
        memory::of_channel(size_of::<Report>(), size_of::<f64>(), reports),
    ]
}

fn frame_memory(stream: &FrameStream) -> u64 {
    let (header, value) = match stream.content {
        FrameContent::Bodies => (size_of::<Stamp>(), size_of::<frame::BodySample>()),
        FrameContent::Surfaces => (size_of::<Stamp>(), size_of::<frame::SurfaceSample>()),
        FrameContent::Loads => (size_of::<Stamp>(), size_of::<frame::LoadSample>()),
        FrameContent::Timings(_) => {
            (size_of::<frame::TimingHeader>(), size_of::<frame::ComponentTiming>())
        }
        FrameContent::Slice(_) => (size_of::<frame::SliceHeader>(), size_of::<frame::SliceNode>()),
        FrameContent::Volume(_) => {
            (size_of::<frame::VolumeHeader>(), size_of::<frame::SliceNode>())
        }
        FrameContent::Profile(_) => {
            (size_of::<frame::ProfileHeader>(), size_of::<frame::ProfileBin>())
        }
        FrameContent::Signals(_) => (size_of::<Stamp>(), size_of::<f64>()),
        FrameContent::Hashes(_) => (size_of::<Stamp>(), size_of::<u64>()),
        FrameContent::Messages(_) => (size_of::<frame::MessagesHeader>(), size_of::<u8>()),
        FrameContent::Log => (size_of::<frame::LogHeader>(), size_of::<u8>()),
    };
    memory::of_channel(header, value, frame_spec(stream))
}

/// A number of bytes as a person would write it.
pub(crate) fn bytes(count: u64) -> String {
    match count {
        0..1_000 => format!("{count} B"),
        1_000..1_000_000 => format!("{:.1} kB", count as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", count as f64 / 1e6),
        _ => format!("{:.1} GB", count as f64 / 1e9),
    }
}
