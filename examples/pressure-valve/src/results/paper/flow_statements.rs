//! Statements on valves without grains, and on those that stay shut.

use super::series::{Series, falls, grows, scatter};
use super::valve_run::{ValveRun, Varied};
use super::{Found, Judged, listed, over};
use crate::scene::{Closure, Dimensions};

const VISCOSITIES: &str = "runs of the pressure valve without grains, in two viscosities or more";
const PISTONS: &str = "runs of the pressure valve without grains, with two pistons or more";

/// Part of a number by which numbers that are to be equal may differ.
const EQUAL: f64 = 0.05;

/// Lift maxima that make a lift that swings.
const SWINGS: usize = 2;

pub(super) const ALL: &[Judged] = &[
    (
        1,
        "the delay grows with viscosity, falls with the piston's speed, and does not depend on grains",
        delays,
    ),
    (2, "the channel beneath the rubber sucks while it opens, more so in viscous fluids", suction),
    (
        3,
        "until it opens the pressure beneath rises in proportion to the piston's speed, whatever the viscosity",
        compression,
    ),
    (4, "the first peak of the lift is at about 10 ms", first_peak),
    (5, "the steady lift grows with viscosity and with the piston's speed", steady_lifts),
    (
        6,
        "at low viscosity the lift swings and settles, at high viscosity it does not swing",
        swings,
    ),
    (15, "the safety valve stays shut at 1 and 2.5 m/s, and opens at higher speeds", stays_shut),
];

/// A series of the pressure valve without grains that has two points or more.
fn clear<'r, 'a>(runs: &'r [ValveRun<'a>], varied: Varied) -> Result<Series<'r, 'a>, &'static str> {
    let series = Series::longest(runs, Closure::Pressure, false, varied);
    let needs = if varied == Varied::Viscosity { VISCOSITIES } else { PISTONS };
    if series.points.len() > 1 { Ok(series) } else { Err(needs) }
}

fn delays(runs: &[ValveRun]) -> Found {
    let viscous = clear(runs, Varied::Viscosity)?.values(ValveRun::delay);
    let pistons = clear(runs, Varied::Piston)?.values(ValveRun::delay);
    let like = |run: &ValveRun| {
        let is_clear = |other: &&ValveRun| {
            let same = |varied| other.number(varied) == run.number(varied);
            other.kind == run.kind
                && other.diameters.is_none()
                && same(Varied::Viscosity)
                && same(Varied::Piston)
        };
        Some(run.delay()? / runs.iter().find(is_clear)?.delay()?)
    };
    let grains = runs.iter().filter(|run| run.diameters.is_some()).filter_map(like);
    let ratios: Vec<[f64; 2]> = grains.map(|ratio| [0.0, ratio]).collect();
    if ratios.is_empty() {
        return Err("runs with grains and without, with the same piston");
    }
    let far = ratios.iter().map(|[_, ratio]| (ratio - 1.0).abs()).fold(0.0, f64::max);
    let found = format!(
        "{} ms at {} Pa s; {} ms at {} m/s; with grains within {:.1} %, of {} runs",
        listed(&viscous, 1e3, 2),
        over(&viscous, 1.0),
        listed(&pistons, 1e3, 2),
        over(&pistons, 1.0),
        1e2 * far,
        ratios.len(),
    );
    Ok((found, grows(&viscous) && falls(&pistons) && far < EQUAL))
}

fn suction(runs: &[ValveRun]) -> Found {
    let series = clear(runs, Varied::Viscosity)?;
    let least = series.values(ValveRun::suction);
    let Some(last) = least.last().filter(|_| least.len() > 1) else {
        return Err("a probe \"channel\" between ring and seat, and two viscosities or more");
    };
    let lowest = least.iter().map(|v| v[1]).fold(f64::INFINITY, f64::min);
    let found =
        format!("least pressures {} kPa at {} Pa s", listed(&least, 1e-3, 0), over(&least, 1.0));
    Ok((found, last[1] < 0.0 && last[1] <= lowest))
}

fn compression(runs: &[ValveRun]) -> Found {
    let viscous = clear(runs, Varied::Viscosity)?.values(ValveRun::compression_rate);
    let per_speed = |run: &ValveRun| Some(run.compression_rate()? / run.number(Varied::Piston));
    let pistons = clear(runs, Varied::Piston)?.values(per_speed);
    if viscous.len() < 2 || pistons.len() < 2 {
        return Err("a probe \"beneath\", and signals closer than a tenth of the delay");
    }
    let found = format!(
        "{} GPa/s at {} Pa s; over the speed {} MPa/mm at {} m/s",
        listed(&viscous, 1e-9, 3),
        over(&viscous, 1.0),
        listed(&pistons, 1e-9, 4),
        over(&pistons, 1.0),
    );
    Ok((found, scatter(&viscous) < EQUAL && scatter(&pistons) < EQUAL))
}

