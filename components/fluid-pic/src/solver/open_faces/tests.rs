//! Tests of channels that are open at their ends.

use super::*;
use crate::particles::seeding::seed;
use crate::solver::pic_solver::PicSolver;

const WATER: [f64; 2] = [0.0, -9.81];

fn open(side: usize, flow: FaceFlow<2>, level: Option<f64>) -> OpenFace<2> {
    OpenFace { axis: 0, side, flow, level }
}

fn velocity(x: f64) -> FaceFlow<2> {
    FaceFlow::Velocity { velocity: [x, 0.0], is_parabolic: false }
}

fn pressure(absorbs: bool) -> FaceFlow<2> {
    FaceFlow::Pressure { pressure: 0.0, absorbs }
}

/// A channel of `cells` of one edge [m], full where `is_wet`, with a velocity along it [m/s].
fn channel(
    cells: [usize; 2],
    edge: f64,
    settings: PicSettings<2>,
    faces: Vec<OpenFace<2>>,
    speed: f64,
    is_wet: impl Fn([f64; 2]) -> bool,
) -> PicSolver<2> {
    let grid = StaggeredGrid::new(cells, edge, [0.0; 2], [false; 2]);
    let mut solver = PicSolver::new(grid, settings, 1, faces, Vec::new()).unwrap();
    seed(&solver.grid, &mut solver.particles, 2, 0.0, 1, is_wet, |_| [speed, 0.0]);
    solver
}

fn run(solver: &mut PicSolver<2>, dt: f64, steps: usize) {
    let mut loads = Vec::new();
    for step in 0..steps {
        let outcome = solver.step(dt, &[], &mut loads);
        assert!(outcome.converged, "step {step}: {outcome:?}");
    }
}

/// A stream that enters with a velocity and leaves at a pressure goes on as it is, with and without
/// a free surface, and as many particles enter as leave.
#[test]
fn a_stream_passes_unchanged() {
    for (is_full, side) in [(true, 0), (false, 0), (true, 1), (false, 1)] {
        let level = (!is_full).then_some(0.5);
        let speed = if side == 0 { 0.4 } else { -0.4 };
        let faces =
            vec![open(side, velocity(speed), level), open(1 - side, pressure(false), level)];
        let settings = PicSettings { fills_all: is_full, ..PicSettings::water(WATER) };
        let mut solver = channel([30, 20], 0.05, settings, faces, speed, |x| is_full || x[1] < 0.5);
        let before = solver.particles.len() as f64;
        run(&mut solver, 0.01, 300);
        let [entered, left] = solver.open_faces.passed().map(|n| n as f64);
        let depth = if is_full { 1.0 } else { 0.5 };
        // Four particles a cell.
        let exact = 0.4 * 3.0 * depth / 0.0025 * 4.0;
        assert!((entered / exact - 1.0).abs() < 0.02, "{is_full}: {entered} {exact}");
        assert!((left / entered - 1.0).abs() < 0.02, "{is_full}: {left} {entered}");
        assert!((solver.particles.len() as f64 / before - 1.0).abs() < 0.02);
        for k in 0..solver.particles.len() {
            let [u, w] = [0, 1].map(|a| solver.particles.velocity[a][k]);
            assert!((u - speed).abs() < 0.03 && w.abs() < 0.03, "{is_full} {side}: {u} {w}");
        }
    }
}

/// Water that is let into a tank raises its level by its volume.
#[test]
fn a_tank_fills_by_what_enters() {
    let faces = vec![open(0, velocity(0.2), Some(0.2))];
    let settings = PicSettings { relaxation: 0.1, ..PicSettings::water(WATER) };
    let mut solver = channel([40, 30], 0.025, settings, faces, 0.0, |x| x[1] < 0.3);
    run(&mut solver, 1e-6, 1);
    let before = solver.sums().volume;
    run(&mut solver, 4e-3, 500);
    let gain = solver.sums().volume - before;
    let exact = 0.2 * 0.2 * 2.0;
    assert!((gain / exact - 1.0).abs() < 0.05, "{gain} {exact}");
    let [entered, left] = solver.passed_volumes();
    assert!((entered / exact - 1.0).abs() < 0.02 && left == 0.0, "{entered} {left}");
}

/// A hump falls apart into two long waves. At faces that absorb waves less than a tenth of their
/// height comes back; at others they come back, upside down.
#[test]
fn waves_leave() {
    let (length, depth, dt) = (6.0, 0.2, 5e-3);
    // Height of the crest that passes a quarter of the way, and of what comes back there.
    let heights = |absorbs: bool| {
        let faces =
            vec![open(0, pressure(absorbs), Some(depth)), open(1, pressure(absorbs), Some(depth))];
        let settings = PicSettings { relaxation: 0.1, ..PicSettings::water(WATER) };
        let hump = |x: f64| depth + 0.06 * (-(x - 0.5 * length).powi(2) / 0.4).exp();
        let mut solver = channel([240, 14], 0.025, settings, faces, 0.0, |x| x[1] < hump(x[0]));
        // Mean height around there over a tenth of a second.
        let mut height = |steps: usize| {
            let mut sum = 0.0;
            for _ in 0..steps {
                run(&mut solver, dt, 1);
                let bottom = (50..70).map(|x| solver.pressure([x, 0], dt)).sum::<f64>() / 20.0;
                sum += bottom / 9810.0 + 0.0125 - depth;
            }
            sum / steps as f64
        };
        height(140);
        let crest = (0..8).map(|_| height(20)).fold(0.0, f64::max);
        height(160);
        let back = (0..12)
            .map(|_| height(20))
            .fold(0.0, |most, h| if h.abs() > f64::abs(most) { h } else { most });
        (crest, back)
    };
    let (crest, absorbed) = heights(true);
    let (_, thrown_back) = heights(false);
    // Half of the hump's height, less what spreads on the way.
    assert!((0.02..0.031).contains(&crest), "{crest}");
    assert!(absorbed.abs() < 0.1 * crest, "{crest} {absorbed}");
    assert!(thrown_back < -0.7 * crest, "{crest} {thrown_back}");
}

/// A velocity that rises and falls makes waves: it is a wave maker.
#[test]
fn a_face_with_a_course_makes_waves() {
    let faces = vec![open(0, velocity(0.1), Some(0.2)), open(1, pressure(true), Some(0.2))];
    let settings = PicSettings { relaxation: 0.1, ..PicSettings::water(WATER) };
    let mut solver = channel([160, 16], 0.025, settings, faces, 0.0, |x| x[1] < 0.2);
    let mut loads = Vec::new();
    let (mut high, mut low) = (0.0_f64, f64::INFINITY);
    for step in 0..800 {
        let time = f64::from(step) * 5e-3;
        solver.set_open_factors([(4.0 * time).sin(), 1.0]);
        assert!(solver.step(5e-3, &[], &mut loads).converged);
        // Pressure at the bottom in the middle: the wave that passes.
        if time > 2.2 {
            let bottom = solver.pressure([80, 0], 5e-3);
            (high, low) = (high.max(bottom), low.min(bottom));
        }
    }
    // A long wave: its pressure is rho c u.
    let exact = 2.0 * 1000.0 * (9.81_f64 * 0.2).sqrt() * 0.1;
    assert!(((high - low) / exact - 1.0).abs() < 0.2, "{high} {low} {exact}");
}
