//! A recording that goes on from a checkpoint has the bytes of one that was never interrupted.

use std::path::Path;
use tremie_messages::frame::{BodySample, LogHeader, SliceHeader, SliceNode};
use tremie_messages::scene::{Domain, Face, Scene};
use tremie_messages::start::{Clock, FrameContent, FrameStream, Signal};
use tremie_messages::{BodyState, Stamp};
use tremie_recorder::{Recorder, Recording};
use tremie_sdk::{Moment, Observer, Setup};
use tremie_test_support::interrupted::{InterruptedRun, files};
use tremie_test_support::observers::{self, stream};

const LAST: u64 = 150;

fn names() -> Vec<Signal> {
    vec![Signal::new("max_speed", "m/s", &[]), Signal::new("body0 z", "m", &[])]
}

fn setup(output: &Path) -> Setup {
    let scene = Scene::empty(Domain::new([0.0; 3], [0.1, 0.2, 0.3], Face::WALLS));
    let clock = Clock { tick: 1.2e-8, ticks_per_window: 10 };
    let mut setup = observers::setup("recorder", scene, clock, LAST, output);
    let of = |from, content, every| FrameStream { every, ..stream(from, "recorder", content) };
    setup.assignment.as_mut().unwrap().frames = vec![
        of("grains", FrameContent::Bodies, 1),
        of("fluid", FrameContent::Slice("mid".into()), 25),
        of("fluid", FrameContent::Signals(names()), 1),
        stream("orchestrator", "recorder", FrameContent::Log),
    ];
    setup
}

fn moment(window: u64) -> Moment {
    let stamp = Stamp { run: 7, window, ticks: 10 * window, ..Stamp::default() };
    Moment { stamp, time: 1.2e-7 * window as f64 }
}

/// Numbers without pattern, so that compression has something to do.
fn noise(seed: u64, k: u64) -> f64 {
    let mixed = (seed << 32 ^ k).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    (mixed ^ mixed >> 29).wrapping_mul(0xBF58_476D_1CE4_E5B9) as f64 / u64::MAX as f64
}

/// Frames of a window, with so many bodies.
fn feed(recorder: &mut Recorder, window: u64, count: u64) {
    let at = moment(window);
    let body = |id| BodySample {
        state: BodyState::at_rest(id, [noise(window, id), noise(window, id + 7), 0.5]),
        radius: 1e-3,
        mass: 1e-6,
        set: 1,
        shape: 1,
        motion: 0,
        part: 3,
    };
    let bodies: Vec<_> = (0..count).map(body).collect();
    recorder.bodies("grains", at, &bodies).unwrap();
    if window.is_multiple_of(25) {
        let header = SliceHeader { stamp: at.stamp, count: [6, 4], ..SliceHeader::default() };
        let node = |k| SliceNode { pressure: noise(window, k) as f32, ..SliceNode::default() };
        let nodes: Vec<_> = (0..24).map(node).collect();
        recorder.slice("fluid", "mid", at, &header, &nodes).unwrap();
    }
    recorder.signals("fluid", at, &names(), &[noise(window, 99), -0.0]).unwrap();
    if window.is_multiple_of(40) {
        let header = LogHeader { stamp: at.stamp, level: LogHeader::WARNING };
        recorder.log(at, &header, &format!("something at {window}")).unwrap();
    }
}

fn run(home: &Path) -> InterruptedRun<'_, Recorder> {
    InterruptedRun { home, setup: &setup, feed: &|r, window| feed(r, window, 20), last: LAST }
}

#[test]
fn it_goes_on_from_a_checkpoint_before_any_frame_was_in_the_file() {
    let home = tempfile::tempdir().unwrap();
    run(home.path()).assert_goes_on(1, [20, 100]);
}

#[test]
fn it_goes_on_from_a_checkpoint_within_a_chunk_and_right_after_one() {
    let home = tempfile::tempdir().unwrap();
    let run = run(home.path());
    // The second chunk is closed with window 63, which is whole when 65 has come.
    for kept in [64, 65, 66, 100] {
        run.assert_goes_on(kept, [140, kept]);
    }
}

#[test]
fn it_goes_on_from_a_checkpoint_of_the_last_window() {
    let home = tempfile::tempdir().unwrap();
    run(home.path()).assert_goes_on(LAST, [LAST, LAST]);
}

#[test]
fn large_frames_end_their_chunks_where_they_did() {
    let home = tempfile::tempdir().unwrap();
    // Three windows are more than a chunk.
    let feed = |recorder: &mut Recorder, window| feed(recorder, window, 10_000);
    let run = InterruptedRun { home: home.path(), setup: &setup, feed: &feed, last: 12 };
    for kept in [4, 5, 6] {
        run.assert_goes_on(kept, [11, 8]);
    }
}