fn first_peak(runs: &[ValveRun]) -> Found {
    let is_control = |run: &&ValveRun| {
        let near = |varied, number: f64| (run.number(varied) / number - 1.0).abs() < 1e-6;
        run.kind == Closure::Pressure
            && run.diameters.is_none()
            && near(Varied::Viscosity, 1e-3)
            && near(Varied::Piston, 6.0)
    };
    let control = runs.iter().find(is_control);
    let control = control.ok_or("the control run: 1e-3 Pa s, 6 m/s, no grains")?;
    let peaks = control.peaks();
    let Some([time, lift]) = peaks.first() else { return Ok(("it has no peak".into(), false)) };
    let found = format!("{:.2} mm at {:.1} ms", 1e3 * lift, 1e3 * time);
    Ok((found, (7e-3..=13e-3).contains(time)))
}

fn steady_lifts(runs: &[ValveRun]) -> Found {
    let viscous = clear(runs, Varied::Viscosity)?.values(ValveRun::steady_mean);
    let pistons = clear(runs, Varied::Piston)?.values(ValveRun::steady_mean);
    if viscous.len() < 2 || pistons.len() < 2 {
        return Err("runs that last until the piston stops");
    }
    let found = format!(
        "{} mm at {} Pa s; {} mm at {} m/s",
        listed(&viscous, 1e3, 2),
        over(&viscous, 1.0),
        listed(&pistons, 1e3, 2),
        over(&pistons, 1.0),
    );
    Ok((found, grows(&viscous) && grows(&pistons)))
}

fn swings(runs: &[ValveRun]) -> Found {
    let series = clear(runs, Varied::Viscosity)?;
    let counts = series.values(|run| Some(run.peaks().len() as f64));
    let settles = |run: &ValveRun| {
        let peaks = run.peaks();
        let sizes = peaks.first().zip(peaks.last());
        sizes.map(|(first, last)| last[1] / first[1])
    };
    let settling = series.values(settles);
    let found = format!("maxima: {} at {} Pa s", listed(&counts, 1.0, 0), over(&counts, 1.0));
    let low = counts[0][1] >= SWINGS as f64 && settling.first().is_some_and(|v| v[1] < 1.0);
    Ok((found, low && counts.last().is_some_and(|v| v[1] < 1.0)))
}

fn stays_shut(runs: &[ValveRun]) -> Found {
    let series = Series::longest(runs, Closure::Safety, false, Varied::Piston);
    let greatest = series.values(|run| run.spread(run.lift, 0.0, run.stop).map(|[.., most]| most));
    let is_slow = |v: &&[f64; 2]| v[0] < 2.6;
    if !greatest.iter().any(|v| is_slow(&v)) || greatest.iter().all(|v| is_slow(&v)) {
        return Err(
            "runs of the safety valve without grains, with pistons to 2.5 m/s and faster ones",
        );
    }
    let lip = Dimensions::default().lip.0;
    let right = greatest.iter().all(|v| (v[1] < lip) == is_slow(&v));
    let found =
        format!("greatest lifts {} mm at {} m/s", listed(&greatest, 1e3, 2), over(&greatest, 1.0));
    Ok((found, right))
}

#[cfg(test)]
mod tests {
    use super::super::valve_run::made_up::{lift, run, signals};
    use super::*;

    /// Delays of 3 and 2 ms at 3 and 6 m/s, of 2 and 4 ms at two viscosities; with grains as given.
    fn judged(with_grains: f64) -> Found {
        let opening = |begin: f64| {
            signals(&[("grains.valve.lift", &move |t| lift(t, [begin, 2e-3, 1e-3, 0.5e-3]))])
        };
        let all = [3e-3, 2e-3, 4e-3, with_grains].map(opening);
        let of = |k: usize, numbers, grains| run(&all[k], Closure::Pressure, numbers, grains);
        delays(&[
            of(0, [1e-3, 3.0], None),
            of(1, [1e-3, 6.0], None),
            of(2, [31.6, 6.0], None),
            of(3, [1e-3, 6.0], Some([0.8e-3, 0.053])),
        ])
    }

    #[test]
    fn delays_are_compared_within_their_series() {
        let (found, right) = judged(2e-3).unwrap();
        assert!(right, "{found}");
        assert!(found.contains("at 0.001, 31.6 Pa s") && found.contains("at 3, 6 m/s"), "{found}");
        let (found, right) = judged(2.5e-3).unwrap();
        assert!(!right, "{found}");
    }

    #[test]
    fn what_no_run_tells_is_not_reached() {
        assert_eq!(delays(&[]), Err(VISCOSITIES));
        assert!(first_peak(&[]).is_err() && stays_shut(&[]).is_err() && suction(&[]).is_err());
    }

    #[test]
    fn a_safety_valve_that_opens_too_early_is_found() {
        let [shut, open] = [0.3e-3, 2e-3].map(|level| {
            signals(&[("grains.valve.lift", &move |t| lift(t, [2e-3, level, 1e-4, 0.1e-3]))])
        });
        let of = |signals, piston| run(signals, Closure::Safety, [1e-3, piston], None);
        let judged =
            |middle| stays_shut(&[of(&shut, 1.0), of(middle, 2.5), of(&open, 6.0)]).unwrap();
        assert!(judged(&shut).1 && !judged(&open).1);
    }
}
