//! One run as a job: its bits, its follower, its ends, and how it is reached from another machine.

use super::Cluster;
use crate::running::{Running, now, until};
use crate::study::errors;
use crate::tremie::{SMALL, left_nothing, tremie};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;
use tempfile::TempDir;

/// Longest time for a job to end and to be told of.
const LONG: Duration = Duration::from_secs(120);

/// A cluster, and a folder with a manifest.
pub struct Jobs {
    home: TempDir,
    cluster: Cluster,
    _place: TempDir,
}

impl Jobs {
    pub fn new(manifest: &str) -> Self {
        let home = tempfile::tempdir().unwrap();
        std::fs::write(home.path().join("m.toml"), manifest).unwrap();
        let place = tempfile::tempdir().unwrap();
        let cluster = Cluster::start(place.path());
        Self { home, cluster, _place: place }
    }

    pub fn out(&self, name: &str) -> PathBuf {
        self.home.path().join(name)
    }

    /// The program in the folder, with the cluster's configuration.
    pub fn command(&self, words: &[&str]) -> Command {
        let mut command = tremie();
        command.current_dir(self.home.path()).args(words).env("SLURM_CONF", self.configuration());
        command
    }

    fn configuration(&self) -> PathBuf {
        self.cluster.folder.join("slurm.conf")
    }

    /// The same where the runs on this machine are out of sight, as on another machine.
    fn elsewhere(&self, words: &[&str]) -> Command {
        let user = std::os::unix::fs::MetadataExt::uid(&std::fs::metadata("/proc/self").unwrap());
        let hide = format!("mount -t tmpfs -o mode=700 none /tmp/tremie-{user} && exec \"$@\"");
        let mut command = Command::new("unshare");
        command.args(["--mount", "sh", "-c", &hide, "sh", env!("CARGO_BIN_EXE_tremie")]);
        command.current_dir(self.home.path()).args(words).env("SLURM_CONF", self.configuration());
        command.stdin(Stdio::null());
        command
    }

    pub fn ran(&self, words: &[&str]) -> Output {
        self.command(words).output().unwrap()
    }

    pub fn following(&self, words: &[&str]) -> Running {
        Running::start(self.command(words).stdout(Stdio::null()).stderr(Stdio::piped()))
    }

    pub fn slurm(&self, program: &str, words: &[&str]) {
        assert!(self.cluster.command(program).args(words).status().unwrap().success(), "{words:?}");
    }

    pub fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.home.path().join(name)).unwrap_or_default()
    }

    /// Waits until the run in `out` makes windows.
    pub fn await_windows(&self, out: &str) {
        until("windows", || self.text(&format!("{out}/signals.csv")).lines().count() > 3);
    }

    #[track_caller]
    pub fn left_nothing(&self, out: &str) {
        let summary: Value =
            serde_json::from_str(&self.text(&format!("{out}/summary.json"))).unwrap();
        left_nothing(&summary, now(), out);
    }

    #[track_caller]
    pub fn assert_same(&self, one: &str, other: &str) {
        let table = |out: &str| self.text(&format!("{out}/signals.csv"));
        assert!(!table(one).is_empty() && table(one) == table(other), "{one}, {other}");
        let differ = self.ran(&["diff", one, other]);
        let said = String::from_utf8_lossy(&differ.stdout).into_owned();
        assert!(said.contains("equal: "), "{said}");
    }
}

