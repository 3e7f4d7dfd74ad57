//! Grains that come and go.

use crate::tremie::run_text;
use tremie_sdk::messages::INTERFACE_VERSION;

/// A stream that brings grains and takes them away.
pub const STREAM: &str = r#"
[run]
until = "6 ms"

[scene]
gravity = ["0 m/s2", "0 m/s2", "0 m/s2"]

[scene.domain]
size = ["4 mm", "4 mm", "8 mm"]
x = "periodic"
y = "periodic"
z = { lower = { velocity = ["0 m/s", "0 m/s", "1 m/s"] }, upper = { pressure = "0 Pa" } }

[scene.fluid]
density = "1000 kg/m3"
viscosity = "0.05 Pa s"
velocity = ["0 m/s", "0 m/s", "1 m/s"]
expected_speed = "1.5 m/s"

[[scene.inlets]]
name = "feed"
density = "1200 kg/m3"
min = ["0 mm", "0 mm", "0 mm"]
max = ["4 mm", "4 mm", "3 mm"]
fraction = 0.08
diameter = "0.9 mm"
velocity = ["0 m/s", "0 m/s", "1 m/s"]

[[scene.outlets]]
name = "drain"
beyond = { axis = "z", at = "7 mm", side = "upper" }

[[scene.contacts]]
normal_stiffness = "500 N/m"
tangential_stiffness = "400 N/m"
friction = 0.3
restitution = 0.8

[components]
fluid = "fluid-lbm"
grains = "grains-dem"

[settings.fluid-lbm]
cell = "0.2 mm"
"#;

/// Grains that came, less grains that went, are the grains that live. Processes and threads, and
/// any number of them, give the same bits.
#[test]
fn a_stream_brings_grains_and_takes_them_away() {
    for schedule in ["serial", "parallel"] {
        let bits = |options: &[&str]| {
            let all = [&["--set", "outputs.record=false", "--schedule", schedule], options];
            run_text(STREAM, &all.concat()).succeeded()
        };
        let ran = bits(&[]);
        let signals = ran.signals();
        let column = |name: &str| &signals[&format!("grains.{name}")];
        let (came, went) = (column("feed.inserted"), column("drain.removed"));
        for (k, living) in column("bodies").iter().enumerate() {
            assert_eq!(came[k] - went[k], *living);
        }
        let (first, last) = (came[0], came.len() - 1);
        assert!(came[last] > first + 10.0 && went[last] > 1.0, "{came:?} {went:?}");
        assert_eq!(ran.signals_text(), bits(&["--in-process"]).signals_text());
        let threads = "components.grains={ program = \"grains-dem\", threads = 3 }";
        assert_eq!(ran.signals_text(), bits(&["--set", threads]).signals_text());
    }
}

/// The stream, slower at first, long enough to fill the region many times. Its heavy grains keep
/// the velocity with which they come: the fluid's at the face.
fn ramp() -> String {
    let given = r#"velocity = ["0 m/s", "0 m/s", "1 m/s"]"#;
    let probe = r#"
[[scene.probes]]
name = "zone"
region = { min = ["0 mm", "0 mm", "0 mm"], max = ["4 mm", "4 mm", "3 mm"] }

[[scene.contacts]]"#;
    let of_face = r#"velocity = { face = "z_lower" }"#;
    STREAM
        .replace("until = \"6 ms\"", "until = \"50 ms\"")
        .replace(
            &format!("lower = {{ {given} }}"),
            &format!("lower = {{ {given}, ramp = \"8 ms\" }}"),
        )
        .replace(&format!("{given}\nexpected"), "expected")
        .replace(&format!("mm\"\n{given}"), &format!("mm\"\n{of_face}"))
        .replace("1200 kg/m3", "8000 kg/m3")
        .replace("cell = \"0.2 mm\"", "cell = \"0.3333333333333333 mm\"")
        .replace("\n[[scene.contacts]]", probe)
}

