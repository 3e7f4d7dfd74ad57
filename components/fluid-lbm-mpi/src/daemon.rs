//! The daemon of a launcher on this host, which has started this rank.

use std::time::Duration;

/// Names of such daemons: Open MPI's of version 4 and of version 5, and MPICH's.
const DAEMONS: [&str; 3] = ["orted", "prted", "hydra_pmi_proxy"];

/// Time for it to end in order.
const GRACE: Duration = Duration::from_secs(1);

/// Ends the daemon that has started this process, and this process with it. It waits for words of a launcher that is out of
/// reach, for minutes, and keeps the other ranks of this host. Does nothing where something else has started this
/// process: the launcher itself, or a scheduler, which ends what it has started.
pub fn end_daemon() {
    // SAFETY: asks for a number; touches no memory.
    let parent = unsafe { libc::getppid() };
    let name = std::fs::read_to_string(format!("/proc/{parent}/comm")).unwrap_or_default();
    if !DAEMONS.contains(&name.trim_end()) {
        return;
    }
    for signal in [libc::SIGTERM, libc::SIGKILL] {
        // SAFETY: sends a signal, to the parent of this process as long as that is there.
        unsafe {
            if libc::getppid() == parent {
                libc::kill(parent, signal);
            }
        }
        std::thread::sleep(GRACE);
    }
}
