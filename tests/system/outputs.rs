//! Outputs that go wrong: two runs that want one folder, tables and recordings that were cut off,
//! full disks.

use crate::running::{Running, until};
use crate::tremie::{SMALL, run_text, tremie};
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

fn manifest(home: &Path, text: &str) -> PathBuf {
    let manifest = home.join("manifest.toml");
    std::fs::write(&manifest, text).unwrap();
    manifest
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The small run with everything that can be written.
fn everything() -> String {
    SMALL.replace("record = false", "frames = \"1 ms\"\nfields = \"2 ms\"\nsignals = \"1 us\"")
}

#[test]
fn of_runs_begun_at_once_with_one_folder_one_gets_it() {
    let home = tempfile::tempdir().unwrap();
    let manifest = manifest(home.path(), &SMALL.replace("0.02 s", "2 ms"));
    let out = home.path().join("out");
    // The same folder, written in several ways.
    let ways = [out.clone(), home.path().join("./out"), out.join("../out"), out.clone()];
    for round in 0..2 {
        let start = |way: &PathBuf| {
            let mut command = tremie();
            command.args(["run", "--quiet", "--in-process", "--out"]).arg(way).arg(&manifest);
            command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap()
        };
        let runs: Vec<_> = ways.iter().map(start).collect();
        let ended: Vec<_> = runs.into_iter().map(|run| run.wait_with_output().unwrap()).collect();
        let won = ended.iter().filter(|run| run.status.success()).count();
        // In the second round all find what the first one left.
        assert_eq!(won, usize::from(round == 0), "{ended:?}");
        for lost in ended.iter().filter(|run| !run.status.success()) {
            let said = errors(lost);
            assert_eq!(lost.status.code(), Some(1), "{said}");
            assert_eq!(said.trim().lines().count(), 1, "{said}");
            assert!(
                said.contains("belongs to a run") || said.contains("holds something"),
                "{said}"
            );
        }
        let table = std::fs::read_to_string(out.join("signals.csv")).unwrap();
        let columns = |line: &str| line.matches(',').count();
        assert!(table.lines().all(|line| columns(line) == columns(table.lines().next().unwrap())));
        assert!(out.join("summary.json").exists() && !out.join("summary.json.part").exists());
    }
}

#[test]
fn runs_begun_at_once_without_a_folder_get_one_each() {
    let home = tempfile::tempdir().unwrap();
    let manifest = manifest(home.path(), &SMALL.replace("0.02 s", "2 ms"));
    let start = |_| {
        let mut command = tremie();
        command.args(["run", "--quiet", "--in-process"]).arg(&manifest).current_dir(home.path());
        command.stderr(Stdio::null()).spawn().unwrap()
    };
    let runs: Vec<_> = (0..3).map(start).collect();
    for mut run in runs {
        assert!(run.wait().unwrap().success());
    }
    let mut made: Vec<_> =
        std::fs::read_dir(home.path().join("runs")).unwrap().map(|e| e.unwrap().path()).collect();
    made.sort();
    assert_eq!(made.len(), 3, "{made:?}");
    assert!(made.iter().all(|folder| folder.join("summary.json").exists()), "{made:?}");
}

#[test]
fn a_folder_of_a_run_under_way_is_refused_and_of_one_that_was_killed_at_the_start_is_not() {
    let home = tempfile::tempdir().unwrap();
    let text = SMALL.replace("0.02 s", "100 s");
    let manifest = manifest(home.path(), &text);
    let out = home.path().join("out");
    let mut command = tremie();
    command.args(["run", "--json", "--out"]).arg(&out).arg(&manifest);
    let mut first = Running::start(command.stdout(Stdio::piped()).stderr(Stdio::piped()));
    first.says("\"progress\"");
    let second =
        || tremie().args(["run", "--quiet", "--out"]).arg(&out).arg(&manifest).output().unwrap();
    let said = errors(&second());
    assert!(said.contains("belongs to a run that is under way"), "{said}");
    first.send("-KILL");
    first.wait(Duration::from_secs(5));
    let said = errors(&second());
    assert!(said.contains("holds something already"), "{said}");
    // All that a run leaves which was killed before its first file.
    for entry in std::fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().path()) {
        match entry.is_dir() {
            true => std::fs::remove_dir_all(entry).unwrap(),
            false if entry.ends_with("summary.json.part") => {}
            false => std::fs::remove_file(entry).unwrap(),
        }
    }
    assert!(out.join("summary.json.part").exists());
    let third = tremie()
        .args(["run", "--quiet", "--until", "1 ms", "--out"])
        .arg(&out)
        .arg(&manifest)
        .output()
        .unwrap();
    assert!(third.status.success(), "{}", errors(&third));
    until("the killed run's components end", || {
        tremie().arg("clean").output().unwrap().status.success()
    });
}

