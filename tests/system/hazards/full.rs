//! Disks and memory that are full in mid-run: one sentence, a checkpoint that is whole or not there,
//! and the same bits when there is room again.

use super::hazard::{Moment, Target};
use super::scenes::{Disturbable, SCENES};
use super::watched::WatchedRun;
use crate::mounts::with_mount;
use crate::resume::{assert_same, assert_same_outputs, assert_same_states, checkpoints};
use crate::tremie::{SMALL, run_text, script, tremie};
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;
use tremie_test_support::Random;

/// A scene in a folder of its own, and the outputs of a run that nothing disturbed.
struct Whole {
    home: TempDir,
    every: String,
}

impl Whole {
    fn of(scene: &Disturbable) -> Self {
        let home = tempfile::tempdir().unwrap();
        scene.write(home.path());
        let every = format!("run.checkpoints={{ windows = {}, keep = 99 }}", scene.every);
        let mut command = tremie();
        command.arg("run").arg(home.path()).arg("--out").arg(home.path().join("out"));
        let ran = command.args(["--quiet", "--set", &every]).output().unwrap();
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
        Self { home, every }
    }

    /// Room that its outputs take on a disk [bytes].
    fn bytes(&self) -> u64 {
        let told =
            Command::new("du").args(["-s", "-B1"]).arg(self.home.path().join("out")).output();
        let text = String::from_utf8(told.unwrap().stdout).unwrap();
        text.split_whitespace().next().unwrap().parse().unwrap()
    }
}

/// A run on a disk with room for `bytes`, resumed while it is still full, and again on a larger one.
/// `None` where no such disk can be mounted.
fn on_a_small_disk(whole: &Whole, bytes: u64) -> Option<FullDisk> {
    let home = tempfile::tempdir().unwrap();
    std::fs::create_dir(home.path().join("disk")).unwrap();
    let script = r#"
        "$2" run "$3" --out "$1/disk/out" --quiet --set "$4" 2> "$1/first"; echo $? > "$1/first.code"
        ls -A "$1/disk/out/checkpoints" > "$1/kept" 2> /dev/null
        cat "$1/disk/out/summary.json" > "$1/summary.json" 2> /dev/null
        "$2" resume "$1/disk/out" --quiet 2> "$1/again"; echo $? > "$1/again.code"
        mount -o remount,size=1g "$1/disk"
        "$2" resume "$1/disk/out" --quiet 2> "$1/second"; echo $? > "$1/second.code"
        cp -r "$1/disk/out" "$1/out" 2> /dev/null; true"#;
    let mount = format!("mount -t tmpfs -o size={bytes} tmpfs \"$1/disk\"");
    let arguments = [
        home.path().display().to_string(),
        env!("CARGO_BIN_EXE_tremie").to_string(),
        whole.home.path().display().to_string(),
        whole.every.clone(),
    ];
    with_mount(&mount, script, &arguments)?;
    Some(FullDisk { home })
}

/// What a run on a disk that was too small has left.
struct FullDisk {
    home: TempDir,
}