#[test]
fn a_run_that_came_to_its_end_goes_on_to_a_later_one() {
    let home = tempfile::tempdir().unwrap();
    let until = |windows| {
        move |output: &Path| {
            let mut setup = setup(output);
            setup.assignment.as_mut().unwrap().windows = windows;
            setup
        }
    };
    let feed = |recorder: &mut Recorder, window| feed(recorder, window, 20);
    let (short, long) = (until(70), until(LAST));
    let first = InterruptedRun { home: home.path(), setup: &short, feed: &feed, last: 70 };
    first.killed(70, 70);
    // This one was closed.
    let folder = home.path().join("70-70-kept");
    let run = InterruptedRun { home: home.path(), setup: &long, feed: &feed, last: LAST };
    let mut recorder = run.resume(&folder, 70).unwrap();
    (71..=LAST).for_each(|window| feed(&mut recorder, window));
    recorder.close(LAST).unwrap();
    assert!(files(&folder) == run.whole().0);
}

#[test]
fn a_torn_end_after_the_checkpoint_does_not_matter() {
    let home = tempfile::tempdir().unwrap();
    let run = run(home.path());
    let folder = run.killed(70, 140);
    let path = folder.join("run.mcap");
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() - 100]).unwrap();
    // Nor does what a resumption left that was killed while it wrote the chunks again.
    std::fs::write(folder.join("run.mcap.part"), &bytes[..bytes.len() / 3]).unwrap();
    let mut recorder = run.resume(&folder, 70).unwrap();
    (71..=LAST).for_each(|window| feed(&mut recorder, window, 20));
    recorder.close(LAST).unwrap();
    assert!(files(&folder) == run.whole().0);
}

#[test]
fn a_file_that_is_not_as_it_was_is_named_and_left_alone() {
    let home = tempfile::tempdir().unwrap();
    let run = run(home.path());
    let folder = run.killed(70, 80);
    let path = folder.join("run.mcap");
    let bytes = std::fs::read(&path).unwrap();
    let refused = |content: &[u8]| {
        std::fs::write(&path, content).unwrap();
        let why = run.resume(&folder, 70).map(|_| ()).unwrap_err().to_string();
        assert!(why.contains(&path.display().to_string()), "{why}");
        assert!(std::fs::read(&path).unwrap() == content);
        assert_eq!(files(&folder).len(), 1, "nothing is left beside it");
        why
    };
    let why = refused(&bytes[..bytes.len() / 2]);
    assert!(why.contains("found 0 messages in 1 chunks, expected 131 in 2"), "{why}");
    let why = refused(&vec![7; bytes.len()]);
    assert!(why.contains("not a readable MCAP file"), "{why}");
    let mut damaged = bytes.clone();
    damaged[bytes.len() / 2] ^= 0x55;
    refused(&damaged);
    let other = |output: &Path| {
        let mut setup = setup(output);
        setup.hello.scene.domain.max[0] *= 2.0;
        setup
    };
    std::fs::write(&path, &bytes).unwrap();
    let why = InterruptedRun { setup: &other, ..run }.resume(&folder, 70).map(|_| ()).unwrap_err();
    assert!(why.to_string().contains("found the scene of another run"), "{why}");
    // Users may change what drives a run.
    let changed = |output: &Path| {
        let mut setup = setup(output);
        setup.hello.scene.gravity = [0.0, 0.0, -9.81];
        setup.hello.scene.domain.faces[2][1] = Face::Symmetry;
        setup
    };
    assert!(InterruptedRun { setup: &changed, ..run }.resume(&folder, 70).is_ok());
    std::fs::write(&path, &bytes).unwrap();
    std::fs::remove_file(&path).unwrap();
    let run = self::run(home.path());
    let why = run.resume(&folder, 70).map(|_| ()).unwrap_err().to_string();
    assert!(why.contains(&path.display().to_string()), "{why}");
    assert!(!path.exists());
}

#[test]
fn what_was_recorded_before_and_after_is_read_back() {
    let home = tempfile::tempdir().unwrap();
    let run = run(home.path());
    let folder = run.killed(70, 80);
    let mut recorder = run.resume(&folder, 70).unwrap();
    (71..=LAST).for_each(|window| feed(&mut recorder, window, 20));
    recorder.close(LAST).unwrap();
    let mut items = Recording::open(&folder.join("run.mcap")).unwrap().items();
    let windows: Vec<u64> = items
        .by_ref()
        .filter_map(|item| match item.unwrap() {
            tremie_recorder::Item::Bodies { at, .. } => Some(at.stamp.window),
            _ => None,
        })
        .collect();
    assert!(windows.into_iter().eq(0..=LAST));
    assert!(items.end().complete);
}
