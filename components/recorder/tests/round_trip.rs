//! Items written through the observer are read back equal, and identical runs give identical files.

use std::path::Path;
use tremie_messages::frame::{BodySample, LogHeader, SliceHeader, SliceNode, SurfaceSample};
use tremie_messages::scene::{Domain, Face, Scene};
use tremie_messages::schedule::Content;
use tremie_messages::start::{Clock, FrameContent, FrameStream, SentChannel, Signal};
use tremie_messages::{BodyState, Stamp, SurfaceVertex};
use tremie_recorder::{End, Item, ReadError, Recorder, Recording};
use tremie_sdk::{Moment, Observer, Setup};
use tremie_test_support::observers::{self, stream};
use tremie_test_support::until;

fn names() -> Vec<Signal> {
    let signal = |name: &str, unit: &str| Signal::new(name, unit, &[]);
    vec![signal("max_speed", "m/s"), signal("body0 z", "m")]
}

fn setup(output: &Path, run: u64) -> Setup {
    let scene = Scene {
        gravity: [0.0, 0.0, -9.81],
        ..Scene::empty(Domain::new([0.0; 3], [0.1, 0.2, 0.3], Face::WALLS))
    };
    let clock = Clock { tick: 1.2e-8, ticks_per_window: 10 };
    let mut setup = observers::setup("recorder", scene, clock, 100, output);
    (setup.hello.run, setup.hello.threads) = (run, run as u32);
    let of = |from, content| FrameStream {
        service: format!("run-{run}"),
        ..stream(from, "recorder", content)
    };
    setup.assignment.as_mut().unwrap().frames = vec![
        of("grains", FrameContent::Bodies),
        of("fluid", FrameContent::Slice("mid/plane".into())),
        of("fluid", FrameContent::Signals(names())),
    ];
    setup
}

fn moment(window: u64) -> Moment {
    let stamp =
        Stamp { run: 0, window, ticks: 10 * window, events: window, substep: 3, iteration: 0 };
    Moment { stamp, time: 1.2e-7 * window as f64 }
}

/// Numbers without pattern, so that compression is not flattered.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
}

fn bodies(window: u64, count: u64) -> Item {
    let mut x = noise(window + 1);
    let body = |id| BodySample {
        state: BodyState {
            id: id << 33,
            position: std::array::from_fn(|_| x()),
            orientation: [0.0, 0.0, 0.0, 1.0],
            velocity: std::array::from_fn(|_| x() * 1e-3),
            angular_velocity: std::array::from_fn(|_| x()),
        },
        radius: 1e-3,
        mass: 1e-6,
        set: 1,
        shape: 1,
        motion: 0,
        part: 3,
    };
    Item::Bodies {
        from: "grains".into(),
        at: moment(window),
        bodies: (0..count).map(body).collect(),
    }
}

fn slice(window: u64, count: [u64; 2]) -> Item {
    let mut x = noise(window + 1000);
    let at = moment(window);
    let header = SliceHeader {
        stamp: at.stamp,
        origin: [0.1, 0.2, 1.0 / 3.0],
        step: [[1e-3, 0.0, 1e-9], [0.0, 1e-3 / 7.0, 0.0]],
        count,
    };
    let node = |k| SliceNode {
        velocity: std::array::from_fn(|_| x() as f32),
        pressure: x() as f32,
        fill: 0.25 * (k % 4) as f32,
        solid: u32::from(k % 5 == 0),
        density: 1.0 + k as f32,
        level: (k % 7) as u32,
    };
    let nodes = (0..count[0] * count[1]).map(node).collect();
    Item::Slice { from: "fluid".into(), name: "mid/plane".into(), at, header, nodes }
}

fn signals(window: u64) -> Item {
    let mut x = noise(window + 2000);
    Item::Signals {
        from: "fluid".into(),
        at: moment(window),
        names: names(),
        values: vec![x(), -0.0],
    }
}

fn line(window: u64) -> Item {
    let at = moment(window);
    let header = LogHeader { stamp: at.stamp, level: LogHeader::WARNING };
    Item::Log { at, header, text: format!("something at {window}") }
}

/// Items of whole windows in the order in which they are written.
fn run(windows: u64) -> Vec<Item> {
    (0..=windows).flat_map(|w| [bodies(w, 20), slice(w, [6, 4]), signals(w)]).collect()
}

fn write(output: &Path, run: u64, items: &[Item], last: u64) -> String {
    let mut recorder = Recorder::open(&setup(output, run)).unwrap();
    for item in items {
        item.tell(&mut recorder).unwrap();
    }
    recorder.close(last).unwrap()
}

