//! A synthetic run shown by the viewer: what arrives in the recording, and how big it gets.

use rerun::external::arrow::array::Array;
use rerun::external::re_log_encoding::DecoderApp;
use rerun::external::re_log_types::LogMsg;
use rerun::log::Chunk;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use tremie_geometry::Turned;
use tremie_messages::frame::{
    BodySample, LogHeader, ProfileBin, ProfileHeader, SliceHeader, SliceNode, SurfaceSample,
    VolumeHeader,
};
use tremie_messages::scene::{
    BinnedAxis, BodySet, DeformableSurface, Diameters, Domain, Face, FluidMaterial, Geometry,
    GrainProfile, Motion, Packing, Part, PartBoundary, Placement, Pose, ProfileVelocity, Scene,
};
use tremie_messages::start::{Clock, FrameContent, FrameStream, Signal, VolumeGrid};
use tremie_messages::{BodyEvent, BodyState, Stamp, SurfaceVertex};
use tremie_sdk::{Moment, Observer, Setup};
use tremie_test_support::observers::{self, stream};
use tremie_viewer::Viewer;

const SIZE: [f64; 3] = [0.04, 0.012, 0.025];
const DIAMETER: f64 = 0.6e-3;

fn scene() -> Scene {
    let set = |name: &str, motion, fraction| BodySet {
        name: name.into(),
        density: 2500.0,
        material: name.into(),
        motion,
        clump: None,
        placement: Placement::Packed(Packing {
            min: [0.0; 3],
            max: SIZE,
            fraction,
            diameters: Diameters::Uniform { min: DIAMETER, max: DIAMETER },
            seed: 1,
        }),
    };
    let walls = || [Face::WALL, Face::WALL];
    let faces = [walls(), [Face::Periodic, Face::Periodic], walls()];
    Scene {
        gravity: [0.0, 0.0, -9.81],
        fluid: Some(FluidMaterial {
            expected_speed: Some(0.1),
            ..FluidMaterial::at_rest(970.0, 0.373)
        }),
        bodies: vec![set("sand", Motion::Free, 0.2), set("gate post", Motion::Fixed, 0.01)],
        ..Scene::empty(Domain::new([0.0; 3], SIZE, faces))
    }
}

