//! Memory, shared memory and disk that the run needs, against those of the machine.

use super::Machine;
use crate::manifest::Spec;
use crate::plan::{Plan, bytes, copied_bytes};
use tremie_channels::memory::SHARED_MEMORY;
use tremie_messages::Finding;
use tremie_messages::Role;
use tremie_messages::frame::{BodySample, LoadSample, ProfileBin, SliceNode, SurfaceSample};
use tremie_messages::scene::{BodySizes, Scene};
use tremie_messages::start::{Description, FrameContent, FrameStream};

/// Fraction of the free amount up to which a run is not doubtful.
const COMFORT: f64 = 0.8;
/// Bytes of a number in the table of signals, with its comma; rarely more.
const WRITTEN_NUMBER: u64 = 20;

/// Resident set of a process of the run by itself [bytes]: for the most part pages of the program,
/// which all processes share.
const PROCESS: u64 = 14_000_000;
/// Memory of a listed body: in the manifest, with the source positions of its values, and in each
/// component [bytes].
const LISTED: u64 = 3_400;
const TOLD: u64 = 700;
/// A listed body in the scene that a run's folder holds [bytes].
const KEPT: u64 = 200;

/// Memory, shared memory and disk that the run takes, as far as that is known.
pub(super) fn findings(
    spec: &Spec,
    plan: &Plan,
    descriptions: &[Description],
    machine: &Machine,
) -> Vec<Finding> {
    let scene = &spec.scene;
    let shared = plan.shared_memory();
    let need = memory(scene, descriptions) + shared;
    // Doubtful against the free memory, wrong only against all of it: other programs may end.
    let memory = within("memory", need, machine.available).wrong_if(
        machine.memory.is_some_and(|memory| need > memory),
        format!(
            "the run takes {}, and the machine has {}",
            bytes(need),
            bytes(machine.memory.unwrap_or(0))
        ),
        "a larger cell, a smaller domain, or precision = \"f32\" where the fluid offers it",
    );
    let keep = u64::from(spec.run.checkpoints.keep);
    let state =
        if keep > 0 && plan.can_be_kept(descriptions) { states(plan, descriptions) } else { 0 };
    // One more while the newest is written, and one that a watchdog asks for.
    let more = if plan.watches.is_empty() { 1 } else { 2 };
    let kept = if state > 0 { (keep + more).saturating_mul(state) } else { 0 };
    let at_checkpoint =
        (state > 0).then(|| within("memory at a checkpoint", need + state, machine.available));
    let mut all = vec![
        memory,
        within("shared memory", shared, machine.shared).wrong_if(
            machine.shared.is_some_and(|room| shared > room),
            format!(
                "the run takes {}, and {} of {SHARED_MEMORY} are free",
                bytes(shared),
                bytes(machine.shared.unwrap_or(0))
            ),
            "make it larger (mount -o remount,size=.. /dev/shm; docker run --shm-size=..), send frames of fewer values, or use --in-process",
        ),
        within(
            "disk, at most",
            disk(plan, descriptions).saturating_add(kept + listed(scene) * KEPT),
            machine.disk,
        ),
    ];
    all.splice(1..1, at_checkpoint);
    all
}

/// Most bytes that the states of the physics take: it can hardly be more than their memory.
fn states(plan: &Plan, descriptions: &[Description]) -> u64 {
    let physics = plan.components.iter().zip(descriptions);
    physics.filter(|(c, _)| c.role != Role::Observer).map(|(_, d)| d.memory).sum()
}

/// Memory of all processes, without shared memory [bytes].
fn memory(scene: &Scene, descriptions: &[Description]) -> u64 {
    let own: u64 = descriptions.iter().map(|description| description.memory).sum();
    let components = descriptions.len() as u64;
    // One process more: the orchestrator.
    own + (components + 1) * PROCESS + listed(scene) * (LISTED + components * TOLD)
}

/// Number of bodies that the scene lists one by one.
fn listed(scene: &Scene) -> u64 {
    let sizes = scene.bodies.iter().map(|set| set.placement.sizes());
    let listed = |sizes| match sizes {
        BodySizes::Listed(diameters) => diameters.len() as u64,
        BodySizes::Packed(_) => 0,
    };
    sizes.map(listed).sum()
}

/// A number of bytes, judged by what there is room for.
fn within(quantity: &str, need: u64, room: Option<u64>) -> Finding {
    let finding = Finding::new(quantity, need as f64, "B");
    let Some(room) = room else {
        return finding.because(format!("{}; how much is free is not known", bytes(need)));
    };
    let tight = need as f64 > COMFORT * room as f64;
    let remedy = match quantity {
        "memory" => "close other programs, or take a larger cell or a smaller domain",
        "memory at a checkpoint" => {
            "make no checkpoints (run.checkpoints.keep = 0), or take a larger cell or a smaller domain"
        }
        "shared memory" => "make /dev/shm larger, or send frames of fewer values",
        _ => {
            "make room, write fewer frames (outputs.frames) and rows (outputs.signals), no messages (outputs.messages), keep fewer checkpoints (run.checkpoints.keep), or choose another --out"
        }
    };
    finding.because(format!("{} of {} that are free", bytes(need), bytes(room))).doubtful_if(
        tight,
        format!("{}, and only {} are free", bytes(need), bytes(room)),
        remedy,
    )
}

/// Most bytes that outputs take: frames of lossless observers without compression, and the table of
/// signals.
fn disk(plan: &Plan, descriptions: &[Description]) -> u64 {
    let kept = plan.frames.iter().filter(|stream| stream.lossless);
    let frames = kept.map(|stream| frames_bytes(plan, stream));
    let physics =
        plan.components.iter().zip(descriptions).filter(|(c, _)| c.role != Role::Observer);
    let columns: u64 = physics.map(|(_, description)| description.signals.len() as u64).sum();
    let rows = plan.windows.div_ceil(plan.signal_rows_every.max(1)) + 1;
    frames.fold(rows.saturating_mul((columns + 2) * WRITTEN_NUMBER), u64::saturating_add)
}

/// Most bytes that the frames of a stream take without compression.
fn frames_bytes(plan: &Plan, stream: &FrameStream) -> u64 {
    let value = match &stream.content {
        FrameContent::Bodies => size_of::<BodySample>(),
        FrameContent::Surfaces => size_of::<SurfaceSample>(),
        FrameContent::Loads => size_of::<LoadSample>(),
        FrameContent::Slice(_) | FrameContent::Volume(_) => size_of::<SliceNode>(),
        // Text and binary.
        FrameContent::Profile(_) => 3 * size_of::<ProfileBin>(),
        FrameContent::Signals(_) => size_of::<f64>(),
        FrameContent::Timings(_) | FrameContent::Log => 0,
        // Of each window, and of the start exchange; how many fit a frame does not matter.
        FrameContent::Hashes(channels) => {
            let row = (1 + channels.len() as u64) * size_of::<u64>() as u64;
            return (plan.windows + 1).saturating_mul(row);
        }
        FrameContent::Messages(_) => {
            return (plan.windows + 1).saturating_mul(copied_bytes(&stream.from, &plan.edges));
        }
    };
    // The start exchange is one more, and the last window has a frame and a row whenever it comes.
    let count = plan.windows.div_ceil(stream.every.max(1)) + 1;
    count.saturating_mul(stream.capacity.saturating_mul(value as u64))
}
