//! A mesh to ask, points to ask about, and a clock.

use std::hint::black_box;
use tremie_geometry::{Mesh, Vec3};
use tremie_test_support::processor_seconds;

/// The shortest of three runs [s], and the last result.
pub fn timed<T>(mut run: impl FnMut() -> T) -> (f64, T) {
    let mut once = || {
        let start = processor_seconds();
        let result = black_box(run());
        (processor_seconds() - start, result)
    };
    let runs = [once(), once(), once()];
    let best = runs.iter().map(|(time, _)| *time).fold(f64::INFINITY, f64::min);
    let [_, _, (_, result)] = runs;
    (best, result)
}

/// Points all over the bounds (Roberts' sequence).
pub fn scattered(i: i32) -> Vec3 {
    const G: f64 = 1.220_744_084_605_759_6;
    let in_box = |x: f64, size: f64| (x.fract() - 0.5) * size;
    let i = f64::from(i);
    Vec3::new(in_box(i / G, 1.5), in_box(i / (G * G), 1.5), in_box(i / (G * G * G), 0.5))
}

/// A ring of radius 0.5, 0.2 thick, with a tilt that leaves nothing in line with the axes.
pub fn torus(along: u32, around: u32) -> Mesh {
    let corner = |i: u32, j: u32| {
        let turn = std::f64::consts::TAU;
        let (sin, cos) = libm::sincos(turn * f64::from(i) / f64::from(along));
        let (up, out) = libm::sincos(turn * f64::from(j) / f64::from(around));
        let r = 0.5 + 0.2 * out;
        Vec3::new(r * cos, r * sin + 0.06 * up, 0.2 * up - 0.3 * r * sin)
    };
    let name = |i: u32, j: u32| (i % along) * around + j % around;
    let all = || (0..along).flat_map(|i| (0..around).map(move |j| (i, j)));
    let quad = |(i, j)| {
        let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    Mesh {
        vertices: all().map(|(i, j)| corner(i, j)).collect(),
        triangles: all().flat_map(quad).collect(),
    }
}
