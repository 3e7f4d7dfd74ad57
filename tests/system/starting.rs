//! Components that never get as far as the first window: the orchestrator stays in charge.

use crate::running::{Running, children_of, is_alive, until};
use crate::tremie::{SMALL, description, run_text, script, small_with_fluid, tremie};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};
use tremie_sdk::messages::INTERFACE_VERSION;

/// Lines of a script that talks without end on standard error, with standard output left open.
const TALKS: &str = "exec 3>&1\nexec yes noise >&2";

/// Longest time of a Ctrl-C, on a busy machine.
const SOON: Duration = Duration::from_secs(2);

/// Starts `tremie COMMAND` with a fluid that is a script of these lines; outputs in `home/out`.
fn start(home: &Path, command: &str, lines: &str) -> Running {
    let manifest = home.join("manifest.toml");
    let program = script(home, "script-fluid", lines);
    std::fs::write(&manifest, small_with_fluid(&program)).unwrap();
    let mut tremie = tremie();
    tremie.arg(command).arg(manifest).stdout(Stdio::piped()).stderr(Stdio::piped());
    if command == "run" {
        tremie.arg("--out").arg(home.join("out"));
    }
    Running::start(&mut tremie)
}

/// Sends SIGINT: the program ends soon, as an interrupted one, and leaves nothing.
#[track_caller]
fn is_interrupted(mut running: Running, home: &Path) {
    let components = children_of(running.id());
    running.send("-INT");
    let begin = Instant::now();
    assert_eq!(running.wait(Duration::from_secs(10)), Some(130));
    assert!(begin.elapsed() < SOON, "{:?}", begin.elapsed());
    let errors = running.errors();
    let last = errors.trim().lines().last().unwrap_or_default();
    assert!(last.starts_with("interrupted before the first window"), "{errors}");
    assert!(!home.join("out").exists(), "a run that never began left a folder behind");
    assert!(!components.into_iter().any(is_alive), "a component is left over");
}

/// Waits until the script of `running` has become `sleep`.
fn sleeps(running: &Running) -> bool {
    let line = |id: &u32| std::fs::read_to_string(format!("/proc/{id}/cmdline"));
    children_of(running.id()).iter().any(|id| line(id).unwrap_or_default().starts_with("sleep"))
}

#[test]
fn ctrl_c_ends_a_run_whose_component_never_answers_the_hello() {
    let home = tempfile::tempdir().unwrap();
    let running = start(home.path(), "run", "exec sleep 1000");
    until("the component starts", || sleeps(&running));
    is_interrupted(running, home.path());
}

#[test]
fn ctrl_c_ends_a_check_too() {
    let home = tempfile::tempdir().unwrap();
    let running = start(home.path(), "check", "exec sleep 1000");
    until("the component starts", || sleeps(&running));
    is_interrupted(running, home.path());
}

#[test]
fn ctrl_c_ends_a_run_whose_component_never_gets_ready() {
    let home = tempfile::tempdir().unwrap();
    let answer = description(INTERFACE_VERSION);
    let lines = format!("read line\necho '{answer}'\nread line\nexec sleep 1000");
    let running = start(home.path(), "run", &lines);
    until("the component has its assignment", || sleeps(&running));
    is_interrupted(running, home.path());
}

#[test]
fn ctrl_c_ends_a_run_whose_component_never_stops_talking() {
    let home = tempfile::tempdir().unwrap();
    let begun = home.path().join("begun");
    let running = start(home.path(), "run", &format!("touch {begun:?}\n{TALKS}"));
    until("the component starts", || begun.exists());
    is_interrupted(running, home.path());
}

#[test]
fn ctrl_c_ends_a_run_in_order_although_a_component_never_stops_talking() {
    let home = tempfile::tempdir().unwrap();
    let tremie = env!("CARGO_BIN_EXE_tremie");
    let lines = format!("yes noise >&2 &\nexec {tremie:?} component fluid-lbm");
    let program = script(home.path(), "loud-fluid", &lines);
    let set = format!("components.fluid={{ program = {program:?}, settings.cell = \"0.5 mm\" }}");
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, SMALL).unwrap();
    let mut command = self::tremie();
    command.args(["run", "--json", "--until", "100 s", "--set", &set, "--out"]);
    command.arg(home.path().join("out")).arg(&manifest).stdout(Stdio::piped());
    let mut running = Running::start(&mut command);
    running.says("\"progress\"");
    running.send("-INT");
    assert_eq!(running.wait(Duration::from_secs(10)), Some(130));
    assert!(home.path().join("out/summary.json").exists());
}

/// A small manifest with so many bodies that a hello exceeds the buffer of a pipe (64 KiB).
fn with_many_bodies(program: PathBuf) -> String {
    let text = small_with_fluid(&program);
    let sphere = |k: usize| {
        let [x, y, z] = [k % 10, k / 10 % 10, k / 100].map(|n| n + 1);
        format!("{{ position = [\"{x} mm\", \"{y} mm\", \"{z} mm\"], diameter = \"0.5 mm\" }}")
    };
    let list: Vec<_> = (0..1000).map(sphere).collect();
    let (before, rest) = text.split_once("spheres = [").unwrap();
    let (_, after) = rest.split_once("\n]").unwrap();
    format!("{before}spheres = [{}]{after}", list.join(", "))
}

#[test]
fn a_component_that_does_not_even_read_is_given_up() {
    let home = tempfile::tempdir().unwrap();
    for lines in ["exec sleep 1000", TALKS] {
        let text = with_many_bodies(script(home.path(), "script-fluid", lines));
        let begin = Instant::now();
        let ran = run_text(&text, &["--set", "run.start_within=1 s"]);
        assert_eq!(ran.code(), Some(2), "{}", ran.errors());
        let expected = "components.fluid: it did not answer within 1 s";
        assert!(ran.errors().contains(expected), "{}", ran.errors());
        assert!(begin.elapsed() < Duration::from_secs(10), "{:?}", begin.elapsed());
        assert!(!ran.out.exists());
    }
}

#[test]
fn a_wait_that_is_none_is_refused() {
    let ran = run_text(SMALL, &["--set", "run.start_within=1e20 s"]);
    assert_eq!(ran.code(), Some(2), "{}", ran.errors());
    assert!(ran.errors().contains("at most 86400 s"), "{}", ran.errors());
}
