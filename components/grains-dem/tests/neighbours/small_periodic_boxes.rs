//! Bodies that are large in a periodic box: bodies that cannot move meet nothing through its faces.

use crate::common::*;
use tremie_messages::scene::{Damping, Face, Motion};

const DT: f64 = 1e-3;

/// Fixed bodies meet nothing: they may be large in a periodic box. A free one must not meet another
/// through both faces.
#[test]
fn fixed_bodies_fill_a_small_periodic_box() {
    let periodic = || [Face::Periodic, Face::Periodic];
    let faces = [periodic(), periodic(), periodic()];
    let places = [[0.253, 0.257, 0.261], [0.753, 0.757, 0.761]];
    let mut small = scene([1.0; 3], faces, law(50.0, 0.5, Damping::Restitution(0.9)));
    let spheres = places.map(|place| sphere(place, 0.492, [0.0; 3]));
    small.bodies = vec![set(Motion::Fixed, spheres.to_vec())];
    let mut dem = make(&small, DT);
    dem.advance(20, &[]).unwrap();
    assert_eq!(state(&dem)[1].position, places[1]);
    small.bodies[0].motion = Motion::Free;
    let refused = tremie_grains_dem::Parameters::default().resolve(&small).unwrap_err();
    assert!(refused[0].to_string().contains("through both faces"), "{refused:?}");
    // A small free one beside a large fixed one: their ranges add up to less than the box.
    small.bodies[0] = set(Motion::Fixed, vec![sphere(places[0], 0.6, [0.0; 3])]);
    small.bodies.push(set(Motion::Free, vec![sphere(places[1], 0.1, [0.0; 3])]));
    make(&small, DT).advance(20, &[]).unwrap();
}
