//! A lattice that several ranks of MPI compute: the bits of one process, and what happens to a rank that dies or
//! hangs.
//!
//! Most needs an MPI, and `fluid-lbm-mpi` built with it, so it runs only where it is asked for. `TREMIE_MPIEXEC` names
//! the launcher of the MPI that the program was built with.

use crate::resume::resumed;
use crate::running::{Running, until};
use crate::tremie::{Ran, left_nothing, run, run_text, tremie};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Grains that stream around a part that moves and turns, a part that stands still, and probes: 54,000 cells.
pub const STREAM: &str = r#"
[run]
until = "50 ms"

[scene]
gravity = ["0.4 m/s2", "0 m/s2", "-9.81 m/s2"]

[scene.domain]
size = ["15 mm", "15 mm", "30 mm"]
x = { lower = "periodic", upper = "periodic" }

[scene.fluid]
density = "1000 kg/m3"
viscosity = "0.02 Pa s"
expected_speed = "0.6 m/s"

[[scene.parts]]
name = "paddle"
box = { size = ["9 mm", "2.6 mm", "7 mm"] }
position = ["7 mm", "7.2 mm", "13 mm"]
motion = "prescribed"
velocity = ["0 m/s", "0 m/s", "0.05 m/s"]
angular_velocity = ["0 rad/s", "3 rad/s", "0 rad/s"]

[[scene.parts]]
name = "rod"
cylinder = { radius = "1.3 mm", length = "60 mm" }
position = ["12 mm", "12 mm", "15 mm"]

[[scene.bodies]]
name = "grains"
density = "2500 kg/m3"
packing = { min = ["0 mm", "0 mm", "0 mm"], max = ["15 mm", "15 mm", "30 mm"], fraction = 0.08, diameter = ["2 mm", "3 mm"], seed = 3 }

[[scene.contacts]]
normal_stiffness = "50 N/m"
tangential_stiffness = "40 N/m"
friction = 0.3
restitution = 0.5

[[scene.probes]]
name = "slit"
section = { axis = "z", at = "14 mm" }

[[scene.probes]]
name = "middle"
region = { min = ["2 mm", "2 mm", "8 mm"], max = ["12 mm", "12 mm", "22 mm"] }

[components]
fluid = "fluid-lbm"
grains = "grains-dem"

[settings.fluid-lbm]
cell = "0.5 mm"

[outputs]
frames = "2 ms"
"#;

/// The same on so many ranks, which have so long to answer.
pub fn on_ranks(text: &str, ranks: usize, deadline: &str) -> String {
    let launcher = std::env::var("TREMIE_MPIEXEC").unwrap_or_else(|_| "mpiexec".into());
    format!(
        "{}\n[settings.fluid-lbm-mpi]\nlaunch = [\"{launcher}\", \"-n\", \"{ranks}\"]\ndeadline = \"{deadline}\"\n",
        text.replace("fluid = \"fluid-lbm\"", "fluid = \"fluid-lbm-mpi\"")
    )
}

/// Lets Open MPI start more ranks than there are cores, as root; MPICH does without asking.
pub fn allow_ranks() {
    for (name, value) in [
        ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
        ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
        ("OMPI_MCA_rmaps_base_oversubscribe", "1"),
        ("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe"),
    ] {
        // SAFETY: tests of this file set the same values, and nothing reads them meanwhile but children.
        unsafe { std::env::set_var(name, value) };
    }
}

/// The same signals and messages, in all windows of both runs.
#[track_caller]
fn assert_same(one: &Ran, other: &Ran, about: &str) {
    assert_same_outputs(&one.out, &other.out, about);
}

/// The same of runs with their outputs in these folders.
#[track_caller]
pub fn assert_same_outputs(one: &Path, other: &Path, about: &str) {
    let signals = |out: &Path| std::fs::read_to_string(out.join("signals.csv")).unwrap();
    let (a, b) = (signals(one), signals(other));
    let line = a.lines().zip(b.lines()).position(|(a, b)| a != b);
    assert_eq!(line, None, "{about}: the tables differ from this line on");
    let differ = tremie().arg("diff").args([one, other]).output().unwrap();
    let said = String::from_utf8_lossy(&differ.stdout).into_owned();
    assert!(said.contains("equal: "), "{about}: {said}");
}

