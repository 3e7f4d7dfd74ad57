//! Columns: numbers that are taken of the signals of each run.

use super::file::{ColumnTable, Reduction};
use crate::manifest::Limit;
use crate::tools::validation::case::Take;
use crate::tools::validation::measure::{first_time, reduce};
use tremie_messages::start::Signal;
use tremie_messages::{Problem, nearest};
use tremie_results::Signals;

/// A column of the table of runs.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyColumn {
    /// Its name.
    pub name: String,
    /// The signal, `component.name`.
    pub signal: String,
    /// SI unit of the numbers; empty until the signals are known.
    pub unit: String,
    of: ColumnKind,
    /// Simulated times between which the signal counts [s].
    from: f64,
    until: f64,
}

/// What a column takes of its signal.
#[derive(Clone, Debug, PartialEq)]
enum ColumnKind {
    Value(Take),
    /// The first time at which it meets a limit [s].
    Crossing(Limit),
    /// The value when another signal first meets a limit.
    At(String, Limit),
}

impl StudyColumn {
    /// Reads a column. What is wrong goes to `problems`.
    pub fn read(name: &str, table: &ColumnTable, problems: &mut Vec<Problem>) -> Option<Self> {
        let at = format!("columns.{name}");
        let mut wrong = |key: &str, message: String, help: &str| {
            problems.push(Problem::new(format!("{at}{key}"), message).help(help));
        };
        let example = "write { signal = \"grains.max_speed\", of = \"max\" }";
        let (Some(signal), Some(of)) = (&table.signal, table.of) else {
            wrong("", "needs a signal and of".into(), example);
            return None;
        };
        let from = table.from.map_or(0.0, |time| time.0);
        let until = table.until.map_or(f64::INFINITY, |time| time.0);
        if from >= until {
            let message = format!("ends at {until} s, not after {from} s, where it begins");
            wrong(".until", message, "give a later time, or leave it out");
        }
        let limit = match (table.above, table.below) {
            (Some(bound), None) => Some(Limit::Above(bound)),
            (None, Some(bound)) => Some(Limit::Below(bound)),
            _ => None,
        };
        let has_bound = table.above.is_some() || table.below.is_some();
        let kind = match (kind_of(of), &table.when, limit) {
            (Some(take), None, _) if !has_bound => ColumnKind::Value(take),
            (Some(_), ..) => {
                let help = "leave when, above and below out, or write of = \"crossing\" or \"at\"";
                wrong("", "only a crossing has a bound".into(), help);
                return None;
            }
            (None, None, Some(limit)) if of == Reduction::Crossing => ColumnKind::Crossing(limit),
            (None, Some(when), Some(limit)) if of == Reduction::At => {
                ColumnKind::At(when.clone(), limit)
            }
            (None, ..) if of == Reduction::At => {
                let help =
                    "write when = \"grains.valve.lift\", above = 1e-4, in that signal's SI unit";
                wrong(
                    "",
                    "a value at a crossing needs when, and either above or below".into(),
                    help,
                );
                return None;
            }
            (None, ..) => {
                let help = "write above = 1e-4, in the signal's SI unit";
                wrong("", "a crossing needs either above or below, of its own signal".into(), help);
                return None;
            }
        };
        let (name, signal) = (name.to_string(), signal.clone());
        Some(Self { name, signal, unit: String::new(), of: kind, from, until })
    }

    /// Takes the unit from the signals of a run: component and signal of each.
    ///
    /// # Errors
    /// A problem, where the run has no such signal.
    pub fn find_signal(&mut self, signals: &[(String, Signal)]) -> Result<(), Problem> {
        let full = |(component, signal): &(String, Signal)| format!("{component}.{}", signal.name);
        let names: Vec<String> = signals.iter().map(full).collect();
        let find = |key: &str, wanted: &str| {
            names.iter().position(|name| name == wanted).ok_or_else(|| {
                let known: Vec<&str> = names.iter().map(String::as_str).collect();
                let message = format!("no run has a signal \"{wanted}\"");
                let problem = Problem::new(format!("columns.{}.{key}", self.name), message);
                problem.help(match nearest(wanted, &known) {
                    Some(near) => format!("did you mean \"{near}\"?"),
                    None => "`tremie signals MANIFEST` lists those of a manifest".into(),
                })
            })
        };
        let own = find("signal", &self.signal)?;
        if let ColumnKind::At(when, _) = &self.of {
            find("when", when)?;
        }
        let is_time = matches!(self.of, ColumnKind::Crossing(_));
        self.unit = if is_time { "s".into() } else { signals[own].1.unit.clone() };
        Ok(())
    }

    /// The number of a run; `None` where the signal is not there, has no values in the time that
    /// counts, or never meets the limit.
    pub fn measure(&self, signals: &Signals) -> Option<f64> {
        let points = |signal: &str| -> Option<Vec<(f64, f64)>> {
            let column = signals.column(signal).ok()?;
            let counts = |(time, _): &(f64, f64)| (self.from..=self.until).contains(time);
            let points = signals.times.iter().copied().zip(column.iter().copied());
            Some(points.filter(counts).collect())
        };
        let own = points(&self.signal)?;
        let value = match &self.of {
            ColumnKind::Value(take) => reduce(*take, &own),
            ColumnKind::Crossing(limit) => first_time(own, *limit),
            ColumnKind::At(when, limit) => {
                let at = first_time(points(when)?, *limit)?;
                own.into_iter().find(|(time, _)| *time >= at).map(|(_, value)| value)
            }
        };
        value.filter(|value| value.is_finite())
    }

