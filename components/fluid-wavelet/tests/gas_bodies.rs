//! Rigid bodies and walls that stand between the points of the grid.

use std::f64::consts::PI;
use tremie_fluid_wavelet::{
    Ball, DomainFace, Gas, GasBody, GasState, HalfSpace, SurfaceHeat, WaveletSettings,
    WaveletSolver,
};

/// Gas at rest, in the units of the speed of sound.
const STILL: GasState = GasState { density: 1.0, velocity: [0.0; 3], pressure: 1.0 / 1.4 };

fn wall(along: f64, normal: [f64; 3]) -> HalfSpace {
    let point = normal.map(|n| along * n.abs());
    HalfSpace { point, normal, velocity: [0.0; 3], heat: SurfaceHeat::Adiabatic }
}

#[test]
fn a_body_in_gas_at_rest_takes_no_load() {
    for (dims, reynolds) in [(2, None), (2, Some(500.0)), (3, Some(500.0))] {
        let settings = WaveletSettings {
            coarsest: 1.0 / 8.0,
            block_edge: 8,
            deepest: if dims == 2 { 4 } else { 2 },
            ..WaveletSettings::new(dims, Gas::scaled(reynolds))
        };
        let centre = [0.43, 0.51, if dims == 3 { 0.47 } else { 0.0 }];
        let ball = Ball { centre, radius: 0.203, velocity: [0.0; 3], spin: [0.0; 3] };
        let mut solver = WaveletSolver::new(settings, 2, &[ball], |_| STILL).expect("threads");
        for _ in 0..8 {
            let dt = solver.longest_step();
            solver.step(dt, &[ball]).expect("gas");
            for load in [solver.loads[0].by_stress, solver.loads[0].by_momentum] {
                let largest = load.force.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
                assert!(largest < 1e-10, "{dims}-d: {load:?}");
            }
        }
        solver.for_each_point(|_, at, fields| {
            let moved = (1..=dims).fold((fields[0] - 1.0).abs(), |m, a| m.max(fields[a].abs()));
            assert!(moved < 1e-12, "{dims}-d: {moved:e} at {at:?}");
        });
    }
}

/// Error of a small pulse that has come back from a wall which is no point of the grid.
fn reflected_pulse(deepest: u8) -> f64 {
    let settings = WaveletSettings {
        block_edge: 8,
        roots: [2, 1, 1],
        coarsest: 1.0 / 16.0,
        deepest,
        tolerance: 1e-9,
        // No face is rough.
        roughness: 1.0,
        faces: [[DomainFace::Open; 2]; 3],
        ..WaveletSettings::new(1, Gas::scaled(None))
    };
    let place = 0.7713;
    let wall = wall(place, [-1.0, 0.0, 0.0]);
    let size = 1e-5;
    let shape = |x: f64| size * (-600.0 * x * x).exp();
    let initial = |x: [f64; 3]| {
        let p = shape(x[0] - 0.4);
        GasState { density: 1.0 + p, velocity: [p, 0.0, 0.0], pressure: (1.0 + 1.4 * p) / 1.4 }
    };
    let mut solver = WaveletSolver::new(settings, 1, &[wall], initial).expect("threads");
    let end = 0.7;
    while solver.time < end {
        let dt = solver.longest_step().min(end - solver.time);
        solver.step(dt, &[wall]).expect("gas");
    }
    let mut error = 0.0_f64;
    solver.for_each_point(|_, at, fields| {
        if at[0] < place {
            let exact = shape(2.0 * place - at[0] - 0.4 - end);
            error = error.max((fields[0] - 1.0 - exact).abs() / size);
        }
    });
    error
}

#[test]
fn a_pulse_comes_back_from_a_wall_between_points() {
    let errors = [4, 5, 6].map(reflected_pulse);
    println!("errors {errors:?}");
    assert!(errors[2] < 0.02, "{errors:?}");
    assert!(errors[0] / errors[2] > 4.0, "of less than first order: {errors:?}");
}