fn read(output: &Path) -> (Vec<Item>, End) {
    let mut items = Recording::open(&output.join("run.mcap")).unwrap().items();
    let all = items.by_ref().map(Result::unwrap).collect();
    (all, items.end())
}

#[test]
fn what_was_written_is_read_back_equal() {
    let folder = tempfile::tempdir().unwrap();
    let mut items = run(50);
    items.push(line(50));
    let note = write(folder.path(), 1, &items, 50);
    assert!(note.contains("153 frames up to window 50"), "{note}");
    let (back, end) = read(folder.path());
    assert_eq!(back, items);
    assert_eq!(end, End { last_common_window: 50, time: end.time, complete: true });
}

#[test]
fn deformable_surfaces_come_back_too() {
    let folder = tempfile::tempdir().unwrap();
    let mut x = noise(7);
    let mut sample = || SurfaceSample {
        vertex: SurfaceVertex {
            position: std::array::from_fn(|_| x()),
            velocity: std::array::from_fn(|_| x()),
        },
        strain: x(),
    };
    let mut surfaces = |window| Item::Surfaces {
        from: "rubber".into(),
        at: moment(window),
        samples: (0..30).map(|_| sample()).collect(),
    };
    let items: Vec<_> =
        (0..=5).flat_map(|w| [bodies(w, 3), surfaces(w), slice(w, [6, 4]), signals(w)]).collect();
    write(folder.path(), 1, &items, 5);
    assert_eq!(read(folder.path()).0, items);
}

#[test]
fn hashes_and_messages_come_back_too() {
    let folder = tempfile::tempdir().unwrap();
    let channel = |content| SentChannel { content, to: "fluid".into() };
    let hashes = |window: u64| Item::Hashes {
        from: "grains".into(),
        at: moment(window),
        channels: vec![channel(Content::Events), channel(Content::State)],
        rows: vec![2 * window, 0, u64::MAX, 2 * window + 1, window << 40, 7],
    };
    let message = |window: u64, content, values: &[u8]| {
        let at = moment(window);
        // Messages inside a window have times of their own.
        let time = setup(folder.path(), 1).assignment.unwrap().clock.seconds(at.stamp.ticks);
        let (at, values) = (Moment { time, ..at }, values.to_vec());
        Item::Message { from: "grains".into(), at, channel: channel(content), values }
    };
    let window = |w| {
        let state = [1_u64, w].map(u64::to_le_bytes).concat();
        let first = [bodies(w, 3), slice(w, [6, 4]), signals(w), hashes(w)];
        let then = [message(w, Content::Events, &[]), message(w, Content::State, &state)];
        first.into_iter().chain(then)
    };
    let items: Vec<_> = (0..=5).flat_map(window).collect();
    write(folder.path(), 1, &items, 5);
    assert_eq!(read(folder.path()).0, items);

    let bytes = std::fs::read(folder.path().join("run.mcap")).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let schema = |topic: &str| {
        let mut channels = summary.channels.values();
        let channel = channels.find(|channel| channel.topic == topic).unwrap();
        channel.schema.as_ref().unwrap().name.clone()
    };
    assert_eq!(schema("/hashes/grains"), "tremie.hashes.grains");
    assert_eq!(schema("/messages/grains/state/fluid"), "tremie.Message");
}

#[test]
fn identical_runs_give_identical_files() {
    let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let items = run(30);
    write(a.path(), 1, &items, 30);
    // Another run id, another folder, and frames of each window in another order.
    let mut shuffled = items.clone();
    shuffled.chunks_mut(3).for_each(|window| window.reverse());
    write(b.path(), 2, &shuffled, 30);
    let bytes = |folder: &Path| std::fs::read(folder.join("run.mcap")).unwrap();
    assert!(bytes(a.path()) == bytes(b.path()));
}

#[test]
fn windows_beyond_the_last_common_one_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let mut items = run(8);
    items.extend([bodies(9, 20), bodies(10, 20), line(9)]);
    let note = write(folder.path(), 1, &items, 8);
    assert!(note.contains("2 windows beyond"), "{note}");
    let (back, end) = read(folder.path());
    assert_eq!(back[..27], run(8)[..]);
    assert_eq!(back[27..], [line(9)], "the log is kept whole");
    assert_eq!(end.last_common_window, 8);
}

