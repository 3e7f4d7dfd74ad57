//! Streams of frames to observers: contents, sender, interval and depth.

use super::Described;
use crate::manifest::{ComponentSpec, ORCHESTRATOR};
use tremie_messages::Role;
use tremie_messages::frame::{MessageHead, SliceNode};
use tremie_messages::schedule::{Content, Edge};
use tremie_messages::start::{
    Description, FrameContent, FrameStream, RunCoupling, SentChannel, VolumeGrid, VolumeWish,
    Watches,
};

/// Frames under way to an observer that must have each: room for a disk that is slow for a moment.
const LOSSLESS_DEPTH: u64 = 8;
/// Frames under way to an observer that shows the newest: one being read, one to come.
const LOSSY_DEPTH: u64 = 2;
/// Volumes under way: one being read, one to come. More would fill the memory.
const VOLUME_DEPTH: u64 = 1;
/// Lines of the log under way.
const LOG_DEPTH: u64 = 256;
/// Longest line of the log [bytes].
const LOG_LINE: u64 = 4096;

/// Least and greatest length of a piece of copied messages [bytes].
const MESSAGES_PIECE: [u64; 2] = [16 << 10, 1 << 20];

/// Most values that frames of the whole scene hold.
#[derive(Clone, Copy)]
pub(super) struct Room {
    /// Bodies.
    pub bodies: u64,
    /// Vertices of deformable surfaces.
    pub vertices: u64,
}

