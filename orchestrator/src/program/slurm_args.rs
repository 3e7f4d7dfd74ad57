//! Arguments of the commands that give a run to a Slurm cluster.

use crate::tools::slurm::check_option;
use clap::Args;

/// Whether a run is given to Slurm, and how.
#[derive(Debug, Args)]
pub struct SlurmArgs {
    /// Check all here, and give the run to a Slurm cluster as one job; then follow it. Ctrl-C leaves it at Slurm
    #[arg(long)]
    pub slurm: bool,
    /// Option of sbatch for the job, as --time=1:00:00; several times for several
    #[arg(long, value_name = "OPTION", requires = "slurm", allow_hyphen_values = true, value_parser = parse_option)]
    pub slurm_option: Vec<String>,
    /// Give the run to Slurm and do not follow it; `tremie attach OUT` does later
    #[arg(long, requires = "slurm")]
    pub detach: bool,
    /// Only check all, and print the script of the job
    #[arg(long, requires = "slurm", conflicts_with = "detach")]
    pub print: bool,
}

fn parse_option(text: &str) -> Result<String, String> {
    check_option(text).map(|()| text.to_string())
}
