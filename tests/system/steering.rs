//! Steering: a user pauses, steps, changes and ends a run in progress from another terminal.

use crate::running::{Running, until};
use crate::tremie::{SMALL, run_text, tremie};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;
use tempfile::TempDir;

/// A run in progress, and where its files are.
struct Steered {
    running: Running,
    out: PathBuf,
    _home: TempDir,
}

impl Steered {
    /// Starts the small run, paused at the end of a window.
    fn paused_at(window: u64, options: &[&str]) -> Self {
        let home = tempfile::tempdir().unwrap();
        let (manifest, out) = (home.path().join("manifest.toml"), home.path().join("out"));
        std::fs::write(&manifest, SMALL).unwrap();
        let mut command = tremie();
        command.arg("run").arg(&manifest).arg("--out").arg(&out);
        command.args(["--pause-at", &window.to_string()]).args(options);
        let running = Running::start(command.stdout(Stdio::null()).stderr(Stdio::piped()));
        let steered = Self { running, out, _home: home };
        until("it pauses", || {
            let status = steered.status();
            status["state"] == "paused" && status["progress"]["window"] == window
        });
        steered
    }

    /// What `tremie ps` says of the run.
    fn status(&self) -> serde_json::Value {
        let listed = tremie().args(["ps", "--json"]).output().unwrap();
        let lines = String::from_utf8(listed.stdout).unwrap();
        let runs = lines.lines().map(|line| serde_json::from_str(line).unwrap());
        let is_it = |run: &serde_json::Value| run["out"].as_str().map(Path::new) == Some(&self.out);
        runs.into_iter().find(is_it).unwrap_or_default()
    }

    fn tell(&self, command: &[&str]) -> Output {
        tremie().args(command).arg(&self.out).output().unwrap()
    }

    /// What the run answers to a command.
    #[track_caller]
    fn told(&self, command: &[&str]) -> String {
        let output = self.tell(command);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap().trim().to_string()
    }

    /// Why the run does not obey a command.
    #[track_caller]
    fn refused(&self, command: &[&str]) -> String {
        let output = self.tell(command);
        assert_eq!(output.status.code(), Some(1));
        String::from_utf8(output.stderr).unwrap().trim().to_string()
    }

    fn set(&self, change: &str) -> Output {
        tremie().args(["set", change, "--run"]).arg(&self.out).output().unwrap()
    }

    #[track_caller]
    fn ends_with(&mut self, code: i32) -> String {
        let ended = self.running.wait(Duration::from_secs(60));
        let errors = self.running.errors();
        assert_eq!(ended, Some(code), "{errors}");
        errors
    }

    fn signals(&self) -> String {
        std::fs::read_to_string(self.out.join("signals.csv")).unwrap()
    }
}

#[test]
fn a_run_that_was_paused_and_stepped_ends_with_the_same_bits() {
    let free = run_text(SMALL, &["--quiet"]).succeeded();
    for options in [&[][..], &["--in-process", "--schedule", "serial"]] {
        let mut run = Steered::paused_at(3, options);
        assert_eq!(run.told(&["step", "2"]), "stands after window 5");
        assert_eq!(run.status()["progress"]["window"], 5);
        assert_eq!(run.told(&["checkpoint"]), "checkpoint of window 6");
        assert_eq!(run.told(&["step", "1"]), "stands after window 7");
        assert_eq!(run.told(&["continue"]), "goes on after window 7");
        run.ends_with(0);
        assert_eq!(run.signals(), free.signals_text());
        let log = std::fs::read_to_string(run.out.join("log.jsonl")).unwrap();
        for command in ["step of 2 windows", "checkpoint", "continue"] {
            assert!(log.contains(&format!("steered: {command}")), "{log}");
        }
        assert!(run.out.join("checkpoints/window-000000000006").is_dir());
        let late = run.tell(&["pause"]);
        assert_eq!(late.status.code(), Some(2));
        let text = String::from_utf8(late.stderr).unwrap();
        assert!(text.contains("no run in progress has the number or the outputs"), "{text}");
    }
}

