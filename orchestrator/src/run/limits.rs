//! Limits that the system sets to the program.

use crate::manifest::ORCHESTRATOR;
use crate::plan::Plan;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use std::os::fd::BorrowedFd;

/// Files that a process opens for itself.
const OWN: u64 = 20;
/// Files for each channel that it has an end of.
const OF_CHANNEL: u64 = 5;
/// Files of the orchestrator for each component: its lines and its bell.
const OF_COMPONENT: u64 = 8;

/// Raises the limit of open files to the most that the system lets this user have. A file that may
/// grow no longer becomes an error, as a full disk is, and does not end the process. Components
/// inherit the first and do the second themselves.
pub fn widen() {
    let limit = getrlimit(Resource::Nofile);
    if limit.current != limit.maximum {
        // Refused or not: the limit is compared with the need before a run.
        let _ = setrlimit(Resource::Nofile, Rlimit { current: limit.maximum, ..limit });
    }
    // SAFETY: a handler that does nothing may run at any time.
    let _ = unsafe { signal_hook::low_level::register(signal_hook::consts::SIGXFSZ, || {}) };
}

/// Most files that a process may keep open; `None` where there is no limit.
pub fn open_files() -> Option<u64> {
    getrlimit(Resource::Nofile).current
}

/// Makes SIGBUS end this program with a sentence. The signal comes where the program touches shared
/// memory that another program has taken since the check.
pub fn explain_bus_errors() {
    const WORDS: &[u8] =
        b"error: /dev/shm is full: something else has taken the shared memory of this run; make it larger\n";
    // SAFETY: standard error stays open as long as the program runs.
    let errors = unsafe { BorrowedFd::borrow_raw(2) };
    let tell = move || {
        let _ = rustix::io::write(errors, WORDS);
        signal_hook::low_level::exit(1);
    };
    // SAFETY: `write` and `exit` may be called in a signal handler, and the handler does not
    // return.
    let _ = unsafe { signal_hook::low_level::register(signal_hook::consts::SIGBUS, tell) };
}

/// Checks that this program and each component may open as many files as a run of this plan needs.
///
/// # Errors
/// A sentence.
pub fn check_open_files(plan: &Plan, in_process: bool) -> Result<(), String> {
    let Some(limit) = open_files() else { return Ok(()) };
    let need = files(plan, in_process);
    if need <= limit {
        return Ok(());
    }
    Err(format!(
        "a process may open {limit} files, and the run needs about {need}: raise the limit (ulimit -n {})",
        // Rounded up: the count is an estimate.
        need.next_power_of_two().max(1024)
    ))
}

/// Checks that a file may be as large as the largest piece of shared memory, which is a file.
///
/// # Errors
/// A sentence.
pub fn check_file_size(plan: &Plan) -> Result<(), String> {
    let need = plan.largest_channel();
    match getrlimit(Resource::Fsize).current {
        Some(limit) if need > limit => Err(format!(
            "a file may have {limit} bytes, and shared memory of the run needs one of {need}: raise the limit (ulimit -f), \
             or use --in-process"
        )),
        _ => Ok(()),
    }
}

/// Files of the process that has most of them open, about. Threads share those of one process.
fn files(plan: &Plan, in_process: bool) -> u64 {
    let channels = |name: &str| {
        let edges = plan.edges.iter().filter(|edge| edge.from == name || edge.to == name).count();
        let frames =
            plan.frames.iter().filter(|frame| frame.from == name || frame.to == name).count();
        (edges + frames) as u64
    };
    let components = plan.components.len() as u64;
    let of_component =
        plan.components.iter().map(|component| OWN + OF_CHANNEL * (2 + channels(&component.name)));
    let of_all =
        OWN + (OF_COMPONENT + 2 * OF_CHANNEL) * components + OF_CHANNEL * channels(ORCHESTRATOR);
    if in_process { of_all + 8 * components } else { of_component.fold(of_all, u64::max) }
}
