//! A head-on collision gives the restitution that the law promises, whichever way it is given.

use crate::common::*;
use tremie_grains_dem::{damping_ratio, restitution};
use tremie_messages::scene::{ContactLaw, Damping, Motion};

const D: f64 = 0.8e-3;
const K: f64 = 1e7;

fn contact_time(m: f64) -> f64 {
    std::f64::consts::PI * (m / K).sqrt()
}

fn law_of(damping: Damping, tension: bool) -> ContactLaw {
    ContactLaw { tension, ..law(K, 0.4, damping) }
}

/// Speed after over speed before, of two equal spheres.
fn of_a_pair(law: ContactLaw) -> f64 {
    let mut scene = scene([4e-3; 3], WALLS, law);
    let (left, right) = ([1.5e-3, 2e-3, 2e-3], [1.5e-3 + D + 1e-9, 2e-3, 2e-3]);
    scene.bodies = vec![set(
        Motion::Free,
        vec![sphere(left, D, [0.5, 0.0, 0.0]), sphere(right, D, [-0.5, 0.0, 0.0])],
    )];
    let dt = contact_time(0.5 * mass(D)) / 4000.0;
    let mut dem = make(&scene, dt);
    dem.advance(20_000, &[]).unwrap();
    let after = state(&dem);
    after[1].velocity[0] - after[0].velocity[0]
}

/// Speed after over speed before, of a sphere against the floor.
fn of_a_wall(law: ContactLaw) -> f64 {
    let mut scene = scene([4e-3; 3], WALLS, law);
    let start = [2e-3, 2e-3, 0.5 * D + 1e-9];
    scene.bodies = vec![set(Motion::Free, vec![sphere(start, D, [0.0, 0.0, -1.0])])];
    let dt = contact_time(mass(D)) / 4000.0;
    let mut dem = make(&scene, dt);
    dem.advance(20_000, &[]).unwrap();
    state(&dem)[0].velocity[2]
}

/// Tolerance 1e-3: the dashpot sets in at once, somewhere within a step, hence the fine step.
fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-3, "{found}, expected {expected}");
}

#[test]
fn given_by_restitution() {
    for tension in [false, true] {
        for e in [0.2, 0.45, 0.9, 1.0] {
            assert_near(of_a_pair(law_of(Damping::Restitution(e), tension)), e);
            assert_near(of_a_wall(law_of(Damping::Restitution(e), tension)), e);
        }
    }
}

#[test]
fn given_by_coefficients() {
    // Grains of 0.8 mm with 3 kg/s: 0.175 between grains, 0.258 at a wall (0.011, 0.107 with
    // tension).
    let damping = coefficients(3.0, 0.0);
    assert_near(of_a_pair(law_of(damping, false)), 0.175);
    assert_near(of_a_wall(law_of(damping, false)), 0.258);
    assert_near(of_a_pair(law_of(damping, true)), 0.011);
    assert_near(of_a_wall(law_of(damping, true)), 0.107);
}

#[test]
fn formulas_invert_each_other() {
    let zeta = damping_ratio(0.451, false);
    assert!((zeta - 0.3).abs() < 1e-4);
    assert!((restitution(zeta, false) - 0.451).abs() < 1e-12);
}
