//! Curves of finished runs.

use crate::tremie::{SMALL, run_text, tremie};

#[test]
fn finished_runs_are_drawn_and_compared() {
    let slow = run_text(SMALL, &["--quiet"]).succeeded();
    let thick =
        run_text(SMALL, &["--quiet", "--set", "scene.fluid.viscosity=\"0.06 Pa s\""]).succeeded();
    let report = |arguments: &[&str]| {
        let mut command = tremie();
        command.arg("report").arg(&slow.out);
        command.args(arguments).output().unwrap()
    };
    let all = report(&[]);
    assert!(all.status.success(), "{}", String::from_utf8_lossy(&all.stderr));
    let picture = std::fs::read_to_string(slow.out.join("report.svg")).unwrap();
    for panel in ["fluid momentum", "grains kinetic energy", "time [ms]"] {
        assert!(picture.contains(panel), "{panel}");
    }
    let both = slow.out.join("both.svg");
    let (thick_out, to) = (thick.out.to_str().unwrap(), both.to_str().unwrap());
    let some = report(&[thick_out, "--signal", "grains.momentum", "--to", to]);
    assert!(some.status.success());
    let said = String::from_utf8(some.stdout).unwrap();
    assert!(said.contains("6 curves in 1 panels"), "{said}");
    let unknown = report(&["--signal", "grains.momentun_z"]);
    assert_eq!(unknown.status.code(), Some(2));
    let said = String::from_utf8(unknown.stderr).unwrap();
    assert!(said.contains("did you mean \"grains.momentum_z\"?"), "{said}");
    let nowhere = tremie().args(["report", "no/such/run"]).output().unwrap();
    assert_eq!(nowhere.status.code(), Some(2));
}
