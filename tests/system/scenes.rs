//! Scenes and tables built from numbers.

use crate::tremie::{run, tremie};

/// `tremie check` accepts the manifests that `tremie scene` writes. Cells that are fluid have the
/// volume of the space, 1 %. Both outlets of a safety valve lead to the same pressure.
#[test]
fn a_valve_from_its_numbers_can_be_run() {
    let home = tempfile::tempdir().unwrap();
    let cases = [("pressure", 197_800.0, "10416 Pa"), ("safety", 208_700.0, "0 Pa")];
    for (closure, volume, outlet) in cases {
        let folder = home.path().join(closure);
        let made = tremie()
            .args(["scene", "pressure-valve"])
            .arg(&folder)
            .args(["--set", &format!("closure={closure}"), "--cell", "0.6 mm"])
            .output()
            .unwrap();
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
        for file in
            ["frame.stl", "valve.stl", "ring.stl", "dimensions.toml", "ring.toml", "ring.json"]
        {
            assert!(folder.join(file).is_file(), "{file}");
        }
        for manifest in ["manifest.toml", "rigid.toml"] {
            let checked = tremie().arg("check").arg(folder.join(manifest)).output().unwrap();
            let errors = String::from_utf8_lossy(&checked.stderr);
            assert!(checked.status.success(), "{closure}, {manifest}: {errors}");
        }
        let text = std::fs::read_to_string(folder.join("manifest.toml")).unwrap();
        let above = format!("y = {{ lower = \"wall\", upper = {{ pressure = \"{outlet}\"");
        assert!(text.contains(&above), "{closure}: {text}");
        let checked =
            tremie().arg("check").arg(folder.join("held.toml")).arg("--json").output().unwrap();
        let text = String::from_utf8_lossy(&checked.stdout);
        assert!(checked.status.success(), "{text}");
        // "... fluid: 24735 cells of 63000 are fluid ..."
        let before = text.split(" are fluid").next().unwrap();
        let cells: f64 = before.rsplit(' ').nth(3).unwrap().parse().unwrap();
        // A cell of 0.6 mm holds eight of 0.3 mm.
        assert!((8.0 * cells / volume - 1.0).abs() < 0.02, "{closure}: {cells}");
    }
}

/// Beneath the valve the slurry has its fraction from the start, to half a grain of thirty; fluid
/// and grains begin to move.
#[test]
fn a_valve_begins_with_the_slurry_of_its_numbers() {
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("grains.toml");
    for scene in ["safety-valve", "pressure-valve"] {
        let made = tremie().args(["scene", scene, "--coarse"]).arg(home.path()).output().unwrap();
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
        let checked = tremie().arg("check").arg(&manifest).output().unwrap();
        assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
    }
    let text = std::fs::read_to_string(&manifest).unwrap();
    let part: f64 = text.split(" is this over ").nth(1).unwrap()[..6].parse().unwrap();
    let options = ["--until", "0.1 ms", "--set", "outputs.record=false"];
    let signals = run(manifest.to_str().unwrap(), &options).succeeded().signals();
    let fraction = signals["grains.packing.solid_fraction"][0] / part;
    assert!((fraction / 0.053 - 1.0).abs() < 0.02, "{fraction}");
    let last = |name: &str| *signals[name].last().unwrap();
    assert!(last("fluid.reservoir_z_lower.velocity") > 1e-3);
    assert!(last("grains.kinetic_energy") > 0.0);
    assert_eq!((last("grains.stuck.number"), last("grains.stuck.area_fraction")), (0.0, 0.0));
}

