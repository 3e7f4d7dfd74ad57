//! Slurm: its commands, its queue, the options of its scripts and the ends of jobs.

mod call;
mod job_end;
mod queue;
mod script_options;

pub use call::{SlurmError, submit};
pub use job_end::{FILES_SEEN, JobEnd};
pub use queue::{JobState, QueuedJob, queued};
pub use script_options::{check_option, option_lines, quoted};
