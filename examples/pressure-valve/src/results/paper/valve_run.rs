//! A run of the valve as Mutabaruka and Kamrin name theirs, with the numbers that they speak of.

use crate::scene::{Closure, Dimensions};
use tremie_messages::scene::{Face, Scene};
use tremie_results::{FinishedRun, Signals, run_name};

/// What the series of the paper vary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Varied {
    /// Viscosity [Pa·s].
    Viscosity,
    /// Velocity of the piston [m/s].
    Piston,
    /// Mean of the least and the greatest diameter of the grains [m]; 0 without grains.
    Diameter,
    /// Greatest diameter over the least; 0 without grains.
    SizeRatio,
    /// Solid fraction of what comes in; 0 without grains.
    Fraction,
}

/// A run of a valve.
#[derive(Clone, Debug)]
pub struct ValveRun<'a> {
    /// Name of its folder.
    pub name: String,
    pub kind: Closure,
    /// By [`Varied`].
    numbers: [f64; 5],
    /// Time at which the piston stops [s].
    pub stop: f64,
    /// Least and greatest diameter of the grains [m].
    pub diameters: Option<[f64; 2]>,
    signals: &'a Signals,
    /// Lift [m].
    pub lift: &'a [f64],
}

impl<'a> ValveRun<'a> {
    /// A run; `None` if it has no piston, or no valve.
    pub fn read(run: &'a FinishedRun) -> Option<Self> {
        let scene = &run.scene;
        let faces = &scene.domain.faces[2];
        let Face::Reservoir(reservoir) = &faces[0] else { return None };
        let lift = run.signals.columns.get("grains.valve.lift")?;
        let inlet = scene.inlets.first();
        let diameters = inlet.map(|inlet| inlet.diameters.extremes());
        let [least, greatest] = diameters.unwrap_or_default();
        Some(Self {
            name: run_name(&run.folder),
            kind: match faces[1] {
                Face::Pressure { .. } => Closure::Safety,
                _ => Closure::Pressure,
            },
            numbers: [
                viscosity(scene),
                reservoir.piston,
                0.5 * (least + greatest),
                if least > 0.0 { greatest / least } else { 0.0 },
                inlet.map_or(0.0, |inlet| inlet.fraction),
            ],
            stop: reservoir.stop.unwrap_or(f64::INFINITY),
            diameters,
            signals: &run.signals,
            lift,
        })
    }

    /// A quantity that the series vary.
    pub fn number(&self, varied: Varied) -> f64 {
        self.numbers[varied as usize]
    }

    /// True if another run has the same numbers but for one, to a millionth.
    pub fn differs_only_in(&self, other: &Self, varied: Varied) -> bool {
        let same = |k: usize| {
            let (a, b) = (self.numbers[k], other.numbers[k]);
            (a - b).abs() <= 1e-6 * a.abs().max(b.abs())
        };
        self.kind == other.kind
            && self.diameters.is_some() == other.diameters.is_some()
            && (0..5).all(|k| k == varied as usize || same(k))
    }

    /// True if another run has the same name, numbers and lifts.
    pub fn is_same_as(&self, other: &Self) -> bool {
        (&self.name, self.kind, self.numbers) == (&other.name, other.kind, other.numbers)
            && self.lift == other.lift
    }

