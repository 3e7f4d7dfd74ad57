//! Studies and runs on a cluster: a real Slurm on this machine, with a configuration of its own.
//!
//! It needs Slurm's daemons (Debian: `apt-get install slurm-wlm`) and the rights of root, so it runs only where
//! it is asked for.

mod ranks;
mod runs;

use crate::running::{Running, until};
use crate::study::{Home, WITH_CHECKPOINTS, errors};
use crate::tremie::tremie;
use std::collections::BTreeMap;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

/// 50 points of small runs. With one of the viscosities the lattice refuses to begin.
const STUDY: &str = r#"
base = "base.toml"

[[axes]]
key = "scene.fluid.viscosity"
values = [VALUES]

[[axes]]
key = "scene.contacts[0].friction"
values = [0.3, 0.1]

[set]
"components.fluid.threads" = 1
"components.grains.threads" = 1

[columns]
speed = { signal = "grains.max_speed", of = "max" }
late = { signal = "grains.max_speed", of = "mean", from = "10 ms" }

[slurm]
cpus = 1
options = ["--time=10"]
"#;

fn fifty() -> String {
    let values = (0..24).map(|k| format!("\"{} Pa s\"", 0.05 + 0.001 * f64::from(k)));
    let mut values: Vec<String> = values.collect();
    // The first point must begin: it tells the signals.
    values.insert(1, "\"1e-12 Pa s\"".into());
    STUDY.replace("VALUES", &values.join(", "))
}

/// Slurm's daemons with four cores to give, whatever the machine has.
struct Cluster {
    folder: PathBuf,
    daemons: Vec<Child>,
}

impl Cluster {
    fn start(folder: &Path) -> Self {
        let port = || TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let (at, control, node) = (folder.display(), port(), port());
        let text = format!(
            "ClusterName=loopback
SlurmctldHost=localhost(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/none
CredType=cred/none
SlurmctldPort={control}
SlurmdPort={node}
StateSaveLocation={at}/state
SlurmdSpoolDir={at}/spool
SlurmctldPidFile={at}/slurmctld.pid
SlurmdPidFile={at}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=batch_sched_delay=0,sched_interval=1,bf_interval=1
KillWait=5
MpiDefault=none
SwitchType=switch/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SlurmdParameters=config_overrides
NodeName=localhost NodeAddr=127.0.0.1 CPUs=4
PartitionName=all Nodes=localhost Default=YES MaxTime=INFINITE
"
        );
        for name in ["state", "spool"] {
            std::fs::create_dir_all(folder.join(name)).unwrap();
        }
        std::fs::write(folder.join("slurm.conf"), text).unwrap();
        let mut cluster = Self { folder: folder.to_path_buf(), daemons: Vec::new() };
        for (name, more) in [("slurmctld", &[][..]), ("slurmd", &["-N", "localhost"])] {
            let log = std::fs::File::create(folder.join(format!("{name}.log"))).unwrap();
            let mut command = cluster.command(name);
            command.arg("-D").args(more).stdin(Stdio::null()).stdout(Stdio::null()).stderr(log);
            let daemon = command.spawn();
            cluster.daemons.push(daemon.expect("Slurm is needed: apt-get install slurm-wlm"));
        }
        until("a node of the cluster", || {
            let told =
                cluster.command("sinfo").args(["--noheader", "--format=%T"]).output().unwrap();
            String::from_utf8_lossy(&told.stdout).contains("idle")
        });
        cluster
    }

    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("SLURM_CONF", self.folder.join("slurm.conf"));
        command
    }

    fn study(&self, home: &Home, options: &[&str]) -> Command {
        let mut command = home.command(options);
        command.env("SLURM_CONF", self.folder.join("slurm.conf"));
        command
    }

    /// Lines of the queue: task and state.
    fn queue(&self) -> Vec<String> {
        let mut command = self.command("squeue");
        let told = command.args(["--array", "--noheader", "--format=%F_%K %T"]).output().unwrap();
        String::from_utf8_lossy(&told.stdout).lines().map(String::from).collect()
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        let _ = self.command("scancel").args(["--user", "root"]).status();
        for daemon in self.daemons.iter_mut().rev() {
            let _ = daemon.kill();
            let _ = daemon.wait();
        }
    }
}

