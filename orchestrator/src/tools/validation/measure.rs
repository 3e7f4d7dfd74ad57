//! Measures: numbers from signals over time.

use super::case::{Measure, Take, Threshold};
use crate::manifest::Limit;
use tremie_results::Signals;

/// Measures a number.
///
/// # Errors
/// A sentence, if the signal is not there or too short for it.
pub fn take(measure: &Measure, signals: &Signals) -> Result<f64, String> {
    let mut column = signals.column(&measure.signal)?.to_vec();
    if let Some(other) = &measure.minus {
        column.iter_mut().zip(signals.column(other)?).for_each(|(value, other)| *value -= other);
    }
    let once = measure.once.as_ref().map_or(Ok(measure.from), |event| time_of(event, signals))?;
    // `time_of` looks at the whole run: an event before `from` counts from `from` on.
    let from = measure.from.max(once);
    let points: Vec<(f64, f64)> = (signals.times.iter().copied().zip(column))
        .filter(|(time, _)| (from..=measure.until).contains(time))
        .collect();
    let value = reduce(measure.take, &points).ok_or_else(|| {
        let Measure { signal, take, until, .. } = measure;
        format!("\"{signal}\" has too few values between {from} s and {until} s for {take:?}")
    })?;
    Ok(value * measure.scale)
}

/// Time at which an event happens first [s].
fn time_of(event: &Threshold, signals: &Signals) -> Result<f64, String> {
    let Threshold { signal, exceeds } = event;
    let column = signals.column(signal)?;
    let points = signals.times.iter().copied().zip(column.iter().copied());
    first_time(points, Limit::Above(*exceeds))
        .ok_or_else(|| format!("\"{signal}\" never exceeds {exceeds}"))
}

/// Time of the first of the points (time, value) whose value meets a limit; `None` if none does.
pub fn first_time(points: impl IntoIterator<Item = (f64, f64)>, limit: Limit) -> Option<f64> {
    points.into_iter().find(|(_, value)| limit.is_met_by(*value)).map(|(time, _)| time)
}

/// Reduces points (time, value) to a number; `None` if they are too few for it.
pub fn reduce(take: Take, points: &[(f64, f64)]) -> Option<f64> {
    let most = |better: fn(f64, f64) -> bool| {
        points.iter().copied().reduce(|a, b| if better(b.1, a.1) { b } else { a })
    };
    let greatest = || most(|b, a| b > a);
    let least = || most(|b, a| b < a);
    match take {
        Take::First => points.first().map(|point| point.1),
        Take::Last => points.last().map(|point| point.1),
        Take::Mean => mean(points),
        Take::Max => greatest().map(|point| point.1),
        Take::Min => least().map(|point| point.1),
        Take::MaxAbs => most(|b, a| b.abs() > a.abs()).map(|point| point.1.abs()),
        Take::PeakToPeak => Some(greatest()?.1 - least()?.1),
        Take::Slope => slope(points),
        Take::TimeOfFirst => points.first().map(|point| point.0),
        Take::TimeOfMax => greatest().map(|point| point.0),
        Take::TimeOfMin => least().map(|point| point.0),
        Take::Frequency => frequency(points),
    }
}

/// Mean over time, by trapezia.
fn mean(points: &[(f64, f64)]) -> Option<f64> {
    let span = points.last()?.0 - points.first()?.0;
    if span <= 0.0 {
        return points.first().map(|point| point.1);
    }
    let area = |pair: &[(f64, f64)]| 0.5 * (pair[0].1 + pair[1].1) * (pair[1].0 - pair[0].0);
    Some(points.windows(2).map(area).sum::<f64>() / span)
}

/// Slope of the line of least squares.
fn slope(points: &[(f64, f64)]) -> Option<f64> {
    let count = points.len() as f64;
    let middle: [f64; 2] =
        [0, 1].map(|k| points.iter().map(|p| [p.0, p.1][k]).sum::<f64>() / count);
    let (mut product, mut square) = (0.0, 0.0);
    for (time, value) in points {
        product += (time - middle[0]) * (value - middle[1]);
        square += (time - middle[0]).powi(2);
    }
    (square > 0.0).then(|| product / square)
}

