//! The three-dimensional Taylor-Green vortex, with and without the closure for turbulence.

use crate::common::*;
use tremie_fluid_lbm::{Collision, LbmFluid};

/// A vortex on `n` cubed cells at a speed, and its kinetic energy after each tenth of a time
/// `n/speed`.
fn energies(n: usize, speed: f64, viscosity: f64, smagorinsky: f64) -> (Vec<f64>, LbmFluid) {
    let mut case = Case::new([n; 3], [PERIODIC; 3], 0.5 + 3.0 * viscosity);
    case.collision = Collision::Bgk;
    case.smagorinsky = smagorinsky;
    case.threads = 2;
    let mut fluid = case.fluid();
    let k = std::f64::consts::TAU / n as f64;
    fluid.set_state(|x| {
        let [a, b, c] = x.map(|x| k * x);
        let pressure =
            speed * speed / 16.0 * ((2.0 * a).cos() + (2.0 * b).cos()) * ((2.0 * c).cos() + 2.0);
        ([speed * a.sin() * b.cos() * c.cos(), -speed * a.cos() * b.sin() * c.cos(), 0.0], pressure)
    });
    let energy = |fluid: &LbmFluid| {
        let square = |c| norm(fluid.velocity_at(c)).powi(2);
        cells(fluid).map(square).sum::<f64>() / (n * n * n) as f64 / (speed * speed)
    };
    let mut found = vec![energy(&fluid)];
    for _ in 0..10 {
        for _ in 0..(0.1 * n as f64 / speed) as usize {
            fluid.step(&[], &mut []).unwrap();
        }
        found.push(energy(&fluid));
    }
    fluid.check().unwrap();
    (found, fluid)
}

/// At a Reynolds number of 1 the energy decays as `exp(-6 nu k^2 t)`: 1 %.
#[test]
fn a_slow_vortex_decays_by_viscosity() {
    let (n, speed) = (24, 0.002);
    let viscosity = speed * n as f64 / std::f64::consts::TAU;
    let (found, _) = energies(n, speed, viscosity, 0.0);
    let k = std::f64::consts::TAU / n as f64;
    let time = 0.1 * n as f64 / speed;
    assert!((found[0] - 0.25).abs() < 1e-12);
    // The nonlinear terms change the energy only in second order of the Reynolds number.
    let rate = -(found[3] / found[1]).ln() / (2.0 * time * 6.0 * viscosity * k * k);
    println!("rate {rate}");
    assert!((rate - 1.0).abs() < 0.02, "{rate}");
}

/// The closure takes energy where viscosity alone cannot hold the small scales, and no more than
/// there is; with `C = 0`, nothing.
#[test]
fn the_closure_takes_energy() {
    let (n, speed, viscosity) = (24, 0.04, 2e-4);
    let (laminar, plain) = energies(n, speed, viscosity, 0.0);
    let (turbulent, fluid) = energies(n, speed, viscosity, 0.17);
    println!("{:?}\n{:?}\ntau {}", laminar, turbulent, fluid.diagnostics().max_tau);
    assert_eq!(plain.diagnostics().max_tau, plain.tau());
    assert!(fluid.diagnostics().max_tau > fluid.tau() + 1e-3);
    for (k, (l, t)) in laminar.iter().zip(&turbulent).enumerate().skip(1) {
        assert!(t < l && *t > 0.0, "{k}: {l} {t}");
    }
    assert!(turbulent[10] < 0.95 * laminar[10]);
}
