//! f32 agrees with f64 to the rounding of its steps: a sphere dragged through a channel.

use crate::common::*;
use tremie_fluid_lbm::Precision;
use tremie_messages::{BodyState, Load};

fn run(precision: Precision) -> (Vec<Load>, Vec<[f64; 3]>) {
    let mut case = Case::new([40, 20, 20], [PERIODIC, WALL, WALL], 0.8);
    case.precision = precision;
    case.average_force = true;
    case.acceleration = [1e-6, 0.0, 0.0];
    let mut fluid = case.fluid();
    let mut bodies = [BodyState::at_rest(1, [10.2, 10.3, 9.6])];
    bodies[0].velocity = [0.02, 0.0, 0.0];
    fluid.apply_events(&[added(1, 4.0)]).unwrap();
    let mut loads = loads_of(&bodies);
    fluid.start(&bodies, &mut loads).unwrap();
    for _ in 0..500 {
        advance(&mut bodies);
        fluid.step(&bodies, &mut loads).unwrap();
    }
    let velocities = cells(&fluid).map(|c| fluid.velocity_at(c)).collect();
    (loads, velocities)
}

/// Force to 1e-3, velocities to 1e-4 of the sphere's speed.
#[test]
fn f32_agrees_with_f64() {
    let ((fine, fine_u), (coarse, coarse_u)) = (run(Precision::F64), run(Precision::F32));
    let scale = norm(fine[0].force);
    let force = norm(std::array::from_fn(|a| fine[0].force[a] - coarse[0].force[a])) / scale;
    let velocity = fine_u
        .iter()
        .zip(&coarse_u)
        .map(|(u, v)| norm(std::array::from_fn(|a| u[a] - v[a])) / 0.02)
        .fold(0.0, f64::max);
    println!("force {force:e}, velocity {velocity:e}");
    assert!(force < 1e-3, "{force}");
    assert!(velocity < 1e-4, "{velocity}");
}
