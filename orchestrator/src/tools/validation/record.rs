//! Record of a case: its results, kept in its folder so that the report can be made from all cases
//! at any time.

use super::ValidationError;
use super::case::{Case, CaseRun};
use super::execute::Outcome;
use super::judge::Finding;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The file of a case's results.
pub const FILE: &str = "result.json";

/// Results of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Version of the program.
    pub version: String,
    /// The short form was run.
    pub short: bool,
    /// Results of each run.
    pub runs: Vec<RunRecord>,
}

/// Results of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// The run.
    pub name: String,
    /// Abscissa in a picture over runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<f64>,
    /// Resolution, from the components' descriptions.
    pub resolution: BTreeMap<String, f64>,
    /// Wall time of its windows [s].
    pub wall_time: f64,
    /// Findings of the checks.
    pub findings: Vec<Finding>,
    /// Reason why there is nothing to check: the run failed, or a run that it is compared with
    /// failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failed: Option<String>,
    /// Times and signals that pictures show; not kept.
    #[serde(skip)]
    pub signals: tremie_results::Signals,
}

/// Verdicts on the checks of a kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OfKind {
    /// Number of checks.
    pub checks: usize,
    /// Number of passed checks.
    pub passed: usize,
}

/// Verdicts on checks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Verdicts {
    /// By kind, in the order of [`CheckKind::ALL`](super::case::CheckKind::ALL).
    pub of_kind: [OfKind; 3],
    /// Failures with a stated reason.
    pub standing: usize,
    /// Other failures, of checks and of runs.
    pub failed: usize,
}

impl Verdicts {
    /// Number of checks.
    pub fn checks(&self) -> usize {
        self.of_kind.iter().map(|of_kind| of_kind.checks).sum()
    }

    /// Adds those of another case.
    pub fn join(&mut self, other: &Self) {
        for (own, other) in self.of_kind.iter_mut().zip(other.of_kind) {
            own.checks += other.checks;
            own.passed += other.passed;
        }
        self.standing += other.standing;
        self.failed += other.failed;
    }
}

impl Record {
    /// Nothing has come out yet.
    pub fn new(short: bool) -> Self {
        Self { version: env!("CARGO_PKG_VERSION").into(), short, runs: Vec::new() }
    }

    /// Adds the results of a run.
    pub fn add(&mut self, run: &CaseRun, outcome: Outcome, findings: Vec<Finding>) {
        let Outcome { signals, resolution, wall_time } = outcome;
        let (name, x) = (run.name.clone(), run.x);
        let failed = None;
        self.runs.push(RunRecord { name, x, resolution, wall_time, findings, failed, signals });
    }

    /// Adds a run that failed, for a reason.
    pub fn fail(&mut self, run: &CaseRun, why: &str) {
        self.runs.push(RunRecord {
            name: run.name.clone(),
            x: run.x,
            resolution: BTreeMap::new(),
            wall_time: 0.0,
            findings: Vec::new(),
            failed: Some(why.into()),
            signals: tremie_results::Signals::default(),
        });
    }

    /// True if any run failed.
    pub fn any_failed(&self) -> bool {
        self.runs.iter().any(|run| run.failed.is_some())
    }

    /// Verdicts on its checks; a run that failed is a failure more.
    pub fn verdicts(&self, case: &Case) -> Verdicts {
        let mut verdicts = Verdicts::default();
        for run in &self.runs {
            verdicts.failed += usize::from(run.failed.is_some());
            for finding in &run.findings {
                let check = case.check(&run.name, &finding.check);
                let kind = check.and_then(|check| check.kind).unwrap_or_default();
                let of_kind = &mut verdicts.of_kind[kind as usize];
                of_kind.checks += 1;
                of_kind.passed += usize::from(finding.passed);
                let stands = check.is_some_and(|check| check.stands.is_some());
                match (finding.passed, stands) {
                    (true, _) => {}
                    (false, true) => verdicts.standing += 1,
                    (false, false) => verdicts.failed += 1,
                }
            }
        }
        verdicts
    }

    /// Keeps it in the case's folder.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn keep(&self, case: &Case) -> Result<PathBuf, ValidationError> {
        let path = case.folder.join(FILE);
        let text = serde_json::to_string_pretty(self)
            .map_err(|error| ValidationError::content(&path, error))?;
        std::fs::write(&path, text + "\n").map_err(ValidationError::io(&path))?;
        Ok(path)
    }

    /// Kept results of a case; `None` if it has not been run.
    ///
    /// # Errors
    /// If it is there and cannot be read.
    pub fn kept(folder: &Path) -> Result<Option<Self>, ValidationError> {
        let path = folder.join(FILE);
        if !path.exists() {
            return Ok(None);
        }
        let text = std::fs::read_to_string(&path).map_err(ValidationError::io(&path))?;
        serde_json::from_str(&text)
            .map(Some)
            .map_err(|error| ValidationError::content(&path, error))
    }
}
