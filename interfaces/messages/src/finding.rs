//! Findings: numbers with a verdict on how far a run can be trusted, and a remedy.

use crate::watch::WatchedQuantity;
use serde::{Deserialize, Serialize};

/// A number about a run, judged.
///
/// A component brings findings of its own in its description: relaxation time, cells across a
/// grain, steps in a collision. The orchestrator adds findings on the whole: fit of the steps,
/// memory, time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Finding {
    /// Name of the number, a few words in lower case: `relaxation time`. Unique in a component.
    pub quantity: String,
    /// Its value, in `unit`; finite.
    pub value: f64,
    /// SI unit, `1` if it has none.
    pub unit: String,
    /// Meaning for the results.
    pub verdict: Verdict,
    /// Reason for the verdict: a sentence with the bounds; empty where there is nothing to say.
    #[serde(default)]
    pub why: String,
    /// Remedy: a sentence with numbers and keys; empty where nothing need be done.
    #[serde(default)]
    pub remedy: String,
}

/// Verdict of a number on the results of a run. Later is worse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The number is as it should be.
    Ok,
    /// Results may be off by more than a few per cent, or the number is not what was meant.
    Doubtful,
    /// Results mean nothing, or the run will not end.
    Wrong,
}

impl Verdict {
    /// Its name in outputs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Doubtful => "doubtful",
            Self::Wrong => "wrong",
        }
    }
}

impl Finding {
    /// A number that is as it should be. One that is not finite is taken as the largest there is:
    /// JSON has no word for it.
    pub fn new(quantity: impl Into<String>, value: f64, unit: &str) -> Self {
        Self {
            quantity: quantity.into(),
            value: if value.is_nan() { 0.0 } else { value.clamp(f64::MIN, f64::MAX) },
            unit: unit.into(),
            verdict: Verdict::Ok,
            why: String::new(),
            remedy: String::new(),
        }
    }

    /// Gives the number a meaning, without judging it.
    pub fn because(mut self, why: impl Into<String>) -> Self {
        self.why = why.into();
        self
    }

    /// Judges the number, unless it was judged worse before.
    pub fn judged(
        mut self,
        verdict: Verdict,
        why: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        if verdict > self.verdict {
            (self.verdict, self.why, self.remedy) = (verdict, why.into(), remedy.into());
        }
        self
    }

    /// Judges the number doubtful if `doubtful` holds.
    pub fn doubtful_if(
        self,
        doubtful: bool,
        why: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        if doubtful { self.judged(Verdict::Doubtful, why, remedy) } else { self }
    }

    /// Judges the number wrong if `wrong` holds.
    pub fn wrong_if(self, wrong: bool, why: impl Into<String>, remedy: impl Into<String>) -> Self {
        if wrong { self.judged(Verdict::Wrong, why, remedy) } else { self }
    }

    /// The value with its unit.
    pub fn value_text(&self) -> String {
        let value = short(self.value);
        if self.unit == "1" { value } else { format!("{value} {}", self.unit) }
    }
}

/// A number as a person would write it, with six digits at most: a relaxation time of 0.500004 is
/// not one of 0.5.
pub fn short(value: f64) -> String {
    // Rounded through its text: dividing by a power of ten would leave stray digits.
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    if rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

/// Limit of a signal through a run. A component states it before; the orchestrator judges the
/// greatest value when the run is over, and stops the run where it watches the signal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limit {
    /// Name of the signal, one of the component's own.
    pub signal: String,
    /// Name of its greatest value, a few words in lower case.
    pub quantity: String,
    /// SI unit, `1` if it has none.
    pub unit: String,
    /// Above it results are doubtful.
    pub doubtful: f64,
    /// Above it they are wrong, if they ever are.
    #[serde(default)]
    pub wrong: Option<f64>,
    /// Reason of the limit, a sentence as that of a [`Finding`].
    pub why: String,
    /// See [`Finding::remedy`].
    pub remedy: String,
    /// Quantity by which a run watches the signal: above [`Limit::doubtful`] a checkpoint is made,
    /// above [`Limit::wrong`], or what the manifest gives for the quantity, the run stops. `None`:
    /// nothing watches it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub watch: Option<WatchedQuantity>,
}

impl Limit {
    /// Finding on the greatest value of the signal, first reached at a time [s].
    pub fn judge(&self, greatest: f64, at: f64) -> Finding {
        let Self { quantity, unit, doubtful, wrong, why, remedy, .. } = self;
        let when = format!("over the whole run, first reached at {} s", short(at));
        let why = format!("{when}; {why}");
        Finding::new(quantity, greatest, unit)
            .because(when)
            .wrong_if(wrong.is_some_and(|wrong| greatest > wrong), &why, remedy)
            .doubtful_if(greatest > *doubtful, why, remedy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_verdict_stays() {
        let finding = Finding::new("cells across the smallest grain", 2.667, "1")
            .doubtful_if(true, "few", "a smaller cell")
            .wrong_if(false, "none", "")
            .doubtful_if(true, "again", "");
        assert_eq!((finding.verdict, finding.why.as_str()), (Verdict::Doubtful, "few"));
        let finding = finding.wrong_if(true, "too few", "a much smaller cell");
        assert_eq!((finding.verdict, finding.why.as_str()), (Verdict::Wrong, "too few"));
        assert!(Verdict::Wrong > Verdict::Doubtful && Verdict::Doubtful > Verdict::Ok);
    }

    #[test]
    fn the_greatest_value_of_a_signal_is_judged() {
        let limit = Limit {
            signal: "max_overlap_ratio".into(),
            quantity: "greatest overlap over the radius".into(),
            unit: "1".into(),
            doubtful: 0.1,
            wrong: Some(0.4),
            why: "it is no small overlap".into(),
            remedy: "stiffer contacts".into(),
            watch: None,
        };
        let verdicts = [0.1, 0.2, 0.5].map(|value| limit.judge(value, 2e-3).verdict);
        assert_eq!(verdicts, [Verdict::Ok, Verdict::Doubtful, Verdict::Wrong]);
        let found = limit.judge(0.2, 2e-3);
        assert!(found.why.contains("0.002 s") && found.why.contains("small"), "{}", found.why);
    }

    #[test]
    fn values_are_finite_and_read_back() {
        for value in [f64::INFINITY, f64::NAN, 0.1] {
            let finding = Finding::new("x", value, "m");
            assert!(finding.value.is_finite());
            let text = serde_json::to_string(&finding).unwrap();
            assert_eq!(serde_json::from_str::<Finding>(&text).unwrap(), finding);
        }
    }

    #[test]
    fn values_are_written_short_but_told_apart() {
        assert_eq!(Finding::new("tau", 0.500004, "1").value_text(), "0.500004");
        assert_eq!(Finding::new("step", 1.2e-7, "s").value_text(), "1.2e-7 s");
        assert_eq!(Finding::new("cells", 8.0 / 3.0, "1").value_text(), "2.66667");
    }
}
