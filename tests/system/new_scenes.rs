//! Scenes that `tremie new` makes, as a new user gets them, and completion in a shell.

use crate::tremie::{Ran, root, run, tremie};
use std::path::PathBuf;
use std::process::Output;
use tempfile::TempDir;
use tremie_geometry::Mesh;
use tremie_messages::scene::Geometry;

/// A folder to work in.
struct Home(TempDir);

impl Home {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// `tremie new NAME OPTIONS`.
    fn made(&self, name: &str, options: &[&str]) -> Output {
        let mut command = tremie();
        command.current_dir(self.0.path()).args(["new", name]).args(options).output().unwrap()
    }

    /// The same, and what `tremie check` and a run of few windows say of it.
    #[track_caller]
    fn runs(&self, name: &str, options: &[&str], until: &str) -> (String, Ran) {
        let made = self.made(name, options);
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
        let said = String::from_utf8(made.stdout).unwrap();
        let next = format!("next:\n  tremie check {name}\n  tremie run {name} --view web\n");
        assert!(said.ends_with(&next), "{said}");
        let folder = self.path(name);
        let checked = tremie().arg("check").arg(&folder).output().unwrap();
        let plan = String::from_utf8_lossy(&checked.stdout);
        assert!(checked.status.success(), "{plan}{}", String::from_utf8_lossy(&checked.stderr));
        assert!(plan.contains(" 0 wrong"), "{plan}");
        let options = ["--quiet", "--until", until, "--set", "outputs.record=false"];
        (said, run(folder.to_str().unwrap(), &options).succeeded())
    }

    #[track_caller]
    fn refused(&self, name: &str, options: &[&str]) -> String {
        let made = self.made(name, options);
        let errors = String::from_utf8(made.stderr).unwrap();
        assert_eq!(made.status.code(), Some(2), "{errors}");
        assert!(made.stdout.is_empty());
        errors
    }

    /// Writes a part as a file of triangles.
    fn part(&self, name: &str, geometry: &Geometry, unit: f64) {
        let mut file = std::fs::File::create(self.path(name)).unwrap();
        Mesh::of(geometry).unwrap().write_stl(&mut file, unit).unwrap();
    }

    fn manifest(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name).join("manifest.toml")).unwrap()
    }
}

/// A tube about z, its bore 8 mm wide.
fn tube() -> Geometry {
    let corners = [[4e-3, 0.0], [6e-3, 0.0], [6e-3, 30e-3], [4e-3, 30e-3]];
    Geometry::Revolved { profile: corners.to_vec() }
}

#[test]
fn a_dam_break_is_made_by_default() {
    let home = Home::new();
    let (said, ran) = home.runs("first", &[], "20 ms");
    assert!(said.starts_with("made first\n  manifest.toml"), "{said}");
    assert!(ran.summary()["windows"].as_u64().unwrap() > 2);
    let text = home.manifest("first");
    assert!(text.starts_with("# first: A column of water") && text.contains("tremie explain KEY"));
    assert!(!text.contains("twice as large"), "the example's own head");
    // Where the folder is empty, or its parents are not there.
    std::fs::create_dir(home.path("empty")).unwrap();
    assert!(home.made("empty", &["--from", "dam-break"]).status.success());
    assert!(home.made("deep/down", &[]).status.success());
}

#[test]
fn a_packed_bed_is_made() {
    let (_, ran) = Home::new().runs("bed", &["--from", "packed-bed"], "4 ms");
    let signals = ran.signals();
    assert!(signals["grains.mean_height"].last() < signals["grains.mean_height"].first());
}

#[test]
fn a_valve_is_made() {
    let home = Home::new();
    let (said, ran) = home.runs("valve", &["--from", "valve"], "50 us");
    assert!(said.contains("grains.toml") && said.contains("frame.stl"), "{said}");
    assert!(ran.signals().contains_key("grains.valve.lift"));
    let text = home.manifest("valve");
    assert!(text.contains("scene.domain.z.lower.reservoir.piston: a velocity"), "{text}");
}

/// Water flows through a tube, in any unit; the flow that enters leaves.
#[test]
fn a_tube_is_flowed_through() {
    let home = Home::new();
    home.part("tube.stl", &tube(), 1e-3);
    home.part("tube-inch.stl", &tube(), 25.4e-3);
    let (said, ran) = home.runs("mm", &["--from", "tube.stl", "--unit", "mm"], "0.1 s");
    assert!(said.contains("the part, in millimetres: 12 x 12 x 30 mm"), "{said}");
    assert!(said.contains("as long as a finger") && said.contains("from z-min to z-max"), "{said}");
    let velocity = ran.signals()["fluid.max_speed"].last().copied().unwrap();
    assert!(velocity > 1e-4, "{velocity} m/s");
    let inch = home.made("inch", &["--from", "tube-inch.stl", "--unit", "in"]);
    assert!(inch.status.success(), "{}", String::from_utf8_lossy(&inch.stderr));
    let size = |name: &str| {
        let text = home.manifest(name);
        text.lines().find(|line| line.starts_with("size = ")).map(str::to_string)
    };
    assert_eq!(size("mm"), size("inch"));
    assert!(home.manifest("inch").contains("unit = \"inch\""));
    let copy = std::fs::read(home.path("inch/tube-inch.stl")).unwrap();
    assert_eq!(copy, std::fs::read(home.path("tube-inch.stl")).unwrap());
    let checked = tremie().arg("check").arg(home.path("inch")).output().unwrap();
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
    // The other way.
    let turned = ["--from", "tube.stl", "--unit", "mm", "--inlet", "z-max"];
    let (said, ran) = home.runs("turned", &turned, "0.1 s");
    assert!(said.contains("from z-max to z-min"), "{said}");
    assert!(ran.signals()["fluid.momentum_z"].last().unwrap() < &0.0);
}

