//! Profiles of grains in a plan: when they are sampled, in whole windows.

use crate::manifest::Spec;
use tremie_messages::finding::short;
use tremie_messages::scene::{GrainProfile, Scene};

/// Windows between tables of the scene's profile of a name: the whole run, where it has one.
pub(super) fn windows_between(spec: &Spec, name: &str, window: f64, windows: u64) -> u64 {
    let profile = spec.scene.profiles.iter().find(|profile| profile.name == name);
    let between = profile.and_then(|profile| profile.schedule(window).windows());
    between.unwrap_or(windows).clamp(1, windows.max(1))
}

/// Notes on when profiles are sampled, and warnings for those that are not sampled as often as they
/// ask, or not at all.
pub(super) fn notes(scene: &Scene, window: f64, windows: u64) -> (Vec<String>, Vec<String>) {
    let notes = scene.profiles.iter().map(|profile| note(profile, window, windows));
    let warnings = scene.profiles.iter().filter_map(|profile| warning(profile, window, windows));
    (notes.collect(), warnings.collect())
}

fn note(profile: &GrainProfile, window: f64, windows: u64) -> String {
    let schedule = profile.schedule(window);
    let (name, bins, tables) = (&profile.name, profile.bins(), schedule.tables(windows));
    let between = short(schedule.every as f64 * window);
    let samples =
        schedule.samples.unwrap_or(windows.saturating_sub(schedule.begin) / schedule.every);
    let tables = if tables == 1 { "1 table".into() } else { format!("{tables} tables") };
    format!("profile {name}: {tables} of {bins} bins and {samples} samples, one every {between} s")
}

fn warning(profile: &GrainProfile, window: f64, windows: u64) -> Option<String> {
    let name = &profile.name;
    let rounds = profile.every.is_some_and(|every| every < window * (1.0 - super::TOLERANCE));
    if rounds {
        return Some(format!(
            "profile {name}: sampled each window, {} s, though every = \"{} s\" asks for more samples",
            short(window),
            profile.every.map_or_else(String::new, short),
        ));
    }
    (profile.schedule(window).tables(windows) == 0)
        .then(|| format!("profile {name}: the run ends before its first sample"))
}
