//! The tab "Coupling" of a synthetic run: what arrives in the recording.

use rerun::external::arrow::array::{Array, Float64Array, UInt64Array};
use rerun::external::re_log_encoding::DecoderApp;
use rerun::external::re_log_types::LogMsg;
use rerun::log::Chunk;
use std::path::Path;
use tremie_messages::frame::{BodySample, ComponentTiming, LoadSample, TimingHeader};
use tremie_messages::scene::{
    BodySet, Diameters, Domain, Face, FluidMaterial, Motion, Packing, Placement, Scene,
};
use tremie_messages::schedule::{Content, Schedule};
use tremie_messages::start::{
    Clock, CoupledComponent, CoupledExchange, FrameContent, RunCoupling, Signal,
};
use tremie_messages::{BodyEvent, BodyState, Role, Stamp};
use tremie_sdk::{Moment, Observer, Setup};
use tremie_test_support::observers::{self, stream};
use tremie_viewer::Viewer;

const GRAINS: u64 = 300;
const FRAMES: u64 = 40;
/// Wall time of a window [ns].
const WINDOW: u64 = 5_000_000;

fn scene() -> Scene {
    let grains = BodySet {
        name: "sand".into(),
        density: 2500.0,
        material: "sand".into(),
        motion: Motion::Free,
        clump: None,
        placement: Placement::Packed(Packing {
            min: [0.0; 3],
            max: [0.02; 3],
            fraction: 0.1,
            diameters: Diameters::Uniform { min: 1e-3, max: 1e-3 },
            seed: 1,
        }),
    };
    Scene {
        gravity: [0.0, 0.0, -9.81],
        fluid: Some(FluidMaterial::at_rest(1000.0, 0.02)),
        bodies: vec![grains],
        ..Scene::empty(Domain::new([0.0; 3], [0.02; 3], Face::WALLS))
    }
}

fn plan() -> RunCoupling {
    let own = |name: &str, role, substeps| CoupledComponent { name: name.into(), role, substeps };
    let sent = |from, to, content, delay| CoupledExchange { from, to, content, delay };
    RunCoupling {
        schedule: Schedule::Serial,
        components: vec![own("fluid", Role::Fluid, 1), own("grains", Role::Grains, 20)],
        exchanges: vec![sent(1, 0, Content::State, 0), sent(0, 1, Content::Load, 1)],
    }
}

fn signals() -> [(&'static str, Vec<Signal>); 2] {
    let signal = |name: &str, unit: &str| Signal::new(name, unit, &[]);
    [
        ("fluid", vec![signal("impulse_delivered_z", "N s"), signal("floor.force_z", "N")]),
        ("grains", vec![signal("impulse_received_z", "N s"), signal("max_speed", "m/s")]),
    ]
}

/// A run that is recorded at `path`, with more parameters.
fn setup(path: &Path, more: serde_json::Value) -> Setup {
    let clock = Clock { tick: 1e-4, ticks_per_window: 1 };
    let mut setup = observers::setup("viewer", scene(), clock, FRAMES, path.parent().unwrap());
    let mut parameters = serde_json::json!({"mode": "file", "file": path});
    parameters.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    setup.hello.parameters = serde_json::from_value(parameters).unwrap();
    let frames = &mut setup.assignment.as_mut().unwrap().frames;
    frames
        .extend(signals().map(|(from, list)| stream(from, "viewer", FrameContent::Signals(list))));
    frames.push(stream("grains", "viewer", FrameContent::Loads));
    frames.push(stream("orchestrator", "viewer", FrameContent::Timings(plan())));
    setup
}

fn place(id: u64) -> [f64; 3] {
    [7, 31, 57].map(|m| 0.02 * ((id * m) % 97) as f64 / 97.0)
}

fn loads(window: u64) -> Vec<LoadSample> {
    let of = |id: u64| LoadSample {
        id,
        position: place(id),
        fluid: [0.0, 0.0, 1e-5 * (1.0 + 0.1 * (0.3 * window as f64 + id as f64).sin())],
        contact: if id < 100 { [0.0, 0.0, 2e-5] } else { [0.0; 3] },
        shape: BodyEvent::SPHERE,
        set: 0,
    };
    (0..GRAINS).map(of).collect()
}

fn timing(windows: u64, compute: u64) -> ComponentTiming {
    let exchange = WINDOW / 100;
    let wait = WINDOW - compute - exchange;
    let [compute, exchange, wait] = [compute, exchange, wait].map(|each| each * windows);
    ComponentTiming { windows, compute, wait, exchange, work: 0 }
}

/// Records the run; of every third window the grains' signals are lost.
fn record(setup: &Setup) {
    let mut viewer = Viewer::open(setup).unwrap();
    let [fluid, grains] = signals();
    for window in 0..FRAMES {
        let stamp = Stamp { run: 7, window, ticks: window, ..Stamp::default() };
        let at = Moment { stamp, time: 1e-4 * window as f64 };
        let body = |id: u64| BodySample {
            state: BodyState::at_rest(1000 + id, place(id)),
            radius: 5e-4,
            mass: 1e-6,
            set: 0,
            shape: BodyEvent::SPHERE,
            motion: BodyEvent::FREE,
            part: 0,
        };
        viewer.bodies("grains", at, &(0..GRAINS).map(body).collect::<Vec<_>>()).unwrap();
        viewer.loads("grains", at, &loads(window)).unwrap();
        let ringing = if window % 2 == 0 { 1.0 } else { 0.5 };
        viewer.signals("fluid", at, &fluid.1, &[1e-9 * window as f64, ringing]).unwrap();
        if window % 3 > 0 {
            let received = 1e-9 * (window as f64 - 1.0);
            viewer.signals("grains", at, &grains.1, &[received, 0.1]).unwrap();
        }
        let header = TimingHeader { stamp, elapsed: WINDOW * window };
        let timings = [timing(window, 4_000_000), timing(window, 500_000)];
        viewer.timings(at, &plan(), &header, &timings).unwrap();
    }
    viewer.close(FRAMES - 1).unwrap();
}

/// All values of a component of an entity, one list for each row that has some.
fn rows<A: Array + Clone + 'static>(path: &Path, entity: &str, component: &str) -> Vec<A> {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut found = Vec::new();
    for message in DecoderApp::decode_eager(file).unwrap() {
        let LogMsg::ArrowMsg(store, arrow) = message.unwrap() else { continue };
        let chunk = Chunk::from_arrow_msg(&arrow).unwrap();
        if !store.is_recording() || chunk.entity_path().to_string() != entity {
            continue;
        }
        for (descriptor, column) in chunk.components().iter() {
            if descriptor.to_string().contains(component) {
                let list = &column.list_array;
                let own = (0..list.len()).filter(|k| list.is_valid(*k)).map(|k| list.value(k));
                found.extend(own.filter_map(|values| values.as_any().downcast_ref::<A>().cloned()));
            }
        }
    }
    found
}

