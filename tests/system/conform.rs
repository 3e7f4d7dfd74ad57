//! `tremie conform` on programs that keep the contract and on one that does not.

use crate::tremie::tremie;

fn conforms(program: &str) {
    let output = tremie().args(["conform", program]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("conforms"), "{said}");
}

#[test]
fn the_built_in_fluid_conforms() {
    conforms("fluid-lbm");
}

#[test]
fn the_built_in_grains_conform() {
    conforms("grains-dem");
}

#[test]
fn the_minimal_fluid_conforms() {
    conforms("minimal-fluid");
}

#[test]
fn a_program_that_speaks_something_else_does_not_conform() {
    let output = tremie().args(["conform", "/bin/cat"]).output().unwrap();
    assert!(!output.status.success());
}
