use super::steps::{Wish, assign};
use super::*;
use crate::manifest;
use proptest::prelude::*;
use std::path::Path;
use tremie_messages::finding::short;
use tremie_messages::schedule::Content;
use tremie_messages::start::{
    FrameContent, InjectionKind, Signal, SliceSpec, VolumeSpec, VolumeWish, Watches,
};
use tremie_messages::{Limit, WatchedQuantity};

const MANIFEST: &str = r#"
[run]
until = "1.2 ms"
[scene.domain]
size = ["1 m", "1 m", "1 m"]
[scene.fluid]
density = "1000 kg/m3"
viscosity = "1 mPa s"
[components]
fluid = "fluid-lbm"
grains = "grains-dem"
viewer = "viewer"
recorder = "recorder"
[outputs]
frames = "12 us"
[[stop_when]]
signal = "grains.max_speed"
below = 1.0
"#;

fn spec(sets: &[(&str, &str)]) -> Spec {
    let sets: Vec<_> = sets.iter().map(|(k, v)| ((*k).to_string(), (*v).to_string())).collect();
    let manifest = manifest::parse(Path::new("manifest.toml"), MANIFEST.into(), &sets);
    manifest.unwrap_or_else(|errors| panic!("{errors}")).spec
}

fn signal(name: &str) -> Signal {
    Signal::new(name, "m/s", &[])
}

/// The paper's steps, whose ratio is 2.4.
fn descriptions() -> Vec<(String, Description)> {
    let fluid = Description {
        program: "fluid-lbm 0.1".into(),
        step: Some(1.2e-7),
        signals: vec![signal("mass")],
        slices: vec![SliceSpec { name: "xz".into(), nodes: 500 }],
        warnings: vec!["too coarse".into()],
        notes: vec!["16 cells across".into()],
        state: Some(1),
        ..Description::default()
    };
    let grains = Description {
        program: "grains-dem 0.1".into(),
        step: Some(5e-8),
        bodies: 40,
        state: Some(1),
        signals: vec![signal("max_speed")],
        ..Description::default()
    };
    vec![
        ("fluid".into(), fluid),
        ("grains".into(), grains),
        ("recorder".into(), Description::default()),
        ("viewer".into(), Description::default()),
    ]
}

fn plan(sets: &[(&str, &str)]) -> Result<Plan, Vec<Problem>> {
    make(&spec(sets), &descriptions(), &Options::default())
}

fn transport() -> Transport {
    Transport {
        between_processes: false,
        root: String::new(),
        prefix: String::new(),
        credit_service: "credit".into(),
        report_service: "report".into(),
        report_depth: 4,
        deadline: 1.0,
        poll: 0.0,
    }
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * b.abs()
}

#[test]
fn a_component_without_a_state_is_named_if_checkpoints_are_wanted() {
    let mut described = descriptions();
    described[0].1.state = None;
    let notes = |sets: &[(&str, &str)]| {
        make(&spec(sets), &described, &Options::default()).unwrap().notes.join("\n")
    };
    assert!(notes(&[]).contains("fluid (fluid-lbm 0.1) keeps no state"), "{}", notes(&[]));
    assert!(!notes(&[("run.checkpoints.keep", "0")]).contains("state"));
}

