//! Charts of series of runs beside what the paper says of them.

use super::grain_run::{Bounded, REGIMES};
use super::grain_statements::{shut_on_grains, swinging_run};
use super::series::Series;
use super::trimmed;
use super::valve_run::{ValveRun, Varied};
use crate::scene::Closure;
use tremie_results::{Chart, Curve};

/// Time that a point of a curve over time is the mean of [s].
const BIN: f64 = 0.1e-3;

const SPEED: &str = "piston [m/s]";
const LIFT: &str = "lift [mm]";
const LIFT_OVER_TIME: [&str; 2] = ["time [ms]", LIFT];

/// All charts that show anything, of the pressure valve and then of the safety valve.
pub fn of_both_valves(runs: &[ValveRun]) -> Vec<Chart> {
    let of_one = |kind| {
        let valve = OneValve { runs, kind };
        [valve.of_flows(), valve.of_grains(), valve.at_rest()].concat()
    };
    let all = [Closure::Pressure, Closure::Safety].into_iter().flat_map(of_one);
    all.filter(|chart| chart.curves.iter().any(|curve| !curve.points.is_empty())).collect()
}

/// The runs of one of the two valves.
struct OneValve<'r, 'a> {
    runs: &'r [ValveRun<'a>],
    kind: Closure,
}

impl<'r, 'a> OneValve<'r, 'a> {
    /// The longest series over a quantity; empty if it has one point.
    fn series(&self, grains: bool, varied: Varied) -> Series<'r, 'a> {
        let series = Series::longest(self.runs, self.kind, grains, varied);
        if series.points.len() > 1 { series } else { Series::default() }
    }

    /// A chart; `statements` are those on the pressure valve and those on the safety valve.
    fn chart(
        &self,
        statements: [&str; 2],
        title: &str,
        [x, y]: [&str; 2],
        curves: Vec<Curve>,
    ) -> Chart {
        let (numbers, valve) = match self.kind {
            Closure::Pressure => (statements[0], "pressure valve"),
            Closure::Safety => (statements[1], "safety valve"),
        };
        let numbers = if numbers.is_empty() { String::new() } else { format!("{numbers}: ") };
        let curves = curves.into_iter().filter(|curve| !curve.points.is_empty()).collect();
        Chart {
            title: format!("{numbers}{title}, {valve}"),
            x: x.into(),
            y: y.into(),
            curves,
            ..Chart::default()
        }
    }

    /// A chart over the viscosity.
    fn over_viscosity(&self, statements: [&str; 2], title: &str, y: &str, curve: Curve) -> Chart {
        let chart = self.chart(statements, title, ["viscosity [Pa s]", y], vec![curve]);
        Chart { log_x: true, ..chart }
    }

    /// The valve without grains; its delays also with.
    fn of_flows(&self) -> Vec<Chart> {
        let [viscous, pistons] =
            [Varied::Viscosity, Varied::Piston].map(|varied| self.series(false, varied));
        let slurries = self.series(true, Varied::Piston);
        let delays =
            |name, series: &Series| line(name, &series.values(ValveRun::delay), [1.0, 1e3]);
        let suctions = line("channel", &viscous.values(ValveRun::suction), [1.0, 1e-3]);
        vec![
            self.chart(
                ["1", ""],
                "delay",
                [SPEED, "delay [ms]"],
                vec![delays("without grains", &pistons), delays("with grains", &slurries)],
            ),
            self.over_viscosity(["1", ""], "delay", "delay [ms]", delays("", &viscous)),
            self.over_viscosity(["2", ""], "suction beneath the ring", "pressure [kPa]", suctions),
            self.chart(
                ["3", ""],
                "pressure until it opens",
                ["way of the piston [mm]", "pressure beneath [kPa]"],
                compressions(&pistons),
            ),
            self.chart(["4, 5", "15"], "pistons", LIFT_OVER_TIME, lifts(&pistons, "m/s")),
            self.chart(["5, 6", ""], "viscosities", LIFT_OVER_TIME, lifts(&viscous, "Pa s")),
        ]
    }

    /// The valve with grains, while it is open.
    fn of_grains(&self) -> Vec<Chart> {
        let [diameters, ratios, fractions, pistons] =
            [Varied::Diameter, Varied::SizeRatio, Varied::Fraction, Varied::Piston]
                .map(|varied| self.series(true, varied));
        let steady = |series: &Series, by_x| {
            vec![line("steady", &series.values(ValveRun::steady_mean), [by_x, 1e3])]
        };
        let diameter = ["mean diameter [mm]", LIFT];
        vec![
            self.chart(["7", ""], "steady lift", diameter, steady(&diameters, 1e3)),
            self.chart(
                ["7", ""],
                "steady lift",
                ["greatest over least diameter", LIFT],
                steady(&ratios, 1.0),
            ),
            self.chart(["8", "16"], "fractions", LIFT_OVER_TIME, lifts(&fractions, "")),
            self.chart(
                ["8", "16"],
                "regimes, from 10 ms on",
                ["flux of grains [m/s]", LIFT],
                regimes(&fractions),
            ),
            self.chart(["9", ""], "fraction 0.084", ["time [ms]", "over its mean"], self.swings()),
            self.chart(["12", ""], "pistons, with grains", LIFT_OVER_TIME, lifts(&pistons, "m/s")),
        ]
    }

