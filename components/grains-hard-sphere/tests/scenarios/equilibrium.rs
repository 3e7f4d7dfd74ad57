//! Elastic gases: rate of collisions and pressure against Carnahan & Starling (1969), and in a plane
//! Henderson (1975) with the correction of Luding (*Phys. Rev. E* 63, 2001, 042201). Without it
//! Henderson's pressure is 1.2 % too high at a fraction of 0.6.

use crate::common::{bare, gas, make};
use std::f64::consts::PI;
use tremie_grains_hard_sphere::Detection;

/// Collisions a body and time, and compressibility `Z`, by theory.
fn theory(dimensions: usize, phi: f64) -> (f64, f64) {
    if dimensions == 3 {
        let g = (1.0 - phi / 2.0) / (1.0 - phi).powi(3);
        (4.0 * 6.0 * phi / PI * g * PI.sqrt(), 1.0 + 4.0 * phi * g)
    } else {
        let g = (1.0 - 7.0 * phi / 16.0) / (1.0 - phi).powi(2)
            - phi.powi(3) / (128.0 * (1.0 - phi).powi(4));
        (2.0 * 4.0 * phi / PI * g * PI.sqrt(), 1.0 + 2.0 * phi * g)
    }
}

/// Rate and `Z` of a gas over so many collisions, once it has forgotten its lattice.
fn measure(dimensions: usize, edge: usize, phi: f64, collisions: f64) -> (f64, f64) {
    let scene = gas(dimensions, edge, phi, (1.0, 0.0), 7);
    let step = 0.1;
    let mut gas = make(&scene, &bare(Detection::Events), step);
    let n = gas.sphere_count() as f64;
    let (rate, _) = theory(dimensions, phi);
    let steps = |collisions: f64| (collisions / (0.5 * n * rate) / step).ceil() as u32;
    gas.advance(steps(15.0 * n), &[]).unwrap();
    let (before, virial) = (gas.diagnostics().collisions, gas.virial());
    let steps = steps(collisions);
    gas.advance(steps, &[]).unwrap();
    let time = f64::from(steps) * step;
    let found = (gas.diagnostics().collisions - before) as f64;
    let z = 1.0 + (gas.virial() - virial) / (dimensions as f64 * n * time);
    assert!(found > 0.95 * collisions, "{found} collisions");
    (2.0 * found / (n * time), z)
}

/// A box of N spheres deviates from theory by about 1/N; the rate's error is that of the number of
/// collisions, some 0.1 %.
fn check(dimensions: usize, edge: usize, fractions: [f64; 4]) {
    for phi in fractions {
        let (rate, z) = measure(dimensions, edge, phi, 4e5);
        let (expected_rate, expected_z) = theory(dimensions, phi);
        let errors = [rate / expected_rate - 1.0, z / expected_z - 1.0];
        println!(
            "{dimensions}-D {phi}: rate {rate:.4} ({:.2} %), Z {z:.4} ({:.2} %)",
            100.0 * errors[0],
            100.0 * errors[1]
        );
        assert!(errors.iter().all(|error| error.abs() < 5e-3), "{dimensions}-D {phi}: {errors:?}");
    }
}

#[test]
fn spheres_collide_and_press_as_carnahan_and_starling_say() {
    check(3, 8, [0.05, 0.2, 0.3, 0.45]);
}

#[test]
fn discs_collide_and_press_as_henderson_and_luding_say() {
    check(2, 32, [0.05, 0.2, 0.4, 0.6]);
}
