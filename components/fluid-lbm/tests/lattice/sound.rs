//! Sound in a closed tube, and shear beside it: each dies at the rate of its own viscosity.

use crate::common::*;
use std::f64::consts::PI;
use tremie_fluid_lbm::{Collision, LbmFluid, Parameters};

/// Cells of the tube: half a wave.
const CELLS: usize = 64;
const K: f64 = PI / CELLS as f64;
const SPEED_OF_SOUND: f64 = 0.577_350_269_189_625_8;

/// A tube along x between mirrors, of one cell across.
fn tube(collision: Collision, (tau, bulk): (f64, Option<f64>), smagorinsky: f64) -> LbmFluid {
    let case = Case::new([CELLS, 1, 1], [SYMMETRY, PERIODIC, PERIODIC], tau);
    Case { collision, bulk, smagorinsky, ..case }.fluid()
}

/// Amplitude of the standing wave: of its pressure and its velocity together.
fn amplitude(fluid: &LbmFluid) -> f64 {
    let [mut pressure, mut velocity] = [0.0; 2];
    for cell in cells(fluid) {
        let x = fluid.centre(cell)[0];
        pressure += fluid.pressure_at(cell) * (K * x).cos();
        velocity += SPEED_OF_SOUND * fluid.velocity_at(cell)[0] * (K * x).sin();
    }
    pressure.hypot(velocity)
}

/// The rate at which sound dies, over some periods.
fn rate_of_sound(fluid: &mut LbmFluid) -> f64 {
    fluid.set_state(|x| ([0.0; 3], 1e-6 * (K * x[0]).cos()));
    let steps = (8.0 * 2.0 * PI / (K * SPEED_OF_SOUND)).round() as usize;
    let begin = amplitude(fluid);
    for _ in 0..steps {
        fluid.step(&[], &mut []).unwrap();
    }
    (begin / amplitude(fluid)).ln() / steps as f64
}

#[test]
fn sound_dies_as_shear_and_bulk_viscosity_say() {
    for (collision, times, smagorinsky) in [
        (Collision::Trt, (0.6, None), 0.0),
        (Collision::Trt, (0.500004, Some(1.0)), 0.1),
        (Collision::Trt, (0.52, Some(0.8)), 0.0),
        (Collision::Bgk, (0.52, Some(1.4)), 0.0),
        (Collision::Bgk, (0.500004, Some(0.7)), 0.1),
        (Collision::CentralMoments, (0.6, None), 0.0),
        (Collision::CentralMoments, (0.500004, Some(1.0)), 0.1),
    ] {
        let (tau, bulk) = times;
        let (shear, zeta) = ((tau - 0.5) / 3.0, 2.0 / 9.0 * (bulk.unwrap_or(tau) - 0.5));
        let expected = 0.5 * K * K * (4.0 / 3.0 * shear + zeta);
        let found = rate_of_sound(&mut tube(collision, times, smagorinsky));
        println!("{collision:?} {times:?}: {found:.5e}, expected {expected:.5e}");
        assert!((found / expected - 1.0).abs() < 0.01, "{collision:?} {times:?}");
    }
}

#[test]
fn a_bulk_viscosity_in_units_is_that_of_the_relaxation_time() {
    let case = Case::new([CELLS, 1, 1], [SYMMETRY, PERIODIC, PERIODIC], 0.52);
    let zeta = "0.0666666666666666666 Pa s".parse().unwrap();
    let parameters = Parameters { bulk_viscosity: Some(zeta), ..case.parameters() };
    let mut fluid =
        LbmFluid::with_variant(&case.scene(), &parameters, 1.0, 1, case.variant).unwrap();
    let other = rate_of_sound(&mut tube(Collision::Trt, (0.52, Some(0.8)), 0.0));
    assert!((rate_of_sound(&mut fluid) / other - 1.0).abs() < 1e-9);
}

#[test]
fn shear_dies_as_it_did() {
    let rate = |bulk: Option<f64>| {
        let case = Case::new([CELLS, 1, 1], [PERIODIC; 3], 0.6);
        let mut fluid = Case { bulk, ..case }.fluid();
        fluid.set_state(|x| ([0.0, 1e-4 * (2.0 * K * x[0]).sin(), 0.0], 0.0));
        let amplitude = |fluid: &LbmFluid| -> f64 {
            let wave = |cell| fluid.velocity_at(cell)[1] * (2.0 * K * fluid.centre(cell)[0]).sin();
            cells(fluid).map(wave).sum()
        };
        let begin = amplitude(&fluid);
        for _ in 0..2000 {
            fluid.step(&[], &mut []).unwrap();
        }
        (begin / amplitude(&fluid)).ln() / 2000.0
    };
    let (without, with) = (rate(None), rate(Some(1.0)));
    assert!((with / without - 1.0).abs() < 1e-6, "{without} {with}");
    assert!((with / (0.1 / 3.0 * 4.0 * K * K) - 1.0).abs() < 0.01, "{with}");
}
