//! The manifest's forms of what changes with time.

use super::bodies::MotionPointTable;
use super::forms::read_by_form;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::units::{Angle, Frequency, Time};

/// A factor over time: points, between which it is linear, or a formula.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub(in super::super) enum CourseEntry {
    /// Points in the order of time: `[["0 s", 0.0], ["1 s", 1.0]]`; constant before the first and
    /// after the last.
    Points(Vec<(Time, f64)>),
    /// A formula.
    Formula(FormulaTable),
}

/// Velocities over time: points, between which they are linear, or a formula for the factor of
/// constant ones.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub(in super::super) enum MotionCourseEntry {
    /// Velocities at times.
    Points(Vec<MotionPointTable>),
    /// A formula for the factor of the velocities that are given.
    Formula(FormulaTable),
}

/// A factor over time by a formula. Exactly one of its keys.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct FormulaTable {
    /// A sine: `mean + amplitude sin(2 pi frequency t + phase)`.
    pub sine: Option<SineTable>,
    /// A rise or a fall, linear between two times and constant before and after.
    pub ramp: Option<RampTable>,
    /// Points that come again and again, linear between them: `[["0 s", 0.0], ["1 s", 1.0], ["3 s",
    /// 0.0]]`; the time from the first to the last is the period.
    pub repeat: Option<Vec<(Time, f64)>>,
}

/// A sine. Exactly one of `frequency` and `period`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct SineTable {
    /// How often it comes in a second.
    pub frequency: Option<Frequency>,
    /// How long it takes once.
    pub period: Option<Time>,
    /// Amplitude (default: 1).
    pub amplitude: Option<f64>,
    /// Phase at time zero (default: 0, where it rises through its mean; a cosine has 90 deg).
    pub phase: Option<Angle>,
    /// Mean (default: 0).
    pub mean: Option<f64>,
}

/// A rise or a fall.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct RampTable {
    /// When it begins (default: at the start).
    pub begin: Option<Time>,
    /// When it ends. Required.
    pub end: Option<Time>,
    /// Factor before (default: 0).
    pub from: Option<f64>,
    /// Factor after (default: 1).
    pub to: Option<f64>,
}

const EXPECTED: &str = "a list of points, or a table with sine, ramp or repeat";

read_by_form!(CourseEntry: EXPECTED, List => Points, Table => Formula);

read_by_form!(MotionCourseEntry: EXPECTED, List => Points, Table => Formula);
