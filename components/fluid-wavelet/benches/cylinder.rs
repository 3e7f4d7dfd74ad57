//! Drag of a cylinder in a stream of Mach 0.1 at Reynolds number 40, or of one that moves through
//! gas at rest.
//!
//! `cargo bench -p tremie-fluid-wavelet --bench cylinder -- LEVEL [moving]`: 32 points across it at
//! level 4, 64 at level 5.

use tremie_fluid_wavelet::{
    Ball, DomainFace, Gas, GasState, Sponge, WaveletSettings, WaveletSolver,
};

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let deepest: u8 = args.get(1).and_then(|arg| arg.parse().ok()).unwrap_or(4);
    let is_moving = args.iter().any(|arg| arg == "moving");
    let reynolds: f64 =
        args.iter().find_map(|arg| arg.strip_prefix("re=")?.parse().ok()).unwrap_or(40.0);
    let mach = 0.1;
    let gas = Gas::scaled(Some(reynolds / mach));
    let wind = if is_moving { 0.0 } else { mach };
    let stream = GasState { density: 1.0, velocity: [wind, 0.0, 0.0], pressure: 1.0 / 1.4 };
    let fields = gas.fields(2, stream);
    let settings = WaveletSettings {
        roots: [6, 5, 1],
        coarsest: 0.5,
        origin: [if is_moving { -36.0 } else { -16.0 }, -20.0, 0.0],
        deepest,
        tolerance: 2e-4,
        faces: [[DomainFace::Given(fields); 2]; 3],
        sponge: Some(Sponge { width: 5.0, rate: 0.3, state: fields }),
        ..WaveletSettings::new(2, gas)
    };
    let ball = |time: f64| Ball {
        centre: [if is_moving { -mach * time } else { 0.0 }, 0.0, 0.0],
        radius: 0.5,
        velocity: [if is_moving { -mach } else { 0.0 }, 0.0, 0.0],
        spin: [0.0; 3],
    };
    let mut solver = WaveletSolver::new(settings, 2, &[ball(0.0)], |_| stream).expect("threads");
    let (mut said, mut sums, mut count) = (0.0, [0.0; 3], 0.0);
    let mut squares = 0.0;
    while solver.time < 20.0 / mach {
        let dt = solver.longest_step();
        if let Err(error) = solver.step(dt, &[ball(solver.time)]) {
            println!("{error}");
            return;
        }
        let per = 0.5 * mach * mach;
        let load = solver.loads[0];
        let drag = [load.by_stress.force[0], load.by_momentum.force[0]].map(|f| f / per);
        sums[0] += drag[0];
        sums[1] += drag[1];
        sums[2] += load.by_stress.force[1] / per;
        squares += drag[0] * drag[0];
        count += 1.0;
        if solver.time > said {
            let mean = sums.map(|sum| sum / count);
            println!(
                "t U/d {:.2}: drag {:.4} (+- {:.4}) by stress, {:.4} by momentum, lift {:.4}; {} points, {:.3} % of all",
                solver.time * mach,
                mean[0],
                (squares / count - mean[0] * mean[0]).max(0.0).sqrt(),
                mean[1],
                mean[2],
                solver.points(),
                100.0 * solver.share_of_full_grid()
            );
            (sums, count, squares) = ([0.0; 3], 0.0, 0.0);
            said += 0.5 / mach;
        }
    }
}