#[test]
fn one_recording_is_not_written_by_two_runs() {
    let home = tempfile::tempdir().unwrap();
    let file = home.path().join("both.mcap");
    let text = format!("{SMALL}\n[settings.recorder]\nfile = {file:?}\n")
        .replace("record = false", "record = true");
    let manifest = manifest(home.path(), &text.replace("0.02 s", "100 s"));
    let mut command = tremie();
    command.args(["run", "--json", "--out"]).arg(home.path().join("a")).arg(&manifest);
    let mut first = Running::start(command.stdout(Stdio::piped()).stderr(Stdio::piped()));
    first.says("\"progress\"");
    let second =
        tremie().args(["run", "--out"]).arg(home.path().join("b")).arg(&manifest).output().unwrap();
    assert!(
        !second.status.success() && errors(&second).contains("is being written by another run"),
        "{}",
        errors(&second)
    );
    assert!(!home.path().join("b").exists());
    first.send("-INT");
    assert_eq!(first.wait(Duration::from_secs(10)), Some(130));
}

#[test]
fn a_folder_that_is_no_text_is_refused_before_anything_starts() {
    let home = tempfile::tempdir().unwrap();
    let manifest = manifest(home.path(), SMALL);
    let out = home.path().join(std::ffi::OsStr::from_bytes(b"out\xff"));
    let run = tremie().args(["run", "--quiet", "--out"]).arg(&out).arg(&manifest).output().unwrap();
    let said = errors(&run);
    assert_eq!((run.status.code(), said.trim().lines().count()), (Some(1), 1), "{said}");
    assert!(said.contains("no UTF-8 text") && said.contains("choose another --out"), "{said}");
    assert!(!out.exists());
    // Also where it is the folder that the program runs in.
    std::fs::create_dir(&out).unwrap();
    let run = tremie().args(["run", "--quiet"]).arg(&manifest).current_dir(&out).output().unwrap();
    assert_eq!(run.status.code(), Some(1), "{}", errors(&run));
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), 0);
}

