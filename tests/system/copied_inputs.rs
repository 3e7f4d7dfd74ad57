//! The files that a manifest names are copied into the folder of a run: it needs nothing else from there on.

use crate::resume::{assert_same, resumed};
use crate::rubber::Valve;
use crate::running::{Running, until};
use crate::tremie::{Ran, run, tremie};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;
use tempfile::TempDir;
use tremie_geometry::Mesh;
use tremie_messages::scene::Geometry;

/// Grains that fall onto two parts. The meshes of these and that of the grains have one name.
const HEAP: &str = r#"
[run]
until = "36 ms"
checkpoints = { windows = 20, keep = 9 }

[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]

[scene.domain]
size = ["20 mm", "10 mm", "30 mm"]

[[scene.parts]]
name = "paddle"
file = "paddle/mesh.stl"
unit = "mm"
position = ["7 mm", "5 mm", "4 mm"]
motion = "prescribed"
velocity = ["0 m/s", "0 m/s", "0.02 m/s"]

[[scene.parts]]
name = "stop"
file = "stop/mesh.stl"
unit = "mm"
position = ["13 mm", "5 mm", "5 mm"]

[[scene.shapes]]
name = "block"
file = "block/mesh.stl"

[[scene.bodies]]
name = "blocks"
density = "2500 kg/m3"
shape = "block"
polyhedra = [
    { position = ["7 mm", "5 mm", "9 mm"], diameter = "3 mm" },
    { position = ["13 mm", "5 mm", "10 mm"], diameter = "3 mm" },
]

[[scene.contacts]]
normal_stiffness = "2000 N/m"
tangential_stiffness = "1600 N/m"
friction = 0.4
restitution = 0.4

[components]
grains = { program = "grains-dem", sync_iter = 50 }

[settings.grains-dem]
time_step = "6 us"
"#;

/// A folder with a manifest and its meshes.
struct Home(TempDir);

impl Home {
    fn new() -> Self {
        let home = Self(tempfile::tempdir().unwrap());
        std::fs::write(home.path("manifest.toml"), HEAP).unwrap();
        for name in ["paddle", "stop", "block"] {
            std::fs::create_dir(home.path(name)).unwrap();
        }
        home.mesh("paddle", Geometry::Box { size: [3e-3; 3] });
        home.mesh("stop", Geometry::Sphere { radius: 2e-3 });
        home.mesh("block", Geometry::Box { size: [1e-3, 2e-3, 1e-3] });
        home
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn mesh(&self, name: &str, geometry: Geometry) {
        let mut file = std::fs::File::create(self.path(name).join("mesh.stl")).unwrap();
        Mesh::of(&geometry).unwrap().write_stl(&mut file, 1e-3).unwrap();
    }

    fn run(&self, options: &[&str]) -> Ran {
        run(self.path("manifest.toml").to_str().unwrap(), &[&["--quiet"], options].concat())
    }
}

/// The run of a folder that was brought elsewhere, and of whose files none is where it was, comes to the end of the
/// run that stayed: also its recording, which is watched there.
#[test]
fn a_run_goes_on_wherever_its_folder_was_brought() {
    let (home, away) = (Home::new(), tempfile::tempdir().unwrap());
    let whole = home.run(&[]).succeeded();
    let broken = home.run(&["--inject", "grains:kill@57"]);
    assert_eq!(broken.code(), Some(1), "{}", broken.errors());
    let moved = away.path().join("moved");
    std::fs::rename(&broken.out, &moved).unwrap();
    drop(home);
    for name in ["mesh.stl", "mesh-2.stl", "mesh-3.stl"] {
        assert!(moved.join("inputs").join(name).exists(), "{name}");
    }
    let manifest = std::fs::read_to_string(moved.join("manifest.toml")).unwrap();
    assert!(manifest.contains("file = \"inputs/mesh-2.stl\""), "{manifest}");
    resumed(&moved, &[]);
    assert_same(&whole.out, &moved);
    let watched = away.path().join("run.rrd");
    let mut view = tremie();
    view.arg("view").arg(&moved).arg("--view").arg(&watched);
    let output = view.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(watched.exists());
    // Changes of its user are made from there, too, and a replay finds the files.
    resumed(&moved, &["--at", "40", "--set", "scene.contacts[0].friction=0.1"]);
    let mut replay = tremie();
    replay.arg("replay").arg(&moved).args(["--only", "grains", "--at", "20"]);
    let output = replay.output().unwrap();
    assert!(!output.status.success(), "the messages were not recorded");
    assert!(!String::from_utf8_lossy(&output.stderr).contains("mesh"), "{output:?}");
}

#[test]
fn a_run_goes_on_without_the_table_of_its_ring() {
    let valve = Valve::on_rough_spheres();
    let every = "run.checkpoints={ windows = 60, keep = 99 }";
    let options = ["--quiet", "--until", "1.2 ms", "--set", every];
    let whole = valve.run(&options).succeeded();
    let broken = valve.run(&[&options[..], &["--inject", "grains:kill@217"]].concat());
    drop(valve);
    resumed(&broken.out, &[]);
    assert_same(&whole.out, &broken.out);
}

/// A run that goes on by itself after a fault does so with the files that it began with.
#[test]
fn a_file_that_is_edited_meanwhile_changes_no_run() {
    let home = Home::new();
    let whole = home.run(&[]).succeeded();
    let out = home.path("out");
    let mut command = tremie();
    command.arg("run").arg(home.path("manifest.toml")).arg("--out").arg(&out).arg("--quiet");
    command.args(["--pause-at", "50", "--restart-on-fault", "1", "--inject", "grains:kill@57"]);
    let mut running = Running::start(command.stdout(Stdio::null()).stderr(Stdio::piped()));
    until("it pauses", || {
        let listed = tremie().args(["ps", "--json"]).output().unwrap().stdout;
        let listed = String::from_utf8(listed).unwrap();
        let own = |line: &str| line.contains(out.to_str().unwrap()) && line.contains("\"paused\"");
        listed.lines().any(own)
    });
    home.mesh("paddle", Geometry::Box { size: [3e-3, 3e-3, 4e-3] });
    assert!(tremie().arg("continue").arg(&out).output().unwrap().status.success());
    let code = running.wait(Duration::from_secs(60));
    assert_eq!(code, Some(0), "{}", running.errors());
    assert_same(&whole.out, &out);
}

/// A file that was changed after a run had begun is not taken for the one that the run has.
#[test]
fn files_count_by_what_they_hold() {
    let (home, twin, other) = (Home::new(), Home::new(), Home::new());
    other.mesh("paddle", Geometry::Box { size: [3e-3, 3e-3, 4e-3] });
    let [first, same, changed] = [&home, &twin, &other].map(|home| home.run(&[]).succeeded());
    let from = format!("{}@40", first.out.display());
    twin.run(&["--from", &from]).succeeded();
    let refused = other.run(&["--from", &from]);
    assert_eq!(refused.code(), Some(2), "{}", refused.errors());
    assert!(refused.errors().contains("scene.parts[0].file"), "{}", refused.errors());
    assert!(!refused.out.exists(), "a refused run leaves nothing");
    let told = |one: &Path, other: &Path| {
        let output = tremie().arg("diff").args([one, other]).output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let (code, text) = told(&first.out, &same.out);
    assert!(code == Some(0) && !text.contains("file"), "{text}");
    let (code, text) = told(&first.out, &changed.out);
    assert!(code == Some(1) && text.contains("scene.parts[0].file"), "{text}");
    assert!(!text.contains("scene.parts[1].file"), "{text}");
}
