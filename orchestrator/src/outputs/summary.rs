//! `summary.json`: ending of a run, its cost, its headline results with their resolution.

use super::signals::Statistics;
use super::{Breach, JudgedFinding, RankShares, ScheduleTiming};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use tremie_messages::start::Fault;

/// Ending of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase", tag = "status")]
pub enum Ending {
    /// All windows were done.
    Completed,
    /// A condition of the manifest was met.
    Stopped {
        /// The condition, with the value that met it.
        reason: String,
    },
    /// The user asked for the end.
    Interrupted,
    /// Something failed.
    Failed {
        /// The first fault.
        fault: Fault,
        /// The watched quantity that passed its limit, if that was it.
        #[serde(skip_serializing_if = "Option::is_none")]
        breach: Option<Box<Breach>>,
    },
}

impl From<Fault> for Ending {
    fn from(fault: Fault) -> Self {
        Self::Failed { fault, breach: None }
    }
}

impl From<Breach> for Ending {
    fn from(breach: Breach) -> Self {
        Self::Failed { fault: breach.fault(), breach: Some(Box::new(breach)) }
    }
}

impl Ending {
    /// Turns a success, a stop or an interrupt into a failure. The first fault counts.
    pub fn spoil(&mut self, fault: Fault) {
        if !matches!(self, Self::Failed { .. }) {
            *self = fault.into();
        }
    }

    /// Exit code of the program.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Completed | Self::Stopped { .. } => 0,
            Self::Failed { .. } => 1,
            Self::Interrupted => 130,
        }
    }
}

/// Sums over the reports of one component.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ComponentTotals {
    /// Wall time in the solver [ns].
    pub compute: u64,
    /// Wall time waiting for peers or credit [ns].
    pub wait: u64,
    /// Wall time sending and bookkeeping [ns].
    pub exchange: u64,
    /// Work done, in the component's unit.
    pub work: u64,
}

/// Work and wall time of a component.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComponentSummary {
    /// Program and version.
    pub program: String,
    /// Wall time in the solver [s].
    pub compute: f64,
    /// Wall time waiting for peers or credit [s].
    pub wait: f64,
    /// Wall time in exchange and bookkeeping [s].
    pub exchange: f64,
    /// Work done.
    pub work: u64,
    /// Unit of the work.
    pub work_unit: String,
    /// Work over time in the solver [1/s].
    pub work_rate: f64,
    /// Resolution of its results.
    pub resolution: BTreeMap<String, f64>,
    /// Doubtful things that it reported at the start.
    pub warnings: Vec<String>,
    /// Where the time of its ranks went, in traced windows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ranks: Option<RankShares>,
}

impl ComponentSummary {
    /// Sums up a component's reports.
    pub fn new(
        description: &tremie_messages::start::Description,
        totals: ComponentTotals,
        ranks: Option<RankShares>,
    ) -> Self {
        let seconds = |nanoseconds: u64| nanoseconds as f64 * 1e-9;
        let compute = seconds(totals.compute);
        Self {
            program: description.program.clone(),
            compute,
            wait: seconds(totals.wait),
            exchange: seconds(totals.exchange),
            work: totals.work,
            work_unit: description.work.clone(),
            work_rate: if compute > 0.0 { totals.work as f64 / compute } else { 0.0 },
            resolution: description.resolution.clone(),
            warnings: description.warnings.clone(),
            ranks,
        }
    }
}

/// The whole of `summary.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Ending of the run.
    #[serde(flatten)]
    pub ending: Ending,
    /// Id of the run, in hexadecimal: names its shared memory.
    pub run: String,
    /// Process ids of the components; empty where they were threads.
    pub processes: BTreeMap<String, u32>,
    /// Last window that all components completed.
    pub windows: u64,
    /// Windows that were planned.
    pub planned_windows: u64,
    /// Window of the newest checkpoint, from which `tremie resume` goes on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub checkpoint: Option<u64>,
    /// Simulated time [s].
    pub simulated_time: f64,
    /// Wall time from the first window to the last [s].
    pub wall_time: f64,
    /// Shares of a window's wall time, and an estimate for the other schedule; `None` without a
    /// fluid and something that moves in it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turns: Option<ScheduleTiming>,
    /// Components that took part in the physics.
    pub components: BTreeMap<String, ComponentSummary>,
    /// Outputs that observers wrote or lost.
    pub observers: BTreeMap<String, String>,
    /// Every signal's extremes and last value.
    pub signals: BTreeMap<String, Statistics>,
    /// Doubtful things about the plan.
    pub warnings: Vec<String>,
    /// Findings known before the run, and findings on its signals.
    pub findings: Vec<JudgedFinding>,
}
