//! Charts of series of runs beside what the paper says of them.

use super::grain_run::{Bounded, REGIMES};
use super::grain_statements::{COMPARED, shut_on_grains, swinging_run};
use super::series::Series;
use super::trimmed;
use super::valve_run::{ValveRun, Varied};
use crate::scene::Closure;
use tremie_results::{Chart, Curve};

/// Points of a curve over time at most; each is a mean.
const POINTS: usize = 200;
/// Points of a pressure while the valve opens: few enough that the sound in the conduit averages out.
const OPENING_POINTS: usize = 25;

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
    all.filter(|chart| !chart.curves.is_empty()).collect()
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

    /// A chart without the curves that are empty; `statements` are the numbers of those that it
    /// stands beside, on the pressure valve and on the safety valve.
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
                ["displacement of the piston [mm]", "pressure beneath [kPa]"],
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
        let diameters = self.series(true, Varied::Diameter).values(ValveRun::rest);
        let over_diameter = self.chart(
            ["", "17"],
            "at rest",
            ["mean diameter [mm]", LIFT],
            vec![line("at rest", &diameters, [1e3, 1e3])],
        );
        if self.kind == Closure::Safety {
            return vec![over_diameter];
        }
        let bounded = |of: fn(&ValveRun) -> Option<Bounded>| {
            let runs = shut_on_grains(self.runs).filter_map(|(run, _)| of(run));
            let found: Vec<_> = runs.map(|it| [it.least, it.found]).collect();
            let bound = ends(found.iter().map(|it| it[0])).map_or(Vec::new(), |[low, high]| {
                [0.9 * low, 1.1 * high].map(|least| [least, least]).into()
            });
            vec![line("at least", &bound, [1.0, 1.0]), marks("runs", &found)]
        };
        vec![
            over_diameter,
            self.chart(
                ["11", ""],
                "at rest",
                ["greatest over least diameter", "lift over the layer of mean grains"],
                self.layers(),
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

    /// Lifts at rest over that on one layer of mean grains, between the layers of the least and of
    /// the greatest (Eq. 32).
    fn layers(&self) -> Vec<Curve> {
        let of = |(run, lift): (&ValveRun, f64)| {
            let [least, greatest] = run.layer_lifts()?;
            Some([greatest / least, 2.0 * lift / (least + greatest)])
        };
        let found: Vec<_> = shut_on_grains(self.runs).filter_map(of).collect();
        let Some([low, high]) = ends(found.iter().map(|it| it[0])) else { return Vec::new() };
        let ratios = (0..=POINTS).map(|k| {
            let part = k as f64 / POINTS as f64;
            low - 0.05 + part * (high - low + 0.1)
        });
        let bound = |of: fn(f64) -> f64| ratios.clone().map(|r| [r, of(r)]).collect::<Vec<_>>();
        vec![
            line("least grains", &bound(|ratio| 2.0 / (1.0 + ratio)), [1.0, 1.0]),
            line("greatest grains", &bound(|ratio| 2.0 * ratio / (1.0 + ratio)), [1.0, 1.0]),
            marks("runs", &found),
        ]
    }

    /// Lift, packing and pressure of the run in which the paper compares them, each over its mean.
    fn swings(&self) -> Vec<Curve> {
        let run = swinging_run(self.runs).filter(|_| self.kind == Closure::Pressure);
        let Some(run) = run else { return Vec::new() };
        let signals = [
            ("lift", Some(run.lift)),
            ("packing", run.signal("grains.packing.solid_fraction")),
            ("pressure", run.signal("fluid.beneath.pressure")),
        ];
        let curve = |(name, signal): (&str, Option<&[f64]>)| {
            let [mean, ..] = run.spread(signal?, COMPARED, run.stop)?;
            let points = binned(run, signal?, [COMPARED, run.stop], POINTS);
            Some(line(name, &points, [1e3, 1.0 / mean]))
        };
        signals.into_iter().filter_map(curve).collect()
    }
}

/// Lift of each run of a series over time.
fn lifts(series: &Series, unit: &str) -> Vec<Curve> {
    each_run(series, unit, |run| {
        let points = binned(run, run.lift, [0.0, run.end()], POINTS);
        points.iter().map(|[time, lift]| (1e3 * time, 1e3 * lift)).collect()
    })
}

/// Pressure beneath the valve of each run of a series over its piston's displacement, until it
/// opens.
fn compressions(series: &Series) -> Vec<Curve> {
    each_run(series, "m/s", |run| {
        let of = || {
            let pressure = run.signal("fluid.beneath.pressure")?;
            let until = run.delay()?;
            let way = displacement(run)?;
            let [ways, pressures] =
                [&way, pressure].map(|signal| binned(run, signal, [0.0, until], OPENING_POINTS));
            // A part in which nothing was measured is missing in the means of the pressure.
            let both = |[time, way]: &[f64; 2]| {
                let [_, pressure] = pressures.iter().find(|mean| mean[0] == *time)?;
                Some((1e3 * way, 1e-3 * pressure))
            };
            Some(ways.iter().filter_map(both).collect())
        };
        of().unwrap_or_default()
    })
}

/// Displacement of the piston at each row [m], by the trapezoidal rule.
fn displacement(run: &ValveRun) -> Option<Vec<f64>> {
    let velocity = run.signal("fluid.reservoir_z_lower.piston_velocity")?;
    let times = run.times();
    let mut way = vec![0.0; times.len()];
    for row in 1..times.len() {
        let mean = 0.5 * (velocity[row - 1] + velocity[row]);
        way[row] = way[row - 1] + mean * (times[row] - times[row - 1]);
    }
    Some(way)
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
    let lifts = least.iter().chain(&greatest).map(|point| point[1]);
    let Some([low, high]) = ends(lifts) else { return Vec::new() };
    let between =
        REGIMES.map(|flux| line(&format!("{flux} m/s"), &[[flux, low], [flux, high]], [1.0, 1e3]));
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

/// Means of a signal over equal parts of a time, with the middles of these [s].
fn binned(run: &ValveRun, signal: &[f64], [from, until]: [f64; 2], parts: usize) -> Vec<[f64; 2]> {
    let width = (until - from) / parts as f64;
    let mean = |part: usize| {
        let begin = from + width * part as f64;
        // A row on the border of two parts is in the later one.
        let [mean, ..] = run.spread(signal, begin, begin + (1.0 - 1e-6) * width)?;
        Some([begin + 0.5 * width, mean])
    };
    (0..parts).filter_map(mean).collect()
}

fn sorted(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    points
}

/// Least and greatest of numbers.
fn ends(numbers: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    numbers.map(|number| [number; 2]).reduce(|[low, high], [a, b]| [low.min(a), high.max(b)])
}

/// A line; of one point, which would show nothing, a mark.
fn line(name: &str, points: &[[f64; 2]], [by_x, by_y]: [f64; 2]) -> Curve {
    let points: Vec<_> = points.iter().map(|[x, y]| (by_x * x, by_y * y)).collect();
    Curve { name: name.into(), marks: points.len() == 1, points }
}

fn marks(name: &str, points: &[[f64; 2]]) -> Curve {
    Curve { marks: true, ..line(name, points, [1.0, 1.0]) }
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
        assert!(over_time.curves[0].name == "0.053" && over_time.curves[0].points.len() == POINTS);
        // 0.9 mm over a layer of 0.8 mm over the cosine of 29.53 degrees.
        let rest = &titled("11: at rest").unwrap().curves[2];
        assert!(rest.marks && near(rest.points[0], 1.2, 0.9 * 0.8701 / 0.8), "{rest:?}");
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
