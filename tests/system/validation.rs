//! The short forms of the validation cases, as `tremie validate --short` runs them.

use crate::tremie::tremie;

#[test]
fn short_forms_of_all_cases_are_within_their_tolerances() {
    let output = tremie().args(["validate", "--short"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    println!("{said}");
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("all passed"));
}

#[test]
fn a_case_that_is_not_there_is_named() {
    let output = tremie().args(["validate", "--short", "settling-spere"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success());
    assert!(said.contains("settling-spere") && said.contains("settling-sphere"), "{said}");
}
