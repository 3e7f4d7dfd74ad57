//! The observer.

use crate::codec::{encode_bodies, encode_grid, encode_nodes, encode_vertices};
use crate::document::RunNote;
use crate::entry::{Entry, exchange_entries, topic};
use crate::file::{Columns, Extent, McapFile};
use crate::hashes::encode_hashes;
use crate::parameters::Parameters;
use crate::proto::{Frame, Level, Log, WholeMessage, timestamp};
use crate::resumption::Beginning;
use crate::signals::{bytes, encode};
use crate::windows::{Progress, Stream};
use std::collections::BTreeMap;
use tremie_messages::frame::{BodySample, LogHeader, SliceHeader, SliceNode, SurfaceSample};
use tremie_messages::start::{Clock, Description, SentChannel, Signal, Watches};
use tremie_messages::{INTERFACE_VERSION, Problem};
use tremie_sdk::state::{KeepsState, StateError, StateExchange};
use tremie_sdk::{AsObserver, ControlPipe, CopiedMessage, Moment, Observer, ObserverError, Setup};

/// Most windows that wait to become whole. Coupled components are a few windows apart and a stream
/// holds a few frames: in good order this is never reached, and a file of equal runs stays equal.
const MOST_WAITING: usize = 64;

/// Version of the recorder's states.
const STATE_VERSION: u32 = 2;

/// Writes a run to MCAP.
pub struct Recorder {
    /// `None` once it is closed, and before the state is put back of a run that goes on.
    file: Option<McapFile>,
    beginning: Beginning,
    name: String,
    clock: Clock,
    progress: Progress,
    names: BTreeMap<Stream, Vec<Signal>>,
    hashed: BTreeMap<Stream, Vec<SentChannel>>,
    waiting: BTreeMap<u64, BTreeMap<Stream, Vec<Entry>>>,
    lines: Vec<Entry>,
    written: Option<u64>,
    frames: u64,
    /// Windows that were written although frames of them were missing.
    partial: u64,
}

const CLOSED: &str = "the recording is closed";

fn closed() -> ObserverError {
    ObserverError::Other(CLOSED.into())
}

/// Simulated time [ns]; files know no other.
fn nanoseconds(at: Moment) -> u64 {
    (at.time * 1e9).round() as u64
}

/// The frame of a moment. The run's id stays out: it differs between identical runs.
fn frame(at: Moment, stream: Option<&Stream>) -> Frame {
    let stamp = at.stamp;
    Frame {
        timestamp: Some(timestamp(nanoseconds(at))),
        topic: topic(stream),
        window: stamp.window,
        ticks: stamp.ticks,
        events: stamp.events,
        substep: stamp.substep,
        iteration: stamp.iteration,
        time: at.time,
        level: 0,
        grid: None,
    }
}

/// What a stream's channel says of its messages, from what is known of all streams.
fn columns_of<'a>(
    names: &'a BTreeMap<Stream, Vec<Signal>>,
    hashed: &'a BTreeMap<Stream, Vec<SentChannel>>,
    stream: &Stream,
) -> Columns<'a> {
    Columns {
        signals: names.get(stream).map_or(&[], Vec::as_slice),
        channels: hashed.get(stream).map_or(&[], Vec::as_slice),
    }
}

impl Recorder {
    /// Takes a message of a stream.
    fn take_of(&mut self, stream: Stream, at: Moment, data: Vec<u8>) -> Result<(), ObserverError> {
        let frame = frame(at, Some(&stream));
        self.take(stream, &frame, nanoseconds(at), data)
    }

    /// Keeps a message until its window is whole, and writes windows that became whole.
    fn take(
        &mut self,
        stream: Stream,
        frame: &Frame,
        time: u64,
        data: Vec<u8>,
    ) -> Result<(), ObserverError> {
        let window = frame.window;
        self.progress.arrived(&stream, window);
        self.keep(stream, frame, time, data);
        self.write_due()
    }

    /// Keeps a message until its window is whole.
    fn keep(&mut self, stream: Stream, frame: &Frame, time: u64, data: Vec<u8>) {
        let entry = Entry::new(Some(stream.clone()), frame, time, data);
        self.waiting.entry(frame.window).or_default().entry(stream).or_default().push(entry);
    }

    /// Writes windows that became whole.
    fn write_due(&mut self) -> Result<(), ObserverError> {
        while let Some((window, entries)) = self.next_due() {
            self.write(window, entries)?;
        }
        Ok(())
    }

