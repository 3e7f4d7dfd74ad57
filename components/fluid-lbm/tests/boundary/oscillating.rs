//! Walls of the domain whose velocity changes with time, beside the solutions of Stokes and of
//! Couette's start.

use crate::common::*;
use std::f64::consts::PI;
use tremie_fluid_lbm::LbmFluid;
use tremie_messages::scene::{Course, Face, Scene, Sine};

const SPEED: f64 = 0.01;

/// A layer between two walls across an axis, periodic along the others; the lower one moves along
/// the next axis.
fn layer(axis: usize, height: usize, tau: f64, course: Course) -> (Case, Scene) {
    let mut case = Case::new([3; 3], [PERIODIC; 3], tau);
    (case.cells[axis], case.faces[axis]) = (height, WALL);
    let mut scene = case.scene();
    let mut velocity = [0.0; 3];
    velocity[(axis + 1) % 3] = SPEED;
    scene.domain.faces[axis][0] = Face::Wall { velocity, course };
    (case, scene)
}

fn profile(fluid: &LbmFluid, axis: usize) -> Vec<f64> {
    let height = fluid.cells()[axis];
    let at = |k: usize| {
        let mut cell = [1; 3];
        cell[axis] = k;
        fluid.velocity_at(cell)[(axis + 1) % 3] / SPEED
    };
    (0..height).map(at).collect()
}

/// Stokes' second problem: `u = U exp(-y/d) sin(w t - y/d)`, `d = sqrt(2 nu/w)`, in a layer of 8 d,
/// at any time of the last of 24 periods, when the start is forgotten; within 0.1 % of the wall's
/// speed with a d of 3 cells and of 5.
#[test]
fn an_oscillating_wall_is_that_of_stokes() {
    let error = |axis: usize, cells: f64| {
        let nu = (0.8 - 0.5) / 3.0;
        let omega = 2.0 * nu / (cells * cells);
        let period = 2.0 * PI / omega;
        let (case, scene) =
            layer(axis, (8.0 * cells) as usize, 0.8, Course::Sine(Sine::new(1.0 / period)));
        let mut fluid = case.fluid_of(&scene);
        let (mut worst, last) = (0.0f64, (24.0 * period) as u32);
        for step in 1..=last {
            fluid.step(&[], &mut []).unwrap();
            if f64::from(step) > 23.0 * period && step % 5 == 0 {
                for (k, u) in profile(&fluid, axis).into_iter().enumerate() {
                    let y = (k as f64 + 0.5) / cells;
                    let exact = (-y).exp() * (omega * f64::from(step) - y).sin();
                    worst = worst.max((u - exact).abs());
                }
            }
        }
        worst
    };
    for (axis, cells) in [(0, 3.0), (1, 5.0), (2, 3.0)] {
        let found = error(axis, cells);
        assert!(found < 1e-3, "axis {axis}, {cells} cells: {found}");
    }
}

/// Couette's flow as it starts at once, and along a ramp: the series of the diffusion equation,
/// within 0.5 % of the wall's speed from a twentieth of the time of diffusion on.
#[test]
fn couette_starts_as_diffusion_says() {
    let (height, tau) = (20usize, 0.9);
    let (nu, h) = ((tau - 0.5) / 3.0, height as f64);
    let rise = 0.3 * h * h / nu;
    // Response at a place to a wall that moves at once.
    let step = |y: f64, time: f64| {
        let mut u = 1.0 - y;
        for n in 1..40 {
            let k = f64::from(n) * PI;
            u -= 2.0 / k * (k * y).sin() * (-k * k * nu * time / (h * h)).exp();
        }
        u
    };
    let ramp = Course::Points(vec![[0.0, 0.0], [rise, 1.0]]);
    for (course, ramped) in [(Course::CONSTANT, false), (ramp, true)] {
        let (case, scene) = layer(1, height, tau, course);
        let mut fluid = case.fluid_of(&scene);
        for at in 1..=(h * h / nu) as u32 {
            fluid.step(&[], &mut []).unwrap();
            let time = f64::from(at);
            if at % 100 != 0 || time < 0.05 * h * h / nu {
                continue;
            }
            for (k, u) in profile(&fluid, 1).into_iter().enumerate() {
                let y = (k as f64 + 0.5) / h;
                let exact = if ramped {
                    // Duhamel's integral over the ramp.
                    let end = time.min(rise);
                    let parts = 400;
                    let sum: f64 = (0..parts)
                        .map(|p| step(y, time - end * (f64::from(p) + 0.5) / f64::from(parts)))
                        .sum();
                    sum * end / f64::from(parts) / rise
                } else {
                    step(y, time)
                };
                assert!((u - exact).abs() < 5e-3, "{ramped} {time} {y}: {u} {exact}");
            }
        }
    }
}