fn signals() -> [(&'static str, Vec<Signal>); 2] {
    let signal = |name: &str, unit: &str| Signal::new(name, unit, &[]);
    [
        (
            "fluid",
            vec![
                signal("max_speed", "m/s"),
                signal("kinetic_energy", "J"),
                signal("momentum_gap", "N s"),
            ],
        ),
        (
            "grains",
            vec![
                signal("max_speed", "m/s"),
                signal("mean_speed", "m/s"),
                signal("mean_height", "m"),
            ],
        ),
    ]
}

fn setup(output: &Path, parameters: serde_json::Value) -> Setup {
    let clock = Clock { tick: 1e-5, ticks_per_window: 10 };
    let mut setup = observers::setup("viewer", scene(), clock, 1000, output);
    setup.hello.parameters = serde_json::from_value(parameters).unwrap();
    let of = |from, content| FrameStream {
        every: 10,
        lossless: false,
        ..stream(from, "viewer", content)
    };
    setup.assignment.as_mut().unwrap().frames =
        signals().map(|(from, list)| of(from, FrameContent::Signals(list))).into();
    setup
}

fn moment(frame: u64) -> Moment {
    let window = 10 * frame;
    let stamp = Stamp { run: 7, window, ticks: 10 * window, ..Stamp::default() };
    Moment { stamp, time: 1e-4 * window as f64 }
}

/// Two vortices side by side that spin up.
fn flow(x: f64, z: f64, t: f64) -> [f64; 3] {
    let (kx, kz) = (2.0 * std::f64::consts::PI / SIZE[0], std::f64::consts::PI / SIZE[2]);
    let strength = 0.08 * (1.0 - (-t / 0.02).exp());
    [
        strength * (kx * x).sin() * (kz * z).cos(),
        0.0,
        -strength * (kx / kz) * (kx * x).cos() * (kz * z).sin() * 0.6,
    ]
}

/// Grains carried by the flow while they sink; the last twentieth are fixed in a column.
fn bodies(count: usize, t: f64) -> Vec<BodySample> {
    (0..count)
        .map(|k| {
            let r = |m: usize| ((k * m) % 9973) as f64 / 9973.0;
            let fixed = k >= count - count / 20;
            let start = if fixed {
                [0.022 + 0.002 * r(31), SIZE[1] * r(77), 0.01 * r(51)]
            } else {
                [
                    SIZE[0] * (0.02 + 0.96 * r(7919)),
                    SIZE[1] * r(104_729),
                    SIZE[2] * (0.02 + 0.96 * r(1299)),
                ]
            };
            let v = flow(start[0], start[2], t);
            let velocity = if fixed { [0.0; 3] } else { [v[0], 0.0, v[2] - 0.02 * r(13)] };
            let position = std::array::from_fn(|a| {
                (start[a] + velocity[a] * t).clamp(0.5 * DIAMETER, SIZE[a] - 0.5 * DIAMETER)
            });
            let motion = if fixed { BodyEvent::FIXED } else { BodyEvent::FREE };
            BodySample {
                state: BodyState { velocity, ..BodyState::at_rest(k as u64, position) },
                radius: 0.5 * DIAMETER,
                mass: 1e-7,
                set: u32::from(fixed),
                shape: BodyEvent::SPHERE,
                motion,
                part: 0,
            }
        })
        .collect()
}

fn slice(count: [u64; 2], t: f64) -> (SliceHeader, Vec<SliceNode>) {
    let step = [SIZE[0] / (count[0] - 1) as f64, SIZE[2] / (count[1] - 1) as f64];
    let header = SliceHeader {
        stamp: Stamp::default(),
        origin: [0.0, 0.5 * SIZE[1], 0.0],
        step: [[step[0], 0.0, 0.0], [0.0, 0.0, step[1]]],
        count,
    };
    let node = |k: u64| {
        let (x, z) = ((k % count[0]) as f64 * step[0], (k / count[0]) as f64 * step[1]);
        let solid = (x - 0.023).hypot(z - 0.006) < 0.002;
        SliceNode {
            velocity: flow(x, z, t).map(|v| v as f32),
            pressure: 0.0,
            fill: 1.0 - f32::from(u8::from(solid)),
            solid: u32::from(solid),
            ..SliceNode::default()
        }
    };
    (header, (0..count[0] * count[1]).map(node).collect())
}

/// Feeds a run of `frames` frames.
fn feed(viewer: &mut Viewer, frames: u64, grains: usize, nodes: [u64; 2]) {
    for frame in 0..frames {
        let at = moment(frame);
        let bodies = bodies(grains, at.time);
        viewer.bodies("grains", at, &bodies).unwrap();
        let (header, cut) = slice(nodes, at.time);
        viewer.slice("fluid", "y = 6 mm", at, &header, &cut).unwrap();
        let fastest = bodies
            .iter()
            .map(|b| b.state.velocity[0].hypot(b.state.velocity[2]))
            .fold(0.0, f64::max);
        let height = bodies.iter().map(|b| b.state.position[2]).sum::<f64>() / grains as f64;
        let [fluid, grain] = signals();
        let grow = 1.0 - (-at.time / 0.02).exp();
        viewer.signals("fluid", at, &fluid.1, &[0.08 * grow, 1e-6 * grow * grow, 1e-19]).unwrap();
        viewer.signals("grains", at, &grain.1, &[fastest, 0.6 * fastest, height]).unwrap();
        if frame % 25 == 0 {
            let header = LogHeader {
                stamp: at.stamp,
                level: if frame == 50 { LogHeader::WARNING } else { LogHeader::INFO },
            };
            viewer
                .log(at, &header, &format!("window {} of {}", at.stamp.window, 10 * frames))
                .unwrap();
        }
    }
}

fn record(path: &Path, frames: u64, grains: usize, nodes: [u64; 2]) -> u64 {
    let parameters = serde_json::json!({"mode": "file", "file": path});
    let mut viewer = Viewer::open(&setup(path.parent().unwrap(), parameters)).unwrap();
    feed(&mut viewer, frames, grains, nodes);
    let note = viewer.close(10 * (frames - 1)).unwrap();
    assert!(note.contains(&format!("{} frames", 2 * frames)), "{note}");
    drop(viewer);
    std::fs::metadata(path).unwrap().len()
}

/// Rows and timelines of each entity.
fn entities(path: &Path) -> BTreeMap<String, (usize, BTreeSet<String>)> {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut found: BTreeMap<String, (usize, BTreeSet<String>)> = BTreeMap::new();
    for message in DecoderApp::decode_eager(file).unwrap() {
        let LogMsg::ArrowMsg(store, arrow) = message.unwrap() else {
            continue;
        };
        if !store.is_recording() {
            continue;
        }
        let chunk = Chunk::from_arrow_msg(&arrow).unwrap();
        let entry = found.entry(chunk.entity_path().to_string()).or_default();
        entry.0 += chunk.num_rows();
        entry.1.extend(chunk.timelines().keys().map(ToString::to_string));
    }
    found
}

#[test]
fn everything_arrives_in_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    // Set this variable to keep the recording and look at it.
    let kept = std::env::var_os("TREMIE_VIEWER_DEMO").map(PathBuf::from);
    let path = kept.unwrap_or_else(|| folder.path().join("run.rrd"));
    record(&path, 100, 2000, [160, 100]);
    let found = entities(&path);
    let time: BTreeSet<String> = ["sim_time", "window"].map(String::from).into();
    for (entity, rows) in [
        ("/scene/bodies/sand", 100),
        ("/scene/bodies/gate\\ post", 100),
        ("/scene/cuts/fluid/y\\ \\=\\ 6\\ mm/arrows", 101),
        ("/signals/fluid/max_speed", 101),
        ("/signals/grains/mean_height", 101),
        ("/log", 4),
    ] {
        let (count, timelines) =
            found.get(entity).unwrap_or_else(|| panic!("no {entity} in {:?}", found.keys()));
        assert_eq!(*count, rows, "{entity}");
        assert_eq!(timelines, &time, "{entity}");
    }
    for entity in [
        "/scene/domain/edges",
        "/scene/domain/wall_z0",
        "/about",
        "/legend/speed/bar",
        "/legend/speed/numbers",
    ] {
        assert!(found.contains_key(entity), "{entity}");
    }
    assert!(!found.contains_key("/scene/domain/wall_y0"), "periodic faces are no walls");
}

