//! Statements on valves that grains pass, and on what is stuck in them.

use super::grain_run::{Bounded, REGIMES};
use super::series::{Series, grows, scatter};
use super::valve_run::{ValveRun, Varied};
use super::{Found, Judged, listed, over};
use crate::scene::Closure;

const FRACTIONS: &str =
    "runs with grains in three solid fractions or more, of fluxes below 0.405 m/s and above";

/// Swing of a lift, part of its mean, below which it counts as nearly constant.
const NEARLY_CONSTANT: f64 = 0.2;

pub(super) const ALL: &[Judged] = &[
    (
        7,
        "the spread of sizes has no effect on the lift; larger grains raise it, to about a diameter",
        sizes,
    ),
    (
        8,
        "grains' flux below 0.405 m/s: lift nearly constant; up to 0.611 it swings; above it is held up",
        |runs| regimes(runs, Closure::Pressure),
    ),
    (
        9,
        "at a fraction of 0.084 the lift lags behind the packing by 1.4 ms; pressure and packing swing in phase",
        lag,
    ),
    (10, "in the first regime the packing beneath the valve is constant", packing),
    (
        11,
        "it shuts at a lift between the least and the greatest diameter over the cosine of the cone's slope",
        shut_lifts,
    ),
    (
        12,
        "at 1 m/s grains hold it at a small lift, none passes, it comes down to 0.48 mm, none is stuck",
        slow_piston,
    ),
    (
        13,
        "the area of stuck grains (NASP) is at least 1.5 times the fraction over that cosine",
        |runs| stuck(runs, false),
    ),
    (
        14,
        "debris is at least 1.5 times area and fraction over that cosine and the diameter, squared",
        |runs| stuck(runs, true),
    ),
    (16, "the safety valve has the same three regimes", |runs| regimes(runs, Closure::Safety)),
    (17, "safety valve: grains of 1.4 mm leave it lower than grains of 1.1 mm", safety_sizes),
];

fn sizes(runs: &[ValveRun]) -> Found {
    let of = |varied| {
        Series::longest(runs, Closure::Pressure, true, varied).values(ValveRun::steady_mean)
    };
    let (ratios, diameters) = (of(Varied::SizeRatio), of(Varied::Diameter));
    if ratios.len() < 2 || diameters.len() < 2 {
        return Err("runs with grains of two sizes or more, and of two spreads of sizes or more");
    }
    let found = format!(
        "{} mm with ratios {}; {} mm with grains of {} mm",
        listed(&ratios, 1e3, 2),
        over(&ratios, 1.0),
        listed(&diameters, 1e3, 2),
        over(&diameters, 1e3),
    );
    let near = diameters.last().is_some_and(|[d, lift]| (lift / d - 1.0).abs() < 0.3);
    Ok((found, scatter(&ratios) < 0.05 && grows(&diameters) && near))
}

/// Swing of the lift over its mean, from the start's end to the piston's stop.
fn swing(run: &ValveRun) -> Option<f64> {
    run.envelope().map(|[mean, least, greatest]| (greatest - least) / mean)
}

fn regimes(runs: &[ValveRun], kind: Closure) -> Found {
    let series = Series::longest(runs, kind, true, Varied::Fraction);
    let fluxes = series.values(|run| run.envelope().map(|_| run.flux()));
    let lifts = series.values(|run| run.envelope().map(|[mean, ..]| mean));
    let swings = series.values(swing);
    let regime = |flux: f64| REGIMES.iter().filter(|bound| flux > **bound).count();
    let of = |values: &[[f64; 2]], wanted: usize| {
        let those = fluxes.iter().zip(values).filter(|(flux, _)| regime(flux[1]) == wanted);
        those.map(|(_, value)| value[1]).collect::<Vec<_>>()
    };
    let [first, second, third] = [0, 1, 2].map(|wanted| of(&swings, wanted));
    if first.is_empty() || second.is_empty() || third.is_empty() {
        return Err(match kind {
            Closure::Pressure => FRACTIONS,
            Closure::Safety => {
                "runs of the safety valve with grains, with fluxes in all three regimes"
            }
        });
    }
    let greatest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    let held = least(&of(&lifts, 2)) > greatest(&of(&lifts, 0));
    let right = greatest(&first) < NEARLY_CONSTANT
        && least(&second) > greatest(&first)
        && least(&third) < greatest(&second)
        && held;
    let found = format!(
        "mean lifts {} mm, swings {} % of them, at fluxes of {} m/s",
        listed(&lifts, 1e3, 2),
        listed(&swings, 1e2, 0),
        listed(&fluxes, 1.0, 3),
    );
    Ok((found, right))
}