/// A job has the bits of a run on this machine. What is wrong is found before anything is submitted.
#[test]
#[ignore = "needs Slurm (apt-get install slurm-wlm) and root"]
fn a_run_by_slurm_has_the_bits_of_one_on_this_machine() {
    let jobs = Jobs::new(&SMALL.replace("record = false", "record = true"));
    assert!(jobs.ran(&["run", "m.toml", "--out", "here", "--quiet"]).status.success());
    let wrong = jobs.ran(&["run", "m.toml", "--out", "out", "--slurm", "--set", "run.untl=1 s"]);
    assert_eq!(wrong.status.code(), Some(2), "{}", errors(&wrong));
    // Only the component itself finds this.
    let refused = ["run", "m.toml", "--out", "out", "--slurm", "--set"];
    let refused = jobs.ran(&[&refused[..], &["scene.fluid.viscosity=1e-12 Pa s"]].concat());
    assert_eq!(refused.status.code(), Some(2), "{}", errors(&refused));
    let shown = jobs.ran(&["run", "m.toml", "--out", "out", "--slurm", "--view", "web"]);
    assert!(errors(&shown).contains("--view FILE.rrd"), "{}", errors(&shown));
    let printed = jobs.ran(&["run", "m.toml", "--out", "out", "--slurm", "--print"]);
    let script = String::from_utf8(printed.stdout).unwrap();
    assert!(script.starts_with("#!/bin/sh\n#SBATCH --job-name=tremie-out\n"), "{script}");
    // Fluid and grains compute, the recorder writes.
    assert!(script.contains("--ntasks=1\n#SBATCH --cpus-per-task=3\n"), "{script}");
    let option = ["run", "m.toml", "--out", "out", "--slurm", "--slurm-option=--partition=none"];
    let option = jobs.ran(&option);
    assert_eq!(option.status.code(), Some(1));
    assert!(errors(&option).contains("error: sbatch: "), "{}", errors(&option));
    assert!(jobs.cluster.queue().is_empty() && !jobs.out("out").exists());

    let words = ["run", "m.toml", "--out", "out", "--slurm", "--slurm-option", "--time=10"];
    let ran = jobs.ran(&words);
    let said = errors(&ran);
    assert!(ran.status.success(), "{said}");
    // The job number says that nothing was submitted before.
    assert!(said.contains("Slurm has the run as job 1; outputs in "), "{said}");
    assert!(said.trim().lines().last().unwrap().starts_with("completed: 40 of 40"), "{said}");
    assert!(!said.contains("Slurm: job"), "an end in order needs no word of Slurm's: {said}");
    jobs.assert_same("here", "out");
    jobs.left_nothing("out");
    assert!(jobs.text("out/slurm/1.sh").contains("#SBATCH --time=10\n"));
    let late = jobs.ran(&["attach", "out"]);
    assert!(late.status.success() && errors(&late).contains("completed: 40"), "{}", errors(&late));
    let again = jobs.ran(&words);
    assert!(errors(&again).contains("holds something already"), "{}", errors(&again));
}

/// Ctrl-C leaves the job; it is followed and steered from here and from elsewhere, and stopped.
#[test]
#[ignore = "needs Slurm (apt-get install slurm-wlm) and root"]
fn a_run_by_slurm_is_left_followed_and_steered() {
    let jobs = Jobs::new(SMALL);
    let words = ["run", "m.toml", "--out", "out", "--slurm", "--until", "1000 s"];
    let mut left = jobs.following(&words);
    jobs.await_windows("out");
    left.send("-TERM");
    assert_eq!(left.wait(LONG), Some(130));
    let said = left.errors();
    assert!(said.contains("job 1 goes on at Slurm; `tremie attach "), "{said}");
    assert!(said.contains("`scancel 1` ends it"), "{said}");

    let mut here = jobs.following(&["attach", "out"]);
    let paused = jobs.elsewhere(&["pause", "out"]).output().unwrap();
    let answer = String::from_utf8_lossy(&paused.stdout).into_owned();
    assert!(answer.starts_with("stands after window"), "{answer}{}", errors(&paused));
    let set = jobs.elsewhere(&["set", "run.until=2000 s", "--run", "out"]).output().unwrap();
    assert!(set.status.success(), "{}", errors(&set));
    until("it is back", || jobs.text("out/manifest.toml").contains("2000 s"));
    let mut there = Running::start(
        jobs.elsewhere(&["attach", "out", "--json"]).stdout(Stdio::piped()).stderr(Stdio::piped()),
    );
    let status: Value = serde_json::from_str(&there.says("progress")).unwrap();
    assert_eq!(status["state"], "paused");
    assert_eq!(status["out"].as_str().map(Path::new), Some(&*jobs.out("out")));
    let step = jobs.elsewhere(&["step", "2", "out"]).output().unwrap();
    assert!(step.status.success(), "{}", errors(&step));
    let stop = jobs.elsewhere(&["stop", "out"]).output().unwrap();
    assert!(stop.status.success(), "{}", errors(&stop));
    assert_eq!(there.wait(LONG), Some(130), "{}", there.errors());
    here.wait(LONG);
    let said = here.errors();
    assert!(said.contains("paused at window") && said.contains("goes on as run"), "{said}");
    until("the job ends", || jobs.cluster.queue().is_empty());
    let late = jobs.ran(&["attach", "out"]);
    assert_eq!(late.status.code(), Some(130));
    assert!(errors(&late).contains("interrupted: "), "{}", errors(&late));
    jobs.left_nothing("out");
}