    /// A signal, if the run has it.
    pub fn signal(&self, name: &str) -> Option<&'a [f64]> {
        self.signals.columns.get(name).map(Vec::as_slice)
    }

    /// Times of the signals [s].
    pub fn times(&self) -> &'a [f64] {
        &self.signals.times
    }

    /// End of the run [s].
    pub fn end(&self) -> f64 {
        self.times().last().copied().unwrap_or(0.0)
    }

    /// Rows of the signals from a time to another.
    pub fn rows(&self, from: f64, until: f64) -> std::ops::Range<usize> {
        let times = self.times();
        let first = times.partition_point(|time| *time < from);
        first..times.partition_point(|time| *time <= until).max(first)
    }

    /// Mean, least and greatest value of a signal over some time; `None` where it has no row.
    pub fn spread(&self, signal: &[f64], from: f64, until: f64) -> Option<[f64; 3]> {
        let part = &signal[self.rows(from, until)];
        let finite = || part.iter().copied().filter(|value| value.is_finite());
        let count = finite().count();
        let fold = |start: f64, of: fn(f64, f64) -> f64| finite().fold(start, of);
        let mean = finite().sum::<f64>() / count as f64;
        (count > 0).then(|| [mean, fold(f64::INFINITY, f64::min), fold(-f64::INFINITY, f64::max)])
    }

    /// Time at which the ring has its height back: the lift passes the lip [s].
    pub fn delay(&self) -> Option<f64> {
        let lip = Dimensions::default().lip.0;
        let row = self.lift.iter().position(|lift| *lift > lip)?;
        Some(self.times()[row])
    }

    /// Mean, least and greatest lift over the last two fifths of the piston's way, if it is open
    /// before and the run lasts as long.
    pub fn steady(&self) -> Option<[f64; 3]> {
        let from = 0.6 * self.stop;
        (self.delay()? < from && self.end() >= 0.99 * self.stop)
            .then(|| self.spread(self.lift, from, self.stop))?
    }

    /// Mean of the [steady](Self::steady) lift [m].
    pub fn steady_mean(&self) -> Option<f64> {
        self.steady().map(|[mean, ..]| mean)
    }

    /// Lift over the last millisecond of a run that ends five milliseconds after the piston, or
    /// later [m].
    pub fn rest(&self) -> Option<f64> {
        let is_long = self.end() >= self.stop + 5e-3;
        is_long
            .then(|| self.spread(self.lift, self.end() - 1e-3, self.end()))?
            .map(|[mean, ..]| mean)
    }

    /// Times and lifts of the maxima after it has opened, up to the stop of the piston: those from
    /// which it comes down by a thirtieth of the greatest lift before it rises by as much again.
    pub fn peaks(&self) -> Vec<[f64; 2]> {
        let Some(delay) = self.delay() else { return Vec::new() };
        let rows = self.rows(delay, self.stop);
        let (lift, times) = (&self.lift[rows.clone()], &self.times()[rows]);
        let drop = lift.iter().copied().fold(0.0, f64::max) / 30.0;
        let (mut peaks, mut rising, mut turn) = (Vec::new(), true, 0);
        for row in 0..lift.len() {
            let gain = if rising { lift[row] - lift[turn] } else { lift[turn] - lift[row] };
            if gain > 0.0 {
                turn = row;
            } else if -gain > drop {
                if rising {
                    peaks.push([times[turn], lift[turn]]);
                }
                (rising, turn) = (!rising, row);
            }
        }
        peaks
    }

    /// Least pressure in the channel between ring and seat, in the three milliseconds in which it
    /// opens [Pa].
    pub fn suction(&self) -> Option<f64> {
        let (channel, delay) = (self.signal("fluid.channel.pressure")?, self.delay()?);
        self.spread(channel, delay, delay + 3e-3).map(|[_, least, _]| least)
    }

    /// Slope of the pressure beneath while the piston compresses the fluid, by least squares [Pa/s].
    /// A fast piston compresses a valve that rises already: the pressure is greatest, and falls,
    /// before the ring has its height back.
    pub fn compression_rate(&self) -> Option<f64> {
        let pressure = self.signal("fluid.beneath.pressure")?;
        let before = self.rows(0.0, self.delay()?);
        let peak = before.max_by(|a, b| pressure[*a].total_cmp(&pressure[*b]))?;
        let first = self.times()[peak];
        let rows = self.rows(0.25 * first, 0.85 * first);
        let (times, pressure) = (&self.times()[rows.clone()], &pressure[rows]);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let (time, level) = (mean(times), mean(pressure));
        let products = times.iter().zip(pressure).map(|(t, p)| (t - time) * (p - level));
        let squares: f64 = times.iter().map(|t| (t - time) * (t - time)).sum();
        (times.len() > 2).then(|| products.sum::<f64>() / squares)
    }
}

fn viscosity(scene: &Scene) -> f64 {
    scene.fluid.as_ref().map_or(0.0, |fluid| fluid.viscosity)
}

