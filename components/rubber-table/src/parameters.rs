//! Settings of the rubber.

use crate::runtime::{Eta, Form, Law};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::Problem;
use tremie_messages::units::{Dashpot, Mass, Velocity};

/// Parameters of seals that follow a table of force and shapes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// Damping nu of `F = h(d) + nu d'`, F the force on the seal, h that of the table, d the
    /// compression.
    pub damping: Dashpot,
    /// Least of the method's number eta in the first pass of a step: `(k + h') dt` of contacts and
    /// table where that is more. The passes after it go by the slope that they measure. It changes
    /// how many passes a step takes, not where it ends.
    pub eta: Dashpot,
    /// A step is settled when a pass changes the compression by less than this times the first
    /// change.
    pub tolerance: f64,
    /// Most passes of a step.
    pub most_passes: u32,
    /// How the load on what touches the seat is counted.
    pub force: ForceForm,
    /// Speed of sound of the fluid, for what it adds to the resistance of a seal: without, a
    /// surface without mass whose loads come an exchange late is unstable, in contact too. A
    /// lattice's speed (cell over time step) is on the safe side.
    pub sound_speed: Velocity,
    /// Mass of fluid that moves with the foot of a seal that is out of contact (default: density
    /// times the foot's area to the power of 3/2).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub added_mass: Option<Mass>,
}

/// How the load on what touches the seat is counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ForceForm {
    /// Its component along the axis, less the pressure around over the projected area: conjugate to
    /// the table's force, also where the surface is curved.
    #[default]
    Axial,
    /// Its pressure, less the pressure around, times the area, as Mutabaruka and Kamrin (2018) have
    /// it.
    Pressure,
}

impl Default for Parameters {
    /// Damping and eta of Mutabaruka and Kamrin, *Comput. Part. Mech.* 5 (2018), Table 5.
    fn default() -> Self {
        let Law { damping, tolerance, most_passes, .. } = Law::default();
        Self {
            damping: Dashpot(damping),
            eta: Dashpot(10.0),
            tolerance,
            most_passes,
            force: ForceForm::default(),
            sound_speed: Velocity(2500.0),
            added_mass: None,
        }
    }
}

impl Parameters {
    /// The law, if all numbers can be meant.
    ///
    /// # Errors
    /// A problem for each that cannot.
    pub fn law(&self) -> Result<Law, Vec<Problem>> {
        let mut problems = Vec::new();
        let mut expect = |right: bool, key: &str, found: String, expected: &str| {
            if !right {
                let text = format!("found {found}, expected {expected}");
                problems.push(Problem::of_parameter(key, text));
            }
        };
        let more = "more than zero";
        let not_less = "zero or more";
        expect(self.damping.0 >= 0.0, "damping", self.damping.to_string(), not_less);
        expect(self.eta.0 > 0.0, "eta", self.eta.to_string(), more);
        let tolerance = self.tolerance;
        let is_small = tolerance > 0.0 && tolerance < 1.0;
        expect(is_small, "tolerance", tolerance.to_string(), "more than zero and less than one");
        let passes = self.most_passes;
        expect(
            (1..=MOST_PASSES).contains(&passes),
            "most_passes",
            passes.to_string(),
            "1 to 10000",
        );
        expect(self.sound_speed.0 > 0.0, "sound_speed", self.sound_speed.to_string(), more);
        if let Some(mass) = self.added_mass {
            expect(mass.0 >= 0.0, "added_mass", mass.to_string(), not_less);
        }
        if problems.is_empty() {
            let (damping, eta) = (self.damping.0, Eta::AtLeast(self.eta.0));
            Ok(Law { damping, eta, tolerance, most_passes: passes })
        } else {
            Err(problems)
        }
    }

    /// The form of the force.
    pub fn form(&self) -> Form {
        match self.force {
            ForceForm::Axial => Form::Axial,
            ForceForm::Pressure => Form::Pressure,
        }
    }
}

/// A run has no more trials in a substep.
const MOST_PASSES: u32 = tremie_messages::schedule::MOST_TRIALS;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_usual_ones_are_right_and_impossible_ones_are_named() {
        assert_eq!(Parameters::default().law().unwrap(), Law::default());
        let read: Parameters = serde_json::from_str(r#"{"damping": "20 kg/s"}"#).unwrap();
        assert_eq!((read.damping.0, read.eta.0), (20.0, 10.0));
        let wrong = Parameters {
            damping: Dashpot(-1.0),
            eta: Dashpot(0.0),
            tolerance: 1.0,
            most_passes: 0,
            sound_speed: Velocity(0.0),
            added_mass: Some(Mass(-1.0)),
            ..Parameters::default()
        };
        let keys: Vec<String> = wrong.law().unwrap_err().into_iter().map(|p| p.key).collect();
        let expected = ["damping", "eta", "tolerance", "most_passes", "sound_speed", "added_mass"];
        assert!(keys.iter().zip(expected).all(|(key, word)| key.ends_with(word)), "{keys:?}");
        assert_eq!(keys.len(), expected.len());
    }
}