#[test]
fn an_hour_stays_small() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = record(&folder.path().join("run.rrd"), 100, 5000, [160, 100]);
    println!("100 frames of 5,000 grains and 16,000 nodes: {:.2} MB", bytes as f64 / 1e6);
    assert!(bytes < 20_000_000, "{bytes}");
}

/// The flow on a lattice of 60 x 18 x 38 nodes.
fn volume(t: f64) -> (VolumeHeader, Vec<SliceNode>) {
    let count = [60, 18, 38];
    let step: [f64; 3] = std::array::from_fn(|a| SIZE[a] / count[a] as f64);
    let origin = step.map(|x| 0.5 * x);
    let header = VolumeHeader { stamp: Stamp::default(), origin, step, count };
    let node = |k: u64| {
        let at = [k % 60, k / 60 % 18, k / (60 * 18)];
        let p: [f64; 3] = std::array::from_fn(|a| origin[a] + at[a] as f64 * step[a]);
        SliceNode {
            velocity: flow(p[0], p[2], t).map(|v| v as f32),
            pressure: p[0] as f32,
            fill: 1.0,
            solid: u32::from((p[0] - 0.023).hypot(p[2] - 0.006) < 0.002),
            ..SliceNode::default()
        }
    };
    (header, (0..60 * 18 * 38).map(node).collect())
}

/// A run with a gate that moves, recorded with these parameters.
fn record_flow(path: &Path, frames: u64, parameters: serde_json::Value) -> u64 {
    let mut setup = setup(path.parent().unwrap(), parameters);
    setup.hello.scene.parts = vec![Part {
        name: "gate".into(),
        geometry: Geometry::Box { size: [0.002, 0.012, 0.02] },
        pose: Pose { position: [0.03, 0.006, 0.01], ..Pose::IDENTITY },
        cavity: false,
        material: "steel".into(),
        motion: Motion::Prescribed(Vec::new()),
        boundary: PartBoundary::Wall,
    }];
    let grid = VolumeGrid { name: "lattice".into(), first: [0; 3], stride: 1, count: [60, 18, 38] };
    let stream = setup.assignment.as_ref().unwrap().frames[0].clone();
    let stream = FrameStream { content: FrameContent::Volume(grid), ..stream };
    setup.assignment.as_mut().unwrap().frames.push(stream);
    let mut viewer = Viewer::open(&setup).unwrap();
    for frame in 0..frames {
        let at = moment(frame);
        let (header, nodes) = volume(at.time);
        viewer.volume("fluid", "lattice", at, &header, &nodes).unwrap();
        let lifted = BodyState::at_rest(9, [0.03, 0.006, 0.01 + 1e-4 * frame as f64]);
        let gate = BodySample { state: lifted, shape: BodyEvent::PART, ..bodies(1, 0.0)[0] };
        viewer.bodies("grains", at, &[gate]).unwrap();
    }
    viewer.close(10 * (frames - 1)).unwrap();
    drop(viewer);
    std::fs::metadata(path).unwrap().len()
}

