//! Factors over time.

use core::f64::consts::TAU;
use serde::{Deserialize, Serialize};

/// A factor over time, by which a velocity or a pressure is multiplied.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Course {
    /// Linear between points `[time [s], factor]` in the order of time, constant before the first
    /// and after the last. Without points it is 1.
    Points(Vec<[f64; 2]>),
    /// Linear between two points or more, which come again and again, for all time before and
    /// after. The time from the first to the last is the period.
    Repeat(Vec<[f64; 2]>),
    /// A sine.
    Sine(Sine),
}

/// `mean + amplitude sin(2 pi frequency t + phase)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sine {
    /// Frequency [1/s].
    pub frequency: f64,
    /// Amplitude.
    pub amplitude: f64,
    /// Phase at time zero [rad].
    pub phase: f64,
    /// Mean.
    pub mean: f64,
}

impl Default for Course {
    fn default() -> Self {
        Self::CONSTANT
    }
}

impl Sine {
    /// Between -1 and 1, rising through zero at time zero; the frequency in [1/s].
    pub fn new(frequency: f64) -> Self {
        Self { frequency, amplitude: 1.0, phase: 0.0, mean: 0.0 }
    }

    /// The angle at a time [s], less whole turns [rad].
    fn angle(&self, time: f64) -> f64 {
        let turns = self.frequency * time;
        // Whole turns are taken off before the sine: a large angle would lose digits.
        TAU * (turns - turns.floor()) + self.phase
    }

    fn at(&self, time: f64) -> f64 {
        self.mean + self.amplitude * libm::sin(self.angle(time))
    }

    /// The integral from time zero [s].
    fn integral(&self, time: f64) -> f64 {
        let swing = libm::cos(self.phase) - libm::cos(self.angle(time));
        self.mean * time + self.amplitude / (TAU * self.frequency) * swing
    }
}

impl Course {
    /// The factor 1 at all times.
    pub const CONSTANT: Self = Self::Points(Vec::new());

    /// True if it is the factor 1, written without points.
    pub fn is_constant(&self) -> bool {
        *self == Self::CONSTANT
    }

    /// The factor at a time [s].
    pub fn at(&self, time: f64) -> f64 {
        match self {
            Self::Points(points) => between(points, time),
            Self::Repeat(points) => between(points, folded(points, time).1),
            Self::Sine(sine) => sine.at(time),
        }
    }

    /// The integral of the factor from time zero to another [s].
    pub fn integral(&self, time: f64) -> f64 {
        match self {
            Self::Points(points) => area(points, time) - area(points, 0.0),
            Self::Repeat(points) => {
                let of = |time: f64| {
                    let (periods, within) = folded(points, time);
                    let end = points.last().map_or(0.0, |last| last[0]);
                    periods * area(points, end) + area(points, within)
                };
                of(time) - of(0.0)
            }
            Self::Sine(sine) => sine.integral(time),
        }
    }

    /// The least and the greatest factor.
    pub fn extremes(&self) -> [f64; 2] {
        match self {
            Self::Points(points) if points.is_empty() => [1.0, 1.0],
            Self::Points(points) | Self::Repeat(points) => {
                points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], point| {
                    [least.min(point[1]), most.max(point[1])]
                })
            }
            Self::Sine(Sine { amplitude, mean, .. }) => {
                [mean - amplitude.abs(), mean + amplitude.abs()]
            }
        }
    }

    /// The largest factor, by amount.
    pub fn largest(&self) -> f64 {
        self.extremes().map(f64::abs).into_iter().fold(0.0, f64::max)
    }

    /// Flaw that makes it invalid, if there is one: a few words.
    pub fn flaw(&self) -> Option<&'static str> {
        let numbers: Vec<f64> = match self {
            Self::Points(points) | Self::Repeat(points) => points.concat(),
            Self::Sine(Sine { frequency, amplitude, phase, mean }) => {
                vec![*frequency, *amplitude, *phase, *mean]
            }
        };
        if !numbers.iter().all(|x| x.is_finite()) {
            return Some("holds a number that is not finite");
        }
        match self {
            Self::Points(points) | Self::Repeat(points)
                if points.windows(2).any(|pair| pair[0][0] >= pair[1][0]) =>
            {
                Some("the times of its course do not ascend")
            }
            Self::Repeat(points) if points.len() < 2 => {
                Some("a course that repeats has two points at least")
            }
            Self::Sine(sine) if sine.frequency <= 0.0 => {
                Some("the frequency of its course is not above zero")
            }
            _ => None,
        }
    }
}

/// The factor at a time between points.
fn between(points: &[[f64; 2]], time: f64) -> f64 {
    let after = points.partition_point(|point| point[0] <= time);
    match (after.checked_sub(1).map(|before| points[before]), points.get(after)) {
        (None, None) => 1.0,
        (None, Some(first)) => first[1],
        (Some(last), None) => last[1],
        (Some([t0, f0]), Some([t1, f1])) => f0 + (f1 - f0) * (time - t0) / (t1 - t0),
    }
}

