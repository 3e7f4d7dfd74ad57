//! Files are read back by an independent reader, and equal the frames sent.

mod reader;

use reader::VtkFile;
use std::path::Path;
use tremie_fields::Fields;
use tremie_messages::frame::{BodySample, SliceNode, SurfaceSample, VolumeHeader};
use tremie_messages::scene::{Domain, Face, Geometry, Motion, Part, PartBoundary, Pose, Scene};
use tremie_messages::start::{Clock, FrameContent, FrameStream, VolumeGrid};
use tremie_messages::{BodyEvent, BodyState, Stamp, SurfaceVertex};
use tremie_sdk::{Moment, Observer, Setup};
use tremie_test_support::observers::{self, ring, stream};

fn scene() -> Scene {
    let part = |name: &str, motion| Part {
        name: name.into(),
        geometry: Geometry::Box { size: [0.2, 0.1, 0.1] },
        pose: Pose { position: [0.5, 0.5, 0.5], ..Pose::IDENTITY },
        cavity: false,
        material: "steel".into(),
        motion,
        boundary: PartBoundary::Wall,
    };
    Scene {
        parts: vec![part("seat", Motion::Fixed), part("gate", Motion::Prescribed(Vec::new()))],
        ..Scene::empty(Domain::new([0.0; 3], [1.0; 3], Face::WALLS))
    }
}

fn setup(output: &Path, parameters: serde_json::Value) -> Setup {
    let grid = VolumeGrid { name: "lattice".into(), first: [0; 3], stride: 1, count: [3, 2, 4] };
    let clock = Clock { tick: 1e-3, ticks_per_window: 1 };
    let mut setup = observers::setup("fields", scene(), clock, 20, output);
    setup.hello.parameters = serde_json::from_value(parameters).unwrap();
    let of = |from, content| FrameStream { every: 5, ..stream(from, "fields", content) };
    setup.assignment.as_mut().unwrap().frames =
        vec![of("fluid", FrameContent::Volume(grid)), of("grains", FrameContent::Bodies)];
    setup
}

fn moment(window: u64) -> Moment {
    let stamp = Stamp { run: 7, window, ticks: window, ..Stamp::default() };
    Moment { stamp, time: 1e-3 * window as f64 }
}

fn header() -> VolumeHeader {
    let (origin, step) = ([0.05, 0.1, -1e-9], [0.1, 0.25, 1.0 / 3.0]);
    VolumeHeader { stamp: Stamp::default(), origin, step, count: [3, 2, 4] }
}

fn nodes(window: u64) -> Vec<SliceNode> {
    let node = |k: u64| {
        let x = (k + 100 * window) as f32 / 7.0;
        SliceNode {
            velocity: [x, -x, 0.5 * x],
            pressure: 1e-6 * x,
            fill: 0.5 * (k % 3) as f32,
            solid: u32::from(k.is_multiple_of(5)),
            density: 1.2 + x,
            level: (k % 3) as u32,
        }
    };
    (0..24).map(node).collect()
}

fn sphere(id: u64) -> BodySample {
    let x = id as f64 / 3.0;
    BodySample {
        state: BodyState {
            id,
            position: [x, 0.1 * x, 1e-9],
            orientation: [0.0, 0.6, 0.0, 0.8],
            velocity: [0.25, x, -x],
            angular_velocity: [x, 2.0, 3.0],
        },
        radius: 1e-3 * x,
        mass: 1e-6,
        set: 2,
        shape: BodyEvent::SPHERE,
        motion: BodyEvent::FREE,
        part: 0,
    }
}

/// The gate, lifted and turned a quarter about z, and lifting and turning on.
fn gate(height: f64) -> BodySample {
    let half = 0.5_f64.sqrt();
    BodySample {
        state: BodyState {
            orientation: [0.0, 0.0, half, half],
            velocity: [0.0, 0.0, 1.0],
            angular_velocity: [0.0, 0.0, 2.0],
            ..BodyState::at_rest(99, [0.5, 0.5, height])
        },
        shape: BodyEvent::PART,
        part: 1,
        ..sphere(0)
    }
}

/// Feeds windows 0, 5, 10 and 15, of which 15 is beyond the last common one.
fn written(folder: &Path, compression: &str) -> String {
    let parameters = serde_json::json!({ "compression": compression });
    let mut fields = Fields::open(&setup(folder, parameters)).unwrap();
    for window in [0, 5, 10, 15] {
        let at = moment(window);
        let header = VolumeHeader { stamp: at.stamp, ..header() };
        fields.volume("fluid", "lattice", at, &header, &nodes(window)).unwrap();
        let bodies = [sphere(3), sphere((1 << 40) + window), gate(0.5 + 0.02 * window as f64)];
        fields.bodies("grains", at, &bodies).unwrap();
    }
    fields.close(10).unwrap()
}