#[test]
fn what_a_killed_run_left_is_read_to_its_last_whole_row() {
    let ran =
        run_text(&SMALL.replace("record = false", "frames = \"0.2 ms\""), &["--quiet"]).succeeded();
    let table = ran.signals_text();
    let rows = table.lines().count() - 1;
    let report = |bytes: &[u8]| {
        std::fs::write(ran.out.join("signals.csv"), bytes).unwrap();
        tremie().arg("report").arg(&ran.out).output().unwrap()
    };
    for cut in [1, 3, 300, 700] {
        let left = &table[..table.len() - cut];
        let whole = left.matches('\n').count() - 1;
        assert!(whole < rows);
        let drawn = report(left.as_bytes());
        let said = errors(&drawn);
        assert!(drawn.status.success(), "{cut}: {said}");
        assert!(said.contains(&format!("{whole} whole rows are read, up to ")), "{cut}: {said}");
    }
    let names = table.find('\n').unwrap() + 1;
    for (left, part) in [
        ("", "it is empty"),
        (&table[..names / 2], "cut off in its first line"),
        (&table[..names], "has no whole row"),
        (&table[..names + 5], "has no whole row"),
    ] {
        let drawn = report(left.as_bytes());
        let said = errors(&drawn);
        assert!(
            !drawn.status.success() && said.starts_with("error: ") && said.contains(part),
            "{said}"
        );
    }
    let recording = std::fs::read(ran.out.join("run.mcap")).unwrap();
    let view = |bytes: &[u8]| {
        std::fs::write(ran.out.join("run.mcap"), bytes).unwrap();
        let mut command = tremie();
        command.arg("view").arg(&ran.out).arg("--view").arg(ran.out.join("a.rrd"));
        command.output().unwrap()
    };
    let whole = view(&recording);
    assert!(whole.status.success() && !errors(&whole).contains("warning"), "{}", errors(&whole));
    let zeros = [&recording[..recording.len() / 2], &[0; 4096]].concat();
    let cut = &recording[..recording.len() * 3 / 4];
    for (about, bytes) in
        [("cut", cut), ("half", &recording[..recording.len() / 2]), ("zeros", &zeros)]
    {
        let shown = view(bytes);
        let said = errors(&shown);
        assert!(shown.status.success(), "{about}: {said}");
        assert!(said.contains("is cut off or damaged: shown up to window "), "{about}: {said}");
    }
    for (bytes, part) in [(&b""[..], "it is empty"), (&recording[..20], "no description of a run")]
    {
        let shown = view(bytes);
        let said = errors(&shown);
        assert!(!shown.status.success() && said.contains(part), "{said}");
    }
}

/// Runs with files of so many bytes at most, which is how a full disk looks to who writes.
fn limited(bytes: u64, manifest: &Path, options: &[&str]) -> (Output, PathBuf) {
    let out = manifest.parent().unwrap().join(format!("out-{bytes}"));
    let blocks = bytes / 512;
    let mut command = Command::new("/bin/sh");
    command.arg("-c").arg(format!("ulimit -f {blocks}; exec \"$@\"")).arg("sh");
    command
        .arg(env!("CARGO_BIN_EXE_tremie"))
        .args(["run", "--in-process", "--out"])
        .arg(&out)
        .arg(manifest);
    (command.args(options).stdin(Stdio::null()).output().unwrap(), out)
}

/// A run that a file ended which could not grow: the last line tells window, file and the system's
/// words.
#[track_caller]
fn ended_by_disk((output, out): (Output, PathBuf), file: &str, words: &str) {
    let said = errors(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    let last = said.trim().lines().last().unwrap();
    assert!(last.starts_with("failed: ") && last.contains("at window "), "{said}");
    assert!(last.contains(file) && last.contains(words), "{said}");
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["status"], "failed");
    assert_eq!(summary["fault"]["kind"], "output");
    assert!(
        summary["windows"].as_u64().is_some()
            && !summary["signals"].as_object().unwrap().is_empty()
    );
    let run = std::os::unix::fs::MetadataExt::uid(&std::fs::metadata("/proc/self").unwrap());
    let left = std::fs::read_dir(format!("/tmp/tremie-{run}")).unwrap();
    let id = summary["run"].as_str().unwrap();
    assert!(!left.flatten().any(|entry| entry.file_name().to_string_lossy().contains(id)));
}