#[test]
fn a_shock_comes_back_from_a_wall_between_points() {
    let gas = Gas::scaled(None);
    // Mach 1.7: 8.579 times the pressure ahead at the wall.
    let mach: f64 = 1.7;
    let ratio = 2.4 * mach * mach / (0.4 * mach * mach + 2.0);
    let behind = GasState {
        density: ratio,
        velocity: [mach * (1.0 - 1.0 / ratio), 0.0, 0.0],
        pressure: (1.0 + 2.8 / 2.4 * (mach * mach - 1.0)) / 1.4,
    };
    let settings = WaveletSettings {
        block_edge: 8,
        roots: [2, 1, 1],
        coarsest: 1.0 / 16.0,
        deepest: 5,
        faces: [
            [DomainFace::Given(gas.fields(1, behind)), DomainFace::Open],
            [DomainFace::Periodic; 2],
            [DomainFace::Periodic; 2],
        ],
        ..WaveletSettings::new(1, gas)
    };
    let wall = wall(0.7713, [-1.0, 0.0, 0.0]);
    let initial = |x: [f64; 3]| if x[0] < 0.25 { behind } else { STILL };
    let mut solver = WaveletSolver::new(settings, 1, &[wall], initial).expect("threads");
    while solver.time < 0.5 {
        let dt = solver.longest_step().min(0.5 - solver.time);
        solver.step(dt, &[wall]).expect("gas");
    }
    let mut nearest = (f64::INFINITY, 0.0);
    solver.for_each_point(|_, at, fields| {
        let distance = 0.7713 - at[0];
        if distance > 0.0 && distance < nearest.0 {
            nearest = (distance, 1.4 * gas.state(1, &fields).pressure);
        }
    });
    let by_stress = -solver.loads[0].by_stress.force[0];
    println!("{} beside the wall, load {by_stress}", nearest.1);
    assert!((nearest.1 / 8.579 - 1.0).abs() < 0.01, "{}", nearest.1);
}

#[test]
fn gas_between_plates_is_sheared_evenly() {
    let [below, above] = [0.2313, 0.8071];
    let speed = 0.05;
    let at_rest = wall(below, [0.0, 1.0, 0.0]);
    let moving = HalfSpace { velocity: [speed, 0.0, 0.0], ..wall(above, [0.0, -1.0, 0.0]) };
    let plates = [at_rest, moving];
    let settings = WaveletSettings {
        block_edge: 8,
        coarsest: 1.0 / 8.0,
        deepest: 2,
        faces: [[DomainFace::Periodic; 2], [DomainFace::Open; 2], [DomainFace::Periodic; 2]],
        ..WaveletSettings::new(2, Gas::scaled(Some(20.0)))
    };
    // From rest: the plate pulls the gas along.
    let mut solver = WaveletSolver::new(settings, 2, &plates, |_| STILL).expect("threads");
    while solver.time < 8.0 {
        let dt = solver.longest_step();
        solver.step(dt, &plates).expect("gas");
    }
    let mut error = 0.0_f64;
    solver.for_each_point(|_, at, fields| {
        if at[1] > below && at[1] < above {
            let exact = speed * (at[1] - below) / (above - below);
            error = error.max((fields[1] / fields[0] - exact).abs() / speed);
        }
    });
    let drag = speed / (20.0 * (above - below));
    println!("error {error}, loads {:?}, drag {drag}", solver.loads);
    assert!(error < 0.01, "{error}");
    for (load, sign) in solver.loads.iter().zip([1.0, -1.0]) {
        for found in [load.by_stress.force[0], load.by_momentum.force[0]] {
            assert!((sign * found / drag - 1.0).abs() < 0.02, "{found} for {drag}");
        }
    }
}

