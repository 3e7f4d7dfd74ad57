//! Two tables of signals, compared row by row.

use serde::Serialize;
use tremie_results::Signals;

/// Most signals of a row that are listed.
const LISTED: usize = 8;

/// A signal that differs in the first row that does.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SignalDifference {
    /// Its name.
    pub name: String,
    /// Its SI unit.
    pub unit: String,
    /// Its value in the first run.
    pub one: f64,
    /// Its value in the second.
    pub other: f64,
}

/// What differs between two tables of signals. Rows are compared where both have one of that time.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SignalComparison {
    /// Rows that were compared.
    pub rows: usize,
    /// Signals that both have.
    pub signals: usize,
    /// Simulated time of the first row that differs [s].
    pub time: Option<f64>,
    /// Signals that differ in it: the first of them.
    pub first: Vec<SignalDifference>,
    /// Number of all that differ in it.
    pub count: usize,
    /// Signals that only one of the runs has.
    pub unmatched: Vec<String>,
}

/// Compares two tables up to the first row that differs.
pub fn compare_signals(one: &Signals, other: &Signals) -> SignalComparison {
    let mut found = SignalComparison::default();
    let both: Vec<_> = one
        .columns
        .iter()
        .filter_map(|(name, column)| Some((name, column, other.columns.get(name)?)))
        .collect();
    found.signals = both.len();
    let all = one.columns.keys().chain(other.columns.keys());
    let is_alone =
        |name: &&String| one.columns.contains_key(*name) != other.columns.contains_key(*name);
    found.unmatched = all.filter(is_alone).cloned().collect();
    for (i, j) in common_rows(&one.times, &other.times) {
        found.rows += 1;
        let differing = both.iter().filter(|(_, a, b)| !is_same(a[i], b[j]));
        for (name, a, b) in differing {
            found.count += 1;
            if found.first.len() < LISTED {
                let unit = one.units.get(*name).cloned().unwrap_or_default();
                let name = (*name).clone();
                found.first.push(SignalDifference { name, unit, one: a[i], other: b[j] });
            }
        }
        if found.count > 0 {
            found.time = Some(one.times[i]);
            break;
        }
    }
    found
}

/// Indices of rows of the same time, in order.
fn common_rows(one: &[f64], other: &[f64]) -> Vec<(usize, usize)> {
    let (mut i, mut j, mut common) = (0, 0, Vec::new());
    while let (Some(a), Some(b)) = (one.get(i), other.get(j)) {
        if a == b {
            common.push((i, j));
        }
        (i, j) = (i + usize::from(a <= b), j + usize::from(b <= a));
        if a.is_nan() || b.is_nan() {
            break;
        }
    }
    common
}

/// True if both are the same number, or none.
fn is_same(one: f64, other: f64) -> bool {
    one.to_bits() == other.to_bits() || one.is_nan() && other.is_nan()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Signals {
        Signals::parse(text.as_bytes()).unwrap()
    }

    const ONE: &str =
        "window,time [s],a.x [m],a.y [m]\n1,0.1,1.0,2.0\n2,0.2,1.5,NaN\n3,0.3,1.25,2.5\n";

    #[test]
    fn equal_tables_have_no_difference() {
        let found = compare_signals(&table(ONE), &table(ONE));
        assert_eq!((found.rows, found.signals, found.time), (3, 2, None));
    }

    #[test]
    fn the_first_row_that_differs_is_found_by_its_time() {
        // Every other row, and another value in the last.
        let other = "window,time [s],a.x [m],b.z [m]\n1,0.1,1.0,7.0\n3,0.3,1.5,7.0\n";
        let found = compare_signals(&table(ONE), &table(other));
        assert_eq!((found.rows, found.signals, found.time), (2, 1, Some(0.3)));
        assert_eq!(found.first[0].name, "a.x");
        assert_eq!((found.first[0].one, found.first[0].other), (1.25, 1.5));
        assert_eq!(found.unmatched, ["a.y", "b.z"]);
    }
}