#[test]
fn a_stream_that_ends_does_not_hold_up_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let mut recorder = Recorder::open(&setup(folder.path(), 1)).unwrap();
    let tell = |item: &Item, recorder: &mut Recorder| item.tell(recorder).unwrap();
    run(9).iter().for_each(|item| tell(item, &mut recorder));
    // From here on the signals are missing.
    let rest: Vec<_> = (10..500).flat_map(|w| [bodies(w, 20), slice(w, [6, 4])]).collect();
    rest.iter().for_each(|item| tell(item, &mut recorder));
    // A thread behind the recorder writes, when it comes to it.
    let path = folder.path().join("run.mcap");
    let written = || std::fs::metadata(&path).unwrap().len();
    until("frames are written though no signals come", || written() > 100_000);
    let note = recorder.close(499).unwrap();
    assert!(note.contains("426 windows written before all their frames had come"), "{note}");
    let (back, end) = read(folder.path());
    assert_eq!(back[..30], run(9)[..]);
    assert_eq!(back[30..], rest[..]);
    assert!(end.complete);
}

#[test]
fn what_a_killed_recorder_wrote_can_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let mut recorder = Recorder::open(&setup(folder.path(), 1)).unwrap();
    let items = run(150);
    items.iter().for_each(|item| item.tell(&mut recorder).unwrap());
    // A killed process runs no destructors.
    std::mem::forget(recorder);
    let path = folder.path().join("run.mcap");
    // Whenever it was killed: what can be read is a beginning of the run.
    until("the file has all closed chunks", || {
        let Ok(recording) = Recording::open(&path) else { return false };
        let back: Vec<_> = recording.items().map(Result::unwrap).collect();
        assert_eq!(back[..], items[..back.len()]);
        back.len() >= 3 * 128
    });
    let (back, end) = read(folder.path());
    assert_eq!(back.len(), 3 * 128, "the chunk that is open has not come to the file");
    assert_eq!(end, End { last_common_window: 127, time: end.time, complete: false });
    // And of a file cut off anywhere, the whole chunks before.
    let bytes = std::fs::read(&path).unwrap();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("run.mcap"), &bytes[..bytes.len() * 3 / 4]).unwrap();
    let (cut, end) = read(folder.path());
    assert!(cut.len() >= 3 * 64 && cut[..] == items[..cut.len()]);
    assert!(!end.complete);
}

#[test]
fn the_setup_is_restored() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 7, &run(3), 3);
    let recording = Recording::open(&folder.path().join("run.mcap")).unwrap();
    let original = setup(folder.path(), 7);
    let restored = recording.setup("viewer", folder.path(), Default::default());
    assert_eq!(restored.hello.scene, original.hello.scene);
    let (a, b) = (restored.assignment.unwrap(), original.assignment.unwrap());
    assert_eq!((a.clock, a.windows), (b.clock, b.windows));
    assert_eq!(a.frames[1].content, b.frames[1].content);
}

#[test]
fn a_recording_played_to_a_recorder_is_the_same_recording() {
    let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    write(a.path(), 1, &run(5), 5);
    let recording = Recording::open(&a.path().join("run.mcap")).unwrap();
    let mut recorder =
        Recorder::open(&recording.setup("recorder", b.path(), Default::default())).unwrap();
    let end = recording.replay(&mut recorder).unwrap();
    recorder.close(end.last_common_window).unwrap();
    let bytes = |folder: &Path| std::fs::read(folder.join("run.mcap")).unwrap();
    assert!(bytes(a.path()) == bytes(b.path()));
}

#[test]
fn other_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    std::fs::write(&path, b"this is not an MCAP file at all").unwrap();
    assert!(matches!(Recording::open(&path), Err(ReadError::Mcap(_))));
    assert!(matches!(Recording::open(&folder.path().join("none")), Err(ReadError::Io(_))));
}

#[test]
fn the_file_is_indexed_and_its_schemas_decode() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 1, &run(20), 20);
    let bytes = std::fs::read(folder.path().join("run.mcap")).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let topics: Vec<_> = {
        let mut topics: Vec<_> = summary.channels.values().map(|c| c.topic.as_str()).collect();
        topics.sort_unstable();
        topics
    };
    assert_eq!(
        topics,
        ["/bodies/grains", "/cuts/fluid/mid/plane", "/frames", "/log", "/signals/fluid"]
    );
    assert_eq!(summary.stats.unwrap().message_count, 2 * 3 * 21);
    if let Some(path) = std::env::var_os("TREMIE_RECORDER_DEMO") {
        std::fs::copy(folder.path().join("run.mcap"), path).unwrap();
    }
}

#[test]
fn size_of_a_frame() {
    let folder = tempfile::tempdir().unwrap();
    let items: Vec<_> =
        (0..20).flat_map(|w| [bodies(w, 5000), slice(w, [160, 100]), signals(w)]).collect();
    write(folder.path(), 1, &items, 19);
    let bytes = std::fs::metadata(folder.path().join("run.mcap")).unwrap().len();
    let per_frame = bytes as f64 / 20.0 / 1e6;
    println!("{per_frame:.3} MB a frame of 5,000 grains and 16,000 nodes of pure noise");
    assert!(per_frame < 0.9);
}
