//! Flow between half-way walls: Poiseuille exact to rounding with the magic parameter 3/16, Couette
//! always.

use crate::common::*;
use tremie_fluid_lbm::Collision;

/// `u = a/(2 nu) y (H - y)` to 1e-11 of its maximum, whatever tau is: rounding, added up over 10^4
/// steps.
#[test]
fn poiseuille_is_exact_with_trt() {
    let height = 12;
    for tau in [0.6, 1.0, 1.8] {
        for axis in 0..3 {
            let mut faces = [PERIODIC; 3];
            let mut cells = [3; 3];
            (faces[axis], cells[axis]) = (WALL, height);
            let mut case = Case::new(cells, faces, tau);
            let along = (axis + 1) % 3;
            let h = height as f64;
            // A slow flow: the comparison is with the linear equation.
            let peak = 1e-4;
            let a = 8.0 * case.viscosity() * peak / (h * h);
            case.acceleration[along] = a;
            let mut fluid = case.fluid();
            // 34 e-foldings of the slowest mode.
            let rate = case.viscosity() * (std::f64::consts::PI / h).powi(2);
            for _ in 0..(34.0 / rate) as usize {
                fluid.step(&[], &mut []).unwrap();
            }
            for k in 0..height {
                let mut cell = [1; 3];
                cell[axis] = k;
                let y = k as f64 + 0.5;
                let expected = a / (2.0 * case.viscosity()) * y * (h - y);
                let error = (fluid.velocity_at(cell)[along] - expected).abs() / peak;
                assert!(error < 1e-11, "tau {tau} axis {axis} y {y}: {error}");
            }
        }
    }
}

/// A linear profile to 1e-11 of the lid's speed, for either collision; and the lid's stress in the
/// balance.
#[test]
fn couette_is_exact() {
    for (collision, tau) in [(Collision::Bgk, 0.7), (Collision::Trt, 0.7), (Collision::Trt, 1.5)] {
        for axis in 0..3 {
            let mut faces = [PERIODIC; 3];
            let mut cells = [4; 3];
            (faces[axis], cells[axis]) = (WALL, 10);
            let mut case = Case::new(cells, faces, tau);
            case.collision = collision;
            let along = (axis + 2) % 3;
            let mut lid = [0.0; 3];
            lid[along] = 0.01;
            case.lid = (axis, lid);
            let mut fluid = case.fluid();
            let rate = case.viscosity() * (std::f64::consts::PI / 10.0).powi(2);
            for _ in 0..(34.0 / rate) as usize {
                fluid.step(&[], &mut []).unwrap();
            }
            for k in 0..10 {
                let mut cell = [1; 3];
                cell[axis] = k;
                let expected = 0.01 * (k as f64 + 0.5) / 10.0;
                let error = (fluid.velocity_at(cell)[along] - expected).abs() / 0.01;
                assert!(error < 1e-11, "{collision:?} tau {tau} axis {axis} {k}: {error}");
            }
            // The two walls' forces cancel.
            assert!(norm(fluid.ledger().walls) < 1e-12);
        }
    }
}
