//! Rough spheres and discs: rolling, sliding, equipartition.

use crate::common::{PERIODIC, bare, density, gas, make, scene, set, sphere, temperature};
use tremie_grains_hard_sphere::{Detection, HardSpheres, Parameters};
use tremie_messages::scene::{Face, Motion, Scene};

/// A ball or disc of 2 cm that spins on a floor.
fn spun_up(is_disc: bool) -> Scene {
    let faces = [PERIODIC[0].clone(), PERIODIC[1].clone(), Face::WALLS[2].clone()];
    let mut scene = scene([0.4, 0.4, 0.1], faces, 0.8, 0.3);
    if is_disc {
        scene.domain.across = Some(1);
        scene.domain.faces[1] = [Face::WALL, Face::WALL];
    }
    scene.gravity = [0.0, 0.0, -9.81];
    let mut ball = sphere([0.2, 0.2, 0.01], 0.02, [0.0; 3]);
    ball.angular_velocity = [0.0, 50.0, 0.0];
    scene.bodies = vec![set(Motion::Free, 2500.0, vec![ball])];
    scene
}

/// A sphere ends at 2/7 of `R w`, a disc at 1/3.
#[test]
fn what_spins_on_a_floor_ends_rolling() {
    for (is_disc, part) in [(false, 2.0 / 7.0), (true, 1.0 / 3.0)] {
        for detection in [Detection::Events, Detection::Steps] {
            let parameters = Parameters { detection, ..Parameters::default() };
            let mut ball = make(&spun_up(is_disc), &parameters, 1e-4);
            ball.advance(5000, &[]).unwrap();
            let (v, w) = (ball.sphere(0).velocity[0], ball.sphere(0).angular_velocity[1]);
            println!("disc {is_disc}, {detection:?}: {:.6} of R w", v / 0.5);
            assert!((v / (0.5 * part) - 1.0).abs() < 1e-9, "{v}");
            assert!((w * 0.01 / v - 1.0).abs() < 1e-9, "{w}");
            assert!(ball.sphere(0).position[2] > 0.0099);
        }
    }
}

/// While it slides it gains `mu g`.
#[test]
fn what_slides_is_braked_by_the_friction_of_its_weight() {
    for detection in [Detection::Events, Detection::Steps] {
        let parameters = Parameters { detection, ..Parameters::default() };
        let mut ball = make(&spun_up(false), &parameters, 1e-4);
        let time = 0.02;
        ball.advance((time / 1e-4f64).round() as u32, &[]).unwrap();
        let gained = ball.sphere(0).velocity[0] / (0.3 * 9.81 * time);
        assert!((gained - 1.0).abs() < 5e-3, "{detection:?}: {gained}");
    }
}

/// Elastic, perfectly rough: energy stays, and rotation gets as much of it as translation.
#[test]
fn perfectly_rough_elastic_ones_share_their_energy() {
    let parameters = Parameters { tangential_restitution: 1.0, ..bare(Detection::Events) };
    let mut spheres: HardSpheres = make(&gas(3, 5, 0.2, (1.0, 1e9), 2), &parameters, 0.5);
    let whole = |spheres: &HardSpheres| {
        let found = spheres.diagnostics();
        found.kinetic_energy + found.rotational_energy
    };
    let before = whole(&spheres);
    spheres.advance(30, &[]).unwrap();
    let (mut kinetic, mut rotational) = (0.0, 0.0);
    for _ in 0..60 {
        spheres.advance(1, &[]).unwrap();
        let found = spheres.diagnostics();
        kinetic += found.kinetic_energy;
        rotational += found.rotational_energy;
    }
    let energy = whole(&spheres) / before - 1.0;
    println!("energy {energy:.1e}, rotational over translational {:.4}", rotational / kinetic);
    assert!(energy.abs() < 1e-12, "{energy}");
    // The whole momentum is fixed: 3 N - 3 ways to move for 3 N to turn.
    let n = spheres.sphere_count() as f64;
    assert!(
        (rotational / kinetic / (n / (n - 1.0)) - 1.0).abs() < 0.02,
        "{}",
        rotational / kinetic
    );
    assert!((temperature(&spheres, 3) - 0.5).abs() < 0.05);
    let _ = density(3);
}