    /// The valve with grains, when it has come to rest.
    fn at_rest(&self) -> Vec<Chart> {
        let runs = || shut_on_grains(self.runs, self.kind).map(|(run, _)| run);
        let bounded = |of: fn(&ValveRun) -> Option<Bounded>| {
            let found: Vec<_> = runs().filter_map(of).map(|it| [it.least, it.found]).collect();
            let bound: Vec<_> = found.iter().map(|[least, _]| [*least, *least]).collect();
            vec![
                line("at least", &lengthened(bound), [1.0, 1.0]),
                marks("runs", &found, [1.0, 1.0]),
            ]
        };
        let bound = |k: usize| {
            let of = |run: &ValveRun| Some([run.number(Varied::Diameter), run.layer_lifts()?[k]]);
            lengthened(runs().filter_map(of).collect())
        };
        let rests: Vec<_> = shut_on_grains(self.runs, self.kind)
            .map(|(run, lift)| [run.number(Varied::Diameter), lift])
            .collect();
        vec![
            self.chart(
                ["11", "17"],
                "at rest",
                ["mean diameter [mm]", LIFT],
                vec![
                    line("least diameter over the cosine", &bound(0), [1e3, 1e3]),
                    line("greatest", &bound(1), [1e3, 1e3]),
                    marks("runs", &rests, [1e3, 1e3]),
                ],
            ),
            self.chart(
                ["13", ""],
                "area of stuck grains (NASP)",
                ["the paper's least", "of the channel's area"],
                bounded(|run| run.stuck_area()),
            ),
            self.chart(
                ["14", ""],
                "debris",
                ["the paper's least", "cubes of a diameter"],
                bounded(|run| run.stuck_debris()),
            ),
        ]
    }

    /// Lift and packing of the run in which the paper compares them, each over its mean.
    fn swings(&self) -> Vec<Curve> {
        let Some(run) = swinging_run(self.runs, self.kind) else { return Vec::new() };
        let packing = run.signal("grains.packing.solid_fraction");
        let signals = [("lift", Some(run.lift)), ("packing", packing)];
        let curve = |(name, signal): (&str, Option<&[f64]>)| {
            let [mean, ..] = run.spread(signal?, 8e-3, run.stop)?;
            let points = binned(run, signal?, [8e-3, run.stop]);
            Some(line(name, &points, [1e3, 1.0 / mean]))
        };
        signals.into_iter().filter_map(curve).collect()
    }
}

/// Lift of each run of a series over time.
fn lifts(series: &Series, unit: &str) -> Vec<Curve> {
    each_run(series, unit, |run| {
        let points = binned(run, run.lift, [0.0, run.end()]);
        points.iter().map(|[time, lift]| (1e3 * time, 1e3 * lift)).collect()
    })
}

/// Pressure beneath the valve of each run of a series over the way of its piston, until it opens.
fn compressions(series: &Series) -> Vec<Curve> {
    each_run(series, "m/s", |run| {
        let pressure = run.signal("fluid.beneath.pressure").zip(run.delay());
        let points =
            pressure.map_or(Vec::new(), |(pressure, delay)| binned(run, pressure, [0.0, delay]));
        let speed = run.number(Varied::Piston);
        points.iter().map(|[time, pressure]| (1e3 * speed * time, 1e-3 * pressure)).collect()
    })
}

/// Mean, least and greatest lift over the flux of grains, and the fluxes between the paper's regimes.
fn regimes(series: &Series) -> Vec<Curve> {
    let fluxes = series.values(|run| run.envelope().map(|_| run.flux()));
    let of = |k: usize| {
        let lifts = series.values(|run| run.envelope().map(|lifts| lifts[k]));
        let points = fluxes.iter().zip(&lifts).map(|(flux, lift)| [flux[1], lift[1]]);
        sorted(points.collect())
    };
    let [mean, least, greatest] = [0, 1, 2].map(of);
    let ends = [&least, &greatest].map(|lifts| lifts.iter().map(|lift| lift[1]));
    let [lowest, highest] = ends.map(|lifts| lifts.collect::<Vec<_>>());
    let low = lowest.into_iter().reduce(f64::min);
    let Some(ends) = low.zip(highest.into_iter().reduce(f64::max)) else { return Vec::new() };
    let between = REGIMES
        .map(|flux| line(&format!("{flux} m/s"), &[[flux, ends.0], [flux, ends.1]], [1.0, 1e3]));
    let lifts = [("mean", mean), ("least", least), ("greatest", greatest)]
        .map(|(name, lifts)| line(name, &lifts, [1.0, 1e3]));
    lifts.into_iter().chain(between).collect()
}

