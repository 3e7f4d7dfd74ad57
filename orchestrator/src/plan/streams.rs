//! Frames: what observers are sent, by whom, how often.

use crate::manifest::{ComponentSpec, ORCHESTRATOR};
use tremie_messages::Role;
use tremie_messages::start::{Description, FrameContent, FrameStream};

/// Frames under way to an observer that must have each: room for a disk that is slow for a moment.
const LOSSLESS_DEPTH: u64 = 8;
/// Frames under way to an observer that shows the newest: one being read, one to come.
const LOSSY_DEPTH: u64 = 2;
/// Lines of the log under way.
const LOG_DEPTH: u64 = 256;
/// Longest line of the log [bytes].
const LOG_LINE: u64 = 4096;

/// All streams to all observers; physics in the order of `components`, then the log.
pub(super) fn streams(
    components: &[(&ComponentSpec, &Description)],
    body_capacity: u64,
    every: u64,
) -> Vec<FrameStream> {
    let is_observer = |c: &&(&ComponentSpec, &Description)| c.0.role == Role::Observer;
    let observers: Vec<_> = components.iter().filter(is_observer).map(|(spec, _)| *spec).collect();
    let mut streams = Vec::new();
    for (spec, description) in components.iter().filter(|c| !is_observer(c)) {
        for observer in &observers {
            for (name, content, capacity) in contents(spec.role, description, body_capacity) {
                streams.push(stream(&spec.name, observer, &name, content, every, capacity));
            }
        }
    }
    for observer in observers {
        let log = stream(ORCHESTRATOR, observer, "log", FrameContent::Log, 1, LOG_LINE);
        streams.push(FrameStream { depth: LOG_DEPTH, ..log });
    }
    streams
}

/// What a component sends: a part of the service's name, the content, most values in a frame.
fn contents(
    role: Role,
    description: &Description,
    bodies: u64,
) -> Vec<(String, FrameContent, u64)> {
    let mut contents = Vec::new();
    if role == Role::Grains {
        contents.push(("bodies".to_string(), FrameContent::Bodies, bodies.max(1)));
    }
    for slice in &description.slices {
        let content = FrameContent::Slice(slice.name.clone());
        contents.push((format!("slice/{}", slice.name), content, slice.nodes.max(1)));
    }
    if !description.signals.is_empty() {
        let signals = description.signals.clone();
        let count = signals.len() as u64;
        contents.push(("signals".to_string(), FrameContent::Signals(signals), count));
    }
    contents
}

fn stream(
    from: &str,
    to: &ComponentSpec,
    name: &str,
    content: FrameContent,
    every: u64,
    capacity: u64,
) -> FrameStream {
    FrameStream {
        from: from.to_string(),
        to: to.name.clone(),
        content,
        every,
        lossless: to.lossless,
        service: format!("{from}/frames/{name}/{}", to.name),
        capacity,
        depth: if to.lossless { LOSSLESS_DEPTH } else { LOSSY_DEPTH },
    }
}