#[test]
#[ignore = "it needs MPI"]
fn ranks_have_the_bits_of_one_process() {
    allow_ranks();
    for precision in ["f64", "f32"] {
        let set = format!("settings.fluid-lbm.precision={precision}");
        let options = ["--set", &set];
        let alone = run_text(STREAM, &options).succeeded();
        assert!(alone.summary()["windows"].as_u64() >= Some(1000), "too short a run to tell");
        for ranks in [1, 2, 4, 8] {
            let ran = run_text(&on_ranks(STREAM, ranks, "60 s"), &options).succeeded();
            assert_same(&alone, &ran, &format!("{ranks} ranks, {precision}"));
            ran.left_nothing(&format!("{ranks} ranks"));
        }
    }
}

/// The coarse valve with its rubber ring, declared gaps and grains, over a thousand windows.
#[test]
#[ignore = "it needs MPI"]
fn a_valve_with_rubber_and_grains_on_ranks() {
    allow_ranks();
    let valve = "examples/pressure-valve/grains.toml";
    let short = ["--set", "run.until=\"0.49 ms\""];
    let alone = run(valve, &short).succeeded();
    assert!(alone.summary()["windows"].as_u64() >= Some(1000), "too short a run to tell");
    for ranks in [2, 4] {
        let launch = launched(ranks);
        let fluid = ["--set", "components.fluid=fluid-lbm-mpi", "--set", &launch];
        let ran = run(valve, &[&short[..], &fluid].concat()).succeeded();
        assert_same(&alone, &ran, &format!("{ranks} ranks"));
    }
}