/// `scancel` ends a run in order, and it goes on as another job to the bits of an undisturbed one.
#[test]
#[ignore = "needs Slurm (apt-get install slurm-wlm) and root"]
fn a_job_that_was_cancelled_is_resumed_as_a_job() {
    let jobs = Jobs::new(&SMALL.replace("0.02 s", "0.4 s"));
    assert!(jobs.ran(&["run", "m.toml", "--out", "whole", "--quiet"]).status.success());
    let mut following = jobs.following(&["run", "m.toml", "--out", "out", "--slurm"]);
    jobs.await_windows("out");
    jobs.slurm("scancel", &["1"]);
    assert_eq!(following.wait(LONG), Some(130));
    let said = following.errors();
    assert!(said.contains("Slurm: job 1 CANCELLED") && said.contains("interrupted: "), "{said}");
    jobs.left_nothing("out");

    let held = ["resume", "out", "--slurm", "--detach", "--slurm-option=--hold"];
    let held = jobs.ran(&held);
    assert!(held.status.success(), "{}", errors(&held));
    let mut waiting = jobs.following(&["attach", "out"]);
    let twice = jobs.ran(&["resume", "out", "--slurm"]);
    assert_eq!(twice.status.code(), Some(1));
    assert!(errors(&twice).contains("job 2 goes on at Slurm"), "{}", errors(&twice));
    let early = jobs.ran(&["pause", "out"]);
    assert!(errors(&early).contains("job 2 waits in Slurm's queue"), "{}", errors(&early));
    jobs.slurm("scancel", &["2"]);
    assert_eq!(waiting.wait(LONG), Some(1));
    let said = waiting.errors();
    assert!(said.contains("job 2 waits in Slurm's queue: JobHeldUser"), "{said}");
    assert!(said.contains("Slurm: job 2 CANCELLED") && said.contains("has no end"), "{said}");

    let resumed = jobs.ran(&["resume", "out", "--slurm"]);
    assert!(resumed.status.success(), "{}", errors(&resumed));
    assert!(errors(&resumed).contains("completed: "), "{}", errors(&resumed));
    jobs.assert_same("whole", "out");
}

/// Jobs that nobody cancelled, and that end all the same: at a limit, with their node, by a fault.
#[test]
#[ignore = "needs Slurm (apt-get install slurm-wlm) and root"]
fn a_job_that_ends_too_early_is_told_with_slurms_word() {
    let jobs = Jobs::new(SMALL);
    let end_of = |out: &str, more: &[&str], disturb: &dyn Fn()| {
        let words = ["run", "m.toml", "--out", out, "--slurm", "--until", "1000 s"];
        let mut following = jobs.following(&[&words[..], more].concat());
        disturb();
        let code = following.wait(LONG);
        (code, following.errors())
    };
    let late = || {
        jobs.await_windows("late");
        jobs.slurm("scontrol", &["update", "JobId=1", "EndTime=now"]);
    };
    let (code, said) = end_of("late", &[], &late);
    assert!(code == Some(130) && said.contains("Slurm: job 1 TIMEOUT"), "{said}");
    jobs.left_nothing("late");
    let (code, said) = end_of("faulty", &["--inject", "grains:kill@50"], &|| ());
    assert!(code == Some(1) && said.contains("failed: grains"), "{said}");
    jobs.left_nothing("faulty");
    let down = || {
        jobs.await_windows("lost");
        let down = ["update", "NodeName=localhost", "State=DOWN", "Reason=test"];
        jobs.slurm("scontrol", &down);
    };
    let (code, said) = end_of("lost", &[], &down);
    assert!(code != Some(0) && said.contains("Slurm: job 3 NODE_FAIL"), "{said}");
    until("the run is gone", || jobs.text("lost/summary.json").contains("interrupted"));
    jobs.left_nothing("lost");
}
