//! Checks of what changes with time: factors, and motions.

use super::super::document::{MotionName, MotionPointTable};
use super::super::path;
use super::super::read::Findings;
use tremie_messages::scene::{Course, Motion, MotionPoint};
use tremie_messages::units::Time;

/// The factor over time of a table with the keys `ramp` and `course`.
pub(super) fn course(
    ramp: Option<Time>,
    points: Option<&[(Time, f64)]>,
    at: &str,
    findings: &mut Findings,
) -> Option<Course> {
    let key = path::join(at, "course");
    match (ramp, points) {
        (Some(_), Some(_)) => {
            findings.problem(&key, "found both ramp and course, expected one of them");
            None
        }
        (Some(ramp), None) => findings
            .above_zero(ramp, &path::join(at, "ramp"))
            .then(|| Course(vec![[0.0, 0.0], [ramp.0, 1.0]])),
        (None, Some([])) => {
            findings.problem(&key, "found an empty list, expected points as [\"0 s\", 1.0]");
            None
        }
        (None, Some(points)) => {
            let points: Vec<[f64; 2]> = points.iter().map(|(time, f)| [time.0, *f]).collect();
            let times = points.iter().map(|point| point[0]);
            in_order(times, &key, findings).then_some(Course(points))
        }
        (None, None) => Some(Course::default()),
    }
}

/// Whether times [s] ascend; a problem at the first that does not.
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

/// A motion by its name, and the course that a prescribed one may have.
pub(super) fn motion(
    name: MotionName,
    course: Option<&[MotionPointTable]>,
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
        MotionName::Prescribed => {
            points(course.unwrap_or(&[]), &key, findings).map(Motion::Prescribed)
        }
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