#[test]
fn a_ball_is_flowed_around_and_a_surface_may_be_the_waters() {
    let home = Home::new();
    home.part("ball.stl", &Geometry::Sphere { radius: 5e-3 }, 1e-3);
    let (said, ran) = home.runs("ball", &["--from", "ball.stl", "--unit", "mm"], "0.2 s");
    assert!(said.contains("around the part, from x-min to x-max"), "{said}");
    assert!(ran.signals()["fluid.part.force_x"].last().unwrap() > &0.0);
    home.part("bore.stl", &Geometry::Cylinder { radius: 4e-3, length: 30e-3 }, 1e-3);
    let inside = ["--from", "bore.stl", "--unit", "mm", "--flow", "inside"];
    let (said, ran) = home.runs("inside", &inside, "0.1 s");
    assert!(said.contains("fills the inside of the surface, from z-min to z-max"), "{said}");
    assert!(ran.signals()["fluid.momentum_z"].last().unwrap() > &0.0);
}

/// The lines on grains in a manifest, without their signs, are a scene that runs.
#[test]
fn grains_are_added_by_lines_that_are_there() {
    let home = Home::new();
    home.part("tube.stl", &tube(), 1e-3);
    assert!(home.made("tube", &["--from", "tube.stl", "--unit", "mm"]).status.success());
    let mut text = home.manifest("tube");
    let begin = text.find("# [[scene.bodies]]").unwrap();
    let end = begin + text[begin..].find("\n\n").unwrap();
    let block = text[begin..end].replace("# ", "").replace('#', "");
    text.replace_range(begin..end, &block);
    let text = text.replace("# grains = ", "grains = ");
    std::fs::write(home.path("tube/manifest.toml"), text).unwrap();
    let checked = tremie().arg("check").arg(home.path("tube")).output().unwrap();
    let said = String::from_utf8_lossy(&checked.stdout);
    assert!(checked.status.success(), "{said}{}", String::from_utf8_lossy(&checked.stderr));
    assert!(said.contains("grains-dem"), "{said}");
}

#[test]
fn what_cannot_be_made_is_refused_with_a_remedy() {
    let home = Home::new();
    std::fs::create_dir(home.path("mine")).unwrap();
    std::fs::write(home.path("mine/manifest.toml"), "mine").unwrap();
    assert!(
        home.refused("mine", &[]).contains("mine is there already, and nothing is overwritten")
    );
    assert_eq!(home.manifest("mine"), "mine");
    let typo = home.refused("new", &["--from", "dam-brake"]);
    assert!(typo.contains("did you mean \"dam-break\"?") && typo.contains("packed-bed"), "{typo}");
    let missing = home.refused("new", &["--from", "gone.stl", "--unit", "mm"]);
    assert!(missing.contains("cannot read gone.stl"), "{missing}");
    let option = home.refused("new", &["--from", "valve", "--unit", "mm"]);
    assert!(option.contains("--unit goes with a file of triangles"), "{option}");
    home.part("tube.stl", &tube(), 1e-3);
    let unit = home.refused("new", &["--from", "tube.stl"]);
    assert!(unit.contains("12 x 12 x 30 of a unit that the file does not say"), "{unit}");
    assert!(unit.contains("--unit mm makes it 12 x 12 x 30 mm"), "{unit}");
    let same = ["--from", "tube.stl", "--unit", "mm", "--inlet", "x-min", "--outlet", "x-min"];
    assert!(home.refused("new", &same).contains("both x-min"));
    let across = ["--from", "tube.stl", "--unit", "mm", "--inlet", "x-min", "--flow", "through"];
    let across = home.refused("new", &across);
    assert!(across.contains("no way leads through the part from x-min to x-max"), "{across}");
    let bend = ["--from", "tube.stl", "--unit", "mm", "--inlet", "x-min", "--outlet", "z-max"];
    assert!(home.refused("new", &bend).contains("expected --outlet x-max"));
    let wrong = root().join("tests/system/wrong");
    for (file, words) in [("damaged.stl", "is no STL file"), ("open.stl", "is not closed")] {
        let file = wrong.join(file);
        let said = home.refused("new", &["--from", file.to_str().unwrap(), "--unit", "mm"]);
        assert!(said.contains(words) && said.contains(file.to_str().unwrap()), "{said}");
    }
    assert!(!home.path("new").exists(), "a folder was made");
    let left: Vec<_> = std::fs::read_dir(home.0.path()).unwrap().flatten().collect();
    assert_eq!(left.len(), 2, "{left:?}");
}

/// Bash completes commands and keys by the script that it reads.
#[test]
fn bash_completes_keys() {
    let script = tremie().args(["completions", "bash"]).output().unwrap();
    assert!(script.status.success());
    let ask = r#"eval "$0"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMP_TYPE=9
        _clap_complete_tremie tremie "${COMP_WORDS[COMP_CWORD]}"; printf '%s\n' "${COMPREPLY[@]}""#;
    let completed = |words: &[&str]| {
        let mut bash = std::process::Command::new("bash");
        bash.args(["-c", ask]).arg(String::from_utf8_lossy(&script.stdout).into_owned());
        let output = bash.arg("tremie").args(words).current_dir(root()).output();
        // Not on every machine.
        output.ok().map(|output| String::from_utf8(output.stdout).unwrap())
    };
    let Some(keys) = completed(&["run", "x", "--set", "scene.fluid.visc"]) else { return };
    assert_eq!(keys, "scene.fluid.viscosity=\n");
    assert_eq!(completed(&["compl"]).unwrap(), "completions\n");
    let files = completed(&["check", "examples/dam"]).unwrap();
    assert_eq!(files, "examples/dam-break/\n");
}