/// A file of the run, with and without compression: both hold the same.
fn read(name: &str) -> [VtkFile; 2] {
    ["none", "lz4"].map(|compression| {
        let home = tempfile::tempdir().unwrap();
        written(home.path(), compression);
        VtkFile::read(&home.path().join("fields").join(name))
    })
}

#[test]
fn a_lattice_comes_back() {
    for file in read("lattice_000005.vti") {
        assert_eq!(file.attribute("VTKFile", "type"), "ImageData");
        assert_eq!(file.numbers("ImageData", "WholeExtent"), [0.0, 2.0, 0.0, 1.0, 0.0, 3.0]);
        assert_eq!(file.numbers("ImageData", "Origin"), header().origin);
        assert_eq!(file.numbers("ImageData", "Spacing"), header().step);
        let sent = nodes(5);
        let velocity = sent.iter().flat_map(|node| node.velocity).collect();
        assert_eq!(file.array::<f32>("velocity"), (3, velocity));
        let pressure = sent.iter().map(|node| node.pressure).collect();
        assert_eq!(file.array::<f32>("pressure"), (1, pressure));
        let fill = sent.iter().map(|node| node.fill).collect();
        assert_eq!(file.array::<f32>("fill"), (1, fill));
        let solid = sent.iter().map(|node| node.solid as u8).collect();
        assert_eq!(file.array::<u8>("solid"), (1, solid));
        let density = sent.iter().map(|node| node.density).collect();
        assert_eq!(file.array::<f32>("density"), (1, density));
        let level = sent.iter().map(|node| node.level).collect();
        assert_eq!(file.array::<u32>("level"), (1, level));
    }
}

#[test]
fn bodies_come_back() {
    for file in read("bodies_000010.vtp") {
        let sent = [sphere(3), sphere((1 << 40) + 10)];
        let all = |of: &dyn Fn(&BodySample) -> Vec<f64>| -> Vec<f64> {
            sent.iter().flat_map(of).collect()
        };
        assert_eq!(file.attribute("Piece", "NumberOfPoints"), "2");
        assert_eq!(file.array::<u64>("id"), (1, vec![3, (1 << 40) + 10]));
        assert_eq!(file.array::<u32>("set"), (1, vec![2, 2]));
        assert_eq!(file.array::<u32>("motion"), (1, vec![BodyEvent::FREE; 2]));
        assert_eq!(file.array::<i64>("connectivity"), (1, vec![0, 1]));
        assert_eq!(file.array::<i64>("offsets"), (1, vec![1, 2]));
        for (name, size, expected) in [
            ("points", 3, all(&|b| b.state.position.into())),
            ("radius", 1, all(&|b| vec![b.radius])),
            ("mass", 1, all(&|b| vec![b.mass])),
            ("velocity", 3, all(&|b| b.state.velocity.into())),
            ("angular_velocity", 3, all(&|b| b.state.angular_velocity.into())),
            ("orientation", 4, all(&|b| b.state.orientation.into())),
        ] {
            assert_eq!(file.array::<f64>(name), (size, expected), "{name}");
        }
    }
}