fn scalars(path: &Path, entity: &str) -> Vec<f64> {
    let rows: Vec<Float64Array> = rows(path, entity, "scalars");
    rows.iter().map(|row| row.value(0)).collect()
}

/// Numbers of values of a component in the rows of an entity.
fn lengths(path: &Path, entity: &str, component: &str) -> Vec<usize> {
    use rerun::external::arrow::array::FixedSizeListArray;
    let rows: Vec<FixedSizeListArray> = rows(path, entity, component);
    rows.iter().map(Array::len).collect()
}

#[test]
fn loads_and_wall_time_and_impulse_arrive() {
    let folder = tempfile::tempdir().unwrap();
    // Set this variable to keep the recording and look at it.
    let kept = std::env::var_os("TREMIE_COUPLING_DEMO").map(std::path::PathBuf::from);
    let path = kept.unwrap_or_else(|| folder.path().join("run.rrd"));
    record(&setup(&path, serde_json::json!({"followed": [7, 250], "tab": "coupling"})));
    // All have a load of the fluid, the first hundred touch something.
    assert_eq!(lengths(&path, "/scene/loads/fluid", "vectors"), [300; 40]);
    assert_eq!(lengths(&path, "/scene/loads/contact", "vectors"), [100; 40]);
    assert_eq!(scalars(&path, "/coupling/followed/250/contact"), [0.0; 40]);
    let followed = scalars(&path, "/coupling/followed/7/contact");
    assert!(followed.iter().all(|force| (force - 2e-5).abs() < 1e-10), "{followed:?}");
    // Stacked, in milliseconds of a window.
    for (line, expected) in [("compute", 4.0), ("exchange", 4.05), ("wait", 5.0)] {
        let times = scalars(&path, &format!("/coupling/time/fluid/{line}"));
        assert_eq!(times.len(), 39);
        assert!(times.iter().all(|time| (time - expected).abs() < 1e-9), "{times:?}");
    }
    let rate = scalars(&path, "/coupling/windows_per_second");
    assert!(rate.iter().all(|rate| (rate - 200.0).abs() < 1e-9), "{rate:?}");
    // A window whose other side was lost is left out.
    let on_the_way = scalars(&path, "/coupling/impulse_on_the_way");
    assert_eq!(on_the_way.len(), 26);
    assert!(on_the_way.iter().all(|impulse| (impulse - 1e-9).abs() < 1e-15), "{on_the_way:?}");
    assert_eq!(lengths(&path, "/coupling/schedule/advances", "centers"), [6]);
}

#[test]
fn a_force_that_rings_has_a_mean_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    record(&setup(&path, serde_json::json!({})));
    let means = scalars(&path, "/signals/fluid/floor.force_z/mean");
    assert_eq!(means.len(), 25);
    assert!(means.iter().all(|mean| (mean - 0.75).abs() < 1e-12), "{means:?}");
}

#[test]
fn bodies_carry_their_ids() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    record(&setup(&path, serde_json::json!({})));
    let ids: Vec<UInt64Array> = rows(&path, "/scene/bodies/sand", "id");
    assert_eq!(ids.len(), 1, "sent once, as nobody comes or goes");
    assert_eq!(ids[0].values()[..3], [1000, 1001, 1002]);
}

#[test]
fn few_arrows_and_a_fixed_scale_where_they_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    let parameters = serde_json::json!({"loads": ["fluid"], "load_arrows": 100, "max_load": "1 N"});
    record(&setup(&path, parameters));
    // Forces far below the end of a fixed scale would be dots.
    assert_eq!(lengths(&path, "/scene/loads/fluid", "vectors"), [0; 40]);
    let other = folder.path().join("other.rrd");
    record(&setup(&other, serde_json::json!({"loads": ["fluid"], "load_arrows": 100})));
    assert_eq!(lengths(&other, "/scene/loads/fluid", "vectors"), [100; 40]);
    assert!(lengths(&other, "/scene/loads/contact", "vectors").is_empty());
}

#[test]
fn without_the_tab_nothing_of_it_arrives() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    let setup = setup(&path, serde_json::json!({"coupling": false}));
    let watches = Viewer::describe(&setup).unwrap().watches;
    assert!(!watches.loads && !watches.timings);
    record(&setup);
    assert!(lengths(&path, "/scene/loads/fluid", "vectors").is_empty());
    assert!(scalars(&path, "/coupling/windows_per_second").is_empty());
    assert!(scalars(&path, "/coupling/impulse_on_the_way").is_empty());
}