/// Heat goes from the hot plate to the cold one. Where conduction balances itself the temperature follows from
/// `k dT/dy = q` with the conductivity of Sutherland's law, which is integrated here.
#[test]
fn heat_is_conducted_between_plates_of_two_temperatures() {
    let [below, above] = [0.2313, 0.8071];
    let gas = Gas::scaled(Some(20.0));
    let cold = gas.reference;
    let hot = 1.2 * cold;
    let plates = [
        HalfSpace { heat: SurfaceHeat::Isothermal(cold), ..wall(below, [0.0, 1.0, 0.0]) },
        HalfSpace { heat: SurfaceHeat::Isothermal(hot), ..wall(above, [0.0, -1.0, 0.0]) },
    ];
    let settings = WaveletSettings {
        block_edge: 8,
        coarsest: 1.0 / 8.0,
        deepest: 2,
        faces: [[DomainFace::Periodic; 2], [DomainFace::Open; 2], [DomainFace::Periodic; 2]],
        ..WaveletSettings::new(2, gas)
    };
    let mut solver = WaveletSolver::new(settings, 2, &plates, |_| STILL).expect("threads");
    while solver.time < 8.0 {
        let dt = solver.longest_step();
        solver.step(dt, &plates).expect("gas");
    }
    // Heat that flows per temperature, summed up from the cold plate; the temperature at a height is where the
    // sum has the height's share.
    let steps = 2000;
    let at = |k: usize| cold + (hot - cold) * k as f64 / steps as f64;
    let mut sums = vec![0.0];
    for k in 0..steps {
        sums.push(sums[k] + 0.5 * (gas.viscosity_at(at(k)) + gas.viscosity_at(at(k + 1))));
    }
    let exact = |height: f64| {
        let wanted = (height - below) / (above - below) * sums[steps];
        at(sums.partition_point(|sum| *sum < wanted))
    };
    let (mut error, mut seen) = (0.0_f64, 0);
    solver.for_each_point(|_, place, fields| {
        if place[1] > below && place[1] < above {
            let state = gas.state(2, &fields);
            let found = state.pressure / (state.density * gas.gas_constant);
            error = error.max((found - exact(place[1])).abs() / (hot - cold));
            seen += 1;
        }
    });
    println!("error {error} of the difference, {seen} points");
    assert!(seen > 100 && error < 0.01, "{error}, {seen}");
}

/// A shaft, or a bore: what is solid lies inside the circle, or outside.
struct Round {
    circle: Ball,
    is_bore: bool,
}

impl GasBody for Round {
    fn height(&self, at: [f64; 3]) -> (f64, [f64; 3]) {
        let (height, normal) = self.circle.height(at);
        if self.is_bore { (-height, normal.map(|n| -n)) } else { (height, normal) }
    }

    fn velocity(&self, at: [f64; 3]) -> [f64; 3] {
        self.circle.velocity(at)
    }

    fn arm(&self, at: [f64; 3]) -> [f64; 3] {
        self.circle.arm(at)
    }
}

#[test]
fn a_shaft_that_turns_in_a_bore_feels_the_torque_of_couette() {
    let circle = |radius: f64, spin: f64| Ball {
        centre: [0.5013, 0.4971, 0.0],
        radius,
        velocity: [0.0; 3],
        spin: [0.0, 0.0, spin],
    };
    let (inner, outer, spin, reynolds) = (0.3, 0.45, 0.2, 20.0);
    let bodies = [
        Round { circle: circle(inner, spin), is_bore: false },
        Round { circle: circle(outer, 0.0), is_bore: true },
    ];
    let settings = WaveletSettings {
        block_edge: 8,
        coarsest: 1.0 / 8.0,
        deepest: 3,
        ..WaveletSettings::new(2, Gas::scaled(Some(reynolds)))
    };
    let mut solver = WaveletSolver::new(settings, 2, &bodies, |_| STILL).expect("threads");
    while solver.time < 1.0 {
        let dt = solver.longest_step();
        solver.step(dt, &bodies).expect("gas");
    }
    let squares = [inner * inner, outer * outer];
    let torque = 4.0 * PI / reynolds * spin * squares[0] * squares[1] / (squares[1] - squares[0]);
    for (load, sign) in solver.loads.iter().zip([-1.0, 1.0]) {
        let found = [load.by_stress.torque[2], load.by_momentum.torque[2]];
        println!("torque {found:?}, exact {torque}");
        for found in found {
            assert!((sign * found / torque - 1.0).abs() < 0.01, "{found} for {torque}");
        }
    }
}
