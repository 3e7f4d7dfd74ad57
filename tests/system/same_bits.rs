//! The same run gives the same bits, however it is carried out.

use crate::tremie::{Ran, SMALL, run_text};

fn bits(options: &[&str]) -> String {
    run_text(SMALL, options).succeeded().signals_text()
}

#[track_caller]
fn assert_same(a: &str, b: &str) {
    let line = a.lines().zip(b.lines()).position(|(a, b)| a != b);
    assert_eq!(line, None, "the tables differ from this line on");
    assert_eq!(a.len(), b.len());
}

#[test]
fn processes_threads_and_repeats_agree() {
    for schedule in ["serial", "parallel"] {
        let once = bits(&["--schedule", schedule]);
        assert!(once.lines().count() > 20, "too short a run to tell");
        assert_same(&once, &bits(&["--schedule", schedule]));
        assert_same(&once, &bits(&["--schedule", schedule, "--in-process"]));
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    for precision in ["f64", "f32"] {
        let threads = |n: &str| {
            let fluid = format!("components.fluid={{ program = \"fluid-lbm\", threads = {n} }}");
            let precision = format!("settings.fluid-lbm.precision={precision}");
            bits(&["--set", &fluid, "--set", &precision])
        };
        let one = threads("1");
        assert_same(&one, &threads("2"));
        assert_same(&one, &threads("3"));
    }
}

#[test]
fn schedules_differ_as_they_must() {
    assert_ne!(bits(&["--schedule", "serial"]), bits(&["--schedule", "parallel"]));
}

#[test]
fn observers_change_nothing() {
    let alone = bits(&[]);
    let recorded = |ran: Ran| {
        let ran = ran.succeeded();
        assert!(ran.out.join("run.mcap").exists(), "{}", ran.errors());
        ran
    };
    let record = ["--set", "outputs.record=true", "--set", "outputs.frames=1 ms"];
    let first = recorded(run_text(SMALL, &record));
    assert_same(&alone, &first.signals_text());
    let second = recorded(run_text(SMALL, &record));
    let file = |ran: &Ran| std::fs::read(ran.out.join("run.mcap")).unwrap();
    assert!(file(&first) == file(&second), "two recordings of one run differ");
}
