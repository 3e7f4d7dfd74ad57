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
    let spectra = ["--signal", "grains.momentum", "--spectrum", "--to", to];
    let few = report(&spectra);
    assert_eq!(few.status.code(), Some(2));
    let said = String::from_utf8(few.stderr).unwrap();
    assert!(said.contains("41 rows lie in this time, and a spectrum needs 72"), "{said}");
    let unknown = report(&["--signal", "grains.momentun_z"]);
    assert_eq!(unknown.status.code(), Some(2));
    let said = String::from_utf8(unknown.stderr).unwrap();
    assert!(said.contains("did you mean \"grains.momentum_z\"?"), "{said}");
    let dense = run_text(SMALL, &["--quiet", "--until", "0.1 s"]).succeeded();
    let of_some = tremie().arg("report").arg(&dense.out).args(spectra).output().unwrap();
    assert!(of_some.status.success(), "{}", String::from_utf8_lossy(&of_some.stderr));
    let said = String::from_utf8(of_some.stdout).unwrap();
    assert!(said.contains("grains momentum, z: rms ") && said.contains(" kg m/s, "), "{said}");
    let picture = std::fs::read_to_string(&both).unwrap();
    assert!(picture.contains("frequency [kHz]") && picture.contains("kg m/s/Hz"), "{picture}");
    let nowhere = tremie().args(["report", "no/such/run"]).output().unwrap();
    assert_eq!(nowhere.status.code(), Some(2));
}
