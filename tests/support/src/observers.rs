//! An observer in a run that lives in no shared memory, and a ring of rubber for it to see.

use std::path::Path;
use tremie_sdk::Setup;
use tremie_sdk::messages::scene::{
    DeformableSurface, FacetKind, Pose, Scene, Section, SectionEdge,
};
use tremie_sdk::messages::start::{Assignment, Clock, FrameContent, FrameStream, Hello, Transport};
use tremie_sdk::messages::{INTERFACE_VERSION, Role};

/// Setup of the observer `component` of run 7, without frames or parameters; it writes to `output`.
pub fn setup(component: &str, scene: Scene, clock: Clock, windows: u64, output: &Path) -> Setup {
    let output = output.to_string_lossy().into_owned();
    Setup {
        hello: Hello {
            interface: INTERFACE_VERSION,
            run: 7,
            component: component.into(),
            role: Role::Observer,
            scene,
            parameters: Default::default(),
            threads: 1,
            output: output.clone(),
        },
        assignment: Some(Assignment {
            clock,
            windows,
            substeps: 1,
            step: clock.window(),
            rows_every: 1,
            body_capacity: 0,
            edges: Vec::new(),
            script: Default::default(),
            watched: Vec::new(),
            frames: Vec::new(),
            transport: Transport {
                between_processes: false,
                root: output,
                prefix: String::new(),
                credit_service: String::new(),
                report_service: String::new(),
                report_depth: 1,
                deadline: 1.0,
                poll: 0.0,
            },
            injections: Vec::new(),
            resume: None,
            timed: None,
        }),
    }
}

/// A lossless stream of frames of every window, from one component to another.
pub fn stream(from: &str, to: &str, content: FrameContent) -> FrameStream {
    FrameStream {
        from: from.into(),
        to: to.into(),
        content,
        every: 1,
        lossless: true,
        service: String::new(),
        capacity: 0,
        depth: 1,
    }
}

/// A surface carried by "gate" whose section has these points [m], its first edge on the seat, its
/// third bonded, the others exposed; in `sectors` sectors.
pub fn ring(name: &str, points: &[[f64; 2]], sectors: u32) -> DeformableSurface {
    let count = points.len() as u32;
    let kind = |edge: u32| match edge {
        0 => FacetKind::Seat,
        2 => FacetKind::Bonded,
        _ => FacetKind::Exposed,
    };
    let edge = |k: u32| SectionEdge { points: [k, (k + 1) % count], kind: kind(k) };
    DeformableSurface {
        name: name.into(),
        carrier: "gate".into(),
        table: String::new(),
        pose: Pose::IDENTITY,
        sectors,
        material: "rubber".into(),
        seat_stiffness: 1e9,
        start: Default::default(),
        section: Section { points: points.to_vec(), edges: (0..count).map(edge).collect() },
    }
}
