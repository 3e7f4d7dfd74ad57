//! A signal is one row of a table.

/// Name, unit, meaning, and how to read its value from a state.
pub type SignalRow<S> = (&'static str, &'static str, &'static str, fn(&S) -> f64);
