//! Coupling of fluid and grains: impulse, momentum, substeps.

use crate::tremie::{SMALL, run_text};

#[test]
fn the_impulse_delivered_is_the_impulse_received_bit_for_bit() {
    for schedule in ["serial", "parallel"] {
        let signals = run_text(SMALL, &["--schedule", schedule]).succeeded().signals();
        for axis in ["x", "y", "z"] {
            let delivered = &signals[&format!("fluid.impulse_delivered_{axis}")];
            let received = &signals[&format!("grains.impulse_received_{axis}")];
            // What the fluid finds in one window, the grains feel in the next.
            assert_eq!(delivered[..delivered.len() - 1], received[1..], "{schedule}, {axis}");
            assert!(received.last().unwrap().abs() > 0.0, "nothing crossed");
        }
    }
}

#[test]
fn the_momentum_of_the_fluid_is_accounted_for_to_rounding() {
    let signals = run_text(SMALL, &[]).succeeded().signals();
    let exchanged = signals["fluid.body_impulse_z"].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let gap = signals["fluid.momentum_residual"].iter().fold(0.0_f64, |a, b| a.max(*b));
    assert!(exchanged > 0.0);
    // Relative to the impulse that the fluid at rest exchanges with a wall of the box in one step.
    let momentum = signals["fluid.mass"][0] * 0.5e-3 / 1e-4;
    assert!(gap <= 1e-12 * momentum, "a gap of {gap} of {momentum}");
}

#[test]
fn mass_is_accounted_for_to_rounding() {
    let signals = run_text(SMALL, &[]).succeeded().signals();
    let mass = signals["fluid.mass"][0];
    let gap = signals["fluid.mass_residual"].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    assert!(gap <= 1e-12 * mass, "a gap of {gap} of {mass}");
}

/// Fixes both steps so that their ratio is 2.4.
const RATIO: [&str; 4] = [
    "--set",
    "settings.fluid-lbm.time_step=0.24 ms",
    "--set",
    "settings.grains-dem.time_step=0.1 ms",
];

#[test]
fn a_ratio_of_two_point_four_becomes_three_substeps_and_is_said() {
    let text = SMALL.replace("\"50 N/m\"", "\"20 N/m\"").replace("\"40 N/m\"", "\"16 N/m\"");
    let ran = run_text(&text, &RATIO).succeeded();
    let said = ran.errors();
    assert!(said.contains("2.4") && said.contains('3'), "{said}");
    let work = &ran.summary()["components"]["grains"]["work"];
    let windows = ran.summary()["windows"].as_u64().unwrap();
    assert_eq!(work.as_u64(), Some(3 * 3 * windows), "three grains, three substeps a window");
}

#[test]
fn fixed_substeps_are_kept_exactly() {
    let program = "components.grains={ program = \"grains-dem\", sync_iter = 25 }";
    let ran = run_text(SMALL, &["--set", program]).succeeded();
    let windows = ran.summary()["windows"].as_u64().unwrap();
    let work = ran.summary()["components"]["grains"]["work"].as_u64().unwrap();
    assert_eq!(work, 3 * 25 * windows);
}