#[test]
fn a_moving_part_is_where_its_body_is() {
    let [file, _] = read("parts_000005.vtp");
    let (_, points) = file.array::<f64>("points");
    assert_eq!(points.len(), 3 * 16);
    let (seat, gate) = points.split_at(3 * 8);
    let span = |points: &[f64], axis: usize| {
        let along = points.chunks(3).map(|p| p[axis]);
        [along.clone().fold(f64::MAX, f64::min), along.fold(f64::MIN, f64::max)]
    };
    let near = |a: [f64; 2], b: [f64; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
    assert!(near(span(seat, 0), [0.4, 0.6]) && near(span(seat, 2), [0.45, 0.55]));
    // Turned, its length lies along y; lifted by 0.1.
    assert!(near(span(gate, 0), [0.45, 0.55]) && near(span(gate, 1), [0.4, 0.6]));
    assert!(near(span(gate, 2), [0.55, 0.65]));
    let (_, velocity) = file.array::<f64>("velocity");
    assert!(velocity[..24].iter().all(|v| *v == 0.0));
    for (point, v) in gate.chunks(3).zip(velocity[24..].chunks(3)) {
        let expected = [-2.0 * (point[1] - 0.5), 2.0 * (point[0] - 0.5), 1.0];
        assert!((0..3).all(|a| (v[a] - expected[a]).abs() < 1e-12), "{point:?} {v:?}");
    }
    assert_eq!(file.array::<u32>("part"), (1, [[0; 12], [1; 12]].concat()));
    let (_, corners) = file.array::<i64>("connectivity");
    assert!(corners[..36].iter().all(|c| (0..8).contains(c)));
    assert!(corners[36..].iter().all(|c| (8..16).contains(c)));
}

#[test]
fn rubber_comes_back_with_its_strain() {
    let home = tempfile::tempdir().unwrap();
    let mut setup = setup(home.path(), serde_json::json!({}));
    let ring = |name| ring(name, &[[1.0, 0.0], [2.0, 0.0], [2.0, 1.0]], 4);
    setup.hello.scene.surfaces = vec![ring("one"), ring("other")];
    let watches = Fields::describe(&setup).unwrap().watches;
    assert!(watches.surfaces);
    let mut fields = Fields::open(&setup).unwrap();
    let sample = |k: u32| SurfaceSample {
        vertex: SurfaceVertex { position: [k.into(), 0.5, 0.0], velocity: [0.0, k.into(), 1.0] },
        strain: f64::from(k) / 7.0,
    };
    let sent: Vec<_> = (0..24).map(sample).collect();
    fields.surfaces("rubber", moment(5), &sent).unwrap();
    assert!(fields.close(5).unwrap().contains("1 of rubber"));
    let file = VtkFile::read(&home.path().join("fields/rubber_000005.vtp"));
    assert_eq!(file.array("strain"), (1, sent.iter().map(|s| s.strain).collect::<Vec<f64>>()));
    let vectors = |of: fn(&SurfaceSample) -> [f64; 3]| sent.iter().flat_map(of).collect::<Vec<_>>();
    assert_eq!(file.array("points"), (3, vectors(|s| s.vertex.position)));
    assert_eq!(file.array("velocity"), (3, vectors(|s| s.vertex.velocity)));
    let kinds = [[0u8; 8], [1; 8], [2; 8]].concat();
    assert_eq!(file.array("kind"), (1, kinds.repeat(2)));
    assert_eq!(file.array("surface"), (1, [[0u32; 24], [1; 24]].concat()));
    let (_, corners) = file.array::<i64>("connectivity");
    assert_eq!(corners.len(), 3 * 48);
    // The second surface has the same triangles, on its own vertices.
    assert!(corners[..72].iter().zip(&corners[72..]).all(|(a, b)| a + 12 == *b && *a < 12));
}

#[test]
fn a_run_ends_at_its_last_common_window() {
    let home = tempfile::tempdir().unwrap();
    let note = written(home.path(), "lz4");
    assert!(note.contains("3 of bodies, 3 of lattice, 3 of parts"), "{note}");
    let mut names: Vec<_> = std::fs::read_dir(home.path().join("fields"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(
        names,
        [
            "about.txt",
            "bodies.pvd",
            "bodies_000000.vtp",
            "bodies_000005.vtp",
            "bodies_000010.vtp",
            "lattice.pvd",
            "lattice_000000.vti",
            "lattice_000005.vti",
            "lattice_000010.vti",
            "parts.pvd",
            "parts_000000.vtp",
            "parts_000005.vtp",
            "parts_000010.vtp",
        ]
    );
    let series = std::fs::read_to_string(home.path().join("fields/lattice.pvd")).unwrap();
    assert_eq!(series.matches("<DataSet").count(), 3);
    assert!(
        series.contains("timestep=\"1e-2\" part=\"0\" file=\"lattice_000010.vti\""),
        "{series}"
    );
}

#[test]
fn equal_runs_give_equal_bytes() {
    let (one, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    written(one.path(), "lz4");
    written(other.path(), "lz4");
    for name in ["lattice_000005.vti", "bodies_000005.vtp", "parts_000005.vtp", "lattice.pvd"] {
        let bytes = |home: &Path| std::fs::read(home.join("fields").join(name)).unwrap();
        assert!(bytes(one.path()) == bytes(other.path()), "{name}");
    }
}

#[test]
fn a_part_that_cannot_be_read_is_named() {
    let home = tempfile::tempdir().unwrap();
    let mut setup = setup(home.path(), serde_json::json!({}));
    setup.hello.scene.parts[1].geometry =
        Geometry::File { path: "/nowhere/gate.stl".into(), unit: 1.0 };
    let problems = Fields::describe(&setup).unwrap_err();
    assert_eq!(problems[0].key, "scene.parts[1].geometry");
    assert!(problems[0].message.contains("/nowhere/gate.stl"), "{:?}", problems[0]);
}
