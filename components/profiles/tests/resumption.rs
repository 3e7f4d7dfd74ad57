//! Tables of a run that goes on from a checkpoint are those of one that was never interrupted.

mod two_profiles;

use std::path::Path;
use tremie_messages::Stamp;
use tremie_messages::frame::{ProfileBin, ProfileHeader};
use tremie_profiles::ProfileWriter;
use tremie_sdk::{Moment, Observer};
use tremie_test_support::interrupted::InterruptedRun;
use two_profiles::{LAST, profile, setup};

/// One profile has a table every third window, the other every seventh.
fn feed(writer: &mut ProfileWriter, window: u64) {
    let stamp = Stamp { run: 7, window, ticks: window, ..Stamp::default() };
    let time = 1e-3 * window as f64;
    for (name, every, count) in [("plane", 3, 8), ("line", 7, 3)] {
        if window == 0 || !window.is_multiple_of(every) {
            continue;
        }
        let bin = |k: u64| ProfileBin {
            grains: (k + window) as f64 / 7.0,
            velocity: if k == 1 { [f64::NAN; 3] } else { [-0.0, time, 1e-9 * time] },
            kinetic_stress: [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(|c| c * time),
            ..ProfileBin::default()
        };
        let bins: Vec<_> = (0..count).map(bin).collect();
        let header = ProfileHeader { stamp, begin: time - 3e-3, end: time, samples: every };
        writer.profile("grains", name, Moment { stamp, time }, &header, &bins).unwrap();
    }
}

fn run(home: &Path) -> InterruptedRun<'_, ProfileWriter> {
    InterruptedRun { home, setup: &setup, feed: &feed, last: LAST }
}

#[test]
fn tables_go_on_where_the_checkpoint_was() {
    let home = tempfile::tempdir().unwrap();
    // Before any table, right after one, between two, and at the end.
    for kept in [1, 3, 7, 11, LAST] {
        run(home.path()).assert_goes_on(kept, [19.max(kept), 14.max(kept)]);
    }
}

#[test]
fn arrays_of_a_run_that_ended_are_gone_until_it_ends_again() {
    let home = tempfile::tempdir().unwrap();
    let run = run(home.path());
    run.killed(8, 8);
    let folder = home.path().join("8-8-kept");
    let arrays = folder.join("profiles/plane.npz");
    assert!(arrays.exists());
    let writer = run.resume(&folder, 8).unwrap();
    assert!(!arrays.exists());
    drop(writer);
}

#[test]
fn rows_that_are_missing_are_told() {
    let home = tempfile::tempdir().unwrap();
    let run = run(home.path());
    let folder = run.killed(8, 15);
    let path = folder.join("profiles/plane.csv");
    let why = || run.resume(&folder, 8).map(|_| ()).unwrap_err().to_string();
    std::fs::write(&path, "begin [s]").unwrap();
    let told = why();
    assert!(told.contains("profiles/plane.csv holds 9 bytes, expected the "), "{told}");
    assert_eq!(std::fs::read(&path).unwrap(), b"begin [s]", "it is left as it is");
    std::fs::remove_file(&path).unwrap();
    let told = why();
    assert!(told.contains("profiles/plane.csv"), "{told}");
}

#[test]
fn a_state_of_other_bins_is_refused() {
    let home = tempfile::tempdir().unwrap();
    let folder = run(home.path()).killed(8, 15);
    let other = |output: &Path| {
        let mut setup = setup(output);
        setup.hello.scene.profiles[0] = profile("plane", &[(2, 3)]);
        setup
    };
    let run = InterruptedRun { setup: &other, ..run(home.path()) };
    let why = run.resume(&folder, 8).map(|_| ()).unwrap_err().to_string();
    assert!(
        why.contains("16 bins of 2 tables of the profile \"plane\", expected 3 of each"),
        "{why}"
    );
}