    /// Its heading, with the unit.
    pub fn heading(&self) -> String {
        format!("{} [{}]", self.name, self.unit)
    }
}

/// The reduction as validation knows it; `None` for what depends on a crossing.
fn kind_of(of: Reduction) -> Option<Take> {
    match of {
        Reduction::Max => Some(Take::Max),
        Reduction::Min => Some(Take::Min),
        Reduction::Mean => Some(Take::Mean),
        Reduction::Last => Some(Take::Last),
        Reduction::Range => Some(Take::PeakToPeak),
        Reduction::Crossing | Reduction::At => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(text: &str) -> Result<StudyColumn, Vec<Problem>> {
        let table: ColumnTable = toml::from_str(text).unwrap();
        let mut problems = Vec::new();
        let column = StudyColumn::read("lift", &table, &mut problems);
        if problems.is_empty() { Ok(column.unwrap()) } else { Err(problems) }
    }

    /// A signal that falls to -1, rises to 3 and ends at 2.
    fn signals() -> Signals {
        let times = vec![0.0, 1.0, 2.0, 3.0, 4.0];
        let columns = [
            ("a.b".to_string(), vec![0.0, -1.0, 1.0, 3.0, 2.0]),
            ("a.none".to_string(), vec![f64::NAN; 5]),
            ("a.lift".to_string(), vec![0.0, 1.0, 2.0, 3.0, 4.0]),
        ];
        Signals { times, columns: columns.into(), ..Signals::default() }
    }

    #[test]
    fn signals_become_numbers() {
        let value =
            |more: &str| column(&format!("signal = 'a.b'\n{more}")).unwrap().measure(&signals());
        assert_eq!(value("of = 'max'"), Some(3.0));
        assert_eq!(value("of = 'min'"), Some(-1.0));
        assert_eq!(value("of = 'mean'"), Some(1.0));
        assert_eq!(value("of = 'last'"), Some(2.0));
        assert_eq!(value("of = 'range'"), Some(4.0));
        assert_eq!(value("of = 'max'\nuntil = '2 s'"), Some(1.0));
        assert_eq!(value("of = 'min'\nfrom = '2 s'"), Some(1.0));
        assert_eq!(value("of = 'crossing'\nabove = 0.5"), Some(2.0));
        assert_eq!(value("of = 'crossing'\nbelow = -0.5"), Some(1.0));
        assert_eq!(value("of = 'crossing'\nbelow = 2.5\nfrom = '3 s'"), Some(4.0));
        assert_eq!(value("of = 'crossing'\nabove = 5.0"), None);
        assert_eq!(value("of = 'max'\nfrom = '9 s'"), None);
        assert_eq!(value("of = 'at'\nwhen = 'a.lift'\nabove = 2.5"), Some(3.0));
        assert_eq!(value("of = 'at'\nwhen = 'a.lift'\nabove = 4.5"), None);
    }

    #[test]
    fn what_is_no_number_is_an_empty_cell() {
        let of = |signal: &str| {
            column(&format!("signal = '{signal}'\nof = 'last'")).unwrap().measure(&signals())
        };
        assert_eq!((of("a.none"), of("a.c")), (None, None));
    }

    #[test]
    fn a_wrong_column_is_refused_with_its_place() {
        for (text, key, words) in [
            ("signal = 'a.b'", "columns.lift", "needs a signal and of"),
            ("of = 'max'", "columns.lift", "needs a signal and of"),
            ("signal = 'a.b'\nof = 'crossing'", "columns.lift", "above or below"),
            ("signal = 'a.b'\nof = 'max'\nabove = 1.0", "columns.lift", "only a crossing"),
            ("signal = 'a.b'\nof = 'max'\nwhen = 'a.lift'", "columns.lift", "only a crossing"),
            ("signal = 'a.b'\nof = 'at'\nabove = 1.0", "columns.lift", "needs when"),
            (
                "signal = 'a.b'\nof = 'crossing'\nwhen = 'a.lift'\nabove = 1.0",
                "columns.lift",
                "of its own signal",
            ),
            (
                "signal = 'a.b'\nof = 'max'\nfrom = '2 s'\nuntil = '1 s'",
                "columns.lift.until",
                "ends at 1 s",
            ),
        ] {
            let problems = column(text).unwrap_err();
            assert_eq!(problems.len(), 1, "{problems:?}");
            assert!(problems[0].key == key && problems[0].message.contains(words), "{problems:?}");
        }
    }

    #[test]
    fn a_column_finds_its_signal_and_unit() {
        let signal = Signal::new("b", "m", &[]);
        let signals = [("a".to_string(), signal)];
        let mut lift = column("signal = 'a.b'\nof = 'max'").unwrap();
        lift.find_signal(&signals).unwrap();
        assert_eq!(lift.heading(), "lift [m]");
        let mut delay = column("signal = 'a.b'\nof = 'crossing'\nabove = 1.0").unwrap();
        delay.find_signal(&signals).unwrap();
        assert_eq!(delay.heading(), "lift [s]");
        let problem = column("signal = 'a.v'\nof = 'max'").unwrap().find_signal(&signals);
        assert_eq!(problem.unwrap_err().help.unwrap(), "did you mean \"a.b\"?");
        let at = "signal = 'a.b'\nof = 'at'\nwhen = 'a.lift'\nabove = 1.0";
        let problem = column(at).unwrap().find_signal(&signals).unwrap_err();
        assert_eq!(problem.key, "columns.lift.when");
    }
}
