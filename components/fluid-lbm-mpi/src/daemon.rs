//! The daemon of a launcher on this host, which has started this rank.

/// Names of such daemons: Open MPI's of version 4 and of version 5, and MPICH's.
const DAEMONS: [&str; 3] = ["orted", "prted", "hydra_pmi_proxy"];

/// Ends the daemon that has started this process, and with it all ranks of this host, which ask the system for that.
///
/// A daemon that has told its launcher of a failed rank waits for an answer, as long as the system tries to reach one that is
/// out of reach. If it is asked to end in order, it ends the ranks and goes on waiting. Does nothing where something
/// else has started this process: the launcher itself, or a scheduler, which ends what it has started.
pub fn end_daemon() {
    // SAFETY: asks for a number; touches no memory.
    let parent = unsafe { libc::getppid() };
    let name = std::fs::read_to_string(format!("/proc/{parent}/comm")).unwrap_or_default();
    if DAEMONS.contains(&name.trim_end()) {
        // SAFETY: sends a signal. Were the parent gone, this process would be, too.
        unsafe {
            libc::kill(parent, libc::SIGKILL);
        }
    }
}
