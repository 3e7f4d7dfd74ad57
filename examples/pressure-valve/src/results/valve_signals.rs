//! Signals of a valve among those of a run.

use tremie_results::Signals;

/// Names that the user gave.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Asked {
    /// The part that slides.
    pub part: Option<String>,
    /// Probe or reservoir of the pressure upstream.
    pub upstream: Option<String>,
    /// Probe or reservoir of the pressure downstream.
    pub downstream: Option<String>,
    /// The probe that measures the rate of flow.
    pub flow: Option<String>,
}

/// Names of a valve's signals.
#[derive(Clone, Debug, PartialEq)]
pub struct Watched {
    /// Its part.
    pub part: String,
    /// Its lift.
    pub lift: String,
    /// Pressure upstream.
    pub upstream: String,
    /// Pressure downstream; gauge zero where there is none.
    pub downstream: Option<String>,
    /// Rate of flow.
    pub flow: Option<String>,
    /// Forces on the valve along its axis.
    pub forces: Vec<String>,
}

impl Watched {
    /// The signals that were asked for. For a name that is not given: the only part that slides,
    /// the only reservoir, the only probe of a rate of flow.
    ///
    /// # Errors
    /// A sentence, where there is none or there are several.
    pub fn find(signals: &Signals, asked: &Asked) -> Result<Self, String> {
        let part = one(
            signals,
            ["grains.", ".lift"],
            "",
            asked.part.as_ref(),
            ["--part", "part that slides"],
        )?;
        let pressure = ["fluid.", ".pressure"];
        let upstream = one(
            signals,
            pressure,
            "reservoir",
            asked.upstream.as_ref(),
            ["--upstream", "reservoir"],
        )?;
        let downstream = asked
            .downstream
            .as_ref()
            .map(|name| one(signals, pressure, "", Some(name), ["--downstream", ""]));
        let flows = ["fluid.", ".flow_rate"];
        // A run without a probe of a flow still has lifts and pressures.
        let flow = match named(signals, flows, "").next() {
            None if asked.flow.is_none() => None,
            _ => Some(one(
                signals,
                flows,
                "",
                asked.flow.as_ref(),
                ["--flow", "probe of a rate of flow"],
            )?),
        };
        let own = format!("grains.{part}.");
        let is_force =
            |name: &&String| name.strip_prefix(&own).is_some_and(|what| what.ends_with("_force"));
        Ok(Self {
            lift: format!("grains.{part}.lift"),
            part,
            upstream: format!("fluid.{upstream}.pressure"),
            downstream: downstream.transpose()?.map(|name| format!("fluid.{name}.pressure")),
            flow: flow.map(|name| format!("fluid.{name}.flow_rate")),
            forces: signals.columns.keys().filter(is_force).cloned().collect(),
        })
    }
}

/// Parts of signals' names between two ends, where they begin with `kind`.
fn named<'a>(
    signals: &'a Signals,
    [head, tail]: [&'a str; 2],
    kind: &'a str,
) -> impl Iterator<Item = &'a str> {
    let between = move |name: &'a String| name.strip_prefix(head)?.strip_suffix(tail);
    signals.columns.keys().filter_map(between).filter(move |name| name.starts_with(kind))
}

/// The name that was asked for, or the only one of a kind.
fn one(
    signals: &Signals,
    ends: [&str; 2],
    kind: &str,
    asked: Option<&String>,
    [option, what]: [&str; 2],
) -> Result<String, String> {
    let listed = |names: &[&str]| names.join(", ");
    if let Some(asked) = asked {
        let all: Vec<&str> = named(signals, ends, "").collect();
        let unknown = || {
            format!(
                "{option} {asked}: the run has no such signal; it has those of {}",
                listed(&all)
            )
        };
        return if all.contains(&asked.as_str()) { Ok(asked.clone()) } else { Err(unknown()) };
    }
    match named(signals, ends, kind).collect::<Vec<_>>()[..] {
        [only] => Ok(only.into()),
        [] => {
            let all: Vec<&str> = named(signals, ends, "").collect();
            let rest =
                if all.is_empty() { String::new() } else { format!(": one of {}", listed(&all)) };
            Err(format!("the run has no {what}; say which with {option}{rest}"))
        }
        ref several => Err(format!(
            "the run has more than one {what}; say which with {option}: {}",
            listed(several)
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signals(names: &[&str]) -> Signals {
        let columns = names.iter().map(|name| ((*name).to_string(), vec![0.0])).collect();
        Signals { times: vec![0.0], columns, ..Signals::default() }
    }

    #[test]
    fn the_only_one_of_a_kind_is_meant() {
        let run = signals(&[
            "fluid.beneath.pressure",
            "fluid.outflow.flow_rate",
            "fluid.outflow.pressure",
            "fluid.reservoir_z_lower.pressure",
            "grains.valve.lift",
            "grains.valve.spring_force",
        ]);
        let found = Watched::find(&run, &Asked::default()).unwrap();
        assert_eq!(found.upstream, "fluid.reservoir_z_lower.pressure");
        assert_eq!(
            (found.part.as_str(), found.flow.as_deref()),
            ("valve", Some("fluid.outflow.flow_rate"))
        );
        assert_eq!(found.forces, ["grains.valve.spring_force"]);
        let asked = Asked { upstream: Some("beneath".into()), ..Asked::default() };
        assert_eq!(Watched::find(&run, &asked).unwrap().upstream, "fluid.beneath.pressure");
        let asked = Asked { downstream: Some("above".into()), ..Asked::default() };
        let error = Watched::find(&run, &asked).unwrap_err();
        assert!(
            error.contains("--downstream above") && error.contains("beneath, outflow"),
            "{error}"
        );
    }

    #[test]
    fn what_is_not_clear_is_asked_for() {
        let two = signals(&["fluid.p.pressure", "grains.a.lift", "grains.b.lift"]);
        let error = Watched::find(&two, &Asked::default()).unwrap_err();
        assert!(error.contains("--part: a, b"), "{error}");
        let asked = Asked { part: Some("a".into()), ..Asked::default() };
        let error = Watched::find(&two, &asked).unwrap_err();
        assert!(error.contains("--upstream: one of p"), "{error}");
        let none = signals(&["fluid.p.pressure"]);
        assert!(
            Watched::find(&none, &Asked::default()).unwrap_err().contains("no part that slides")
        );
    }
}