#[test]
fn a_run_watches_what_components_limit_unless_the_manifest_says_otherwise() {
    let limit = |signal: &str, watch, wrong| Limit {
        signal: signal.into(),
        quantity: format!("greatest {signal}"),
        unit: "1".into(),
        doubtful: 1.0,
        wrong,
        why: String::new(),
        remedy: String::new(),
        watch,
    };
    let mut described = descriptions();
    described[0].1.limits = vec![limit("mass", Some(WatchedQuantity::Mass), None)];
    described[1].1.limits = vec![
        limit("max_speed", Some(WatchedQuantity::Speed), Some(4.0)),
        limit("max_speed", None, Some(4.0)),
        limit("nothing", Some(WatchedQuantity::Energy), Some(4.0)),
    ];
    described[1].1.tells_places = true;
    let planned = |sets: &[(&str, &str)]| {
        let plan = make(&spec(sets), &described, &Options::default()).unwrap();
        let levels = plan.watches.iter().map(|watch| (watch.watched.from, watch.watched.limit));
        let names = plan.watches.iter().map(PlannedWatch::name);
        (names.zip(levels).collect::<Vec<_>>(), plan)
    };
    let speed = |from: f64, limit: f64| ("grains.max_speed".to_string(), (from, limit));
    let (found, plan) = planned(&[]);
    assert_eq!(found, [speed(1.0, 4.0)]);
    assert_eq!(plan.components.iter().map(|c| c.values_of_places()).sum::<usize>(), 5);
    assert_eq!(
        plan.components[1].assignment(transport(), None).watched,
        plan.components[1].watched
    );
    assert!(plan.to_string().contains("grains.max_speed"), "{plan}");
    assert_eq!(planned(&[("watch.speed", "off")]).0, []);
    let mass = ("fluid.mass".to_string(), (0.25, 0.5));
    assert_eq!(planned(&[("watch.mass", "0.5")]).0, [mass, speed(1.0, 4.0)]);
    let (found, plan) = planned(&[("watch.speed", "9"), ("watch.mach", "2")]);
    assert_eq!(found, [speed(1.0, 9.0)]);
    let unused = plan.notes.iter().any(|note| note.starts_with("watch.mach is not used"));
    assert!(unused, "{:?}", plan.notes);
}