/// Grains come as fast as the fluid at the face, and fill what they fill in the mean over time
/// although the stream grows: within 2 %. At rest, they would be half as fast. Processes and
/// threads give the same bits.
#[test]
fn grains_come_as_fast_as_the_fluid_at_the_face() {
    for schedule in ["serial", "parallel"] {
        let run = |until: &str, options: &[&str]| {
            let all = ["--set", "outputs.record=false", "--schedule", schedule, "--until", until];
            run_text(&ramp(), &[&all, options].concat()).succeeded()
        };
        let signals = run("50 ms", &[]).signals();
        let mean = |name: &str, from: f64| {
            let first = signals["time"].partition_point(|t| *t < from);
            let values = &signals[name][first..];
            values.iter().sum::<f64>() / values.len() as f64
        };
        let fraction = mean("grains.zone.solid_fraction", 2e-3);
        // They come whole, 0.9 mm from the face in the mean.
        let filled = 1.0 - 0.9 / 3.0;
        assert!((fraction / (0.08 * filled) - 1.0).abs() < 0.02, "{schedule}: {fraction}");
        let speed = mean("grains.zone.velocity_z", 16e-3);
        assert!((speed - 1.0).abs() < 0.08, "{schedule}: {speed}");
        let bits = [run("8 ms", &[]), run("8 ms", &["--in-process"])].map(|ran| ran.signals_text());
        assert_eq!(bits[0], bits[1], "{schedule}");
    }
}

/// A message of the ports' edge with a wrong stamp, count or value is the fluid's fault, noticed by
/// the grains; so is one that is lost.
#[test]
fn wrong_messages_of_ports_are_caught() {
    let cases = [("stale", "stamp"), ("count", "count"), ("nan", "not_finite"), ("drop", "lost")];
    for (k, (fault, kind)) in cases.into_iter().enumerate() {
        let inject = format!("fluid:{fault}@{}", 7 + 3 * k);
        let schedule = ["serial", "parallel"][k % 2];
        let options = ["--inject", &inject, "--schedule", schedule, "--set", "run.deadline=30 s"];
        let ran = run_text(&ramp(), &options);
        let about = format!("{inject} {schedule}\n{}", ran.errors());
        assert_eq!(ran.code(), Some(1), "{about}");
        let found = ran.summary()["fault"].clone();
        assert_eq!((&found["blamed"], &found["noticed_by"]), (&"fluid".into(), &"grains".into()));
        // Where the message after it comes in its place, a lost one is a wrong stamp.
        let kinds = [kind, if kind == "lost" { "stamp" } else { kind }];
        assert!(kinds.contains(&found["kind"].as_str().unwrap()), "{about}");
        assert!(found["message"].as_str().unwrap().contains("ports"), "{about}");
        ran.left_nothing(&about);
    }
}

#[test]
fn a_fluid_that_tells_no_velocities_is_refused_where_they_are_asked_for() {
    let home = tempfile::tempdir().unwrap();
    let told = crate::tremie::description(INTERFACE_VERSION);
    let program = crate::tremie::script(
        home.path(),
        "mute",
        &format!("read hello; echo '{told}'; read assignment"),
    );
    let text = ramp().replace("fluid = \"fluid-lbm\"", &format!("fluid = {program:?}"));
    let ran = run_text(&text, &[]);
    assert_eq!(ran.code(), Some(2), "{}", ran.errors());
    let errors = ran.errors();
    assert!(errors.contains("scene.inlets[0].velocity"), "{errors}");
    assert!(errors.contains("does not tell"), "{errors}");
}

/// A box that an inlet fills without a way out comes to rest, without a word of how many fit; a
/// capacity below that is doubted with both numbers, and where it is met the error names the key.
#[test]
fn a_box_fills_up_without_a_word_of_how_many_fit() {
    let text = r#"
[run]
until = "0.8 s"
[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]
[scene.domain]
size = ["10 mm", "10 mm", "20 mm"]
[[scene.inlets]]
name = "i"
density = "2500 kg/m3"
min = ["1 mm", "1 mm", "14 mm"]
max = ["9 mm", "9 mm", "19 mm"]
fraction = 0.15
diameter = "2 mm"
velocity = ["0 m/s", "0 m/s", "-0.3 m/s"]
[[scene.contacts]]
normal_stiffness = "2000 N/m"
tangential_stiffness = "1600 N/m"
friction = 0.3
restitution = 0.5
[components]
grains = "grains-dem"
[outputs]
record = false
"#;
    let ran = run_text(text, &[]).succeeded();
    let bodies = ran.signals()["grains.bodies"].last().copied().unwrap();
    // More than twice the inlet's fraction of the box would be.
    assert!(bodies > 0.32 * 2000.0 / (std::f64::consts::PI / 6.0 * 8.0), "{bodies}");
    let ran = run_text(text, &["--set", "settings.grains-dem.capacity=60"]);
    assert_eq!(ran.code(), Some(1), "{}", ran.errors());
    let errors = ran.errors();
    assert!(errors.contains("doubtful: grains: room for spheres is 60: 306 fit"), "{errors}");
    assert!(errors.contains("raise `capacity` in settings.grains-dem"), "{errors}");
}