#[test]
fn what_is_made_from_a_volume_arrives() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    let parameters = serde_json::json!({
        "mode": "file",
        "file": path,
        "iso_speed": "0.01 m/s",
        "slices": [{"point": ["20 mm", "6 mm", "12 mm"], "normal": [1.0, 0.0, 0.5]}],
    });
    record_flow(&path, 20, parameters);
    let found = entities(&path);
    for (entity, rows) in [
        ("/scene/streamlines/fluid/lattice", 20),
        ("/scene/cuts/fluid/plane\\ 1", 21),
        // Its shape, its pose at the start, and each time it moved: not in the first frame.
        ("/scene/parts/gate", 2 + 19),
    ] {
        let (count, _) =
            found.get(entity).unwrap_or_else(|| panic!("no {entity} in {:?}", found.keys()));
        assert_eq!(*count, rows, "{entity}");
    }
    let (surfaces, _) = &found["/scene/isosurfaces/fluid/lattice/speed"];
    assert!((1..=20).contains(surfaces), "the flow starts from rest: {surfaces}");
    assert!(!found.contains_key("/scene/isosurfaces/fluid/lattice/pressure"));
}

/// A ring around the x axis, carried by a gate, in the half of a domain before a mirror.
fn ring() -> DeformableSurface {
    let half = 0.5_f64.sqrt();
    let section = [[2e-3, 0.0], [3e-3, 0.0], [3e-3, 1e-3], [2e-3, 1e-3]];
    let pose = Pose { orientation: [0.0, half, 0.0, half], ..Pose::IDENTITY };
    DeformableSurface { pose, ..observers::ring("ring", &section, 12) }
}

/// Numbers in the column `component` of all rows of an entity, one list for each row that has some.
fn lengths(path: &Path, entity: &str, component: &str) -> Vec<usize> {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut found = Vec::new();
    for message in DecoderApp::decode_eager(file).unwrap() {
        let LogMsg::ArrowMsg(_, arrow) = message.unwrap() else { continue };
        let chunk = Chunk::from_arrow_msg(&arrow).unwrap();
        if chunk.entity_path().to_string() != entity {
            continue;
        }
        for (descriptor, column) in chunk.components().iter() {
            if descriptor.to_string().contains(component) {
                let rows = &column.list_array;
                found.extend(
                    (0..rows.len()).filter(|k| rows.is_valid(*k)).map(|k| rows.value(k).len()),
                );
            }
        }
    }
    found
}

#[test]
fn rubber_is_drawn_as_far_as_the_mirror_with_its_own_scale() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    let mut setup = setup(folder.path(), serde_json::json!({"mode": "file", "file": path}));
    assert!(Viewer::describe(&setup).unwrap().watches.surfaces);
    let scene = &mut setup.hello.scene;
    // The ring's axis lies in the plane y = 0: half of the ring is beyond.
    scene.domain.faces[1] = [Face::Symmetry, Face::WALL];
    scene.parts = vec![Part {
        name: "gate".into(),
        geometry: Geometry::Box { size: [0.002, 0.012, 0.02] },
        pose: Pose { position: [0.03, 0.0, 0.01], ..Pose::IDENTITY },
        cavity: false,
        material: "steel".into(),
        motion: Motion::Fixed,
        boundary: PartBoundary::Wall,
    }];
    scene.surfaces = vec![ring()];
    let turned = Turned::of(&ring());
    let sample = |place: [f64; 3], strain: f64| SurfaceSample {
        vertex: SurfaceVertex { position: place, velocity: [0.0; 3] },
        strain,
    };
    let mut viewer = Viewer::open(&setup).unwrap();
    for frame in 0..70 {
        let strain = 0.004 * frame as f64;
        let samples: Vec<_> = turned
            .places(&ring().section.points)
            .into_iter()
            .map(|place| sample(place.into(), strain))
            .collect();
        viewer.surfaces("rubber", moment(frame), &samples).unwrap();
    }
    viewer.close(690).unwrap();
    drop(viewer);
    let found = entities(&path);
    assert_eq!(found["/scene/rubber/ring"].0, 70);
    assert!(found.contains_key("/legend/strain/bar"));
    // 0, 0.004 and on to 0.276: from 0.005 to 0.5, each of 1, 2 and 5.
    assert_eq!(found["/legend/strain/numbers"].0, 7);
    let entity = "/scene/rubber/ring";
    // Half of the ring's 96 triangles, and two for each of the two sections; sent twice.
    assert_eq!(lengths(&path, entity, "triangle_indices"), [52, 52]);
    // Four sharp edges of seven vertices, drawn for both sides, and two sections of four corners.
    let vertices = vec![2 * 4 * 7 + 2 * 4; 70];
    assert_eq!(lengths(&path, entity, "vertex_positions"), vertices);
    assert_eq!(lengths(&path, entity, "vertex_colors"), vertices);
}

