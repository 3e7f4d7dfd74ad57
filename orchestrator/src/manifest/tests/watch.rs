//! Watchdogs.

use super::*;
use crate::manifest::WatchLimit;
use tremie_messages::WatchedQuantity;

fn with(lines: &str) -> String {
    format!("{GOOD}\n[watch]\n{lines}\n")
}

#[test]
fn limits_are_numbers_or_off() {
    let text = with("mach = 0.2\ndensity = \"off\"\nspeed = 3");
    let watch = read(&text).unwrap_or_else(|errors| panic!("{errors}")).spec.watch;
    let expected = [
        (WatchedQuantity::Mach, WatchLimit::Above(0.2)),
        (WatchedQuantity::Density, WatchLimit::Off),
        (WatchedQuantity::Speed, WatchLimit::Above(3.0)),
    ];
    assert_eq!(watch.into_iter().collect::<Vec<_>>(), expected);
    reads_back(&text);
    assert!(read(GOOD).unwrap().spec.watch.is_empty());
    for quantity in WatchedQuantity::ALL {
        let text = with(&format!("{quantity} = 0.5"));
        assert_eq!(read(&text).unwrap().spec.watch.get(&quantity), Some(&WatchLimit::Above(0.5)));
    }
}

#[test]
fn wrong_limits_are_told_at_their_keys() {
    one_problem(&with("mach = 0.0"), &["watch.mach", "found 0", "above zero"]);
    one_problem(&with("mass = -1"), &["watch.mass", "found -1", "takes the watchdog away"]);
    one_problem(&with("overlap = \"on\""), &["watch.overlap", "found \"on\"", "\"off\""]);
    one_problem(&with("energy = true"), &["watch.energy", "a number above zero, or \"off\""]);
    one_problem(&with("overlaps = 0.3"), &["watch.overlaps", "did you mean \"overlap\"?"]);
}
