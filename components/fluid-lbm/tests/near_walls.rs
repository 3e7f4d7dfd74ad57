//! A plate all but touches the centres of the last layer of cells before it, in fluids of small viscosity: sound between
//! it and the floor, and links that begin there, must not grow.

mod common;

use common::*;
use tremie_fluid_lbm::Collision;
use tremie_messages::BodyState;
use tremie_messages::scene::{Geometry, Motion};

/// Largest deviation of the density long after a knock at a plate at a height above the floor [cells].
fn rings(height: f64, tau: f64, smagorinsky: f64) -> f64 {
    let mut case = Case::new([32, 16, 14], [WALL; 3], tau);
    case.collision = Collision::Bgk;
    case.smagorinsky = smagorinsky;
    let mut scene = case.scene();
    let mut plate = part("plate", Geometry::Box { size: [20.0, 10.0, 16.0] }, [16.0, 8.0, 0.0]);
    plate.motion = Motion::Prescribed(Vec::new());
    scene.parts.push(plate);
    let mut fluid = case.fluid_of(&scene);
    let mut body = [BodyState::at_rest(1, [16.0, 8.0, height + 8.0])];
    fluid.apply_events(&[added_part(1, 0)]).unwrap();
    let mut loads = loads_of(&body);
    fluid.start(&body, &mut loads).unwrap();
    for k in 0..3000 {
        let knock = if k < 200 { 1e-3 * (0.7 * f64::from(k)).sin() } else { 0.0 };
        body[0].velocity[2] = knock;
        body[0].position[2] += knock;
        fluid.step(&body, &mut loads).unwrap();
    }
    let seen = fluid.diagnostics();
    seen.max_density_deviation.max(-seen.min_density_deviation)
}

/// The knock is of about 1e-3. With walls where they are, it grows to 1e-2 and more in most of these, or to no number
/// at all.
#[test]
fn sound_between_near_walls_dies_down() {
    for (tau, smagorinsky, heights) in [
        (0.500008, 0.4, [1.55, 2.6, 3.55]),
        (0.505, 0.0, [1.55, 1.6, 2.55]),
        (0.51, 0.0, [1.52, 1.55, 2.52]),
        (0.513, 0.0, [1.52, 1.53, 1.54]),
    ] {
        for height in heights {
            let left = rings(height, tau, smagorinsky);
            println!("tau {tau}, {height} cells: {left:.1e}");
            assert!(left < 5e-4, "tau {tau}, {height} cells: {left}");
        }
    }
}