#[test]
fn profiles_are_bars_and_sheets() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    let mut setup = setup(folder.path(), serde_json::json!({"mode": "file", "file": path}));
    assert!(!Viewer::describe(&setup).unwrap().watches.profiles, "there are none");
    let profile = |name: &str, axes: &[(usize, usize)]| GrainProfile {
        name: name.into(),
        axes: axes.iter().map(|&(axis, bins)| BinnedAxis { axis, bins }).collect(),
        min: [0.0; 3],
        max: SIZE,
        from: 0.0,
        every: None,
        average: None,
        velocity: ProfileVelocity::Instantaneous,
    };
    setup.hello.scene.profiles =
        vec![profile("height", &[(2, 7)]), profile("plane", &[(0, 5), (2, 3)])];
    assert!(Viewer::describe(&setup).unwrap().watches.profiles);
    let sent = ["height", "plane"].map(|name| FrameContent::Profile(name.into()));
    let frames = sent.map(|content| stream("grains", "viewer", content));
    setup.assignment.as_mut().unwrap().frames.extend(frames);
    let mut viewer = Viewer::open(&setup).unwrap();
    for frame in 1..=4 {
        for (name, bins) in [("height", 7), ("plane", 15)] {
            let bin = |k: usize| ProfileBin {
                solid_fraction: 0.04 * (k * frame as usize % 16) as f64,
                velocity: [f64::NAN; 3],
                ..ProfileBin::default()
            };
            let bins: Vec<_> = (0..bins).map(bin).collect();
            let header = ProfileHeader::default();
            viewer.profile("grains", name, moment(frame), &header, &bins).unwrap();
        }
    }
    viewer.close(40).unwrap();
    drop(viewer);
    let found = entities(&path);
    for quantity in ["solid_fraction", "velocity"] {
        assert_eq!(found[&format!("/profiles/height/{quantity}")].0, 4);
    }
    let sheet = "/scene/profiles/plane";
    assert_eq!(lengths(&path, sheet, "vertex_positions"), [4 * 15]);
    assert_eq!(lengths(&path, sheet, "triangle_indices"), [2 * 15]);
    assert_eq!(lengths(&path, sheet, "vertex_colors"), [4 * 15; 4]);
    assert!(found.contains_key("/legend/solid_fraction/bar"), "sheets have a scale of their own");
}

#[test]
fn streamlines_of_an_hour_stay_small() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    let bytes = record_flow(&path, 20, serde_json::json!({"mode": "file", "file": path}));
    println!("20 frames of 120 streamlines: {:.2} MB", bytes as f64 / 1e6);
    // 200 frames are what a run sends unless told otherwise.
    assert!(bytes / 20 * 200 < 100_000_000, "{bytes}");
}

/// Every grain of every frame is in the recording, in no more bytes than its place and colour have.
#[test]
fn many_grains_are_all_recorded() {
    const GRAINS: usize = 100_000;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd");
    let bytes = record(&path, 5, GRAINS, [160, 100]);
    let fixed = GRAINS / 20;
    assert_eq!(lengths(&path, "/scene/bodies/sand", "positions"), [GRAINS - fixed; 5]);
    assert!(bytes < 16 * 5 * GRAINS as u64, "{bytes} bytes");
}

#[test]
fn a_page_is_served_until_the_viewer_is_dropped() {
    let folder = tempfile::tempdir().unwrap();
    let mut viewer =
        Viewer::open(&setup(folder.path(), serde_json::json!({"web_port": 0, "grpc_port": 0})))
            .unwrap();
    feed(&mut viewer, 3, 100, [8, 5]);
    let note = viewer.close(20).unwrap();
    let url = viewer.session().url().unwrap().to_string();
    assert!(note.contains(&url), "{note}");
    let port: u16 = url.split([':', '/']).nth(4).unwrap().parse().unwrap();
    assert!(std::net::TcpStream::connect(("127.0.0.1", port)).is_ok());
    drop(viewer);
    assert!(std::net::TcpStream::connect(("127.0.0.1", port)).is_err());
}

#[test]
fn wrong_parameters_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let problems =
        Viewer::describe(&setup(folder.path(), serde_json::json!({"memory_limit": "lots"})));
    assert_eq!(problems.unwrap_err()[0].key, "@memory_limit");
    let problems =
        Viewer::describe(&setup(folder.path(), serde_json::json!({"mod": "web"}))).unwrap_err();
    assert_eq!(problems[0].help.as_deref(), Some("did you mean \"mode\"?"));
}