/// A user sees where the time of ranks goes: by window in a trace, and before a run in a finding.
#[test]
#[ignore = "it needs MPI"]
fn ranks_tell_their_times() {
    allow_ranks();
    let text = on_ranks(STREAM, 2, "60 s");
    let ran = run_text(&text, &["--until", "4 ms", "--trace=11-20"]).succeeded();
    let trace: Value =
        serde_json::from_str(&std::fs::read_to_string(ran.out.join("trace.json")).unwrap())
            .unwrap();
    let events = trace.as_array().unwrap();
    let tracks: Vec<_> = events.iter().filter(|event| event["ph"] == "M").collect();
    let names: Vec<_> =
        tracks.iter().map(|track| track["args"]["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["fluid", "grains", "fluid rank 0", "fluid rank 1"]);
    let windows = |name: &str, track: usize| -> Vec<u64> {
        let own = |event: &&Value| event["name"] == name && event["tid"] == tracks[track]["tid"];
        events.iter().filter(own).map(|event| event["args"]["window"].as_u64().unwrap()).collect()
    };
    for rank in [2, 3] {
        assert_eq!(windows("compute", rank), (11..=20).collect::<Vec<_>>());
        assert_eq!(windows("wait for ranks", rank), (11..=20).collect::<Vec<_>>());
    }
    let ranks = &ran.summary()["components"]["fluid"]["ranks"];
    assert_eq!((&ranks["windows"], ranks["compute"].as_array().unwrap().len()), (&10.into(), 2));
    let share = |key: &str| ranks[key].as_f64().unwrap();
    let whole = share("efficiency") + share("imbalance") + share("messages");
    assert!((whole - 1.0).abs() < 1e-9 && share("efficiency") > 0.05, "{ranks}");

    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, text).unwrap();
    let checked = tremie().args(["check", "--measure"]).arg(&manifest).output().unwrap();
    let said = String::from_utf8([checked.stdout, checked.stderr].concat()).unwrap();
    assert!(said.contains("efficiency of ranks") && said.contains("2 ranks compute"), "{said}");
}

/// Words of the launcher of so many ranks, for `--set`.
fn launched(ranks: usize) -> String {
    let launcher = std::env::var("TREMIE_MPIEXEC").unwrap_or_else(|_| "mpiexec".into());
    format!("settings.fluid-lbm-mpi.launch=[\"{launcher}\", \"-n\", \"{ranks}\"]")
}

/// A run of one process goes on on ranks, and one on ranks in one process.
#[test]
#[ignore = "it needs MPI"]
fn one_process_and_ranks_go_on_from_each_others_checkpoints() {
    allow_ranks();
    let every = "run.checkpoints={ windows = 150, keep = 99 }";
    let text = STREAM.replace("until = \"50 ms\"", "until = \"24 ms\"");
    let whole = run_text(&text, &[]).succeeded();
    let options = ["--set", every, "--inject", "grains:kill@400"];
    let on_two = on_ranks(&text, 2, "60 s");
    let to_ranks = [launched(2), "components.fluid.program=fluid-lbm-mpi".into()];
    let to_one = ["components.fluid.program=fluid-lbm".into()];
    for (text, sets) in [(&text, &to_ranks[..]), (&on_two, &to_one)] {
        let broken = run_text(text, &options);
        assert_eq!(broken.code(), Some(1), "{}", broken.errors());
        resumed(&broken.out, &sets.iter().flat_map(|set| ["--set", set]).collect::<Vec<_>>());
        assert_same(&whole, &broken, &format!("{sets:?}"));
    }
}

/// A run on four ranks that a fault breaks off goes on from its checkpoint on four, two and three, and ends with the
/// bits of one process that was never disturbed.
#[test]
#[ignore = "it needs MPI"]
fn ranks_go_on_from_a_checkpoint_of_another_number() {
    allow_ranks();
    let every = "run.checkpoints={ windows = 150, keep = 99 }";
    let text = STREAM.replace("until = \"50 ms\"", "until = \"24 ms\"");
    let alone = run_text(&text, &[]).succeeded();
    for ranks in [4, 2, 3] {
        let options = ["--set", every, "--inject", "grains:kill@400"];
        let broken = run_text(&on_ranks(&text, 4, "60 s"), &options);
        assert_eq!(broken.code(), Some(1), "{}", broken.errors());
        let folder = broken.out.join("checkpoints/window-000000000300");
        let parts = std::fs::read_dir(&folder).unwrap().flatten();
        let parts = parts.filter(|file| file.file_name().to_string_lossy().starts_with("fluid."));
        assert_eq!(parts.count(), 4, "a file of each rank");
        resumed(&broken.out, &["--set", &launched(ranks)]);
        assert_same(&alone, &broken, &format!("kept by 4 ranks, put back by {ranks}"));
        broken.left_nothing(&format!("resumed by {ranks} ranks"));
    }
}

/// A part that is lost or damaged is named, and no rank waits for ever.
#[test]
#[ignore = "it needs MPI"]
fn a_lost_part_of_a_checkpoint_is_named() {
    allow_ranks();
    let options = ["--set", "run.checkpoints={ windows = 100 }", "--inject", "grains:kill@150"];
    let broken = run_text(&on_ranks(STREAM, 3, "60 s"), &options);
    let part = broken.out.join("checkpoints/window-000000000100/fluid.part-2.npz");
    let resume = || {
        let resume = tremie().arg("resume").arg(&broken.out).arg("--quiet").output().unwrap();
        assert!(!resume.status.success());
        String::from_utf8_lossy(&resume.stderr).into_owned()
    };
    let whole = std::fs::read(&part).unwrap();
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 1;
    std::fs::write(&part, damaged).unwrap();
    let said = resume();
    assert!(said.contains("rank ") && said.contains("checksum"), "{said}");
    std::fs::remove_file(&part).unwrap();
    let said = resume();
    assert!(said.contains("expected"), "{said}");
}

/// Process ids of the ranks of a run, and where its outputs are.
pub fn ranks_of(out: &Path) -> Vec<u32> {
    let name = std::fs::read_dir("/proc").unwrap().flatten();
    let of_program = name.filter_map(|entry| {
        let id: u32 = entry.file_name().to_str()?.parse().ok()?;
        let command = std::fs::read_to_string(format!("/proc/{id}/comm")).ok()?;
        // The name is cut off after 15 characters.
        (command.trim() == "fluid-lbm-mpi").then_some(id)
    });
    let folder = std::fs::canonicalize(out.parent().unwrap()).unwrap();
    let own = |id: &u32| {
        let environment = std::fs::read(format!("/proc/{id}/environ")).unwrap_or_default();
        String::from_utf8_lossy(&environment).contains(&*folder.to_string_lossy())
    };
    let mut ids: Vec<u32> = of_program.filter(own).collect();
    ids.sort_unstable();
    ids
}

/// The last error in a run's log: why it ended. A launcher may say more behind it.
pub fn last_error(log: &str) -> &str {
    log.lines().rfind(|line| line.contains("\"level\":\"error\"")).unwrap_or_default()
}

/// A run that goes on for ever is disturbed: a signal to one of four ranks, or to the orchestrator.
fn disturbed(signal: &str, target: Option<usize>) -> (String, Duration) {
    allow_ranks();
    let home = tempfile::tempdir().unwrap();
    let (manifest, out) = (home.path().join("manifest.toml"), home.path().join("out"));
    let text = on_ranks(STREAM, 4, "2 s").replace("until = \"50 ms\"", "until = \"100 s\"");
    std::fs::write(&manifest, text).unwrap();
    let mut command: Command = tremie();
    command.arg("run").arg(&manifest).arg("--out").arg(&out);
    // By this the ranks of this run are told from those of others.
    command.env("TREMIE_TEST_HOME", std::fs::canonicalize(home.path()).unwrap());
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut run = Running::start(&mut command);
    let begins = || {
        let log = std::fs::read_to_string(out.join("log.jsonl")).unwrap_or_default();
        log.contains(" begin, with")
    };
    until("the run begins", begins);
    let ids = ranks_of(&out);
    assert_eq!(ids.len(), 4, "ranks");
    let begin = Instant::now();
    match target {
        Some(rank) => crate::running::send(ids[rank], signal),
        None => run.send(signal),
    }
    let code = run.wait(Duration::from_secs(20));
    let took = begin.elapsed();
    assert_ne!(code, Some(0));
    until("the ranks end", || ranks_of(&out).is_empty());
    let errors = std::fs::read_to_string(out.join("log.jsonl")).unwrap_or_default();
    let shared = std::fs::read_dir("/dev/shm").unwrap().flatten();
    let of_mpi = shared.filter(|file| file.file_name().to_string_lossy().contains("_segment."));
    assert_eq!(of_mpi.count(), 0, "shared memory of MPI is left");
    if target.is_some() {
        let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
        let summary: Value = serde_json::from_str(&summary).unwrap();
        left_nothing(&summary, crate::running::now(), signal);
    }
    (errors, took)
}

#[test]
#[ignore = "it needs MPI"]
fn a_rank_that_dies_ends_the_run_and_is_named() {
    for rank in [0, 1, 3] {
        let (errors, took) = disturbed("-KILL", Some(rank));
        assert!(took < Duration::from_secs(5), "rank {rank}: {took:?}");
        let last = last_error(&errors);
        assert!(last.contains("rank ") || last.contains(" RUNNING AT "), "rank {rank}: {last}");
    }
}

#[test]
#[ignore = "it needs MPI"]
fn a_rank_that_hangs_ends_the_run_within_its_deadline() {
    for rank in [1, 3] {
        let (errors, took) = disturbed("-STOP", Some(rank));
        // The deadline, and a second in which the rank may say that it is there.
        assert!(took < Duration::from_secs(8), "rank {rank}: {took:?}");
        let last = last_error(&errors);
        let named = last.contains(&format!("rank {rank} on ")) && last.contains("has not answered");
        assert!(named, "rank {rank}: {last}");
    }
}

#[test]
#[ignore = "it needs MPI"]
fn ranks_end_with_their_orchestrator() {
    for signal in ["-KILL", "-TERM"] {
        let (_, took) = disturbed(signal, None);
        assert!(took < Duration::from_secs(10), "{signal}: {took:?}");
    }
}

#[test]
#[ignore = "it needs MPI"]
fn what_ranks_cannot_do_is_said_before() {
    allow_ranks();
    let many = run_text(&on_ranks(STREAM, 20, "60 s"), &[]);
    assert!(many.errors().contains("take at most 1"), "{}", many.errors());
    let wrong = on_ranks(STREAM, 2, "0 s");
    let wrong = run_text(&wrong, &[]);
    assert!(wrong.errors().contains("expected more than 0"), "{}", wrong.errors());
    let no_words = on_ranks(STREAM, 2, "1 s").replace("launch = [", "launch = [1, ");
    let no_words = run_text(&no_words, &[]);
    assert!(no_words.errors().contains("expected words as"), "{}", no_words.errors());
}

#[test]
fn a_built_in_component_has_no_launcher() {
    let text = format!("{STREAM}\n").replace(
        "[settings.fluid-lbm]",
        "[settings.fluid-lbm]\nlaunch = [\"mpiexec\", \"-n\", \"2\"]",
    );
    let ran = run_text(&text, &[]);
    assert!(ran.errors().contains("fluid-lbm is one process"), "{}", ran.errors());
}

/// Where the program of ranks is not there, the error says how to get it.
#[test]
fn without_the_program_of_ranks_the_error_says_how_to_build_it() {
    let home = tempfile::tempdir().unwrap();
    let program = home.path().join("tremie");
    std::fs::copy(env!("CARGO_BIN_EXE_tremie"), &program).unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, on_ranks(STREAM, 2, "1 s")).unwrap();
    let check = Command::new(&program).arg("check").arg(&manifest).env("PATH", "").output();
    let said = String::from_utf8_lossy(&check.unwrap().stderr).into_owned();
    for word in ["libopenmpi-dev", "--features mpi", "components.fluid"] {
        assert!(said.contains(word), "{said}");
    }
}