/// Shift of one signal behind another at which they are most alike [s], between bounds: rows must
/// be equally far apart.
fn lag_of(late: &[f64], early: &[f64], spacing: f64, bounds: [f64; 2]) -> f64 {
    let without_mean = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter().map(|value| value - mean).collect::<Vec<_>>()
    };
    let (late, early) = (without_mean(late), without_mean(early));
    let likeness = |shift: isize| {
        let pairs = (0..late.len() as isize).filter_map(|row| {
            let other = usize::try_from(row - shift).ok()?;
            Some((late[row as usize], *early.get(other)?))
        });
        let (product, squares) = pairs.fold((0.0, [0.0; 2]), |(product, [a, b]), (x, y)| {
            (product + x * y, [a + x * x, b + y * y])
        });
        product / (squares[0] * squares[1]).sqrt()
    };
    let [first, last] = bounds.map(|bound| (bound / spacing).round() as isize);
    let best = (first..=last).max_by(|a, b| likeness(*a).total_cmp(&likeness(*b)));
    best.unwrap_or(0) as f64 * spacing
}

/// Time from which on lift and packing are compared [s].
pub(super) const COMPARED: f64 = 8e-3;

/// The run in which the paper compares lift and packing: at 6 m/s with a fraction of 0.084.
pub(super) fn swinging_run<'r, 'a>(runs: &'r [ValveRun<'a>]) -> Option<&'r ValveRun<'a>> {
    runs.iter().find(|run| {
        run.kind == Closure::Pressure
            && (run.number(Varied::Fraction) - 0.084).abs() < 1e-3
            && (run.number(Varied::Piston) - 6.0).abs() < 1e-3
            && run.steady().is_some()
    })
}

fn lag(runs: &[ValveRun]) -> Found {
    let needs =
        "a run of the pressure valve at 6 m/s with a fraction of 0.084, to the piston's stop";
    let run = swinging_run(runs).ok_or(needs)?;
    let packing = run.signal("grains.packing.solid_fraction").ok_or(needs)?;
    let pressure = run.signal("fluid.beneath.pressure").ok_or(needs)?;
    let rows = run.rows(COMPARED, run.stop);
    let times = &run.times()[rows.clone()];
    if times.len() < 2 {
        return Err(needs);
    }
    let spacing = (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64;
    let [lift, packing, pressure] = [run.lift, packing, pressure].map(|all| &all[rows.clone()]);
    let behind = lag_of(lift, packing, spacing, [-3e-3, 3e-3]);
    let phase = lag_of(pressure, packing, spacing, [-3e-3, 3e-3]);
    let found = format!(
        "the lift lags by {:.2} ms, the pressure by {:.2} ms ({})",
        1e3 * behind,
        1e3 * phase,
        run.name
    );
    Ok((found, (1e-3..=1.8e-3).contains(&behind) && phase.abs() < 0.4e-3))
}

fn packing(runs: &[ValveRun]) -> Found {
    let series = Series::longest(runs, Closure::Pressure, true, Varied::Fraction);
    let is_first = |run: &ValveRun| run.flux() < REGIMES[0];
    let swings = series.values(|run| run.packing_swing().filter(|_| is_first(run)));
    if swings.is_empty() {
        return Err("runs with grains whose flux is below 0.405 m/s");
    }
    let most = swings.iter().map(|v| v[1]).fold(0.0, f64::max);
    let found = format!(
        "the packing swings by {} % of its mean at fractions of {}",
        listed(&swings, 1e2, 0),
        over(&swings, 1.0)
    );
    Ok((found, most < NEARLY_CONSTANT))
}

/// Runs of the pressure valve with grains, with pistons faster than 2 m/s, that have opened and come
/// to rest; with their lift.
pub(super) fn shut_on_grains<'r, 'a>(
    runs: &'r [ValveRun<'a>],
) -> impl Iterator<Item = (&'r ValveRun<'a>, f64)> {
    let fast = |run: &&ValveRun| run.kind == Closure::Pressure && run.number(Varied::Piston) > 2.0;
    let opened = |run: &&ValveRun| run.diameters.is_some() && run.delay().is_some();
    runs.iter().filter(fast).filter(opened).filter_map(|run| Some((run, run.rest()?)))
}

