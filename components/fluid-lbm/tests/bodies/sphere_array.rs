//! Drag of a simple cubic array of spheres in Stokes flow, `K = F/(6 pi mu a U)` with `U` the mean
//! over the whole cell of the array: Zick & Homsy 1982, Sangani & Acrivos 1982. 16 cells a
//! diameter; within 3 %.

use crate::common::*;

/// `K` from the load on the sphere, and from the balance of forces, on a box of `n` cells.
fn drag(n: usize, fraction: f64, expected: f64) -> [f64; 2] {
    let length = n as f64;
    let radius = length * (3.0 * fraction / (4.0 * std::f64::consts::PI)).cbrt();
    let mut case = Case::new([n; 3], [PERIODIC; 3], 1.0);
    let mu = case.viscosity();
    let a = 1e-7;
    case.acceleration = [a, 0.0, 0.0];
    // Begins near the mean velocity of the steady flow, which a fluid at rest would take long to
    // reach.
    let scale = 6.0 * std::f64::consts::PI * mu * radius;
    case.velocity = [a * length.powi(3) / (scale * expected), 0.0, 0.0];
    case.threads = 2;
    let middle = 0.5 * length;
    let position = [middle + 0.1, middle + 0.2, middle + 0.3];
    let steady = steady_drag(&case, &case.scene(), added(1, radius), position);
    let scale = scale * steady.superficial;
    [steady.force / scale, a * length.powi(3) / scale]
}

#[test]
fn the_drag_of_an_array_is_that_of_the_series() {
    for (n, fraction, expected) in [(43, 0.027, 2.008), (26, 0.125, 4.292), (22, 0.216, 7.443)] {
        let [by_load, by_balance] = drag(n, fraction, expected);
        println!("fraction {fraction}: {by_load:.4} {by_balance:.4}, expected {expected}");
        assert!((by_load / expected - 1.0).abs() < 0.03, "{fraction}: {by_load}");
        assert!((by_load / by_balance - 1.0).abs() < 3e-3, "{fraction}: {by_load} {by_balance}");
    }
}