/// All streams that observers want; physics in the order of `components`, then those of the
/// orchestrator. `every`: windows between frames of a content to an observer.
pub(super) fn streams(
    components: &[Described<'_>],
    room: Room,
    (edges, coupling): (&[Edge], &RunCoupling),
    every: impl Fn(&ComponentSpec, &FrameContent) -> u64,
) -> Vec<FrameStream> {
    let is_observer = |c: &&Described<'_>| c.0.role == Role::Observer;
    let observers: Vec<_> = components.iter().filter(is_observer).collect();
    let mut streams = Vec::new();
    for (spec, description) in components.iter().filter(|c| !is_observer(c)) {
        for (observer, wishes) in &observers {
            let mut contents = contents(spec.role, description, &wishes.watches, room);
            if description.tells_messages && observer.lossless {
                contents.extend(of_messages(&spec.name, &wishes.watches, edges));
            }
            for (name, content, capacity) in contents {
                let every = every(observer, &content);
                streams.push(stream(&spec.name, observer, &name, content, every, capacity));
            }
        }
    }
    for (observer, _) in observers.iter().filter(|(_, wishes)| wishes.watches.timings) {
        let content = FrameContent::Timings(coupling.clone());
        let (every, room) = (every(observer, &content), coupling.components.len().max(1) as u64);
        streams.push(stream(ORCHESTRATOR, observer, "timings", content, every, room));
    }
    for (observer, _) in observers.iter().filter(|(_, wishes)| wishes.watches.log) {
        streams.push(stream(ORCHESTRATOR, observer, "log", FrameContent::Log, 1, LOG_LINE));
    }
    streams
}

/// Notes on the size of volumes that an observer keeps, and warnings for wished regions without
/// nodes.
pub(super) fn notes(
    components: &[Described<'_>],
    streams: &[FrameStream],
    windows: u64,
) -> (Vec<String>, Vec<String>) {
    let (mut notes, mut warnings) = (Vec::new(), Vec::new());
    for (observer, description) in components {
        let Some(wish) = &description.watches.volumes else { continue };
        for stream in streams.iter().filter(|s| s.to == observer.name && s.lossless) {
            if let FrameContent::Volume(grid) = &stream.content {
                notes.push(volume_note(stream, grid, windows));
            }
        }
        for volume in components.iter().flat_map(|(_, physics)| &physics.volumes) {
            if VolumeGrid::new(volume, wish).is_none() {
                let VolumeWish { region, .. } = wish;
                warnings.push(format!(
                    "{}: no node of the volume \"{}\" lies in the region {region:?} m",
                    observer.name, volume.name
                ));
            }
        }
    }
    (notes, warnings)
}

fn volume_note(stream: &FrameStream, grid: &VolumeGrid, windows: u64) -> String {
    let [nx, ny, nz] = grid.count;
    // At the start, every so many windows, and at the end.
    let frames = 1 + windows.div_ceil(stream.every);
    let frame = grid.nodes() * size_of::<SliceNode>() as u64;
    format!(
        "{} takes {frames} frames of {nx} x {ny} x {nz} nodes from {}: {} each, {} in all before compression",
        stream.to,
        stream.from,
        super::report::bytes(frame),
        super::report::bytes(frame * frames),
    )
}

/// Contents that a component sends to an observer: part of the service's name, content, most values
/// in a frame.
fn contents(
    role: Role,
    description: &Description,
    watches: &Watches,
    room: Room,
) -> Vec<(String, FrameContent, u64)> {
    let mut contents = Vec::new();
    if role == Role::Grains && watches.bodies {
        // At least one: shared memory is never of size zero.
        contents.push(("bodies".to_string(), FrameContent::Bodies, room.bodies.max(1)));
    }
    if role == Role::Grains && watches.loads && description.tells_loads {
        contents.push(("loads".to_string(), FrameContent::Loads, room.bodies.max(1)));
    }
    if role == Role::Rubber && watches.surfaces {
        let content = FrameContent::Surfaces;
        contents.push(("surfaces".to_string(), content, room.vertices.max(1)));
    }
    for slice in description.slices.iter().filter(|_| watches.slices) {
        let content = FrameContent::Slice(slice.name.clone());
        contents.push((format!("slice/{}", slice.name), content, slice.nodes.max(1)));
    }
    for profile in description.profiles.iter().filter(|_| watches.profiles) {
        let content = FrameContent::Profile(profile.name.clone());
        contents.push((format!("profile/{}", profile.name), content, profile.bins.max(1)));
    }
    for volume in &description.volumes {
        let grid = watches.volumes.as_ref().and_then(|wish| VolumeGrid::new(volume, wish));
        if let Some(grid) = grid {
            let (name, nodes) = (format!("volume/{}", volume.name), grid.nodes());
            contents.push((name, FrameContent::Volume(grid), nodes));
        }
    }
    if !description.signals.is_empty() && watches.signals {
        let signals = description.signals.clone();
        let count = signals.len() as u64;
        contents.push(("signals".to_string(), FrameContent::Signals(signals), count));
    }
    contents
}

/// Hashes and copies of the messages of a component: as [`contents`].
fn of_messages(
    component: &str,
    watches: &Watches,
    edges: &[Edge],
) -> Vec<(String, FrameContent, u64)> {
    let channels = SentChannel::of_sender(component, edges);
    let mut contents = Vec::new();
    if channels.is_empty() {
        return contents;
    }
    if watches.hashes {
        // Where a run goes on at another rate, rows of before come with those of a whole frame.
        let rows = 2 * FrameContent::MOST_HASHED_WINDOWS;
        let capacity = rows * (1 + channels.len() as u64);
        contents.push(("hashes".into(), FrameContent::Hashes(channels.clone()), capacity));
    }
    if watches.messages {
        let own = edges.iter().filter(|edge| edge.from == component);
        let [least, most] = MESSAGES_PIECE;
        let piece = own.map(message_bytes).fold(0, u64::saturating_add).clamp(least, most);
        contents.push(("messages".into(), FrameContent::Messages(channels), piece));
    }
    contents
}

/// Most bytes of a copied message of an edge.
fn message_bytes(edge: &Edge) -> u64 {
    let (_, value) = edge.content.value_type();
    edge.capacity.saturating_mul(value as u64).saturating_add(size_of::<MessageHead>() as u64)
}

/// Trials of a substep that are assumed where their number is not known: a rubber makes as many as it
/// takes.
const ASSUMED_TRIALS: u64 = 4;

/// Most bytes that copies of a component's messages take in a window, as far as that is known.
pub(crate) fn copied_bytes(component: &str, edges: &[Edge]) -> u64 {
    let own = edges.iter().filter(|edge| edge.from == component);
    let of = |edge: &Edge| {
        let substeps = u64::from(edge.sender_substeps);
        let count = match edge.content {
            Content::Carrier | Content::Resultant => substeps,
            Content::Trial | Content::Contact => ASSUMED_TRIALS * substeps,
            _ => 1,
        };
        message_bytes(edge).saturating_mul(count)
    };
    own.map(of).fold(0, u64::saturating_add)
}

fn stream(
    from: &str,
    to: &ComponentSpec,
    name: &str,
    content: FrameContent,
    every: u64,
    capacity: u64,
) -> FrameStream {
    let depth = match content {
        FrameContent::Log => LOG_DEPTH,
        FrameContent::Volume(_) => VOLUME_DEPTH,
        _ if to.lossless => LOSSLESS_DEPTH,
        _ => LOSSY_DEPTH,
    };
    FrameStream {
        from: from.to_string(),
        to: to.name.clone(),
        content,
        every,
        lossless: to.lossless,
        service: format!("{from}/frames/{name}/{}", to.name),
        capacity,
        depth,
    }
}
