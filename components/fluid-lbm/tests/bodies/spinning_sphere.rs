//! Torque on a sphere that spins in a fluid at rest: `8 pi mu a^3 omega` (Stokes). 10 cells a
//! diameter, a periodic box of 8 radii, whose images change the torque by the solid fraction, 0.8
//! %; within 3 %.

use crate::common::*;
use tremie_messages::BodyState;

#[test]
fn the_torque_on_a_spinning_sphere_is_that_of_stokes() {
    let case = Case::new([40; 3], [PERIODIC; 3], 1.0);
    let mut fluid = case.fluid();
    let radius = 5.0_f64;
    let mut body = [BodyState::at_rest(1, [20.1, 19.8, 20.3])];
    body[0].angular_velocity = [1e-4, 2e-4, -2e-4];
    fluid.apply_events(&[added(1, radius)]).unwrap();
    let mut loads = loads_of(&body);
    fluid.start(&body, &mut loads).unwrap();
    for _ in 0..800 {
        fluid.step(&body, &mut loads).unwrap();
    }
    let stokes = 8.0 * std::f64::consts::PI * case.viscosity() * radius.powi(3);
    for a in 0..3 {
        let ratio = -loads[0].torque[a] / (stokes * body[0].angular_velocity[a]);
        println!("torque over Stokes': {ratio}");
        assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
    }
    assert!(norm(loads[0].force) < 1e-3 * stokes * 3e-4 / radius);
}