#[test]
fn a_change_holds_from_the_next_window_on() {
    let mut run = Steered::paused_at(8, &[]);
    let set = run.set("scene.gravity[2]=4 m/s2");
    assert_eq!(String::from_utf8_lossy(&set.stderr), "");
    let said = String::from_utf8(set.stdout).unwrap();
    assert_eq!(said.trim(), "scene.gravity[2]=4 m/s2 from window 9 on");
    // The run has started again, and is paused as it was.
    until("it is back", || run.status()["state"] == "paused");
    assert_eq!(run.status()["progress"]["window"], 9);
    run.told(&["continue"]);
    let said = run.ends_with(0);
    assert!(said.contains("changed: scene.gravity[2] = 4 m/s2"), "{said}");
    // It went on, so it did not end in between.
    assert!(!said.contains("interrupted") && said.contains("completed: 40 of 40"), "{said}");
    let manifest = std::fs::read_to_string(run.out.join("manifest.toml")).unwrap();
    assert!(manifest.contains("4 m/s2"), "{manifest}");
    // The same by hand: a run that is resumed with the change.
    let home = tempfile::tempdir().unwrap();
    let (file, out) = (home.path().join("manifest.toml"), home.path().join("out"));
    std::fs::write(&file, SMALL).unwrap();
    let every = ["--set", "run.checkpoints={ windows = 9, keep = 99 }"];
    let made = tremie().arg("run").arg(&file).arg("--out").arg(&out).args(every).output().unwrap();
    assert!(made.status.success());
    let free = std::fs::read_to_string(out.join("signals.csv")).unwrap();
    let resumed = tremie()
        .arg("resume")
        .arg(&out)
        .args(["--at", "9", "--set", "scene.gravity[2]=4 m/s2"])
        .output()
        .unwrap();
    assert!(resumed.status.success(), "{}", String::from_utf8_lossy(&resumed.stderr));
    let by_hand = std::fs::read_to_string(out.join("signals.csv")).unwrap();
    assert_eq!(run.signals(), by_hand);
    // And once more by itself, from what was recorded of the change.
    for out in [&run.out, &out] {
        let again = home.path().join("again");
        let changes = ["--changes", out.join("steering.jsonl").to_str().unwrap()].map(String::from);
        let mut command = tremie();
        command.arg("run").arg(out.join("begun.toml")).arg("--out").arg(&again).args(changes);
        let made = command.output().unwrap();
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
        let read = |out: &Path, name: &str| std::fs::read_to_string(out.join(name)).unwrap();
        assert_eq!(read(&again, "signals.csv"), by_hand);
        assert_eq!(read(&again, "steering.jsonl"), read(out, "steering.jsonl"));
        std::fs::remove_dir_all(&again).unwrap();
    }
    let differ = free.lines().zip(by_hand.lines()).position(|(one, other)| one != other);
    // The header, and windows 0 to 9.
    assert_eq!(differ, Some(11), "the first window with another gravity is 10");
}

#[test]
fn what_cannot_be_is_refused_and_the_run_goes_on() {
    let mut run = Steered::paused_at(2, &[]);
    for (change, why) in [
        ("scene.domain.size[0]=20 mm", "scene.domain.size[0] cannot change from a checkpoint on"),
        ("run.seed=3", "run.seed cannot change from a checkpoint on"),
        ("scene.gravity[2]=fast", "gravity"),
        ("run.untill=1 s", "until"),
    ] {
        let output = run.set(change);
        assert_eq!(output.status.code(), Some(1));
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(text.contains(why), "{change}: {text}");
    }
    assert_eq!(run.status()["progress"]["window"], 2);
    run.told(&["continue"]);
    run.ends_with(0);
    let mut run = Steered::paused_at(2, &["--set", "run.checkpoints.keep=0"]);
    let why = run.refused(&["checkpoint"]);
    assert_eq!(why, "error: this run keeps no checkpoints: run.checkpoints.keep is 0");
    run.told(&["continue"]);
    run.ends_with(0);
}

#[test]
fn a_change_with_which_the_run_cannot_go_on_is_taken_back() {
    let free = run_text(SMALL, &["--quiet"]).succeeded();
    let mut run = Steered::paused_at(2, &[]);
    // The lattice's time step follows from it.
    assert!(run.set("scene.fluid.viscosity=0.06 Pa s").status.success());
    until("it is back", || run.status()["state"] == "paused");
    run.told(&["continue"]);
    let errors = run.ends_with(0);
    assert!(errors.contains("warning: the change is taken back"), "{errors}");
    assert!(errors.contains("time step: it was made with windows of"), "{errors}");
    assert!(!run.out.join("steering.jsonl").exists() && !run.out.join("begun.toml").exists());
    assert_eq!(run.signals(), free.signals_text());
}

#[test]
fn a_run_is_ended_in_order_and_resumed() {
    let free = run_text(SMALL, &["--quiet"]).succeeded();
    let mut run = Steered::paused_at(5, &[]);
    assert_eq!(run.told(&["stop"]), "ends in order, soon after window 5");
    let errors = run.ends_with(130);
    assert!(errors.contains("goes on from window 6"), "{errors}");
    let resumed = tremie().arg("resume").arg(&run.out).arg("--quiet").output().unwrap();
    assert!(resumed.status.success());
    assert_eq!(run.signals(), free.signals_text());
}

#[test]
fn a_run_that_is_attached_to_is_followed_to_its_end() {
    let mut run = Steered::paused_at(4, &[]);
    let mut command = tremie();
    command.arg("attach").arg(&run.out).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut attached = Running::start(&mut command);
    std::thread::sleep(Duration::from_millis(500));
    run.told(&["continue"]);
    run.ends_with(0);
    assert_eq!(attached.wait(Duration::from_secs(30)), Some(0));
    let text = attached.errors();
    assert!(text.contains("paused at window 4") && text.contains("completed: "), "{text}");
}

#[test]
fn another_user_cannot_reach_a_run() {
    let mut run = Steered::paused_at(1, &[]);
    let number = run.status()["run"].as_str().unwrap().to_string();
    let user = rustix::process::getuid().as_raw();
    let folder = format!("/tmp/tremie-{user}/{number}");
    assert!(Path::new(&folder).join("steering").exists());
    // Only root can act as somebody else.
    if user == 0 {
        let looked = Command::new("ls").arg(&folder).uid(65534).output().unwrap();
        assert!(!looked.status.success(), "{}", String::from_utf8_lossy(&looked.stdout));
    }
    run.told(&["continue"]);
    run.ends_with(0);
    assert!(!Path::new(&folder).exists(), "nothing is left");
}
