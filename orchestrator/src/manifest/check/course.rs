//! Checks of what changes with time: factors, and motions.

use super::super::document::{
    CourseEntry, FormulaTable, MotionCourseEntry, MotionName, MotionPointTable, RampTable,
    SineTable,
};
use super::super::path;
use super::super::read::Findings;
use tremie_messages::scene::{Course, Motion, MotionPoint, Sine, TimedMotion};
use tremie_messages::units::Time;

/// The factor over time of a table with the keys `ramp` and `course`.
pub(super) fn course(
    ramp: Option<Time>,
    entry: Option<&CourseEntry>,
    at: &str,
    findings: &mut Findings,
) -> Option<Course> {
    let key = path::join(at, "course");
    match (ramp, entry) {
        (Some(_), Some(_)) => {
            findings.problem(&key, "found both ramp and course, expected one of them");
            None
        }
        (Some(ramp), None) => findings
            .above_zero(ramp, &path::join(at, "ramp"))
            .then(|| Course::Points(vec![[0.0, 0.0], [ramp.0, 1.0]])),
        (None, Some(CourseEntry::Points(points))) if points.is_empty() => {
            findings.problem(&key, "found an empty list, expected points as [\"0 s\", 1.0]");
            None
        }
        (None, Some(CourseEntry::Points(points))) => {
            ascending(points, &key, findings).map(Course::Points)
        }
        (None, Some(CourseEntry::Formula(table))) => formula(table, &key, findings),
        (None, None) => Some(Course::default()),
    }
}

/// The factor that a formula says.
fn formula(table: &FormulaTable, at: &str, findings: &mut Findings) -> Option<Course> {
    let kinds = [
        ("sine", table.sine.is_some()),
        ("ramp", table.ramp.is_some()),
        ("repeat", table.repeat.is_some()),
    ];
    let kind = findings.only_one(&kinds, "how the factor changes with time", at)?;
    let key = path::join(at, kind);
    match kind {
        "sine" => sine(table.sine.as_ref()?, &key, findings).map(Course::Sine),
        "ramp" => ramp(table.ramp.as_ref()?, &key, findings).map(Course::Points),
        _ => {
            let points = ascending(table.repeat.as_ref()?, &key, findings)?;
            if points.len() < 2 {
                let message = format!(
                    "found {}, expected two points or more: the time from the first to the last is the period",
                    if points.is_empty() { "an empty list" } else { "one point" }
                );
                findings.problem(&key, message);
                return None;
            }
            Some(Course::Repeat(points))
        }
    }
}

fn sine(table: &SineTable, at: &str, findings: &mut Findings) -> Option<Sine> {
    let kinds = [("frequency", table.frequency.is_some()), ("period", table.period.is_some())];
    let kind = findings.only_one(&kinds, "how often it comes", at)?;
    let key = path::join(at, kind);
    let frequency = match (table.frequency, table.period) {
        (Some(frequency), _) => findings.above_zero(frequency, &key).then_some(frequency.0)?,
        (None, period) => findings.above_zero(period?, &key).then_some(1.0 / period?.0)?,
    };
    Some(Sine {
        frequency,
        amplitude: table.amplitude.unwrap_or(1.0),
        phase: table.phase.map_or(0.0, |phase| phase.0),
        mean: table.mean.unwrap_or(0.0),
    })
}

fn ramp(table: &RampTable, at: &str, findings: &mut Findings) -> Option<Vec<[f64; 2]>> {
    let (begin, end) =
        (table.begin.map_or(0.0, |time| time.0), findings.required(&table.end, at, "end")?);
    if end.0 <= begin {
        let message = format!("found {end}, expected a time after the begin at {begin} s");
        findings.problem(&path::join(at, "end"), message);
        return None;
    }
    Some(vec![[begin, table.from.unwrap_or(0.0)], [end.0, table.to.unwrap_or(1.0)]])
}

/// Points whose times ascend.
fn ascending(points: &[(Time, f64)], at: &str, findings: &mut Findings) -> Option<Vec<[f64; 2]>> {
    let points: Vec<[f64; 2]> = points.iter().map(|(time, f)| [time.0, *f]).collect();
    in_order(points.iter().map(|point| point[0]), at, findings).then_some(points)
}

/// True if times [s] ascend; a problem at the first that does not.
fn in_order(times: impl Iterator<Item = f64>, at: &str, findings: &mut Findings) -> bool {
    let mut last = f64::NEG_INFINITY;
    for (i, time) in times.enumerate() {
        if time <= last {
            let message = format!("found {time} s after {last} s, expected times that ascend");
            findings.problem(&path::item(at, i), message);
            return false;
        }
        last = time;
    }
    true
}

/// A motion by its name, and the course that a prescribed one may have. Of one that a formula says,
/// the velocities are those of the bodies, and zero here.
pub(super) fn motion(
    name: MotionName,
    course: Option<&MotionCourseEntry>,
    at: &str,
    findings: &mut Findings,
) -> Option<Motion> {
    let key = path::join(at, "course");
    if course.is_some() && name != MotionName::Prescribed {
        let help = "write motion = \"prescribed\", or leave out the course";
        findings.problem_with_help(&key, "only a prescribed motion has a course", help);
        return None;
    }
    match name {
        MotionName::Free => Some(Motion::Free),
        MotionName::Fixed => Some(Motion::Fixed),
        MotionName::Prescribed => match course {
            None => Some(Motion::Prescribed(Vec::new())),
            Some(MotionCourseEntry::Points(tables)) => {
                points(tables, &key, findings).map(Motion::Prescribed)
            }
            Some(MotionCourseEntry::Formula(table)) => {
                let course = formula(table, &key, findings)?;
                let (velocity, angular_velocity) = ([0.0; 3], [0.0; 3]);
                let timed = TimedMotion { velocity, angular_velocity, course };
                Some(Motion::Timed(Box::new(timed)))
            }
        },
    }
}

fn points(
    tables: &[MotionPointTable],
    at: &str,
    findings: &mut Findings,
) -> Option<Vec<MotionPoint>> {
    let points: Vec<_> = (tables.iter().enumerate())
        .map(|(i, table)| {
            let time = findings.required(&table.time, &path::item(at, i), "time")?;
            Some(MotionPoint {
                time: time.0,
                velocity: table.velocity.unwrap_or_default().map(|v| v.0),
                angular_velocity: table.angular_velocity.unwrap_or_default().map(|w| w.0),
            })
        })
        .collect();
    let points: Vec<MotionPoint> = points.into_iter().collect::<Option<_>>()?;
    in_order(points.iter().map(|point| point.time), at, findings).then_some(points)
}