#[cfg(test)]
pub mod made_up {
    //! Runs that never were.

    use super::*;

    /// Rows every 20 us up to 35 ms.
    pub fn signals(columns: &[(&str, &dyn Fn(f64) -> f64)]) -> Signals {
        let times: Vec<f64> = (0..=1750).map(|row| 2e-5 * f64::from(row)).collect();
        let column = |(name, of): &(&str, &dyn Fn(f64) -> f64)| {
            (name.to_string(), times.iter().map(|time| of(*time)).collect())
        };
        Signals { columns: columns.iter().map(column).collect(), times, ..Signals::default() }
    }

    /// A run of a valve of a kind: viscosity, speed of the piston, which stops at 25 ms; grains of
    /// a mean diameter, sizes of a ratio of 1.2, a fraction.
    pub fn run(
        signals: &Signals,
        kind: Closure,
        [viscosity, piston]: [f64; 2],
        grains: Option<[f64; 2]>,
    ) -> ValveRun<'_> {
        let [diameter, fraction] = grains.unwrap_or_default();
        let least = diameter / 1.1;
        let ratio = if grains.is_some() { 1.2 } else { 0.0 };
        ValveRun {
            name: "made up".into(),
            kind,
            numbers: [viscosity, piston, diameter, ratio, fraction],
            stop: 25e-3,
            diameters: grains.map(|_| [least, 1.2 * least]),
            signals,
            lift: &signals.columns["grains.valve.lift"],
        }
    }

    /// A lift that begins at a time, swings about `level` with a period of 3.5 ms, dying down with
    /// a time, and comes down to `rest` at 26 ms [m].
    pub fn lift(time: f64, [begin, level, damping, rest]: [f64; 4]) -> f64 {
        let since = time - begin;
        match time {
            _ if since < 0.0 => 0.05e-3,
            _ if time > 26e-3 => rest,
            _ => {
                level
                    * (1.0
                        - (-since / damping).exp() * (std::f64::consts::TAU * since / 3.5e-3).cos())
            }
        }
    }

    /// A pressure that rises by 200 MPa/s, and falls before the valve is open.
    #[test]
    fn a_compression_ends_where_the_pressure_is_greatest() {
        let pressure = |t: f64| 2e8 * t.min(4.6e-3 - t).max(0.0);
        let all = signals(&[
            ("grains.valve.lift", &|t| lift(t, [2.8e-3, 2e-3, 1e-3, 0.5e-3])),
            ("fluid.beneath.pressure", &pressure),
        ]);
        let it = run(&all, Closure::Pressure, [1e-3, 6.0], None);
        assert!(it.delay().unwrap() > 3e-3);
        assert!((it.compression_rate().unwrap() / 2e8 - 1.0).abs() < 1e-9);
    }

    #[test]
    fn delays_means_and_peaks_are_those_of_a_damped_oscillation() {
        let of = |damping: f64| {
            signals(&[("grains.valve.lift", &|t| lift(t, [2e-3, 2e-3, damping, 0.5e-3]))])
        };
        let swinging = of(5e-3);
        let it = run(&swinging, Closure::Pressure, [1e-3, 6.0], None);
        let peaks = it.peaks();
        assert!(peaks.len() >= 3, "{peaks:?}");
        assert!((peaks[0][0] - 3.7e-3).abs() < 0.15e-3, "{peaks:?}");
        assert!(peaks.windows(2).all(|two| two[1][1] < two[0][1]), "{peaks:?}");
        let delay = it.delay().unwrap();
        assert!(delay > 2.2e-3 && delay < 2.6e-3, "{delay}");
        let [mean, least, greatest] = it.steady().unwrap();
        assert!((mean - 2e-3).abs() < 0.05e-3 && least < mean && greatest > mean);
        assert!((it.rest().unwrap() - 0.5e-3).abs() < 1e-12);
        let rising = signals(&[("grains.valve.lift", &|t: f64| 0.1 * t)]);
        assert!(run(&rising, Closure::Pressure, [31.6, 6.0], None).peaks().is_empty());
    }
}
