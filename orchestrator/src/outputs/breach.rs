//! Breach: a watched quantity that has passed its limit.

use serde::Serialize;
use tremie_messages::finding::short;
use tremie_messages::start::{Fault, FaultKind};
use tremie_messages::{Place, WatchedQuantity};

/// A watched quantity that has passed its limit, and so ended a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Breach {
    /// Component whose signal it is.
    pub component: String,
    /// Full name of the signal, `component.signal`.
    pub signal: String,
    /// Quantity: its key in the manifest's table `watch`.
    pub quantity: WatchedQuantity,
    /// What the signal is, a few words.
    pub what: String,
    /// Its value.
    pub value: f64,
    /// SI unit, `1` if it has none.
    pub unit: String,
    /// Limit that it has passed.
    pub limit: f64,
    /// Window at whose end it was so.
    pub window: u64,
    /// Where it was so.
    #[serde(skip_serializing_if = "Place::is_unknown")]
    pub place: Place,
    /// Reason for the limit, and remedy.
    #[serde(skip)]
    pub advice: [String; 2],
    /// Window of the newest checkpoint from before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub checkpoint: Option<u64>,
}

impl Breach {
    /// The fault that it is.
    pub fn fault(&self) -> Fault {
        let [why, remedy] = &self.advice;
        let advice = [("", why), ("what helps: ", remedy)].map(|(before, text)| match text.len() {
            0 => String::new(),
            _ => format!("; {before}{text}"),
        });
        Fault {
            kind: FaultKind::Physics,
            noticed_by: self.component.clone(),
            blamed: self.component.clone(),
            window: self.window,
            message: format!("{}{}", self.sentence(), advice.concat()),
        }
    }

    fn sentence(&self) -> String {
        let Self { what, quantity, place, .. } = self;
        let [value, limit] = [self.value, self.limit].map(|value| with_unit(value, &self.unit));
        format!("{what}{place} is {value}, above the limit of {limit} (watch.{quantity})")
    }

    /// How to go on from before it: the text after `tremie resume OUT`, and what that does.
    pub fn resumption(&self) -> Option<[String; 2]> {
        let Self { quantity, checkpoint, .. } = self;
        let window = (*checkpoint)?;
        // Twice what was found: the next number that a user would try, too.
        let higher: f64 = format!("{:.1e}", 2.0 * self.value).parse().unwrap_or(f64::MAX);
        let options = format!(" --at {window} --set watch.{quantity}={}", short(higher));
        let effect = format!(
            "goes on from window {window}, before that, under a higher limit; with `--view web` it can be watched, and \
             `--set outputs.frames=TIME` shows more of it"
        );
        Some([options, effect])
    }
}

/// A number with its unit.
pub fn with_unit(value: f64, unit: &str) -> String {
    if unit == "1" { short(value) } else { format!("{} {unit}", short(value)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn breach() -> Breach {
        Breach {
            component: "fluid".into(),
            signal: "fluid.max_mach".into(),
            quantity: WatchedQuantity::Mach,
            what: "largest Mach number".into(),
            value: 0.1834,
            unit: "1".into(),
            limit: 0.17,
            window: 812,
            place: Place::at([0.01, 0.02, 0.0]),
            advice: ["compressible".into(), "a shorter step".into()],
            checkpoint: Some(800),
        }
    }

    #[test]
    fn its_fault_says_what_where_found_expected_and_what_to_do() {
        let fault = breach().fault();
        assert_eq!((fault.kind, fault.window), (FaultKind::Physics, 812));
        assert_eq!(
            fault.to_string(),
            "fluid failed at window 812: largest Mach number at (0.01, 0.02, 0) m is 0.1834, above the limit of 0.17 \
             (watch.mach); compressible; what helps: a shorter step"
        );
    }

    #[test]
    fn a_run_goes_on_from_before_it() {
        let [options, effect] = breach().resumption().unwrap();
        assert_eq!(options, " --at 800 --set watch.mach=0.37");
        assert!(effect.contains("window 800"), "{effect}");
        assert_eq!(Breach { checkpoint: None, ..breach() }.resumption(), None);
    }
}
