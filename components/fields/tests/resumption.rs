//! Files of a run that goes on from a checkpoint are those of one that was never interrupted.

use std::path::Path;
use tremie_fields::Fields;
use tremie_messages::frame::{BodySample, SliceNode, VolumeHeader};
use tremie_messages::scene::{Domain, Face, Geometry, Motion, Part, PartBoundary, Pose, Scene};
use tremie_messages::start::{Clock, FrameContent, FrameStream, VolumeGrid};
use tremie_messages::{BodyEvent, BodyState, Stamp};
use tremie_sdk::{Moment, Observer, Setup};
use tremie_test_support::interrupted::{InterruptedRun, files};
use tremie_test_support::observers::{self, stream};

const LAST: u64 = 40;

fn setup(output: &Path) -> Setup {
    let part = Part {
        name: "gate".into(),
        geometry: Geometry::Box { size: [0.2, 0.1, 0.1] },
        pose: Pose { position: [0.5, 0.5, 0.5], ..Pose::IDENTITY },
        cavity: false,
        material: "steel".into(),
        motion: Motion::Prescribed(Vec::new()),
        boundary: PartBoundary::Wall,
    };
    let domain = Domain::new([0.0; 3], [1.0; 3], Face::WALLS);
    let scene = Scene { parts: vec![part], ..Scene::empty(domain) };
    let clock = Clock { tick: 1e-3, ticks_per_window: 1 };
    let mut setup = observers::setup("fields", scene, clock, LAST, output);
    let grid = VolumeGrid { name: "lattice".into(), first: [0; 3], stride: 1, count: [3, 2, 4] };
    let of = |from, content| FrameStream { every: 5, ..stream(from, "fields", content) };
    setup.assignment.as_mut().unwrap().frames =
        vec![of("fluid", FrameContent::Volume(grid)), of("grains", FrameContent::Bodies)];
    setup
}

/// The gate rises from window 10 to window 20.
fn gate(window: u64) -> BodySample {
    let height = 0.5 + 0.01 * window.clamp(10, 20) as f64 - 0.1;
    let rises = (11..20).contains(&window);
    let at = BodyState::at_rest(99, [0.5, 0.5, height]);
    BodySample {
        state: BodyState { velocity: [0.0, 0.0, if rises { 10.0 } else { 0.0 }], ..at },
        radius: 0.1,
        mass: 1.0,
        set: 0,
        shape: BodyEvent::PART,
        motion: BodyEvent::PRESCRIBED,
        part: 0,
    }
}

/// Every fifth window has frames; those of the lattice begin with window 10.
fn feed(fields: &mut Fields, window: u64) {
    if !window.is_multiple_of(5) {
        return;
    }
    let stamp = Stamp { run: 7, window, ticks: window, ..Stamp::default() };
    let at = Moment { stamp, time: 1e-3 * window as f64 };
    if window >= 10 {
        let (origin, step) = ([0.05, 0.1, -1e-9], [0.1, 0.25, 1.0 / 3.0]);
        let header = VolumeHeader { stamp, origin, step, count: [3, 2, 4] };
        let node = |k: u64| SliceNode { pressure: (k + window) as f32, ..SliceNode::default() };
        let nodes: Vec<_> = (0..24).map(node).collect();
        fields.volume("fluid", "lattice", at, &header, &nodes).unwrap();
    }
    let sphere = |id| BodySample {
        state: BodyState::at_rest(id, [0.01 * window as f64, id as f64, 0.0]),
        shape: BodyEvent::SPHERE,
        ..gate(window)
    };
    fields.bodies("grains", at, &[sphere(1), sphere(2), gate(window)]).unwrap();
}

fn run(home: &Path) -> InterruptedRun<'_, Fields> {
    InterruptedRun { home, setup: &setup, feed: &feed, last: LAST }
}

#[test]
fn series_go_on_where_the_checkpoint_was() {
    let home = tempfile::tempdir().unwrap();
    // Before the lattice, before and while the gate moves, when it rests again, at the end.
    for kept in [1, 5, 10, 17, 32, LAST] {
        run(home.path()).assert_goes_on(kept, [37.max(kept), 26.max(kept)]);
    }
}

#[test]
fn what_is_later_is_gone_and_what_is_not_ours_stays() {
    let home = tempfile::tempdir().unwrap();
    let run = run(home.path());
    let folder = run.killed(7, 22);
    let within = folder.join("fields");
    for name in ["notes_000099.txt", "other_000099.vtp", "bodies_000025.part", "view.pvd"] {
        std::fs::write(within.join(name), "x").unwrap();
    }
    drop(run.resume(&folder, 7).unwrap());
    let found: Vec<String> = files(&within).into_keys().collect();
    assert_eq!(
        found,
        [
            "about.txt",
            "bodies.pvd",
            "bodies_000000.vtp",
            "bodies_000005.vtp",
            "notes_000099.txt",
            "other_000099.vtp",
            "parts.pvd",
            "parts_000000.vtp",
            "view.pvd",
        ]
    );
    let series = std::fs::read_to_string(within.join("bodies.pvd")).unwrap();
    assert_eq!(series.matches("<DataSet").count(), 2);
}

#[test]
fn a_file_that_is_missing_or_cut_is_told() {
    let home = tempfile::tempdir().unwrap();
    let run = run(home.path());
    let folder = run.killed(12, 22);
    let why = || run.resume(&folder, 12).map(|_| ()).unwrap_err().to_string();
    let path = folder.join("fields/lattice_000010.vti");
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..100]).unwrap();
    let told = why();
    assert!(told.contains("lattice_000010.vti holds 100 bytes, expected the "), "{told}");
    std::fs::remove_file(&path).unwrap();
    let told = why();
    assert!(told.contains("without ") && told.contains("lattice_000010.vti"), "{told}");
    std::fs::write(&path, &bytes).unwrap();
    std::fs::remove_file(folder.join("fields/about.txt")).unwrap();
    let told = why();
    assert!(told.contains("about.txt"), "{told}");
    assert!(folder.join("fields/bodies_000020.vtp").exists(), "nothing was removed");
}