/// A study of 50 runs by Slurm, of which the follower is killed three times, one task is cancelled, and two
/// fail: the next study makes the cancelled one, and the table is that of a study on this machine.
#[test]
#[ignore = "needs Slurm (apt-get install slurm-wlm) and root"]
fn a_study_by_slurm_ends_with_the_table_of_one_on_this_machine() {
    let home = Home::new(&fifty());
    let local = home.study(&["--out", "local"]);
    assert!(
        errors(&local).contains("48 of 50 runs are done, 50 made now, 2 failed"),
        "{}",
        errors(&local)
    );

    let place = tempfile::tempdir().unwrap();
    let cluster = Cluster::start(place.path());
    let options = ["--out", "out", "--slurm", "--jobs", "3"];
    for ended in [0, 5, 15] {
        let mut command = cluster.study(&home, &options);
        let mut following = Running::start(command.stdout(Stdio::null()).stderr(Stdio::null()));
        until("runs", || home.ended("out").len() >= ended && !cluster.queue().is_empty());
        following.send("-KILL");
        following.wait(Duration::from_secs(20));
        let queue = cluster.queue();
        let running = queue.iter().filter(|line| line.ends_with("RUNNING")).count();
        assert!(running <= 6, "three of a study's array, three of what failed: {queue:?}");
    }
    let given = scripts(&home);
    let mut command = cluster.study(&home, &options);
    let mut following = Running::start(command.stdout(Stdio::null()).stderr(Stdio::piped()));
    // It gives what failed to Slurm again, and follows from then on.
    until("the follower", || scripts(&home) > given);
    let queue = cluster.queue();
    // Of the first array: what failed fails again.
    let waits = |line: &&String| line.starts_with("1_") && line.ends_with("PENDING");
    let last = queue.iter().rfind(waits).expect("tasks that wait");
    let task = last.split(' ').next().unwrap();
    assert!(cluster.command("scancel").arg(task).status().unwrap().success());
    assert_eq!(following.wait(Duration::from_secs(120)), Some(1));
    let words = following.errors();
    assert!(words.contains("Slurm has ") && words.contains(" of the runs already"), "{words}");
    assert!(words.contains(&format!("Slurm: job {task} ")), "{words}");
    assert!(words.contains("FAILED, exit code 2:0"), "{words}");
    assert!(words.contains("makes the failed ones again"), "{words}");

    let again = cluster.study(&home, &options).output().unwrap();
    let words = errors(&again);
    assert!(words.contains("48 of 50 runs are done"), "{words}");
    assert_eq!(home.table("out", "runs.csv"), home.table("local", "runs.csv"));
    // What Slurm had was not given to it again: only what failed, or was cancelled.
    let mut given: BTreeMap<String, usize> = BTreeMap::new();
    for entry in std::fs::read_dir(home.path().join("out/slurm")).unwrap().flatten() {
        if entry.path().extension().is_some_and(|end| end == "lines") {
            for line in std::fs::read_to_string(entry.path()).unwrap().lines() {
                *given.entry(line.to_string()).or_default() += 1;
            }
        }
    }
    assert_eq!((given.len(), given.values().filter(|times| **times > 1).count()), (50, 3));
}

/// Number of arrays that Slurm was given.
fn scripts(home: &Home) -> usize {
    let entries = std::fs::read_dir(home.path().join("out/slurm")).into_iter().flatten().flatten();
    entries.filter(|entry| entry.path().extension().is_some_and(|end| end == "sh")).count()
}

/// Ctrl-C leaves the runs at Slurm, which go on; the same command collects them.
#[test]
#[ignore = "needs Slurm (apt-get install slurm-wlm) and root"]
fn ctrl_c_leaves_the_runs_at_slurm() {
    let home = Home::new(&STUDY.replace("VALUES", "\"0.05 Pa s\", \"0.06 Pa s\", \"0.07 Pa s\""));
    let place = tempfile::tempdir().unwrap();
    let cluster = Cluster::start(place.path());
    let options = ["--out", "out", "--slurm"];
    let mut command = cluster.study(&home, &options);
    let mut following = Running::start(command.stdout(Stdio::null()).stderr(Stdio::piped()));
    until("tasks", || !cluster.queue().is_empty());
    following.send("-TERM");
    assert_eq!(following.wait(Duration::from_secs(20)), Some(130));
    let words = following.errors();
    assert!(words.contains("runs go on at Slurm; `scancel "), "{words}");
    assert!(words.contains("`tremie study study.toml --out out --slurm` goes on"), "{words}");
    until("the end of the tasks", || cluster.queue().is_empty());
    let output: Output = cluster.study(&home, &options).output().unwrap();
    assert!(output.status.success(), "{}", errors(&output));
    assert!(errors(&output).contains("6 of 6 runs are done, 0 made now"), "{}", errors(&output));
}

