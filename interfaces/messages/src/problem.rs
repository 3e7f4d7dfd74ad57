//! Problems of a user's input, in a form that the orchestrator can point at a line of the manifest.

use serde::{Deserialize, Serialize};

/// One fault of a user's input: its place, the values found and expected, a remedy.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Problem {
    /// Path of the key in the manifest, as `scene.fluid.viscosity` or `scene.bodies[2].density`.
    /// A component names its own parameters relative to its table (`cell`), with
    /// [`Problem::of_parameter`]; the orchestrator knows where that table stands.
    pub key: String,
    /// Description of the problem, a sentence without the key.
    pub message: String,
    /// Remedy, a sentence; `None` if there is none known.
    pub help: Option<String>,
}

impl Problem {
    /// A problem of the manifest key `key` (path from the manifest's root).
    pub fn new(key: impl Into<String>, message: impl Into<String>) -> Self {
        Self { key: key.into(), message: message.into(), help: None }
    }

    /// A problem of a component's own parameter `key`.
    pub fn of_parameter(key: &str, message: impl Into<String>) -> Self {
        Self::new(format!("{}{key}", Self::PARAMETER_PREFIX), message)
    }

    /// Says what to do.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Marks keys that are relative to the component's own table.
    pub const PARAMETER_PREFIX: &str = "@";
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.key.trim_start_matches(Self::PARAMETER_PREFIX), self.message)?;
        match &self.help {
            Some(help) => write!(f, " ({help})"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for Problem {}

/// The candidate closest to `word`, if one is close enough to have been meant.
pub fn nearest<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    candidates
        .iter()
        .map(|candidate| (strsim::damerau_levenshtein(word, candidate), *candidate))
        // A longer word may hold more typing errors. `min` breaks ties by the alphabet.
        .filter(|(distance, candidate)| *distance <= 1 + candidate.len() / 3)
        .min()
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_pen_is_near_and_another_word_is_not() {
        let words = ["frames", "compression"];
        assert_eq!(nearest("frame", &words), Some("frames"));
        assert_eq!(nearest("compresion", &words), Some("compression"));
        assert_eq!(nearest("viscosity", &words), None);
    }
}
