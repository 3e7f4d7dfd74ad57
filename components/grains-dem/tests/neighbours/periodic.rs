//! Nothing tells a periodic face from any other place.

use crate::common::*;
use tremie_messages::{
    body::BodyState,
    scene::{Damping, Motion},
};

/// Two spheres that collide obliquely at `place`, afterwards.
fn collide_at(place: [f64; 3]) -> Vec<BodyState> {
    let size = 8e-3;
    let mut scene = scene([size; 3], PERIODIC, law(1e4, 0.4, Damping::Restitution(0.6)));
    let at = |offset: [f64; 3]| std::array::from_fn(|a| (place[a] + offset[a]).rem_euclid(size));
    let mut left = sphere(at([-0.6e-3, 0.1e-3, 0.0]), 1e-3, [1.0, 0.1, 0.3]);
    left.angular_velocity = [0.0, 300.0, -500.0];
    let right = sphere(at([0.6e-3, -0.1e-3, 0.2e-3]), 1e-3, [-1.0, 0.0, 0.0]);
    scene.bodies = vec![set(Motion::Free, vec![left, right])];
    let mut dem = make(&scene, 2e-7);
    dem.advance(4_000, &[]).unwrap();
    state(&dem)
}

#[test]
fn a_collision_across_faces_equals_one_in_the_middle() {
    let middle = collide_at([4e-3; 3]);
    assert!(middle[0].velocity[0] < 0.0, "they did collide");
    for place in [[0.0, 4e-3, 4e-3], [8e-3, 0.0, 0.0], [0.0; 3]] {
        for (a, b) in collide_at(place).iter().zip(&middle) {
            assert!(norm(minus(a.velocity, b.velocity)) < 1e-11);
            assert!(norm(minus(a.angular_velocity, b.angular_velocity)) < 1e-8);
            assert!(a.position.iter().all(|x| (0.0..8e-3).contains(x)));
        }
    }
}