/// Number of whole periods before a time, and the time [s] within the first period.
fn folded(points: &[[f64; 2]], time: f64) -> (f64, f64) {
    let [Some(first), Some(last)] = [points.first(), points.last()] else { return (0.0, time) };
    let (begin, period) = (first[0], last[0] - first[0]);
    if period <= 0.0 {
        return (0.0, time);
    }
    let periods = ((time - begin) / period).floor();
    // Rounding may put the rest just outside the period.
    (periods, (time - periods * period).clamp(begin, last[0]))
}

/// The integral of the factor from the first point to a time.
fn area(points: &[[f64; 2]], time: f64) -> f64 {
    let Some(&[begin, first]) = points.first() else { return time };
    if time <= begin {
        return first * (time - begin);
    }
    let mut area = 0.0;
    for pair in points.windows(2) {
        let ([t0, f0], [t1, _]) = (pair[0], pair[1]);
        if time <= t0 {
            return area;
        }
        let end = time.min(t1);
        area += 0.5 * (f0 + between(points, end)) * (end - t0);
    }
    let [end, last] = points[points.len() - 1];
    area + last * (time - end).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_2, PI};
    use proptest::prelude::*;

    #[test]
    fn a_course_is_linear_between_its_points_and_constant_outside() {
        assert_eq!(Course::default().at(7.0), 1.0);
        let course = Course::Points(vec![[1.0, 0.0], [3.0, 4.0]]);
        let at: Vec<f64> = [0.0, 1.0, 2.0, 3.0, 9.0].map(|t| course.at(t)).to_vec();
        assert_eq!(at, [0.0, 0.0, 2.0, 4.0, 4.0]);
        assert_eq!([2.0, 3.0, 5.0].map(|t| course.integral(t)), [1.0, 4.0, 12.0]);
    }

    #[test]
    fn what_repeats_is_the_same_a_period_later() {
        let course = Course::Repeat(vec![[1.0, 0.0], [2.0, 2.0], [5.0, -1.0]]);
        assert_eq!([1.5, 5.5, -2.5, 3.0].map(|t| course.at(t)), [1.0, 1.0, 1.0, 1.0]);
        let period = course.integral(7.3) - course.integral(3.3);
        assert!((period - 2.5).abs() < 1e-12, "{period}");
        assert_eq!(course.largest(), 2.0);
    }

    #[test]
    fn a_sine_has_mean_amplitude_frequency_and_phase() {
        let sine = Sine { amplitude: 2.0, phase: FRAC_PI_2, mean: 0.5, ..Sine::new(0.25) };
        let course = Course::Sine(sine);
        for (time, factor) in [(0.0, 2.5), (1.0, 0.5), (2.0, -1.5), (400_001.0, 0.5)] {
            assert!((course.at(time) - factor).abs() < 1e-10, "{time}: {}", course.at(time));
        }
        assert!((course.integral(1.0) - (0.5 + 2.0 * 4.0 / (2.0 * PI))).abs() < 1e-14);
        assert_eq!(course.largest(), 2.5);
    }

    proptest! {
        /// Integrals are those of the factors, by the midpoints of many short steps.
        #[test]
        fn integrals_are_of_the_factors(
            points in prop::collection::vec((0.1..2.0f64, -3.0..3.0f64), 2..6),
            (frequency, amplitude, phase, mean) in (0.1..2.0f64, -2.0..2.0f64, -4.0..4.0f64, -1.0..1.0f64),
            begin in -3.0..3.0f64,
            end in 0.0..9.0f64,
        ) {
            let mut time = begin;
            let points: Vec<[f64; 2]> = points.iter().map(|&(step, f)| { time += step; [time, f] }).collect();
            let sine = Sine { frequency, amplitude, phase, mean };
            for course in [Course::Points(points.clone()), Course::Repeat(points), Course::Sine(sine)] {
                prop_assert_eq!(course.flaw(), None);
                let count = 20_000;
                let step = end / f64::from(count);
                let sum: f64 = (0..count).map(|k| course.at((f64::from(k) + 0.5) * step) * step).sum();
                // A step in which a course that repeats jumps is off by half the jump at most.
                let jumps = match &course {
                    Course::Repeat(points) => {
                        let (first, last) = (points[0], points[points.len() - 1]);
                        (end / (last[0] - first[0]) + 1.0) * (last[1] - first[1]).abs()
                    }
                    _ => 0.0,
                };
                let bound = 5e-3 + 0.5 * step * jumps;
                prop_assert!((course.integral(end) - sum).abs() < bound, "{course:?}: {} {sum}", course.integral(end));
                let most = (0..count).map(|k| course.at(f64::from(k) * step).abs()).fold(0.0, f64::max);
                prop_assert!(most <= course.largest() + 1e-12);
            }
        }
    }

    #[test]
    fn a_flaw_is_named() {
        let flaw = |course: Course| course.flaw().unwrap();
        assert!(flaw(Course::Points(vec![[1.0, 0.0], [1.0, 1.0]])).contains("ascend"));
        assert!(flaw(Course::Repeat(vec![[1.0, 0.0]])).contains("two points"));
        assert!(flaw(Course::Sine(Sine::new(0.0))).contains("frequency"));
        assert!(flaw(Course::Sine(Sine::new(f64::NAN))).contains("finite"));
    }
}
