//! Slurm: its commands and its queue, the ends of jobs, and the job of a run.
//!
//! A study gives Slurm arrays of runs (`tools/study/slurm`), `tremie run --slurm` gives it one run: a script in
//! the run's folder (`run_script`), of a size that the manifest tells (`job_size`), and a record of the job
//! (`run_job`), by which any terminal finds it again. On another machine a run in progress is reached by a step
//! in its job (`job_step`).

mod call;
mod job_end;
mod job_size;
mod job_step;
mod queue;
mod run_job;
mod run_script;
mod script_options;

pub use call::{SlurmError, submit};
pub use job_end::{FILES_SEEN, JobEnd};
pub use job_size::JobSize;
pub use job_step::{StepStatuses, step_of};
pub use queue::{JobState, QueuedJob, queued};
pub use run_job::{NotSubmitted, RunJob};
pub use run_script::RunScript;
pub use script_options::{check_option, option_lines, quoted};
