//! Scenes built from numbers.

use crate::tremie::tremie;

/// What `tremie scene` writes, `tremie check` accepts; as many cells are fluid as the space has
/// volume, 1 %.
#[test]
fn a_valve_from_its_numbers_can_be_run() {
    let home = tempfile::tempdir().unwrap();
    for (closure, volume) in [("pressure", 197_800.0), ("safety", 208_700.0)] {
        let folder = home.path().join(closure);
        let made = tremie()
            .args(["scene", "pressure-valve"])
            .arg(&folder)
            .args(["--set", &format!("closure={closure}"), "--cell", "0.6 mm"])
            .output()
            .unwrap();
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
        for file in ["frame.stl", "valve.stl", "ring.stl", "dimensions.toml", "manifest.toml"] {
            assert!(folder.join(file).is_file(), "{file}");
        }
        let checked = tremie().arg("check").arg(&folder).arg("--json").output().unwrap();
        let text = String::from_utf8_lossy(&checked.stdout);
        assert!(checked.status.success(), "{text}");
        let cells = text.split("cells of").next().and_then(|t| t.rsplit(' ').nth(1)).unwrap();
        let cells: f64 = cells.parse().unwrap();
        // A cell of 0.6 mm holds eight of 0.3 mm.
        assert!((8.0 * cells / volume - 1.0).abs() < 0.02, "{closure}: {cells}");
    }
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
    assert!(refused("bore_radios=4 mm").contains("bore_radius"));
    assert!(refused("bore_radius=4").contains("with a unit"));
    assert!(!home.path().join("out").exists());
}