/// A curve for each run of a series, named by its number.
fn each_run(
    series: &Series,
    unit: &str,
    points: impl Fn(&ValveRun) -> Vec<(f64, f64)>,
) -> Vec<Curve> {
    let named = |(number, runs): &(f64, Vec<&ValveRun>)| {
        let name = format!("{} {unit}", trimmed(*number)).trim_end().to_string();
        let curve =
            |run: &&ValveRun| Curve { name: name.clone(), points: points(run), marks: false };
        runs.iter().map(curve).collect::<Vec<_>>()
    };
    series.points.iter().flat_map(named).collect()
}

/// Means of a signal over [bins](BIN) from a time to another, with the bins' middles [s].
fn binned(run: &ValveRun, signal: &[f64], [from, until]: [f64; 2]) -> Vec<[f64; 2]> {
    let bins = ((until - from) / BIN).ceil().max(1.0) as usize;
    let mean = |bin: usize| {
        let begin = from + BIN * bin as f64;
        let [mean, ..] = run.spread(signal, begin, (begin + BIN).min(until))?;
        Some([begin + 0.5 * BIN, mean])
    };
    (0..bins).filter_map(mean).collect()
}

fn sorted(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points
}

/// A bound that is proportional to what it is drawn over, a tenth longer to each side.
fn lengthened(points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let points = sorted(points);
    let scaled =
        |point: Option<&[f64; 2]>, by: f64| point.map(|point| point.map(|value| by * value));
    let ends = [scaled(points.first(), 0.9), scaled(points.last(), 1.1)];
    let [first, last] = ends.map(|end| end.into_iter());
    first.chain(points).chain(last).collect()
}

fn line(name: &str, points: &[[f64; 2]], [by_x, by_y]: [f64; 2]) -> Curve {
    let points = points.iter().map(|[x, y]| (by_x * x, by_y * y)).collect();
    Curve { name: name.into(), points, marks: false }
}

fn marks(name: &str, points: &[[f64; 2]], scales: [f64; 2]) -> Curve {
    Curve { marks: true, ..line(name, points, scales) }
}

#[cfg(test)]
mod tests {
    use super::super::valve_run::made_up::{lift, run, signals};
    use super::*;

    #[test]
    fn a_series_of_fractions_stands_beside_the_regimes() {
        let all = [1.2e-3, 1.4e-3].map(|level| {
            signals(&[("grains.valve.lift", &move |t| lift(t, [2e-3, level, 1e-3, 0.9e-3]))])
        });
        let of = |k: usize, fraction| {
            run(&all[k], Closure::Pressure, [1e-3, 6.0], Some([0.8e-3, fraction]))
        };
        let charts = of_both_valves(&[of(1, 0.084), of(0, 0.053)]);
        let titled = |title: &str| charts.iter().find(|chart| chart.title.starts_with(title));
        let regimes = titled("8: regimes").unwrap();
        let names: Vec<_> = regimes.curves.iter().map(|curve| curve.name.as_str()).collect();
        assert_eq!(names, ["mean", "least", "greatest", "0.405 m/s", "0.611 m/s"]);
        let near = |point: (f64, f64), x: f64, y: f64| {
            (point.0 / x - 1.0).abs() < 1e-9 && (point.1 / y - 1.0).abs() < 0.02
        };
        let mean = &regimes.curves[0].points;
        assert!(near(mean[0], 6.0 * 0.053, 1.2) && near(mean[1], 6.0 * 0.084, 1.4), "{mean:?}");
        let over_time = titled("8: fractions").unwrap();
        assert!(over_time.curves[0].name == "0.053" && over_time.curves[0].points.len() == 350);
        let rest = titled("11: at rest").unwrap();
        assert!(rest.curves[2].marks && near(rest.curves[2].points[0], 0.8, 0.9), "{rest:?}");
        // Nothing of what takes other series, nothing of the other valve.
        assert!(titled("1: ").is_none() && titled("16: ").is_none() && titled("9: ").is_some());
    }

    #[test]
    fn one_run_without_grains_makes_no_chart() {
        let shut = signals(&[("grains.valve.lift", &|_| 0.05e-3)]);
        assert_eq!(of_both_valves(&[run(&shut, Closure::Safety, [1e-3, 1.0], None)]), []);
        assert_eq!(of_both_valves(&[]), []);
    }
}
