//! A plate all but touches the centres of the last layer of cells before it, in fluids of small
//! viscosity: sound between it and the floor must not grow.

use crate::common::*;
use tremie_fluid_lbm::Collision;
use tremie_messages::scene::Geometry;

/// Largest deviation of the density in a box with a plate at a height above its floor [cells], soon
/// and long after its fluid set out.
fn rings(height: f64, tau: f64, smagorinsky: f64) -> [f64; 2] {
    let mut case = Case::new([32, 16, 14], [WALL; 3], tau);
    case.collision = Collision::Bgk;
    case.smagorinsky = smagorinsky;
    case.velocity = [1e-3, 0.0, 1e-3];
    let mut scene = case.scene();
    let plate = Geometry::Box { size: [20.0, 10.0, 16.0] };
    scene.parts.push(part("plate", plate, [16.0, 8.0, height + 8.0]));
    let mut fluid = case.fluid_of(&scene);
    fluid.start(&[], &mut []).unwrap();
    [20, 2980].map(|steps| {
        for _ in 0..steps {
            fluid.step(&[], &mut []).unwrap();
        }
        let seen = fluid.diagnostics();
        seen.max_density_deviation.max(-seen.min_density_deviation)
    })
}

/// At the start it is about 1e-3. Walls keep the mass, so nothing else than sound is left in the
/// end. With walls where they are, it grows to 1e-2 and more in most of these, or to no number at
/// all.
#[test]
fn sound_between_near_walls_dies_down() {
    for (tau, smagorinsky, heights) in [
        (0.500008, 0.4, [1.55, 2.6, 3.55]),
        (0.505, 0.0, [1.55, 1.6, 2.55]),
        (0.51, 0.0, [1.52, 1.55, 2.52]),
        (0.513, 0.0, [1.52, 1.53, 1.54]),
    ] {
        for height in heights {
            let [first, left] = rings(height, tau, smagorinsky);
            println!("tau {tau}, {height} cells: {first:.1e}, then {left:.1e}");
            assert!(first > 5e-4 && left < 1e-3, "tau {tau}, {height} cells: {first} {left}");
        }
    }
}
