//! Faults committed on purpose, at random windows of both schedules. Each is caught, and both sides
//! are named. Outputs stay readable up to the last common window, and nothing is left behind.

use crate::tremie::{Ran, SMALL, run_text};

/// Window of a fault, spread over the run by a fixed rule: tests must repeat.
fn window(case: usize) -> u64 {
    3 + (case as u64 * 7) % 13
}

fn failed_run(component: &str, fault: &str, schedule: &str, window: u64) -> Ran {
    let inject = format!("{component}:{fault}@{window}");
    let options = ["--schedule", schedule, "--inject", &inject, "--set", "run.deadline=0.4 s"];
    run_text(&SMALL.replace("record = false", "record = true\nframes = \"1 ms\""), &options)
}

#[track_caller]
fn caught(fault: &str, kinds: &[&str], names_both: bool) {
    let mut case = fault.len();
    for schedule in ["serial", "parallel"] {
        for component in ["fluid", "grains"] {
            case += 1;
            let window = window(case);
            let ran = failed_run(component, fault, schedule, window);
            let about = format!("{component}:{fault}@{window} {schedule}\n{}", ran.errors());
            assert_eq!(ran.code(), Some(1), "{about}");
            let last = ran.errors().trim().lines().last().unwrap().to_string();
            assert!(last.contains(component) && last.contains("window"), "{about}");
            let summary = ran.summary();
            let found = &summary["fault"];
            assert!(kinds.contains(&found["kind"].as_str().unwrap()), "{about}");
            assert_eq!(found["blamed"], component, "{about}");
            if names_both {
                assert_ne!(found["noticed_by"], component, "{about}");
            }
            let at = found["window"].as_u64().unwrap();
            assert!(at.abs_diff(window) <= 2, "{about}");
            outputs_end_at_the_last_common_window(&ran, &about);
            ran.left_nothing(&about);
        }
    }
}

#[track_caller]
fn outputs_end_at_the_last_common_window(ran: &Ran, about: &str) {
    let windows = ran.summary()["windows"].as_u64().unwrap();
    let signals = ran.signals();
    assert_eq!(*signals["window"].last().unwrap() as u64, windows, "{about}");
    let recording = std::fs::metadata(ran.out.join("run.mcap")).unwrap();
    assert!(recording.len() > 0, "{about}");
}

#[test]
fn a_lost_message_is_caught() {
    // Either nothing comes any more, or the next message comes in its place.
    caught("drop", &["lost", "stamp"], true);
}

#[test]
fn a_message_sent_twice_is_caught() {
    caught("duplicate", &["stamp"], true);
}

#[test]
fn a_stale_stamp_is_caught() {
    caught("stale", &["stamp"], true);
}

#[test]
fn a_wrong_count_is_caught() {
    caught("count", &["count"], true);
}

#[test]
fn a_value_that_is_no_number_is_caught() {
    caught("nan", &["not_finite"], true);
}

#[test]
fn a_component_that_hangs_is_caught_at_the_deadline() {
    caught("hang", &["deadline"], true);
}

#[test]
fn a_component_that_exits_is_caught() {
    caught("exit", &["exit"], true);
}

#[test]
fn a_component_that_is_killed_is_caught() {
    caught("kill", &["exit"], true);
}

#[test]
fn one_substep_too_many_or_too_few_is_caught_with_both_sides_named() {
    for fault in ["substep-more", "substep-less"] {
        for schedule in ["serial", "parallel"] {
            let ran = failed_run("grains", fault, schedule, 9);
            let fault = ran.summary()["fault"].clone();
            assert_eq!(fault["kind"], "substeps", "{}", ran.errors());
            assert_eq!(fault["blamed"], "grains");
            assert_ne!(fault["noticed_by"], "grains");
            assert!(ran.errors().contains("substep"), "{}", ran.errors());
        }
    }
}
