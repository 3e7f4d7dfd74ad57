//! Arguments of the commands to a run in progress.

use super::completion::complete_setting;
use clap::{Args, Subcommand};
use clap_complete::ArgValueCompleter;
use tremie_results::key_value;

/// Commands to a run in progress.
#[derive(Debug, Subcommand)]
pub enum SteerCommand {
    /// List the runs in progress: number, state, windows, outputs.
    Ps {
        /// Print JSON, one document for each run
        #[arg(long)]
        json: bool,
    },
    /// Show a run in progress live, until it ends: windows a second, who waits. Also one at Slurm, by the folder
    /// of its outputs: in the queue, on its node, and how it ended.
    Attach(AttachArgs),
    /// Pause a run in progress between two windows.
    Pause(RunChoice),
    /// Make some windows more, then pause.
    Step {
        /// Number of windows
        #[arg(value_parser = clap::value_parser!(u64).range(1..))]
        windows: u64,
        /// The run.
        #[command(flatten)]
        run: RunChoice,
    },
    /// Go on with a run that is paused.
    Continue(RunChoice),
    /// Change values of a run in progress from the next window on; `tremie resume --set` can change the
    /// same.
    Set {
        /// Values, as run.until="2 s"
        #[arg(required = true, value_name = "KEY=VALUE", value_parser = key_value, add = ArgValueCompleter::new(complete_setting))]
        changes: Vec<(String, String)>,
        /// Number of the run, or folder of its outputs [default: the only one]
        #[arg(long, value_name = "RUN")]
        run: Option<String>,
    },
    /// Make a checkpoint of a run in progress now.
    Checkpoint(RunChoice),
    /// End a run in progress in order, as Ctrl-C does.
    Stop(RunChoice),
}

/// Choice of a run in progress.
#[derive(Debug, Args)]
pub struct RunChoice {
    /// Number of the run, or folder of its outputs [default: the only one]
    pub run: Option<String>,
}

/// Arguments of `tremie attach`.
#[derive(Debug, Args)]
pub struct AttachArgs {
    /// The run.
    #[command(flatten)]
    pub choice: RunChoice,
    /// Print JSON, a document each second, as that of `tremie ps --json`
    #[arg(long)]
    pub json: bool,
}
