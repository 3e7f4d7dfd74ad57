//! Output of the component for a user who starts it by hand.

use std::process::Command;

#[test]
fn started_by_hand_it_says_how_it_is_meant_to_be_started() {
    let output = Command::new(env!("CARGO_BIN_EXE_minimal-observer")).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("tremie run"), "{said}");
    assert!(said.contains("`observer`"), "{said}");
}
