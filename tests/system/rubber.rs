//! A rubber ring on a valve, in a run: the dry test of Mutabaruka and Kamrin (Fig. 11), and what
//! can go wrong inside a window.

use crate::fields::reader::VtkFile;
use crate::tremie::{Ran, run, tremie};
use std::collections::BTreeMap;
use std::path::PathBuf;
use tremie_messages::frame::SurfaceSample;
use tremie_recorder::{Item, Recording};
use tremie_rubber_table::{make::make, spec::Spec, table::Table};

/// The valve's ring.
const RING: &str = r#"
[section.rectangle]
inner_radius = "6.5 mm"
outer_radius = "11 mm"
height = "3 mm"
elements = [6, 4]

[rubber]
shear_modulus = "0.3 MPa"
bulk_modulus = "8 MPa"

[table]
compression = "0.6 mm"
"#;

/// A valve of 9.2 g with the ring below, touching twelve spheres on the floor; 40 N press it down.
const VALVE: &str = r#"
[run]
until = "4 ms"

[scene.domain]
size = ["30 mm", "30 mm", "12 mm"]

[scene.materials.rubber]

[[scene.parts]]
name = "disc"
cylinder = { radius = "11 mm", length = "2 mm" }
position = ["15 mm", "15 mm", "5.4 mm"]
motion = { slider = { axis = [0, 0, 1], mass = "9.2 g", force = "-40 N" } }

[[scene.surfaces]]
name = "ring"
carrier = "disc"
table = "ring.json"
position = ["0 mm", "0 mm", "-4 mm"]
sectors = 24
material = "rubber"

[[scene.bodies]]
name = "beads"
density = "2500 kg/m3"
spheres = [
    BEADS
]

[[scene.contacts]]
between = ["beads", "rubber"]
normal_stiffness = "1e5 N/m"
tangential_stiffness = "0 N/m"
normal_damping = "0 kg/s"
tangential_damping = "0 kg/s"

[[scene.contacts]]
normal_stiffness = "1e6 N/m"
tangential_stiffness = "0 N/m"
normal_damping = "2 kg/s"
tangential_damping = "0 kg/s"

[components]
grains = { program = "grains-dem", sync_iter = 10 }
rubber = "rubber-table"

[settings.grains-dem]
time_step = "4e-7 s"

[outputs]
record = false
"#;

/// The manifest and the ring's table, in a folder of their own.
pub struct Valve {
    home: tempfile::TempDir,
    table: Table,
}

impl Valve {
    fn new() -> Self {
        Self::on_beads(VALVE)
    }

    /// With friction on spheres that gravity draws along the floor.
    pub fn on_rough_spheres() -> Self {
        let rough = "tangential_stiffness = \"5e4 N/m\"\nfriction = 0.3";
        let text = VALVE.replace("tangential_stiffness = \"0 N/m\"", rough);
        Self::on_beads(&format!("scene.gravity = [\"4 m/s2\", \"0 m/s2\", \"-9 m/s2\"]\n{text}"))
    }

    fn on_beads(text: &str) -> Self {
        // In the middle of every other sector: there the foot is a flat facet, not an edge.
        let bead = |k: usize| {
            let (sin, cos) = (std::f64::consts::PI * (4 * k + 1) as f64 / 24.0).sin_cos();
            let (x, y) = (15.0 + 8.75 * cos, 15.0 + 8.75 * sin);
            format!(
                "    {{ position = [\"{x} mm\", \"{y} mm\", \"0.7 mm\"], diameter = \"1.4 mm\" }},"
            )
        };
        let beads: Vec<String> = (0..12).map(bead).collect();
        Self::of(&text.replace("    BEADS", &beads.join("\n")))
    }

    fn of(text: &str) -> Self {
        let home = tempfile::tempdir().unwrap();
        let spec = Spec::parse(&PathBuf::from("ring.toml"), RING.into()).unwrap();
        let table = make(&spec).unwrap();
        table.write(&home.path().join("ring.json")).unwrap();
        std::fs::write(home.path().join("manifest.toml"), text).unwrap();
        Self { home, table }
    }