const SHUT: &str = "runs of the pressure valve with grains that end 5 ms after the piston's stop";

fn shut_lifts(runs: &[ValveRun]) -> Found {
    let shut = shut_on_grains(runs);
    let all: Vec<_> = shut.filter_map(|(run, lift)| Some((run.layer_lifts()?, lift))).collect();
    if all.is_empty() {
        return Err(SHUT);
    }
    let within = all.iter().filter(|([low, high], lift)| (*low..=*high).contains(lift)).count();
    let each: Vec<_> = all
        .iter()
        .map(|([low, high], lift)| {
            let [lift, low, high] = [lift, low, high].map(|length| 1e3 * length);
            format!("{lift:.2} ({low:.2} to {high:.2})")
        })
        .collect();
    let found = format!("{within} of {} runs: {} mm", all.len(), each.join(", "));
    Ok((found, within == all.len()))
}

fn slow_piston(runs: &[ValveRun]) -> Found {
    let is_slow = |run: &&ValveRun| {
        run.kind == Closure::Pressure
            && run.diameters.is_some()
            && (run.number(Varied::Piston) - 1.0).abs() < 1e-3
    };
    let needs = "a run of the pressure valve with grains at 1 m/s, to 5 ms after the piston's stop";
    let run = runs.iter().find(is_slow).ok_or(needs)?;
    let rest = run.rest().ok_or(needs)?;
    let stuck = run.signal("grains.stuck.area_fraction").and_then(|area| area.last().copied());
    let [mean, least, greatest] = run.spread(run.lift, 13e-3, run.stop).ok_or(needs)?;
    let stuck = stuck.ok_or("a probe \"stuck\" in the valve's channel")?;
    let found = format!(
        "lift {:.2} mm, from {:.2} to {:.2}, from 13 ms to the stop; then {:.2} mm, NASP {stuck:.3}",
        1e3 * mean,
        1e3 * least,
        1e3 * greatest,
        1e3 * rest
    );
    let right = (greatest - least) < NEARLY_CONSTANT * mean
        && (rest - 0.48e-3).abs() < 0.01e-3
        && stuck == 0.0;
    Ok((found, right))
}

/// NASP of runs against its lower bound (Eq. 33), or debris (Eq. 35).
fn stuck(runs: &[ValveRun], broken: bool) -> Found {
    let of = |run: &ValveRun| if broken { run.stuck_debris() } else { run.stuck_area() };
    let all: Vec<_> = shut_on_grains(runs).filter_map(|(run, _)| of(run)).collect();
    if all.is_empty() {
        return Err(SHUT);
    }
    let above = all.iter().filter(|number| number.found >= number.least).count();
    let digits = if broken { 0 } else { 2 };
    let each: Vec<_> = all
        .iter()
        .map(|Bounded { found, least }| format!("{found:.digits$} (at least {least:.digits$})"))
        .collect();
    Ok((format!("{above} of {} runs: {}", all.len(), each.join(", ")), above == all.len()))
}