/// As of a run that was made on a cluster: its parts and its ring's table are not here.
#[test]
fn a_run_is_read_and_compared_without_the_files_of_its_scene() {
    let home = tempfile::tempdir().unwrap();
    let made = tremie().args(["scene", "pressure-valve", "--coarse"]).arg(home.path()).output();
    assert!(made.unwrap().status.success());
    let manifest = home.path().join("manifest.toml");
    let options = ["--until", "0.1 ms", "--set", "outputs.record=false"];
    let ran = run(manifest.to_str().unwrap(), &options).succeeded();
    let ask = |words: &[&str]| {
        let output = tremie().args(words).output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        (output.status.code(), String::from_utf8(said).unwrap())
    };
    let out = ran.out.to_str().unwrap();
    let here = ask(&["valve", out]);
    assert_eq!(here.0, Some(0), "{}", here.1);
    drop(home);
    assert_eq!(ask(&["valve", out]), here);
    assert_eq!(ask(&["diff", out, out]).0, Some(0));
    // Without its scene, the manifest's, with the copies of its files. A damaged one is told of.
    let scene = ran.out.join("scene.json");
    std::fs::write(&scene, "{").unwrap();
    let (code, said) = ask(&["valve", out]);
    assert!(code == Some(0) && said.starts_with(&here.1), "{said}");
    assert!(said.contains("warning: cannot read ") && said.contains("scene.json"), "{said}");
    std::fs::remove_file(scene).unwrap();
    assert_eq!(ask(&["valve", out]), here);
    std::fs::remove_dir_all(ran.out.join("inputs")).unwrap();
    let (code, said) = ask(&["valve", out]);
    assert!(code == Some(2) && said.contains("inputs/frame.stl"), "{said}");
}

#[test]
fn numbers_that_make_no_valve_are_refused() {
    let home = tempfile::tempdir().unwrap();
    let refused = |set: &str| {
        let mut command = tremie();
        command.args(["scene", "pressure-valve"]).arg(home.path().join("out"));
        let made = command.args(["--set", set]).output().unwrap();
        assert_eq!(made.status.code(), Some(2));
        String::from_utf8(made.stderr).unwrap()
    };
    let narrow = refused("rubber_inner_radius=4 mm");
    assert!(narrow.contains("rubber_inner_radius is 0.004 m, but must be more than bore_radius"));
    let weak = refused("lip=0.2 mm");
    assert!(weak.contains("does not hold 61.5 N") && weak.contains("lip, 0.0002 m"), "{weak}");
    assert!(refused("bore_radios=4 mm").contains("bore_radius"));
    assert!(refused("bore_radius=4").contains("with a unit"));
    assert!(!home.path().join("out").exists());
}

/// The table of a seal, made and read by the program: force as of the reference for this mesh
/// (66.76 N at 0.48 mm with 18 x 12 elements), 0.2 %.
#[test]
fn a_seal_becomes_a_table_with_pictures() {
    let home = tempfile::tempdir().unwrap();
    let (spec, out) = (home.path().join("ring.toml"), home.path().join("ring.json"));
    let text = include_str!("../../components/rubber-table/studies/ring.toml");
    let coarse = text.replace("[36, 24]", "[18, 12]").replace("\"0.6 mm\"", "\"0.48 mm\"");
    std::fs::write(&spec, &coarse).unwrap();
    let make = |spec: &std::path::Path| {
        let mut command = tremie();
        command.args(["rubber", "make-table"]).arg(spec).arg("--out").arg(&out).output().unwrap()
    };
    let made = make(&spec);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let said = String::from_utf8(made.stdout).unwrap();
    let force = said.split("presses with ").nth(1).and_then(|t| t.split(' ').next()).unwrap();
    let force: f64 = force.parse().unwrap();
    assert!((force / 66.76 - 1.0).abs() < 2e-3, "{force}");
    for picture in ["ring.force.svg", "ring.shapes.svg"] {
        assert!(home.path().join(picture).is_file(), "{picture}");
    }

    std::fs::write(&spec, coarse.replace("height", "heigth")).unwrap();
    let refused = make(&spec);
    assert_eq!(refused.status.code(), Some(2));
    let text = String::from_utf8(refused.stderr).unwrap();
    assert!(text.contains("unknown key \"heigth\"") && text.contains("\"height\""), "{text}");
}