    /// Writes manifest and table into a folder, with words of the manifest replaced by others.
    pub fn write(&self, folder: &std::path::Path, changes: &[[&str; 2]]) {
        let mut text = std::fs::read_to_string(self.home.path().join("manifest.toml")).unwrap();
        for [from, to] in changes {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        std::fs::write(folder.join("manifest.toml"), text).unwrap();
        self.table.write(&folder.join("ring.json")).unwrap();
    }

    pub fn run(&self, options: &[&str]) -> Ran {
        run(self.home.path().to_str().unwrap(), options)
    }
}

fn last_value(ran: &Ran, name: &str) -> f64 {
    last(&ran.signals(), name)
}

fn last(signals: &BTreeMap<String, Vec<f64>>, name: &str) -> f64 {
    *signals[name].last().unwrap()
}

#[test]
fn the_valve_comes_to_rest_on_its_ring() {
    let valve = Valve::new();
    for (load, settled) in [(40.0, 0.313e-3), (10.0, 0.087e-3)] {
        let force = format!("scene.parts[0].motion.slider.force=-{load} N");
        let ran = valve.run(&["--set", &force]).succeeded();
        let signals = ran.signals();
        let value = |name: &str| last(&signals, name);
        // F = h = the load, and the grains get the same force.
        for name in ["rubber.ring.force", "rubber.ring.table_force", "grains.disc.surface_force"] {
            assert!((value(name) / load - 1.0).abs() < 5e-3, "{name}: {} of {load}", value(name));
        }
        let compression = value("rubber.ring.compression");
        assert!((compression / settled - 1.0).abs() < 0.03, "{compression}");
        let at = valve.table.bracket(compression).unwrap();
        assert!((value("rubber.ring.table_force") - valve.table.force(at)).abs() < 1e-6 * load);
        // Damping over the secant's slope.
        let rows = &signals["rubber.ring.table_force"];
        let gone = rows.iter().position(|h| *h >= load * (1.0 - (-1.0f64).exp())).unwrap();
        let (time, expected) = (signals["time"][gone], 80.0 * compression / load);
        assert!((time / expected - 1.0).abs() < 0.12, "{time} s, {expected} s");
        let passes = value("rubber.ring.mean_passes");
        assert!((2.0..5.0).contains(&passes), "{passes} passes");
        assert!(value("rubber.ring.most_passes") < 20.0);
    }
}

/// Beads of different sizes on the floor from the ring's inner rim to its outer, and small ones
/// that fly up at it.
fn squeezed_and_thrown() -> Vec<String> {
    let at = |turn: f64, r: f64| {
        let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
        (15.0 + r * cos, 15.0 + r * sin)
    };
    let squeezed = (0..15).map(|k| {
        let (x, y) = at((f64::from(k) + 0.3) / 15.0, 6.45 + 4.6 * f64::from(k) / 14.0);
        let d = [1.4, 1.3, 1.36][k as usize % 3];
        let z = 0.5 * d;
        format!("{{ position = [\"{x} mm\", \"{y} mm\", \"{z} mm\"], diameter = \"{d} mm\" }},")
    });
    let thrown = (0..6).map(|k| {
        let r = [6.4, 8.75, 11.1, 6.5, 10.0, 11.0][k];
        let (x, y) = at((2.0 * k as f64 + 0.8) / 15.0, r);
        let (place, up) = (
            format!("[\"{x} mm\", \"{y} mm\", \"0.5 mm\"]"),
            "[\"0 m/s\", \"0 m/s\", \"1.5 m/s\"]",
        );
        format!("{{ position = {place}, diameter = \"0.9 mm\", velocity = {up} }},")
    });
    squeezed.chain(thrown).collect()
}

/// Friction and dashpots everywhere, contacts that open within a step, grains on the ring's rims,
/// which count with its foot or with its sides. The ring is thrown off nowhere, and comes to rest
/// on the largest grains. Processes and threads give the same bits.
#[test]
fn grains_with_dashpots_are_squeezed_and_thrown_at_the_ring() {
    let text = VALVE
        .replace("    BEADS", &squeezed_and_thrown().join("\n"))
        .replace("5.4 mm", "5.6 mm")
        .replace("until = \"4 ms\"", "until = \"2 ms\"")
        .replace("4e-7 s", "4.8e-8 s");
    let contacts = text.find("[[scene.contacts]]").unwrap();
    let components = text.find("[components]").unwrap();
    let damped = r#"[[scene.contacts]]
normal_stiffness = "1e6 N/m"
tangential_stiffness = "8e5 N/m"
friction = 0.4
restitution = 0.3

"#;
    let text = [&text[..contacts], damped, &text[components..]].concat();
    let valve = Valve::of(&text);
    let ran = valve.run(&["--in-process"]).succeeded();
    let signals = ran.signals();
    for name in ["rubber.ring.force", "grains.disc.surface_force"] {
        assert!(
            (last(&signals, name) / 40.0 - 1.0).abs() < 0.02,
            "{name}: {}",
            last(&signals, name)
        );
    }
    // The thrown ones have lost what they had, and what the ring lost went nowhere else.
    assert!(last(&signals, "grains.kinetic_energy") < 1e-3 * 3.5e-3);
    let [mean, most] = ["mean", "most"].map(|of| &signals[&format!("rubber.ring.{of}_passes")]);
    let mean = mean.iter().sum::<f64>() / mean.len() as f64;
    let most = most.iter().fold(0.0, |a: f64, b| a.max(*b));
    assert!(mean < 5.0 && most < 60.0, "{mean} passes, at most {most}");
    let bits = |options: &[&str]| {
        valve.run(&[&["--set", "run.until=0.4 ms"], options].concat()).succeeded().signals_text()
    };
    assert!(bits(&[]) == bits(&["--in-process"]), "threads and processes differ");
}

#[test]
fn processes_threads_and_repeats_agree() {
    let valve = Valve::new();
    let short = ["--set", "run.until=0.1 ms"];
    let bits = |more: &[&str]| {
        let ran = valve.run(&[&short[..], more].concat()).succeeded();
        ran.left_nothing("a run with rubber");
        ran.signals_text()
    };
    let once = bits(&[]);
    assert!(once.lines().count() > 20, "too short a run to tell");
    assert!(once == bits(&["--in-process"]), "threads and processes differ");
    let two = "components.grains={ program = \"grains-dem\", sync_iter = 10, threads = 2 }";
    assert!(once == bits(&["--set", two]), "one thread and two differ");
    assert!(once == bits(&["--schedule", "parallel"]), "no fluid, no order of work");
}

#[test]
fn a_ring_that_is_watched_is_the_same_ring() {
    let valve = Valve::new();
    let short = ["--set", "run.until=0.1 ms"];
    let alone = valve.run(&short).succeeded().signals_text();
    let view = valve.home.path().join("run.rrd");
    let watched = ["--set", "outputs.record=true", "--set", "outputs.frames=20 us"];
    let more = ["--set", "outputs.fields=50 us", "--view", view.to_str().unwrap()];
    let ran = valve.run(&[&short[..], &watched, &more].concat()).succeeded();
    assert!(ran.signals_text() == alone, "observers changed the run");
    let items = Recording::open(&ran.out.join("run.mcap")).unwrap().items();
    let surfaces = |item: Result<Item, _>| match item.unwrap() {
        Item::Surfaces { at, samples, .. } => Some((at.stamp.window, samples)),
        _ => None,
    };
    let seen: Vec<_> = items.filter_map(surfaces).collect();
    // The start, and every five of 25 windows.
    assert_eq!(seen.len(), 6);
    let lowest = |samples: &[SurfaceSample]| {
        samples.iter().map(|s| s.vertex.position[2]).fold(f64::INFINITY, f64::min)
    };
    let highest_strain =
        |samples: &[SurfaceSample]| samples.iter().map(|s| s.strain).fold(0.0, f64::max);
    let (_, first) = seen.first().unwrap();
    let (window, last) = seen.last().unwrap();
    assert!((lowest(first) - 1.4e-3).abs() < 1e-9 && highest_strain(first) == 0.0);
    // It bulges as it is pressed.
    let compression = last_value(&ran, "rubber.ring.compression");
    let pressed = lowest(last) - lowest(first);
    let moved = last_value(&ran, "grains.disc.lift");
    // The foot lies on the seat of the table as well as that holds it.
    assert!((pressed - (compression + moved)).abs() < 1e-8, "{pressed} {compression} {moved}");
    let strain = highest_strain(last);
    let mean = compression / 3e-3;
    assert!((mean..10.0 * mean).contains(&strain), "{strain}, compressed by {mean}");
    let file = VtkFile::read(&ran.out.join(format!("fields/rubber_{window:06}.vtp")));
    let sent: Vec<f64> = last.iter().map(|sample| sample.strain).collect();
    assert_eq!(file.array::<f64>("strain"), (1, sent));
    assert!(std::fs::read(&view).unwrap().starts_with(b"RRF"));
}

#[test]
fn faults_inside_a_window_are_caught_with_both_sides_named() {
    let valve = Valve::new();
    for (component, fault, kinds) in [
        ("rubber", "drop", &["lost"][..]),
        ("rubber", "duplicate", &["stamp"]),
        ("rubber", "stale", &["stamp"]),
        ("rubber", "count", &["count"]),
        ("rubber", "nan", &["not_finite"]),
        ("rubber", "hang", &["deadline"]),
        ("rubber", "exit", &["exit"]),
        ("rubber", "kill", &["exit"]),
        ("grains", "drop", &["lost"]),
        ("grains", "duplicate", &["stamp", "substeps"]),
        ("grains", "stale", &["stamp"]),
        ("grains", "count", &["count"]),
        ("grains", "nan", &["not_finite"]),
        ("grains", "hang", &["deadline"]),
        ("grains", "kill", &["exit"]),
        ("grains", "substep-more", &["substeps", "stamp"]),
        ("grains", "substep-less", &["substeps", "stamp"]),
    ] {
        let inject = format!("{component}:{fault}@5");
        // Only one that hangs is found by the deadline; on a busy machine a short one would find
        // others first.
        let deadline = if fault == "hang" { 3.0 } else { 30.0 };
        let deadline = format!("run.deadline={deadline} s");
        let sets = ["--set", &deadline, "--set", "run.until=0.1 ms"];
        let ran = valve.run(&[&["--inject", &inject][..], &sets].concat());
        let about = format!("{inject}\n{}", ran.errors());
        assert_eq!(ran.code(), Some(1), "{about}");
        let found = &ran.summary()["fault"];
        assert!(kinds.contains(&found["kind"].as_str().unwrap()), "{about}");
        assert_eq!(found["blamed"], component, "{about}");
        assert_ne!(found["noticed_by"], component, "{about}");
        assert!(found["window"].as_u64().unwrap().abs_diff(5) <= 1, "{about}");
        ran.left_nothing(&about);
    }
    let refused = valve.run(&["--inject", "rubber:substep-more@5"]);
    assert!(refused.errors().contains("makes the substeps of the grains"), "{}", refused.errors());
}

#[test]
fn a_ring_that_leaves_its_table_ends_the_run_with_what_to_do() {
    let valve = Valve::new();
    let pressed = ["--set", "scene.parts[0].motion.slider.force=-100 N"];
    let failed = |options: &[&str], kind: &str, words: &[&str]| {
        let ran = valve.run(&[&pressed[..], options].concat());
        assert_eq!(ran.code(), Some(1), "{}", ran.errors());
        let found = &ran.summary()["fault"];
        assert_eq!((&found["kind"], &found["blamed"]), (&kind.into(), &"rubber".into()));
        words.iter().for_each(|word| assert!(ran.errors().contains(word), "{}", ran.errors()));
    };
    // Its watchdog sees it come.
    let words = ["compression of ring over the largest of its table is 0.99", "watch.compression"];
    failed(&[], "physics", &words);
    let words = ["\"ring\"", "its table ends at 0.6000 mm", "larger compression"];
    failed(&["--set", "watch.compression=off"], "solver", &words);
}

#[test]
fn what_cannot_carry_or_hold_a_ring_says_so() {
    let valve = Valve::new();
    // Parts that do not slide.
    let output = tremie()
        .arg("check")
        .arg(valve.home.path())
        .args(["--set", "scene.parts[0].motion=fixed"])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("scene.surfaces[0].carrier") || said.contains("carrier = "), "{said}");
    assert!(said.contains("does not slide"), "{said}");
    // In the floor from the start.
    let output = tremie()
        .arg("check")
        .arg(valve.home.path())
        .args(["--set", "scene.parts[0].position=[\"15 mm\", \"15 mm\", \"3 mm\"]"])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        said.contains("begins 1.000e-3 m deep in its seat") && said.contains("(start)"),
        "{said}"
    );
    // A fluid that knows nothing of surfaces.
    let ran = valve.run(&[
        "--set",
        "scene.fluid={ density = \"1000 kg/m3\", viscosity = \"1 Pa s\" }",
        "--set",
        "components.fluid=minimal-fluid",
    ]);
    assert_eq!(ran.code(), Some(2), "{}", ran.errors());
    assert!(ran.errors().contains("takes no deformable surfaces"), "{}", ran.errors());
}
