//! Runs that something breaks off at random: faults that a component commits, signals to components
//! and to the orchestrator, at random windows and moments, also while a checkpoint is being written.
//!
//! Each is noticed in time, leaves nothing behind, and goes on to the bits of a run that nothing
//! disturbed. All is drawn from a seed: case 37 is always the same.

mod check;
mod full;
mod hazard;
mod scenes;
mod watched;

use check::{Disturbed, Undisturbed};
use hazard::Hazard;
use std::time::Duration;

/// Seed of all draws.
const SEED: u64 = 20_261_128;
/// Cases of the long form.
const CASES: u64 = 100;

/// Carries out cases, and returns the time after which each was noticed, where that was seen.
fn carry_out(cases: impl Iterator<Item = u64>) -> Vec<(&'static str, Duration)> {
    let mut undisturbed = Undisturbed::default();
    let (mut delays, mut late) = (Vec::new(), 0);
    let mut count = 0;
    for case in cases {
        let hazard = Hazard::draw(SEED, case);
        let about = format!("case {case}: {hazard}");
        let disturbed = Disturbed::run(&hazard, &mut undisturbed, &about);
        println!("{about}: {disturbed}");
        delays.extend(disturbed.noticed_after.map(|delay| (hazard.what.name(), delay)));
        late += u64::from(disturbed.came_too_late);
        count += 1;
    }
    // A machine that is too busy to hit a run while it lasts would test nothing.
    assert!(4 * late <= count, "{late} of {count} runs were over before they were disturbed");
    delays
}

#[test]
fn runs_that_are_broken_off_go_on_to_the_same_bits() {
    carry_out((0..CASES).step_by(10));
}

/// Takes minutes: `cargo test --release --workspace --test system -- --ignored --nocapture
/// a_hundred_random_faults`.
#[test]
#[ignore = "minutes; CONTRIBUTING.md has the command"]
fn a_hundred_random_faults() {
    let only = std::env::var("TREMIE_CASE").ok().map(|case| case.parse::<u64>().unwrap());
    let mut delays = carry_out((0..CASES).filter(|case| only.is_none_or(|only| only == *case)));
    delays.sort_by_key(|(_, delay)| *delay);
    let within = |limit: u64| {
        delays.iter().filter(|(_, delay)| *delay <= Duration::from_millis(limit)).count()
    };
    println!("{} faults were noticed, after the time at which they had to be", delays.len());
    for limit in [1, 2, 5, 10, 20, 50, 100, 150, 200, 250] {
        println!("  within {limit:4} ms: {}", within(limit));
    }
    for (name, delay) in delays.iter().rev().take(5) {
        println!("  late: {name}, {:.1} ms", 1e3 * delay.as_secs_f64());
    }
}
