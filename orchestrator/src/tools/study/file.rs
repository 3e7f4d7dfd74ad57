//! The study file as it is written: tables whose keys may all be missing.

use serde::Deserialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use tremie_messages::units::Time;

/// A study file.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StudyDocument {
    /// The manifest that all runs have in common, from the study file's folder.
    pub base: Option<String>,
    /// Runs of each point, with the seeds 1, 2 and so on; without it one, with the manifest's seed.
    pub repeats: Option<u32>,
    /// Axes, of whose rows all combinations are made.
    pub axes: Vec<AxisTable>,
    /// Values of the manifest that all runs change, by key.
    pub set: Map<String, Value>,
    /// Numbers that are taken of each run, by name.
    pub columns: BTreeMap<String, ColumnTable>,
    /// Plots of columns over axes.
    pub plots: Vec<PlotTable>,
    /// What the runs ask of a cluster.
    pub slurm: SlurmTable,
}

/// What the runs of a study ask of a Slurm cluster.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SlurmTable {
    /// Cores of a run; without it, one for each component that computes.
    pub cpus: Option<u32>,
    /// Options of `sbatch`, as `--time=1:00:00`.
    pub options: Vec<String>,
}

/// An axis: one key with its values, or several keys that change together.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AxisTable {
    /// Key of the manifest.
    pub key: Option<String>,
    /// Keys that change together.
    pub keys: Option<Vec<String>>,
    /// Values of the key, one a point.
    pub values: Option<Vec<Value>>,
    /// Values of the keys, one list a point.
    pub rows: Option<Vec<Vec<Value>>>,
    /// Values at even distances.
    pub range: Option<RangeTable>,
    /// Values at even ratios.
    pub log: Option<RangeTable>,
    /// Random values, uniform between two bounds.
    pub random: Option<RangeTable>,
}

/// Values between two bounds.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RangeTable {
    /// The first value, a number or a number with a unit.
    pub from: Option<Value>,
    /// The last value, in the same unit.
    pub to: Option<Value>,
    /// Number of values.
    pub count: Option<u32>,
    /// Seed of random values.
    pub seed: Option<u64>,
}

/// A column: a signal reduced to a number.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ColumnTable {
    /// The signal, `component.name`.
    pub signal: Option<String>,
    /// Kind of the reduction.
    pub of: Option<Reduction>,
    /// Simulated time from which on the signal counts.
    pub from: Option<Time>,
    /// Simulated time up to which it counts.
    pub until: Option<Time>,
    /// Of a crossing: the bound that the signal exceeds, in its SI unit. Of a value at a crossing: the bound
    /// that the signal `when` exceeds.
    pub above: Option<f64>,
    /// The same of a bound that it falls below.
    pub below: Option<f64>,
    /// Of a value at a crossing: the signal that crosses the bound.
    pub when: Option<String>,
}

/// Reduction of a signal to a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Reduction {
    /// The greatest value.
    Max,
    /// The least value.
    Min,
    /// The mean over time.
    Mean,
    /// The last value.
    Last,
    /// Greatest minus least value.
    Range,
    /// The first time at which the signal is above or below a bound [s].
    Crossing,
    /// The value when another signal is first above or below a bound.
    At,
}

/// A plot of a column over a key.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PlotTable {
    /// Key of an axis.
    pub x: Option<String>,
    /// Name of a column.
    pub y: Option<String>,
}
