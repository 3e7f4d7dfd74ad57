//! Gases that cool (Haff 1983; van Noije & Ernst 1998 for the correction).

use crate::common::{gas, make, temperature};
use std::f64::consts::PI;
use tremie_grains_hard_sphere::Parameters;

fn correction(e: f64, d: f64) -> f64 {
    16.0 * (1.0 - e) * (1.0 - 2.0 * e * e)
        / (9.0 + 24.0 * d + (8.0 * d - 41.0) * e + 30.0 * e * e * (1.0 - e))
}

/// `T = exp(-(1 - e²) (1 + a2/4) C/d)` with `C` collisions a body.
#[test]
fn the_temperature_falls_with_the_number_of_collisions() {
    for (dimensions, edge, phi) in [(3, 5, 0.1), (2, 20, 0.1)] {
        for e in [0.8, 0.9, 0.95] {
            let d = dimensions as f64;
            let exponent = (1.0 - e * e) / d * (1.0 + correction(e, d) / 4.0);
            let mut sum = 0.0;
            let seeds = 1..=8;
            for seed in seeds.clone() {
                let scene = gas(dimensions, edge, phi, (e, 0.0), seed);
                let mut gas = make(&scene, &Parameters::default(), 0.2);
                let n = gas.sphere_count() as f64;
                let collisions = |gas: &tremie_grains_hard_sphere::HardSpheres| {
                    2.0 * gas.diagnostics().collisions as f64 / n
                };
                while collisions(&gas) < 12.0 {
                    gas.advance(1, &[]).unwrap();
                }
                sum -= temperature(&gas, dimensions).ln() / collisions(&gas);
                let guarded = gas.diagnostics().guarded_by_time as f64;
                assert!(guarded < 1e-3 * gas.diagnostics().collisions as f64, "{guarded}");
            }
            let error = sum / seeds.count() as f64 / exponent - 1.0;
            println!("{dimensions}-D e {e}: exponent {exponent:.5}, {:.2} % off", 100.0 * error);
            assert!(error.abs() < 0.03, "{dimensions}-D e {e}: {error}");
        }
    }
}

/// `T = (1 + t/tau)^-2`: after a tenfold decay, and its slope late.
#[test]
fn the_temperature_falls_with_the_square_of_time() {
    let (e, phi, d) = (0.9, 0.1, 3.0);
    let g = (1.0 - phi / 2.0) / (1.0f64 - phi).powi(3);
    let rate = 4.0 * 6.0 * phi / PI * g * PI.sqrt();
    let tau = 1.0 / ((1.0 - e * e) * (1.0 + 3.0 * correction(e, d) / 16.0) * rate / (2.0 * d));
    let tenfold = (10f64.sqrt() - 1.0) * tau;
    let (mut sums, seeds, step) = ([0.0; 2], 6, tenfold / 20.0);
    for seed in 1..=seeds {
        let mut gas = make(&gas(3, 5, phi, (e, 0.0), seed), &Parameters::default(), step);
        for sum in &mut sums {
            gas.advance(20, &[]).unwrap();
            *sum += temperature(&gas, 3) / seeds as f64;
        }
    }
    let error = sums[0] / 0.1 - 1.0;
    // From t to 2 t: the slope against 1 + t/tau.
    let way = ((1.0 + 2.0 * tenfold / tau) / (1.0 + tenfold / tau)).ln();
    let slope = (sums[1] / sums[0]).ln() / way;
    println!("after a tenfold decay {:.2} % off, slope {slope:.3}", 100.0 * error);
    assert!(error.abs() < 0.05, "{error}");
    assert!((slope + 2.0).abs() < 0.1, "{slope}");
}
