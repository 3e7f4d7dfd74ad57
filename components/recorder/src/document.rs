//! The document of a file: everything about its run apart from frames.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use tremie_messages::scene::Scene;
use tremie_messages::schedule::Script;
use tremie_messages::start::{Assignment, Clock, FrameContent, FrameStream, Hello, Transport};
use tremie_messages::{INTERFACE_VERSION, Role};
use tremie_sdk::Setup;

/// Name of the metadata record at the file's beginning.
pub const RUN: &str = "tremie.run";
/// Name of the metadata record at the file's end.
pub const END: &str = "tremie.end";
/// Version of the file's form.
pub const FORMAT: &str = "1";

/// A stream, without what differs between identical runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct StreamNote {
    from: String,
    content: FrameContent,
    every: u64,
}

/// The run as its recorder knew it.
#[derive(Clone, Debug, PartialEq)]
pub struct RunNote {
    scene: Scene,
    clock: Clock,
    windows: u64,
    streams: Vec<StreamNote>,
}

impl RunNote {
    /// Of a recorder's setup.
    pub fn new(setup: &Setup, assignment: &Assignment) -> Self {
        let note = |frame: &FrameStream| StreamNote {
            from: frame.from.clone(),
            content: frame.content.clone(),
            every: frame.every,
        };
        Self {
            // Runs of equal scenes have equal recordings, wherever their files are.
            scene: setup.hello.scene.with_copies(),
            clock: assignment.clock,
            windows: assignment.windows,
            streams: assignment.frames.iter().map(note).collect(),
        }
    }

    /// As a metadata record's content.
    pub fn to_map(&self) -> Result<BTreeMap<String, String>, serde_json::Error> {
        let entry = |key: &str, value: String| (key.to_string(), value);
        Ok(BTreeMap::from([
            entry("format", FORMAT.into()),
            entry("version", env!("CARGO_PKG_VERSION").into()),
            entry("scene", serde_json::to_string(&self.scene)?),
            entry("clock", serde_json::to_string(&self.clock)?),
            entry("windows", self.windows.to_string()),
            entry("streams", serde_json::to_string(&self.streams)?),
        ]))
    }

    /// From a metadata record's content.
    pub fn from_map(map: &BTreeMap<String, String>) -> Result<Self, serde_json::Error> {
        let text = |key: &str| map.get(key).map_or("null", String::as_str);
        Ok(Self {
            scene: serde_json::from_str(text("scene"))?,
            clock: serde_json::from_str(text("clock"))?,
            windows: serde_json::from_str(text("windows"))?,
            streams: serde_json::from_str(text("streams"))?,
        })
    }

    /// Ticks and windows.
    pub fn clock(&self) -> Clock {
        self.clock
    }

    /// True if a component sent frames of such a content.
    pub fn sends(&self, from: &str, is_such: impl Fn(&FrameContent) -> bool) -> bool {
        self.streams.iter().any(|stream| stream.from == from && is_such(&stream.content))
    }

    /// True if some component did.
    pub fn has(&self, is_such: impl Fn(&FrameContent) -> bool) -> bool {
        self.streams.iter().any(|stream| is_such(&stream.content))
    }

    /// Setup that an observer named `component` would have got.
    pub fn setup(
        &self,
        component: &str,
        output: &str,
        parameters: serde_json::Map<String, serde_json::Value>,
    ) -> Setup {
        Setup {
            hello: Hello {
                interface: INTERFACE_VERSION,
                run: 0,
                component: component.into(),
                role: Role::Observer,
                scene: self.scene.clone().in_folder(Path::new(output)),
                parameters,
                threads: 1,
                output: output.into(),
            },
            assignment: Some(self.assignment(component)),
        }
    }

    fn assignment(&self, component: &str) -> Assignment {
        let frame = |stream: &StreamNote| FrameStream {
            from: stream.from.clone(),
            to: component.into(),
            content: stream.content.clone(),
            every: stream.every,
            lossless: true,
            service: String::new(),
            capacity: 0,
            depth: 1,
        };
        Assignment {
            clock: self.clock,
            windows: self.windows,
            substeps: 1,
            step: self.clock.window(),
            rows_every: 1,
            body_capacity: 0,
            edges: Vec::new(),
            script: Script::default(),
            watched: Vec::new(),
            frames: self.streams.iter().map(frame).collect(),
            transport: no_transport(),
            injections: Vec::new(),
            resume: None,
            timed: None,
        }
    }
}

/// A file is played back without shared memory.
fn no_transport() -> Transport {
    Transport {
        between_processes: false,
        root: String::new(),
        prefix: String::new(),
        credit_service: String::new(),
        report_service: String::new(),
        report_depth: 1,
        deadline: 0.0,
        poll: 0.0,
    }
}