#[test]
fn a_ratio_of_2_4_becomes_3_substeps_and_is_said() {
    let plan = plan(&[]).unwrap();
    let [fluid, grains, ..] = plan.components.as_slice() else { panic!() };
    assert_eq!((fluid.substeps, grains.substeps), (1, 3));
    assert!(close(plan.window, 1.2e-7) && close(grains.step, 4e-8) && close(fluid.step, 1.2e-7));
    assert_eq!((plan.clock.ticks_per_window, plan.windows), (3, 10_000));
    assert_eq!(
        plan.notes,
        ["ratio 2.4 becomes 3 substeps: grains step 5e-8 s shortened to 4e-8 s"]
    );
    assert_eq!(plan.warnings, ["fluid: too coarse"]);
    let text = plan.to_string();
    for words in [
        "10000 windows of 1.2e-7 s",
        "grains -> fluid, state",
        "16 cells across",
        "warning: fluid",
        "note: ratio 2.4",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

#[test]
fn a_fixed_sync_iter_is_taken_or_refused_with_what_would_do() {
    let fixed = plan(&[("components.grains.sync_iter", "5")]).unwrap();
    assert_eq!(fixed.components[1].substeps, 5);
    assert!(close(fixed.components[1].step, 2.4e-8));
    assert!(fixed.notes.is_empty());

    let problems = plan(&[("components.grains.sync_iter", "2")]).unwrap_err();
    assert_eq!(problems.len(), 1);
    assert_eq!(problems[0].key, "components.grains.sync_iter");
    assert_eq!(
        problems[0].message,
        "2 substeps in a window of 1.2e-7 s are steps of 6e-8 s, but grains takes at most 5e-8 s"
    );
    assert_eq!(
        problems[0].help.as_deref(),
        Some(
            "sync_iter = 3 would do (grains then steps 4e-8 s), or a step of at most 1e-7 s for fluid"
        )
    );
}

#[test]
fn sync_iter_of_the_slowest_widens_the_window() {
    let plan = plan(&[("components.fluid.sync_iter", "2")]).unwrap();
    let [fluid, grains, ..] = plan.components.as_slice() else { panic!() };
    assert_eq!((fluid.substeps, grains.substeps), (2, 5));
    assert!(close(plan.window, 2.4e-7) && close(fluid.step, 1.2e-7) && close(grains.step, 4.8e-8));
    assert_eq!(plan.clock.ticks_per_window, 10);
}

#[test]
fn too_many_substeps_and_impossible_steps_are_refused() {
    let with = |fluid: Option<f64>, grains: Option<f64>| {
        let mut descriptions = descriptions();
        descriptions[0].1.step = fluid;
        descriptions[1].1.step = grains;
        make(&spec(&[]), &descriptions, &Options::default())
    };
    let problems = with(Some(1.2e-7), Some(1e-10)).unwrap_err();
    assert_eq!(problems[0].key, "components.grains");
    assert!(problems[0].message.contains("1200 substeps"), "{}", problems[0]);
    assert_eq!(with(Some(f64::NAN), Some(1.0)).unwrap_err()[0].key, "components.fluid");
    let any = with(None, None).unwrap();
    assert_eq!(any.windows, 1000);
    assert!(any.notes.iter().any(|note| note.contains("can take any step")), "{:?}", any.notes);
    let any = with(None, Some(5e-8)).unwrap();
    assert_eq!(any.components[0].substeps, 1);
    assert!(close(any.window, 5e-8) && close(any.components[0].step, 5e-8));
    assert_eq!(with(Some(1e-22), Some(1e-22)).unwrap_err()[0].key, "run.until");
}

#[test]
fn edges_and_frames_carry_what_is_needed() {
    let plan = plan(&[("run.schedule", "parallel")]).unwrap();
    let edges: Vec<_> = plan
        .edges
        .iter()
        .map(|e| (e.service.as_str(), e.capacity, e.sender_substeps, e.events_lag))
        .collect();
    let expected = [
        ("grains/events/fluid", 40, 3, 0),
        ("grains/state/fluid", 40, 3, 0),
        ("fluid/load/grains", 40, 1, 1),
    ];
    assert_eq!(edges, expected);
    let frames: Vec<_> =
        plan.frames.iter().map(|s| (s.service.as_str(), s.every, s.lossless)).collect();
    assert_eq!(
        frames,
        [
            ("fluid/frames/slice/xz/recorder", 100, true),
            ("fluid/frames/signals/recorder", 100, true),
            ("fluid/frames/slice/xz/viewer", 100, false),
            ("fluid/frames/signals/viewer", 100, false),
            ("grains/frames/bodies/recorder", 100, true),
            ("grains/frames/signals/recorder", 100, true),
            ("grains/frames/bodies/viewer", 100, false),
            ("grains/frames/signals/viewer", 100, false),
            ("orchestrator/frames/log/recorder", 1, true),
            ("orchestrator/frames/log/viewer", 1, false),
        ]
    );
    let assignment = plan.components[1].assignment(transport(), None);
    assert_eq!(assignment.edges.len(), 3);
    assert_eq!(assignment.edges[2].content, Content::Load);
    assert_eq!(assignment.frames.len(), 4);
    assert_eq!((assignment.substeps, assignment.body_capacity), (3, 40));
    assert_eq!(assignment.transport, transport());
    let viewer = plan.components[3].assignment(transport(), None);
    assert!(viewer.edges.is_empty() && viewer.script.window.is_empty());
    assert_eq!(viewer.frames.len(), 5);
    assert_eq!(viewer.frames[4].content, FrameContent::Log);
    assert!(plan.shared_memory() > 40 * 112);
}

#[test]
fn observers_get_what_they_want_when_they_want_it() {
    let mut descriptions = descriptions();
    descriptions[0].1.volumes = vec![VolumeSpec {
        name: "lattice".into(),
        origin: [0.0; 3],
        step: [0.1; 3],
        count: [10, 10, 20],
    }];
    let volumes = Some(VolumeWish { most_nodes: Some(300), ..Default::default() });
    descriptions[3].1.watches =
        Watches { slices: false, log: false, volumes, ..Default::default() };
    let whole = Watches {
        slices: false,
        signals: false,
        log: false,
        volumes: Some(VolumeWish::default()),
        ..Default::default()
    };
    descriptions.push(("fields".into(), Description { watches: whole, ..Default::default() }));
    let mut spec = spec(&[("outputs.fields", "0.6 ms")]);
    spec.add_observer("fields");
    let plan = make(&spec, &descriptions, &Options::default()).unwrap();
    let to = |observer: &str| -> Vec<_> {
        let streams = plan.frames.iter().filter(|s| s.to == observer);
        streams.map(|s| (s.service.as_str(), s.every, s.lossless, s.capacity, s.depth)).collect()
    };
    assert_eq!(
        to("fields"),
        [
            ("fluid/frames/volume/lattice/fields", 5000, true, 2000, 1),
            ("grains/frames/bodies/fields", 5000, true, 40, 8),
        ]
    );
    assert_eq!(
        to("viewer"),
        [
            ("fluid/frames/volume/lattice/viewer", 100, false, 5 * 5 * 10, 1),
            ("fluid/frames/signals/viewer", 100, false, 1, 2),
            ("grains/frames/bodies/viewer", 100, false, 40, 2),
            ("grains/frames/signals/viewer", 100, false, 1, 2),
        ]
    );
    let note = "fields takes 3 frames of 10 x 10 x 20 nodes from fluid: 64.0 kB each";
    assert!(plan.notes.iter().any(|found| found.starts_with(note)), "{:?}", plan.notes);
}

#[test]
fn observers_that_ask_get_loads_and_wall_time_with_the_schedule() {
    for (schedule, delay) in [("serial", 0), ("parallel", 1)] {
        let mut descriptions = descriptions();
        descriptions[1].1.tells_loads = true;
        descriptions[3].1.watches = Watches {
            bodies: false,
            slices: false,
            signals: false,
            log: false,
            loads: true,
            timings: true,
            ..Watches::default()
        };
        let spec = spec(&[("run.schedule", schedule)]);
        let plan = make(&spec, &descriptions, &Options::default()).unwrap();
        let streams: Vec<_> = plan.frames.iter().filter(|s| s.to == "viewer").collect();
        let services: Vec<_> = streams.iter().map(|s| (s.service.as_str(), s.capacity)).collect();
        let expected =
            [("grains/frames/loads/viewer", 40), ("orchestrator/frames/timings/viewer", 2)];
        assert_eq!(services, expected);
        let FrameContent::Timings(coupling) = &streams[1].content else { panic!() };
        let names: Vec<_> =
            coupling.components.iter().map(|c| (c.name.as_str(), c.substeps)).collect();
        assert_eq!(names, [("fluid", 1), ("grains", 3)]);
        let of = |content| coupling.exchanges.iter().find(|e| e.content == content).unwrap();
        assert_eq!((of(Content::State).delay, of(Content::Load).delay), (delay, 1));
        // Of an observer that must have each frame they keep nobody waiting.
        assert_eq!(plan.lossless_observers().len(), 1);
        descriptions[1].1.tells_loads = false;
        let plan = make(&spec, &descriptions, &Options::default()).unwrap();
        assert!(plan.frames.iter().all(|s| s.content != FrameContent::Loads));
    }
}

#[test]
fn a_region_without_nodes_is_a_warning() {
    let mut descriptions = descriptions();
    let count = [10; 3];
    let (origin, step) = ([0.0; 3], [0.1; 3]);
    descriptions[0].1.volumes = vec![VolumeSpec { name: "lattice".into(), origin, step, count }];
    let region = Some([[5.0; 3], [6.0; 3]]);
    descriptions[3].1.watches.volumes = Some(VolumeWish { region, ..Default::default() });
    let plan = make(&spec(&[]), &descriptions, &Options::default()).unwrap();
    let warning = plan.warnings.iter().find(|warning| warning.starts_with("viewer: no node"));
    assert!(warning.is_some(), "{:?}", plan.warnings);
}

#[test]
fn rows_of_signals_are_bounded_unless_asked_for() {
    assert_eq!(plan(&[]).unwrap().signal_rows_every, 1);
    assert_eq!(plan(&[("run.until", "12 ms")]).unwrap().signal_rows_every, 5);
    assert_eq!(plan(&[("outputs.signals", "1 us")]).unwrap().signal_rows_every, 8);
    assert_eq!(plan(&[("outputs.signals", "1 h")]).unwrap().signal_rows_every, 10_000);
}

#[test]
fn stop_conditions_and_injections_must_name_what_is_there() {
    let problems = plan(&[("stop_when[0].signal", "grains.max_sped")]).unwrap_err();
    assert_eq!(problems[0].key, "stop_when[0].signal");
    assert_eq!(problems[0].help.as_deref(), Some("did you mean \"grains.max_speed\"?"));

    let injection = |window| Injection { kind: InjectionKind::Nan, window };
    let with = |name: &str, window| {
        let options = Options { injections: vec![(name.into(), injection(window))] };
        make(&spec(&[]), &descriptions(), &options)
    };
    let plan = with("grains", 7).unwrap();
    assert_eq!(plan.components[1].assignment(transport(), None).injections, [injection(7)]);
    assert!(plan.components[0].assignment(transport(), None).injections.is_empty());
    assert!(with("grain", 7).unwrap_err()[0].to_string().contains("did you mean \"grains\"?"));
    assert!(with("grains", 10_001).unwrap_err()[0].message.contains("none of the run"));
}

#[test]
fn velocities_at_faces_must_be_told_and_taken() {
    let inlet = r#"
[[scene.inlets]]
name = "feed"
density = "2500 kg/m3"
min = ["0 m", "0 m", "0 m"]
max = ["1 m", "1 m", "0.2 m"]
fraction = 0.05
diameter = "1 cm"
velocity = { face = "z_lower" }
[components]
"#;
    let text = MANIFEST.replace("[components]\n", inlet);
    let spec = manifest::parse(Path::new("manifest.toml"), text, &[]).unwrap().spec;
    let with = |fluid: bool, grains: bool| {
        let mut all = descriptions();
        (all[0].1.ports, all[1].1.ports) = (fluid, grains);
        make(&spec, &all, &Options::default())
    };
    let plan = with(true, true).unwrap();
    let edge = plan.edges.iter().find(|edge| edge.content == Content::Ports).unwrap();
    assert_eq!((edge.service.as_str(), edge.capacity), ("fluid/ports/grains", 1));
    for (fluid, grains, words) in [
        (false, true, "which fluid-lbm 0.1, the run's fluid, does not tell"),
        (true, false, "which grains-dem 0.1, the run's grains, does not take"),
    ] {
        let problems = with(fluid, grains).unwrap_err();
        assert_eq!(problems[0].key, "scene.inlets[0].velocity");
        assert!(problems[0].message.contains(words), "{problems:?}");
    }
    let dry = Spec { components: spec.components[1..].to_vec(), ..spec.clone() };
    let problems = make(&dry, &descriptions(), &Options::default()).unwrap_err();
    assert!(problems[0].message.contains("the run has no fluid"), "{problems:?}");
}

#[test]
fn numbers_are_short() {
    assert_eq!(short(1.2e-7 / 3.0), "4e-8");
    assert_eq!(short(2.4), "2.4");
    assert_eq!(short(1.0 / 3.0), "0.333333");
    assert_eq!(short(0.0), "0");
}

proptest! {
    #[test]
    fn steps_fit_and_are_never_lengthened(
        a in 1e-9..1e-2f64,
        ratio in 1.0..900.0f64,
        middle in 1.0..30.0f64,
        sync_iter in prop::option::of(1u32..6),
        length in 0.5..1e4f64,
    ) {
        let wish = |name: &str, step, sync_iter| Wish {
            name: name.into(),
            key: name.into(),
            step: Some(step),
            limit: String::new(),
            sync_iter,
        };
        let wishes = [wish("slow", a, sync_iter), wish("middle", a / middle, None), wish("fast", a / ratio, None)];
        let until = a * length;
        match assign(&wishes, until) {
            Err(problems) => prop_assert!(ratio * f64::from(sync_iter.unwrap_or(1)) > 999.0, "{:?}", problems),
            Ok(steps) => {
                let window = steps.clock.window();
                prop_assert!(close(window, a * f64::from(sync_iter.unwrap_or(1))));
                for (wish, n) in wishes.iter().zip(&steps.substeps) {
                    let step = steps.step(*n);
                    let largest = wish.step.unwrap();
                    prop_assert_eq!(steps.clock.ticks_per_window % u64::from(*n), 0);
                    prop_assert!((step * f64::from(*n) - window).abs() <= 1e-12 * window);
                    prop_assert!(step <= largest * (1.0 + 1e-8));
                    let one_fewer = window / f64::from(*n - 1).max(0.5);
                    prop_assert!(*n == 1 || one_fewer > largest * (1.0 - 1e-8), "as few as fit");
                }
                let run = window * steps.windows as f64;
                prop_assert!(run >= until * (1.0 - 1e-6) - 1e-8 * window);
                prop_assert!(run < until + window * (1.0 + 1e-8));
            }
        }
    }
}

#[test]
fn a_rubber_makes_the_substeps_of_the_grains_and_bounds_them() {
    use tremie_messages::scene::{DeformableSurface, Pose, Section, SectionEdge};
    let mut spec = spec(&[]);
    spec.components.push(ComponentSpec {
        name: "rubber".into(),
        role: Role::Rubber,
        program: "rubber-table".into(),
        ..spec.component("grains").unwrap().clone()
    });
    // A disc: its first and last points are on the axis.
    let edge = |a: u32| SectionEdge { points: [a, a + 1], kind: Default::default() };
    let section = Section {
        points: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        edges: (0..3).map(edge).collect(),
    };
    spec.scene.surfaces.push(DeformableSurface {
        name: "seal".into(),
        carrier: "disc".into(),
        table: String::new(),
        pose: Pose::IDENTITY,
        sectors: 10,
        material: "rubber".into(),
        seat_stiffness: 1e9,
        start: Default::default(),
        section,
    });
    for (bound, substeps) in [(None, 3), (Some(5e-8), 3), (Some(2e-8), 6)] {
        let mut descriptions = descriptions();
        descriptions.push(("rubber".into(), Description { step: bound, ..Description::default() }));
        let plan = make(&spec, &descriptions, &Options::default()).unwrap();
        let of = |name: &str| plan.components.iter().find(|c| c.name == name).unwrap();
        assert_eq!((of("grains").substeps, of("rubber").substeps), (substeps, substeps));
        assert_eq!((of("fluid").substeps, of("viewer").substeps), (1, 1));
        let edge = |content| plan.edges.iter().find(|edge| edge.content == content).unwrap();
        let capacity = |content| edge(content).capacity;
        assert_eq!([Content::Surface, Content::Trial].map(capacity), [22, 22]);
        assert_eq!([Content::SurfaceLoad, Content::Contact].map(capacity), [160, 160]);
        assert_eq!([Content::Carrier, Content::Resultant].map(capacity), [1, 1]);
        assert_eq!(edge(Content::Trial).sender_substeps, substeps);
        assert_eq!(edge(Content::SurfaceLoad).service, "fluid/surface_load/rubber");
        let seen = |plan: &Plan| {
            let frames = plan.frames.iter().filter(|s| s.content == FrameContent::Surfaces);
            frames.map(|s| (s.service.clone(), s.capacity)).collect::<Vec<_>>()
        };
        assert_eq!(seen(&plan), [], "nobody asks");
        descriptions[3].1.watches.surfaces = true;
        let plan = make(&spec, &descriptions, &Options::default()).unwrap();
        assert_eq!(seen(&plan), [("rubber/frames/surfaces/viewer".to_string(), 22)]);
    }
    let injection = Injection { kind: InjectionKind::SubstepMore, window: 3 };
    let options = Options { injections: vec![("rubber".into(), injection)] };
    let mut descriptions = descriptions();
    descriptions.push(("rubber".into(), Description::default()));
    let problems = make(&spec, &descriptions, &options).unwrap_err();
    assert!(problems[0].message.contains("substeps of the grains"), "{problems:?}");
}