    /// The oldest waiting window, if it is whole, or if too many wait: a stream that has ended must
    /// not make all others pile up.
    fn next_due(&mut self) -> Option<(u64, BTreeMap<Stream, Vec<Entry>>)> {
        let waiting = self.waiting.len();
        let first = self.waiting.first_entry()?;
        let is_whole = self.progress.is_whole(*first.key());
        if !is_whole && waiting <= MOST_WAITING {
            return None;
        }
        self.partial += u64::from(!is_whole);
        Some(first.remove_entry())
    }

    /// Writes a window. Channels are added here and not on arrival, so that their order is that of
    /// the streams and not that of chance.
    fn write(
        &mut self,
        window: u64,
        entries: BTreeMap<Stream, Vec<Entry>>,
    ) -> Result<(), ObserverError> {
        let file = self.file.as_mut().ok_or_else(closed)?;
        let failed = |error| ObserverError::output(&self.beginning.path, &error);
        for (stream, entries) in entries {
            let columns = columns_of(&self.names, &self.hashed, &stream);
            self.frames += entries.len() as u64;
            for entry in entries {
                file.write(entry, columns).map_err(failed)?;
            }
        }
        self.written = Some(window);
        file.end_window().map_err(failed)
    }
}

impl Observer for Recorder {
    const PROGRAM: &'static str = concat!("recorder ", env!("CARGO_PKG_VERSION"));

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        let parameters = setup.parameters::<Parameters>()?;
        parameters.check()?;
        Ok(Description {
            interface: INTERFACE_VERSION,
            program: Self::PROGRAM.into(),
            state: Some(STATE_VERSION),
            watches: Watches {
                surfaces: true,
                hashes: true,
                messages: parameters.messages,
                ..Watches::default()
            },
            ..Description::default()
        })
    }

    fn open(setup: &Setup) -> Result<Self, ObserverError> {
        let parameters: Parameters = setup.parameters()?;
        parameters.check()?;
        let assignment = setup.assigned()?;
        let path = parameters.path(&setup.hello.output);
        let run = RunNote::new(setup, assignment).to_map();
        let run = run.map_err(|error| ObserverError::Other(error.to_string()))?;
        let mut beginning = Beginning { path, level: parameters.compression, run };
        let file = if setup.goes_on() { None } else { Some(beginning.create()?) };
        Ok(Self {
            file,
            beginning,
            name: parameters.file.display().to_string(),
            clock: assignment.clock,
            progress: Progress::new(&assignment.frames),
            names: BTreeMap::new(),
            hashed: BTreeMap::new(),
            waiting: BTreeMap::new(),
            lines: Vec::new(),
            written: None,
            frames: 0,
            partial: 0,
        })
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let Self { file, beginning, names, hashed, progress, waiting, lines, .. } = self;
        let mut reached = match file {
            _ if state.restores() => Extent::default(),
            Some(file) => file.extent(),
            None => return state.unfit(CLOSED),
        };
        if let Some(file) = file.as_ref().filter(|_| !state.restores()) {
            state.relies_on(beginning.on_disk(file.pieces()));
        }
        state.value("file", &mut reached)?;
        let open = file.iter().flat_map(McapFile::open_entries);
        let open = exchange_entries(state, "open", open)?;
        let entries = waiting.values().flat_map(BTreeMap::values).flatten();
        let entries = exchange_entries(state, "waiting", entries)?;
        let log = exchange_entries(state, "log", lines.iter())?;
        state.value("signals", names)?;
        state.value("hashed", hashed)?;
        state.within("progress", |state| progress.exchange_state(state))?;
        state.value("written", &mut self.written)?;
        state.value("frames", &mut self.frames)?;
        state.value("partial", &mut self.partial)?;
        if state.restores() {
            *lines = log;
            waiting.clear();
            for entry in entries {
                let Some(stream) = entry.stream.clone() else { continue };
                let window = waiting.entry(entry.window).or_default();
                window.entry(stream).or_default().push(entry);
            }
            let columns = |stream: &Stream| columns_of(names, hashed, stream);
            *file = Some(beginning.resume(&reached, open, columns)?);
        }
        Ok(())
    }

    fn bodies(
        &mut self,
        from: &str,
        at: Moment,
        bodies: &[BodySample],
    ) -> Result<(), ObserverError> {
        let stream = Stream::Bodies(from.into());
        self.take_of(stream, at, bytes(&encode_bodies(nanoseconds(at), bodies)))
    }

    fn surfaces(
        &mut self,
        from: &str,
        at: Moment,
        samples: &[SurfaceSample],
    ) -> Result<(), ObserverError> {
        let stream = Stream::Surfaces(from.into());
        self.take_of(stream, at, bytes(&encode_vertices(nanoseconds(at), samples)))
    }

    fn slice(
        &mut self,
        from: &str,
        name: &str,
        at: Moment,
        header: &SliceHeader,
        nodes: &[SliceNode],
    ) -> Result<(), ObserverError> {
        let stream = Stream::Cut(from.into(), name.into());
        let time = nanoseconds(at);
        let data = bytes(&encode_nodes(time, header, nodes));
        let frame = Frame { grid: Some(encode_grid(header)), ..frame(at, Some(&stream)) };
        self.take(stream, &frame, time, data)
    }

    fn signals(
        &mut self,
        from: &str,
        at: Moment,
        names: &[Signal],
        values: &[f64],
    ) -> Result<(), ObserverError> {
        let stream = Stream::Signals(from.into());
        if !self.names.contains_key(&stream) {
            self.names.insert(stream.clone(), names.to_vec());
        }
        self.take_of(stream, at, encode(nanoseconds(at), values))
    }

    fn hashes(
        &mut self,
        from: &str,
        at: Moment,
        channels: &[SentChannel],
        rows: &[u64],
    ) -> Result<(), ObserverError> {
        let stream = Stream::Hashes(from.into());
        if !self.hashed.contains_key(&stream) {
            self.hashed.insert(stream.clone(), channels.to_vec());
        }
        self.take_of(stream, at, encode_hashes(nanoseconds(at), channels.len(), rows))
    }

    fn messages(
        &mut self,
        from: &str,
        at: Moment,
        channels: &[SentChannel],
        messages: &[CopiedMessage<'_>],
    ) -> Result<(), ObserverError> {
        for CopiedMessage { channel, stamp, values } in messages {
            let Some(channel) = channels.get(*channel) else { continue };
            let stream = Stream::of_channel(from, channel);
            let at = Moment { stamp: *stamp, time: self.clock.seconds(stamp.ticks) };
            let time = nanoseconds(at);
            let (name, size) = channel.content.value_type();
            let whole = WholeMessage {
                timestamp: Some(timestamp(time)),
                r#type: name.into(),
                count: (values.len() / size) as u64,
                values: values.to_vec(),
            };
            let frame = frame(at, Some(&stream));
            self.keep(stream, &frame, time, bytes(&whole));
        }
        // Also of channels without a message in this window.
        for channel in channels {
            self.progress.arrived(&Stream::of_channel(from, channel), at.stamp.window);
        }
        self.write_due()
    }

    fn log(&mut self, at: Moment, header: &LogHeader, text: &str) -> Result<(), ObserverError> {
        let level = match header.level {
            LogHeader::ERROR => Level::Error,
            LogHeader::WARNING => Level::Warning,
            _ => Level::Info,
        };
        let time = nanoseconds(at);
        let line = Log {
            timestamp: Some(timestamp(time)),
            level: level.into(),
            message: text.into(),
            name: "tremie".into(),
        };
        let frame = Frame { level: header.level, ..frame(at, None) };
        self.lines.push(Entry::new(None, &frame, time, bytes(&line)));
        Ok(())
    }

    fn close(&mut self, last_common_window: u64) -> Result<String, ObserverError> {
        let beyond = self.waiting.split_off(&(last_common_window + 1));
        for (window, entries) in std::mem::take(&mut self.waiting) {
            self.write(window, entries)?;
        }
        let mut file = self.file.take().ok_or_else(closed)?;
        let failed = |error| ObserverError::output(&self.beginning.path, &error);
        for line in std::mem::take(&mut self.lines) {
            file.write(line, Columns::default()).map_err(failed)?;
        }
        file.finish(last_common_window).map_err(failed)?;
        let dropped = match beyond.len() {
            0 => String::new(),
            n => format!(", {n} windows beyond the last common one left out"),
        };
        let partial = match self.partial {
            0 => String::new(),
            n => format!(", {n} windows written before all their frames had come"),
        };
        Ok(format!(
            "{}: {} frames up to window {}{dropped}{partial}",
            self.name,
            self.frames,
            self.written.unwrap_or(0)
        ))
    }
}

/// Takes part in a run, over `line`.
///
/// # Errors
/// A sentence for standard error.
pub fn run(line: ControlPipe) -> Result<(), String> {
    tremie_sdk::run::<AsObserver<Recorder>>(line)
}