impl FullDisk {
    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.home.path().join(name)).unwrap_or_default()
    }

    fn code(&self, name: &str) -> i32 {
        self.text(&format!("{name}.code")).trim().parse().unwrap()
    }

    /// Checks it all; returns what happened, in a few words.
    #[track_caller]
    fn check(&self, whole: &Whole, bytes: u64) -> &'static str {
        let first = self.text("first");
        let about = format!("{bytes} bytes\n{first}\nagain\n{}", self.text("again"));
        // A checkpoint that had no room may be missing.
        let table = |home: &Path| std::fs::read(home.join("out/signals.csv")).unwrap();
        let is_whole = || table(whole.home.path()) == table(self.home.path());
        if self.code("first") == 0 {
            assert!(is_whole(), "{about}");
            return "had room enough";
        }
        assert_eq!(self.code("first"), 1, "{about}");
        assert!(first.contains("No space left on device"), "{about}");
        assert!(!first.contains("panicked"), "{about}");
        let kept = self.text("kept");
        assert!(kept.lines().all(|name| name.starts_with("window")), "{kept}: {about}");
        let summary = self.text("summary.json");
        if summary.is_empty() {
            let is_error = first.trim().lines().last().unwrap_or("").starts_with("error: ");
            assert!(is_error && !self.home.path().join("out").exists(), "{about}");
            return "did not begin";
        }
        let summary: serde_json::Value = serde_json::from_str(&summary).expect(&about);
        let sentence = first.lines().find(|line| line.starts_with("failed: ")).expect(&about);
        assert!(sentence.contains("at window "), "{about}");
        assert_eq!(first.contains("tremie resume"), !kept.is_empty(), "{about}");
        assert_eq!(summary["checkpoint"].is_u64(), !kept.is_empty(), "{about}");
        if kept.is_empty() {
            assert_eq!(self.code("second"), 2, "{about}");
            return "kept nothing to go on from";
        }
        if self.code("again") == 0 {
            // It makes fewer checkpoints than the first try did, and may fit where that did not.
            assert!(
                self.text("again").contains("no checkpoint of window") && is_whole(),
                "{about}"
            );
            return "had room enough for the rest";
        }
        assert!(self.text("again").contains("No space left on device"), "{about}");
        assert_eq!(self.code("second"), 0, "{}: {about}", self.text("second"));
        let (whole, own) = (whole.home.path().join("out"), self.home.path().join("out"));
        assert_same_outputs(&whole, &own);
        let (all, kept) = (checkpoints(&whole), checkpoints(&own));
        assert!(kept.iter().all(|name| all.contains(name)), "{kept:?}\n{about}");
        // A try that failed may have had room for a later one, from which the next went on.
        let said = first + &self.text("again");
        for name in all.iter().filter(|name| !kept.contains(name)) {
            let window: u64 = name.trim_start_matches("window-").parse().unwrap();
            let told = format!("no checkpoint of window {window}:");
            assert!(said.contains(&told), "{told} {kept:?}\n{about}");
        }
        assert_same_states(&whole, &own, &kept);
        "went on to the same bits"
    }
}

/// Runs on disks of `count` sizes between nothing and enough; returns how many went on when there was room
/// again. Where nearly all of the room is for checkpoints, runs do without these and are whole. `None` where
/// no such disk can be mounted.
fn on_small_disks(scene: &Disturbable, count: u64) -> Option<u64> {
    let whole = Whole::of(scene);
    let most = whole.bytes();
    let mut draw = Random::of_case(super::SEED, most);
    let mut went_on = 0;
    for place in 0..count {
        let part = most * (2 * place + 1) / (2 * count);
        // In whole pages, of which a file system counts.
        let bytes = (part + draw.between(0, most / count / 2)) / 4096 * 4096 + 8192;
        let disk = on_a_small_disk(&whole, bytes)?;
        let what = disk.check(&whole, bytes);
        println!("{}: {bytes} of {most} bytes: {what}", scene.name);
        went_on += u64::from(what == "went on to the same bits");
    }
    Some(went_on)
}

#[test]
fn runs_go_on_when_a_full_disk_has_room_again() {
    let went_on = on_small_disks(&SCENES[0], 4);
    assert_ne!(went_on, Some(0), "no disk was full after a checkpoint");
}

#[test]
#[ignore = "minutes; CONTRIBUTING.md has the command"]
fn runs_of_all_scenes_go_on_when_a_full_disk_has_room_again() {
    let went_on: Option<u64> = SCENES.iter().map(|scene| on_small_disks(scene, 12)).sum();
    assert_ne!(went_on, Some(0), "no disk was full after a checkpoint");
}

