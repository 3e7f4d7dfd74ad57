//! Conservation of energy, momentum and angular momentum in collisions.

use crate::common::*;
use tremie_grains_dem::GrainsDem;
use tremie_messages::scene::{Damping, Motion};

#[test]
fn a_gas_with_friction_conserves_momentum_to_rounding() {
    let mut scene = scene([8e-3; 3], PERIODIC, law(1e4, 0.5, Damping::Restitution(0.7)));
    gas(&mut scene, 1.0, 7);
    let mut dem = make(&scene, 5e-7);
    let before = dem.diagnostics();
    dem.advance(20_000, &[]).unwrap();
    let after = dem.diagnostics();
    assert!(after.kinetic_energy < 0.9 * before.kinetic_energy, "they did collide");
    let scale = (2.0 * before.kinetic_energy * mass(1e-3) * dem.body_count() as f64).sqrt();
    let change = norm(minus(after.momentum, before.momentum));
    assert!(change < 1e-12 * scale, "{change} of {scale}");
}

/// Angular momentum of all bodies about the origin.
fn angular_momentum(dem: &GrainsDem) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (s, radius) in state(dem).iter().zip(dem.radii()) {
        let d = 2.0 * radius;
        let orbital = cross(s.position, s.velocity);
        for a in 0..3 {
            sum[a] += mass(d) * orbital[a] + inertia(d) * s.angular_velocity[a];
        }
    }
    sum
}

#[test]
fn an_oblique_collision_conserves_both_momenta_to_rounding() {
    let mut scene = scene([8e-3; 3], WALLS, law(1e4, 0.3, Damping::Restitution(0.6)));
    let mut left = sphere([3e-3, 4e-3, 4e-3], 1e-3, [1.0, 0.1, 0.0]);
    left.angular_velocity = [100.0, 300.0, -500.0];
    let right = sphere([4.2e-3, 4.3e-3, 3.9e-3], 1.2e-3, [-0.5, 0.0, 0.2]);
    scene.bodies = vec![set(Motion::Free, vec![left, right])];
    let mut dem = make(&scene, 2e-7);
    let (p, l) = (dem.diagnostics().momentum, angular_momentum(&dem));
    dem.advance(5_000, &[]).unwrap();
    assert!(state(&dem)[0].velocity[0] < 0.5, "they did collide");
    let (p_after, l_after) = (dem.diagnostics().momentum, angular_momentum(&dem));
    assert!(norm(minus(p_after, p)) < 1e-13 * norm(p));
    assert!(norm(minus(l_after, l)) < 1e-12 * norm(l), "{l:?} {l_after:?}");
}

/// Largest deviation of the energy of an elastic gas in 2 ms, relative.
fn energy_error(dt: f64) -> f64 {
    let mut scene = scene([5e-3; 3], WALLS, law(1e4, 0.0, Damping::Restitution(1.0)));
    gas(&mut scene, 0.5, 3);
    let mut dem = make(&scene, dt);
    let energy = |dem: &mut GrainsDem| {
        let d = dem.diagnostics();
        d.kinetic_energy + d.elastic_energy
    };
    let start = energy(&mut dem);
    let mut worst = 0.0f64;
    for _ in 0..(2e-3 / dt).round() as usize {
        dem.advance(1, &[]).unwrap();
        worst = worst.max((energy(&mut dem) / start - 1.0).abs());
    }
    worst
}

#[test]
fn an_elastic_gas_conserves_energy_to_second_order() {
    let errors = [1e-6, 5e-7, 2.5e-7].map(energy_error);
    let orders = [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2);
    println!("energy errors {errors:?}, orders {orders:?}");
    assert!(errors[0] < 1e-2, "{errors:?}");
    let overall = (orders[0] + orders[1]) / 2.0;
    assert!(overall > 1.7, "{errors:?}: orders {orders:?}");
}
