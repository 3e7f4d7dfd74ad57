//! Decay of Taylor-Green vortices: second order in the cell, at constant tau and with the Mach
//! number shrinking with the cell (diffusive scaling).

use crate::common::*;
use tremie_fluid_lbm::Collision;

/// Relative error of the velocity (L2) after the time in which it decays by half, on n x n cells.
fn error(n: usize, collision: Collision, tau: f64) -> f64 {
    let mut case = Case::new([n, n, 1], [PERIODIC; 3], tau);
    case.collision = collision;
    let mut fluid = case.fluid();
    let k = std::f64::consts::TAU / n as f64;
    let speed = 0.02 * 16.0 / n as f64;
    let exact = move |x: [f64; 3], decay: f64| {
        let (cx, sx, cy, sy) =
            ((k * x[0]).cos(), (k * x[0]).sin(), (k * x[1]).cos(), (k * x[1]).sin());
        let pressure =
            -0.25 * (speed * decay).powi(2) * ((2.0 * k * x[0]).cos() + (2.0 * k * x[1]).cos());
        ([-speed * decay * cx * sy, speed * decay * sx * cy, 0.0], pressure)
    };
    fluid.set_state(|x| exact(x, 1.0));
    let rate = 2.0 * case.viscosity() * k * k;
    let steps = (2.0_f64.ln() / rate).round() as usize;
    for _ in 0..steps {
        fluid.step(&[], &mut []).unwrap();
    }
    let decay = (-rate * steps as f64).exp();
    let (mut difference, mut total) = (0.0, 0.0);
    for cell in cells(&fluid) {
        let (u, v) = (exact(fluid.centre(cell), decay).0, fluid.velocity_at(cell));
        for a in 0..3 {
            difference += (u[a] - v[a]).powi(2);
            total += u[a].powi(2);
        }
    }
    (difference / total).sqrt()
}

#[test]
fn the_error_is_of_second_order() {
    for (collision, tau) in [
        (Collision::Bgk, 0.8),
        (Collision::Trt, 0.8),
        (Collision::Trt, 0.6),
        (Collision::CentralMoments, 0.8),
        (Collision::CentralMoments, 0.6),
    ] {
        let errors = [16, 32, 64].map(|n| error(n, collision, tau));
        let orders = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).log2()];
        println!("{collision:?} tau {tau}: errors {errors:?}, orders {orders:?}");
        assert!(orders.iter().all(|&order| order > 1.9), "{orders:?}");
        assert!(errors[2] < 3e-3);
    }
}