#[test]
fn shared_memory_that_others_fill_does_not_disturb_a_run() {
    // Not below /dev/shm, where folders of temporary files may be, and which is hidden here.
    let home = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, SMALL.replace("0.02 s", "0.1 s")).unwrap();
    let whole = run_text(&SMALL.replace("0.02 s", "0.1 s"), &[]).succeeded();
    // As soon as the run has kept a checkpoint, something else takes all that is left.
    let script = r#"
        "$2" run "$3" --out "$1/out" --quiet --set run.checkpoints.windows=20 & run=$!
        until ls "$1"/out/checkpoints/window-* > /dev/null 2>&1; do kill -0 $run || break; sleep 0.01; done
        head -c 100M /dev/zero > /dev/shm/other 2> /dev/null
        wait $run"#;
    let arguments = [home.path(), Path::new(env!("CARGO_BIN_EXE_tremie")), &manifest];
    let mount = "mount -t tmpfs -o size=60m tmpfs /dev/shm";
    let Some(ran) = with_mount(mount, script, &arguments) else { return };
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    let table = std::fs::read_to_string(home.path().join("out/signals.csv")).unwrap();
    assert_eq!(table, whole.signals_text());
}

/// A component that may not have so much memory: however little it is, the run ends with a sentence
/// that names it.
#[test]
fn a_component_without_memory_ends_the_run_with_a_sentence() {
    let program = env!("CARGO_BIN_EXE_tremie");
    let mut kilobytes = 30_000;
    loop {
        let home = tempfile::tempdir().unwrap();
        let lines = format!("ulimit -v {kilobytes}\nexec {program:?} component fluid-lbm");
        let starved = script(home.path(), "starved", &lines);
        let set =
            format!("components.fluid={{ program = {starved:?}, settings.cell = \"0.5 mm\" }}");
        let ran = run_text(SMALL, &["--quiet", "--set", &set]);
        let said = ran.errors();
        if ran.code() == Some(0) {
            break;
        }
        assert!(matches!(ran.code(), Some(1 | 2)), "{kilobytes} kB: {said}");
        assert!(said.contains("fluid"), "{kilobytes} kB: {said}");
        let names_cause = ["memory", "allocat", "signal ", "thread"];
        assert!(names_cause.iter().any(|word| said.contains(word)), "{kilobytes} kB: {said}");
        kilobytes += kilobytes / 3;
        assert!(kilobytes < 100_000_000, "it never was enough: {said}");
    }
}

/// A component that gets no more memory in mid-run: the run goes on without checkpoints, or ends with
/// a sentence that names component, cause, window, and how to go on.
#[test]
fn a_component_that_gets_no_more_memory_ends_with_a_sentence_or_not_at_all() {
    let whole = Whole::of(&SCENES[0]);
    for (component, program) in SCENES[0].physics {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("out");
        let words = ["run", whole.home.path().to_str().unwrap(), "--out", out.to_str().unwrap()];
        let mut words: Vec<String> = words.map(String::from).into();
        words.extend(["--set".into(), whole.every.clone()]);
        let mut run = WatchedRun::start(&words, &out, home.path());
        let moment = Moment::After { checkpoints: 2, milliseconds: 0 };
        let struck = run.strike_by(Target::Component(component, program), moment, |process| {
            let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
            let size = status.lines().find_map(|line| line.strip_prefix("VmSize:")).unwrap();
            let kilobytes: u64 = size.trim().trim_end_matches(" kB").parse().unwrap();
            let mut limit = Command::new("prlimit");
            limit.arg(format!("--pid={process}")).arg(format!("--as={}", kilobytes << 10));
            limit
        });
        let code = run.wait();
        let said = run.said();
        run.left_nothing(&said);
        if code == Some(0) {
            let table = |home: &Path| std::fs::read(home.join("out/signals.csv")).unwrap();
            assert!(table(home.path()) == table(whole.home.path()), "{said}");
            continue;
        }
        assert!(struck.is_some(), "{said}");
        assert_eq!(code, Some(1), "{said}");
        let sentence = said.lines().find(|line| line.starts_with("failed: ")).expect(&said);
        assert!(sentence.contains(component) && sentence.contains("at window "), "{said}");
        assert!(said.contains("memory") && said.contains("tremie resume"), "{said}");
        assert!(checkpoints(&out).iter().all(|name| name.starts_with("window")), "{said}");
        let resumed = tremie().arg("resume").arg(&out).arg("--quiet").output().unwrap();
        assert!(resumed.status.success(), "{}", String::from_utf8_lossy(&resumed.stderr));
        assert_same(&whole.home.path().join("out"), &out);
    }
}