#[test]
fn a_file_that_cannot_grow_ends_the_run_with_window_path_and_reason() {
    const WORDS: &str = "File too large (os error 27)";
    let home = tempfile::tempdir().unwrap();
    let long = SMALL.replace("0.02 s", "0.5 s");
    let run = |bytes: u64, outputs: &str, options: &[&str]| {
        let path = manifest(home.path(), &long.replace("record = false", outputs));
        limited(bytes, &path, options)
    };
    ended_by_disk(run(1 << 16, "record = false", &[]), "signals.csv", WORDS);
    let rare = "record = false\nsignals = \"1 s\"";
    // The summary has to fit.
    ended_by_disk(run(3 << 14, rare, &["--trace"]), "trace.json", WORDS);
    ended_by_disk(run(1 << 17, "frames = \"0.1 ms\"\nsignals = \"1 s\"", &[]), "run.mcap", WORDS);
    let seen = home.path().join("seen.rrd");
    let options = ["--view", seen.to_str().unwrap()];
    let shown = "record = false\nframes = \"1 ms\"\nsignals = \"1 s\"";
    ended_by_disk(run(3 << 16, shown, &options), "seen.rrd", WORDS);
    let options = ["--set", "settings.fluid-lbm.cell=\"0.2 mm\"", "--until", "4 ms"];
    let (output, out) = run(1 << 19, "record = false\nfields = \"1 ms\"", &options);
    let left = out.join("fields").read_dir().unwrap().flatten().map(|entry| entry.path());
    assert!(!left.into_iter().any(|path| path.extension().is_some_and(|ending| ending == "part")));
    ended_by_disk((output, out), "fields/lattice_0000", WORDS);
    // Shared memory is made of files, too.
    let path = manifest(home.path(), &long);
    let mut command = Command::new("/bin/sh");
    command.args([
        "-c",
        "ulimit -f 128; exec \"$@\"",
        "sh",
        env!("CARGO_BIN_EXE_tremie"),
        "run",
        "--quiet",
    ]);
    let ran = command.arg(&path).arg("--out").arg(home.path().join("out")).output().unwrap();
    let said = errors(&ran);
    assert_eq!((ran.status.code(), said.trim().lines().count()), (Some(1), 1), "{said}");
    assert!(said.contains("a file may have 65536 bytes") && said.contains("ulimit -f"), "{said}");
    assert!(!home.path().join("out").exists());
}

/// Runs `script` in a place of its own where `disk` is a small file system; `None`, said, where
/// that is not permitted.
fn on_a_disk(bytes: &str, disk: &Path, script: &str) -> Option<Output> {
    let mount = format!("mount -t tmpfs -o size={bytes} tmpfs \"$1\"");
    let program = Path::new(env!("CARGO_BIN_EXE_tremie"));
    crate::mounts::with_mount(&mount, script, &[disk, program])
}

#[test]
fn a_full_disk_ends_the_run_with_a_summary() {
    let home = tempfile::tempdir().unwrap();
    let disk = home.path().join("disk");
    std::fs::create_dir(&disk).unwrap();
    manifest(home.path(), &everything().replace("0.02 s", "0.2 s"));
    for options in [
        "",
        "--in-process --trace",
        "--set outputs.record=false",
        "--set outputs.signals='\"1 ms\"'",
    ] {
        let script = format!(
            "\"$2\" run \"$1/../manifest.toml\" --out \"$1/out\" {options}; rc=$?; cat \"$1/out/summary.json\"; exit $rc"
        );
        let Some(ran) = on_a_disk("2M", &disk, &script) else { return };
        let said = errors(&ran);
        assert_eq!(ran.status.code(), Some(1), "{options}: {said}");
        let last = said.trim().lines().last().unwrap();
        assert!(
            last.starts_with("failed: ") && last.contains("No space left on device (os error 28)"),
            "{options}: {said}"
        );
        let summary: serde_json::Value = serde_json::from_slice(&ran.stdout).unwrap();
        assert_eq!(
            (summary["status"].as_str(), summary["fault"]["kind"].as_str()),
            (Some("failed"), Some("output")),
            "{options}"
        );
    }
    // Too little for anything: nothing begins.
    let script =
        "\"$2\" run \"$1/../manifest.toml\" --quiet --out \"$1/out\"; rc=$?; ls \"$1\"; exit $rc";
    let Some(ran) = on_a_disk("100k", &disk, script) else { return };
    let said = errors(&ran);
    assert!(ran.status.code() == Some(1) && said.contains("No space left on device"), "{said}");
    assert_eq!(String::from_utf8_lossy(&ran.stdout), "", "nothing is left");
}
