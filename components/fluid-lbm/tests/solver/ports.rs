//! Velocities at the faces on which inlets of grains sit.

use crate::common::*;
use tremie_messages::BodyState;
use tremie_messages::scene::{Diameters, Inlet, InletVelocity};

fn at_face(axis: usize, side: usize) -> Inlet {
    Inlet {
        name: "feed".into(),
        bodies: "grains".into(),
        min: [0.0; 3],
        max: [1.0; 3],
        fraction: 0.1,
        diameters: Diameters::Uniform { min: 1.0, max: 1.0 },
        every: None,
        velocity: InletVelocity::Face { axis, side },
        until: None,
        seed: 1,
        tries: 1,
    }
}

/// A face tells the mean of the velocity normal to it, into the domain, over the cells of its layer
/// that are fluid.
#[test]
fn a_face_tells_the_mean_velocity_through_it() {
    let case = Case::new([12, 10, 8], [WALL; 3], 0.8);
    let mut scene = case.scene();
    scene.inlets = vec![at_face(2, 1), at_face(0, 0), at_face(2, 1)];
    let mut fluid = case.fluid_of(&scene);
    let u = |x: [f64; 3]| 1e-3 * (1.0 + x[0] - 0.5 * x[1] + 0.25 * x[2]);
    fluid.set_state(|x| ([u(x), 0.0, -u(x)], 0.0));
    let told: Vec<_> = fluid.ports().iter().map(|port| (port.to_string(), port.velocity)).collect();
    // Cells of size 1: the layers' middles are half a cell from the faces.
    let expected = [("x_lower", u([0.5, 5.0, 4.0])), ("z_upper", u([6.0, 5.0, 7.5]))];
    for ((name, velocity), (face, mean)) in told.iter().zip(expected) {
        assert_eq!(name, face);
        assert!((velocity - mean).abs() < 1e-14, "{face}: {velocity} {mean}");
    }
    assert_eq!(told.len(), 2);
    // A body on the face that covers the layer's cells of x from 4 to 6 and y from 4 to 6.
    let body = [BodyState::at_rest(1, [5.0, 5.0, 7.5])];
    fluid.apply_events(&[added(1, 1.0)]).unwrap();
    fluid.start(&body, &mut loads_of(&body)).unwrap();
    let all = 120.0 * u([6.0, 5.0, 7.5]) - 4.0 * u([5.0, 5.0, 7.5]);
    assert!((fluid.ports()[1].velocity - all / 116.0).abs() < 1e-14);
}
