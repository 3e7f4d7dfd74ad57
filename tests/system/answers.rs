//! Answers of commands whose reader is gone or whose disk is full.

use crate::tremie::{SMALL, run_text, tremie};
use std::fs::File;
use std::process::{Command, Output, Stdio};

/// Runs `tremie` with `arguments` and a standard output of its own.
fn into(output: Stdio, arguments: &[&str]) -> Output {
    tremie()
        .args(arguments)
        .stdout(output)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
        .wait_with_output()
        .unwrap()
}

/// The writing end of a pipe whose reader has gone.
fn closed_pipe() -> Stdio {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    writer.into()
}

fn full_disk() -> Stdio {
    File::options().write(true).open("/dev/full").unwrap().into()
}

#[test]
fn no_command_panics_or_claims_success_where_its_answer_is_lost() {
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, SMALL).unwrap();
    let manifest = manifest.to_str().unwrap();
    let ran = run_text(SMALL, &["--quiet"]).succeeded();
    let out = ran.out.to_str().unwrap();
    let valve = home.path().join("valve");
    let commands: &[&[&str]] = &[
        &["--help"],
        &["--version"],
        &["run", "--help"],
        &["rubber", "make-table", "--help"],
        &["schema"],
        &["components"],
        &["clean"],
        &["bench", "--list"],
        &["bench", "--list", "--json"],
        &["check", manifest],
        &["check", manifest, "--json"],
        &["check", manifest, "--measure", "--until", "2 ms"],
        &["signals", manifest],
        &["explain", "scene.fluid"],
        &["signals", manifest, "--json"],
        &["report", out],
        &["conform", "fluid-lbm"],
        &["scene", "pressure-valve", valve.to_str().unwrap(), "--coarse"],
    ];
    for arguments in commands {
        let told = into(closed_pipe(), arguments);
        let said = String::from_utf8_lossy(&told.stderr);
        assert_eq!((told.status.code(), said.as_ref()), (Some(141), ""), "{arguments:?}");
        let told = into(full_disk(), arguments);
        let said = String::from_utf8_lossy(&told.stderr);
        assert_eq!(told.status.code(), Some(1), "{arguments:?}: {said}");
        let expected =
            "error: cannot write to standard output: No space left on device (os error 28)\n";
        assert_eq!(said, expected, "{arguments:?}");
    }
    // What is wrong stays wrong.
    let wrong = home.path().join("wrong.toml");
    std::fs::write(&wrong, SMALL.replace("viscosity", "vicosity")).unwrap();
    for arguments in [
        &["check", wrong.to_str().unwrap(), "--json"][..],
        &["report", "no/such/run"],
        &["nonsense"],
    ] {
        assert_eq!(into(closed_pipe(), arguments).status.code(), Some(2), "{arguments:?}");
        assert_eq!(into(full_disk(), arguments).status.code(), Some(2), "{arguments:?}");
    }
}

#[test]
fn errors_that_nobody_hears_end_no_command_otherwise() {
    let home = tempfile::tempdir().unwrap();
    let wrong = home.path().join("wrong.toml");
    std::fs::write(&wrong, SMALL.replace("viscosity", "vicosity")).unwrap();
    let right = home.path().join("right.toml");
    std::fs::write(&right, SMALL.replace("0.02 s", "2 ms")).unwrap();
    let out = home.path().join("out");
    for (arguments, code) in [
        (vec!["check".as_ref(), wrong.as_os_str()], 2),
        (vec!["nonsense".as_ref()], 2),
        (vec!["explain".as_ref(), "viscosty".as_ref()], 2),
        (vec!["report".as_ref(), "no/such/run".as_ref()], 2),
        (vec!["component".as_ref(), "fluid-lbm".as_ref()], 2),
        (vec!["run".as_ref(), right.as_os_str(), "--out".as_ref(), out.as_os_str()], 0),
    ] {
        for errors in [closed_pipe(), full_disk()] {
            let _ = std::fs::remove_dir_all(&out);
            let mut command = tremie();
            let status =
                command.args(&arguments).stdout(Stdio::null()).stderr(errors).status().unwrap();
            assert_eq!(status.code(), Some(code), "{arguments:?}");
        }
    }
}

#[test]
fn a_run_whose_events_nobody_reads_goes_on() {
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, SMALL).unwrap();
    for (output, code) in [(closed_pipe(), 141), (full_disk(), 1)] {
        let out = home.path().join(format!("out-{code}"));
        let told = into(
            output,
            &["run", "--json", manifest.to_str().unwrap(), "--out", out.to_str().unwrap()],
        );
        assert_eq!(told.status.code(), Some(code));
        let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
        assert!(summary.contains("\"status\": \"completed\""));
    }
}

#[test]
fn a_pipe_into_head_ends_quietly() {
    let script = "\"$1\" schema | head -c 1 > /dev/null; \"$1\" signals \"$2\" | head -1";
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, SMALL).unwrap();
    let mut command = Command::new("sh");
    command.args(["-c", script, "sh", env!("CARGO_BIN_EXE_tremie")]).arg(&manifest);
    let told = command.output().unwrap();
    assert_eq!(String::from_utf8_lossy(&told.stderr), "");
    assert_eq!(String::from_utf8_lossy(&told.stdout).lines().count(), 1);
}
