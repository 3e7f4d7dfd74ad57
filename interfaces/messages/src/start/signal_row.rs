//! Signals as rows of a table: one row each, so that name, unit, meaning and value stand together.

use super::Signal;

/// Name, unit, meaning, and how to read the value from a state.
pub type SignalRow<S> = (&'static str, &'static str, &'static str, fn(&S) -> f64);

/// Describes the signals of a table; each is named by what stands before its name.
pub fn describe<S>(rows: &[SignalRow<S>], before: &str) -> impl Iterator<Item = Signal> {
    rows.iter().map(move |(name, unit, meaning, _)| Signal {
        name: format!("{before}{name}"),
        unit: (*unit).into(),
        meaning: (*meaning).into(),
        sampled: false,
    })
}

/// Appends the values of a table, in its order.
pub fn push<S>(rows: &[SignalRow<S>], of: &S, values: &mut Vec<f64>) {
    values.extend(rows.iter().map(|(_, _, _, value)| value(of)));
}