/// Frequency of the crossings of the mean upwards, from the first to the last, each found by linear
/// interpolation.
fn frequency(points: &[(f64, f64)]) -> Option<f64> {
    let level = mean(points)?;
    let crossings: Vec<f64> = points
        .windows(2)
        .filter(|pair| pair[0].1 < level && pair[1].1 >= level)
        .map(|pair| {
            let [(t0, v0), (t1, v1)] = [pair[0], pair[1]];
            t0 + (level - v0) / (v1 - v0) * (t1 - t0)
        })
        .collect();
    let periods = crossings.len().checked_sub(1).filter(|periods| *periods > 0)?;
    Some(periods as f64 / (crossings[periods] - crossings[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave() -> Signals {
        let times: Vec<f64> = (0..=4000).map(|k| f64::from(k) * 1e-3).collect();
        let values = times.iter().map(|t| 1.0 + (std::f64::consts::TAU * 2.5 * t).sin()).collect();
        Signals { columns: [("a.b".to_string(), values)].into(), times, ..Signals::default() }
    }

    fn measured(kind: Take, from: f64, until: f64) -> Result<f64, String> {
        let (signal, minus) = ("a.b".into(), None);
        let measure =
            Measure { signal, run: None, minus, take: kind, from, until, once: None, scale: 2.0 };
        take(&measure, &wave())
    }

    #[test]
    fn a_wave_is_measured() {
        let near = |kind, expected: f64| {
            let value = measured(kind, 0.0, f64::INFINITY).unwrap() / 2.0;
            assert!((value - expected).abs() < 1e-3, "{kind:?}: {value}, expected {expected}");
        };
        near(Take::Frequency, 2.5);
        near(Take::Mean, 1.0);
        near(Take::Max, 2.0);
        near(Take::Min, 0.0);
        near(Take::PeakToPeak, 2.0);
        near(Take::TimeOfMax, 0.1);
        near(Take::Last, 1.0);
        near(Take::TimeOfFirst, 0.0);
        let rise = measured(Take::Slope, 0.0, 2e-3).unwrap() / 2.0;
        assert!((rise / (std::f64::consts::TAU * 2.5) - 1.0).abs() < 1e-3, "{rise}");
        assert!(measured(Take::Slope, 0.0, 0.0).is_err());
    }

    #[test]
    fn a_signal_can_be_taken_from_another() {
        let (signal, minus) = ("a.b".into(), Some("a.b".into()));
        let (from, until) = (0.0, f64::INFINITY);
        let (take_all, once) = (Take::MaxAbs, None);
        let measure =
            Measure { signal, run: None, minus, take: take_all, from, until, once, scale: 1.0 };
        assert_eq!(take(&measure, &wave()), Ok(0.0));
    }

    #[test]
    fn a_signal_can_count_from_an_event_on() {
        let measured = |exceeds| {
            let (signal, minus, take_first) = ("a.b".into(), None, Take::First);
            let once = Some(Threshold { signal: "a.b".into(), exceeds });
            let (from, until) = (0.05, f64::INFINITY);
            let measure = Measure {
                signal,
                run: None,
                minus,
                take: take_first,
                from,
                until,
                once,
                scale: 1.0,
            };
            take(&measure, &wave())
        };
        // The wave passes 1.9 at 0.071 s, and 1.1 before it counts.
        assert!((measured(1.9).unwrap() - 1.9).abs() < 0.02);
        assert!((measured(1.1).unwrap() - 1.707).abs() < 0.02);
        assert!(measured(2.5).unwrap_err().contains("never exceeds 2.5"));
    }

    #[test]
    fn what_cannot_be_measured_is_said() {
        assert!(measured(Take::Frequency, 0.0, 0.3).unwrap_err().contains("too few"));
        assert!(measured(Take::Mean, 9.0, 10.0).unwrap_err().contains("between 9"));
        let other = Measure {
            signal: "a.c".into(),
            run: None,
            minus: None,
            take: Take::Last,
            from: 0.0,
            until: 1.0,
            once: None,
            scale: 1.0,
        };
        assert!(take(&other, &wave()).unwrap_err().contains("did you mean \"a.b\""));
    }
}