fn safety_sizes(runs: &[ValveRun]) -> Found {
    let rests =
        Series::longest(runs, Closure::Safety, true, Varied::Diameter).values(ValveRun::rest);
    let of = |d: f64| rests.iter().find(|v| (v[0] / d - 1.0).abs() < 0.01).map(|v| v[1]);
    let needs = "runs of the safety valve with grains of 1.1 and of 1.4 mm, to 5 ms after the stop";
    let (small, large) = of(1.1e-3).zip(of(1.4e-3)).ok_or(needs)?;
    let found = format!("{} mm with grains of {} mm", listed(&rests, 1e3, 2), over(&rests, 1e3));
    Ok((found, large < small))
}

#[cfg(test)]
mod tests {
    use super::super::valve_run::made_up::{lift, run, signals};
    use super::*;
    use std::f64::consts::PI;
    use tremie_results::Signals;

    const GRAINS: f64 = 0.8e-3;

    fn at_rest(rest: f64, area: f64) -> Signals {
        signals(&[
            ("grains.valve.lift", &move |t| lift(t, [2e-3, 1.3e-3, 1e-3, rest])),
            ("grains.stuck.area_fraction", &move |_| area),
        ])
    }

    /// Grains of 0.727 to 0.873 mm hold it at 0.836 to 1.003 mm (the paper's Eq. 32), and cover at
    /// least 1.724 times the fraction (Eq. 33).
    #[test]
    fn lifts_and_areas_at_rest_have_their_bounds() {
        let [right, wrong] = [at_rest(0.9e-3, 0.1), at_rest(1.1e-3, 0.08)];
        let of = |signals| run(signals, Closure::Pressure, [1e-3, 6.0], Some([GRAINS, 0.053]));
        let (found, holds) = shut_lifts(&[of(&right)]).unwrap();
        assert!(holds && found.contains("0.90 (0.84 to 1.00)"), "{found}");
        assert!(!shut_lifts(&[of(&right), of(&wrong)]).unwrap().1);
        let (found, holds) = stuck(&[of(&right)], false).unwrap();
        assert!(holds && found.contains("0.10 (at least 0.09)"), "{found}");
        assert!(!stuck(&[of(&wrong)], false).unwrap().1);
        assert!(stuck(&[of(&right)], true).unwrap().1);
    }

    #[test]
    fn regimes_are_told_apart_by_their_swing() {
        let swinging = |level: f64, swing: f64| {
            signals(&[("grains.valve.lift", &move |t: f64| match t {
                t if t < 2e-3 => 0.0,
                t if t > 26e-3 => 0.9e-3,
                t => level * (1.0 + swing * (2.0 * PI * t / 3.5e-3).sin()),
            })])
        };
        let all = [swinging(1.2e-3, 0.02), swinging(1.4e-3, 0.2), swinging(1.9e-3, 0.05)];
        let of = |k: usize, fraction| {
            run(&all[k], Closure::Pressure, [1e-3, 6.0], Some([GRAINS, fraction]))
        };
        let (found, right) =
            regimes(&[of(0, 0.053), of(1, 0.084), of(2, 0.117)], Closure::Pressure).unwrap();
        assert!(right && found.contains("0.318, 0.504, 0.702"), "{found}");
        assert!(
            !regimes(&[of(1, 0.053), of(0, 0.084), of(2, 0.117)], Closure::Pressure).unwrap().1
        );
        assert_eq!(regimes(&[of(0, 0.053)], Closure::Pressure), Err(FRACTIONS));
    }

    /// A sine that comes 1.4 ms after another.
    #[test]
    fn the_lag_of_a_sine_is_found() {
        let sine = |late: f64| {
            let at = |row: usize| (2.0 * PI * (2e-5 * row as f64 - late) / 3.5e-3).sin() + 2.0;
            (0..800).map(at).collect::<Vec<_>>()
        };
        let lag = lag_of(&sine(1.4e-3), &sine(0.0), 2e-5, [-1.7e-3, 1.7e-3]);
        assert!((lag - 1.4e-3).abs() < 1e-9, "{lag}");
    }
}
