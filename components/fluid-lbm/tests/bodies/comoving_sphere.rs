//! A sphere that moves with the fluid feels nothing, at any place relative to the cells (Galilean
//! invariance): to 1e-12 of Stokes' drag at its speed, which is rounding.

use crate::common::*;
use tremie_messages::BodyState;

/// Largest force over Stokes' drag at the same speed, while the sphere crosses 25 cells and a
/// periodic face.
fn largest_force(tau: f64) -> f64 {
    let u = [0.05, 0.02, -0.01];
    let mut case = Case::new([32, 24, 24], [PERIODIC; 3], tau);
    case.velocity = u;
    let mut fluid = case.fluid();
    let radius = 5.0;
    let mut bodies = [BodyState::at_rest(1, [12.0, 12.0, 12.0])];
    bodies[0].velocity = u;
    fluid.apply_events(&[added(1, radius)]).unwrap();
    let mut loads = loads_of(&bodies);
    fluid.start(&bodies, &mut loads).unwrap();
    let stokes = 6.0 * std::f64::consts::PI * case.viscosity() * radius * norm(u);
    let mut largest = 0.0_f64;
    for _ in 0..500 {
        advance(&mut bodies);
        fluid.step(&bodies, &mut loads).unwrap();
        largest = largest.max(norm(loads[0].force) / stokes);
    }
    assert!(fluid.diagnostics().links > 300);
    largest
}

#[test]
fn a_sphere_that_moves_with_the_fluid_feels_nothing() {
    for tau in [0.6, 0.8, 1.2] {
        let force = largest_force(tau);
        println!("tau {tau}: {force}");
        assert!(force < 1e-12, "tau {tau}: {force}");
    }
}