/// Each of several studies has an array of its own. A run that both have is given once, also when Slurm has it
/// already from a command that was left.
#[test]
#[ignore = "needs Slurm (apt-get install slurm-wlm) and root"]
fn several_studies_give_slurm_a_run_of_both_once() {
    let home = Home::new("");
    for (name, values) in
        [("thin", r#""0.05 Pa s", "0.06 Pa s""#), ("thick", r#""0.06 Pa s", "0.07 Pa s""#)]
    {
        let file = home.path().join(format!("{name}.toml"));
        std::fs::write(file, STUDY.replace("VALUES", values)).unwrap();
    }
    let place = tempfile::tempdir().unwrap();
    let cluster = Cluster::start(place.path());
    let study = |words: &[&str]| {
        let mut command = tremie();
        command.env("SLURM_CONF", cluster.folder.join("slurm.conf"));
        command.current_dir(home.path()).arg("study").args(words);
        command
    };
    let lines = |out: &str| {
        let file = home.path().join(out).join("slurm/1.lines");
        std::fs::read_to_string(file).map_or(0, |text| text.lines().count())
    };
    let made = study(&["thin.toml", "thick.toml", "--out", "new", "--slurm"]).output().unwrap();
    let words = errors(&made);
    assert!(made.status.success(), "{words}");
    assert!(words.contains("8 of 8 runs of 2 studies are done, 6 made now"), "{words}");
    assert_eq!((lines("new/thin"), lines("new/thick")), (4, 2));

    // One task at a time: the second study begins while Slurm has most of the first.
    let mut command = study(&["thick.toml", "--out", "left/thick", "--slurm", "--jobs", "1"]);
    let mut following = Running::start(command.stdout(Stdio::null()).stderr(Stdio::null()));
    until("tasks", || !cluster.queue().is_empty());
    following.send("-KILL");
    following.wait(Duration::from_secs(20));
    let made = study(&["thin.toml", "thick.toml", "--out", "left", "--slurm"]).output().unwrap();
    let words = errors(&made);
    assert!(made.status.success(), "{words}");
    assert!(words.contains("8 of 8 runs of 2 studies are done"), "{words}");
    assert_eq!((lines("left/thin"), lines("left/thick")), (2, 4), "{words}");
    for name in ["thin", "thick"] {
        assert!(study(&[&format!("{name}.toml")]).status().unwrap().success());
        let of = |all: &str| home.table(&format!("{all}/{name}"), "runs.csv");
        assert_eq!((of("new"), of("left")), (of("studies"), of("studies")), "{name}");
    }
}

/// A task that is cancelled after a checkpoint, or runs into its time limit, goes on from there when the study
/// is made again, to the bytes of an undisturbed run. With a checkpoint that is damaged it begins again.
#[test]
#[ignore = "needs Slurm (apt-get install slurm-wlm) and root"]
fn a_task_that_was_broken_off_goes_on_from_its_checkpoint() {
    let home = Home::new(WITH_CHECKPOINTS);
    assert!(home.study(&["--out", "whole"]).status.success());
    let place = tempfile::tempdir().unwrap();
    let cluster = Cluster::start(place.path());
    for way in ["goes on", "damaged"] {
        let options = ["--out", way, "--slurm"];
        let mut command = cluster.study(&home, &options);
        let mut following = Running::start(command.stdout(Stdio::null()).stderr(Stdio::piped()));
        until("a checkpoint", || !home.checkpoints(way).is_empty());
        let job = cluster.queue()[0].split('_').next().unwrap().to_string();
        assert!(cluster.command("scancel").arg(job).status().unwrap().success());
        assert_eq!(following.wait(Duration::from_secs(120)), Some(1));
        let words = following.errors();
        assert!(words.contains("CANCELLED"), "{way}: it was cancelled too late: {words}");
        if way == "damaged" {
            home.checkpoints(way).iter().for_each(|file| std::fs::write(file, "{").unwrap());
        }
        let again = cluster.study(&home, &options).output().unwrap();
        assert!(again.status.success(), "{way}: {}", errors(&again));
        assert_eq!(home.table(way, "runs.csv"), home.table("whole", "runs.csv"), "{way}");
        let log = std::fs::read_to_string(home.ended(way)[0].join("log.jsonl")).unwrap();
        let words = errors(&again);
        assert_eq!(log.contains("the run goes on from"), way == "goes on", "{way}: {words}\n{log}");
    }
}

/// Without Slurm the words say what is needed.
#[test]
fn a_machine_without_slurm_is_told_of() {
    let home = Home::new(&STUDY.replace("VALUES", "\"0.05 Pa s\""));
    let mut command = home.command(&["--out", "out", "--slurm"]);
    let output = command.env("PATH", "/nowhere").output().unwrap();
    let words = errors(&output);
    assert_eq!(output.status.code(), Some(1), "{words}");
    assert!(words.contains("sbatch: ") && words.contains("--print"), "{words}");
}
