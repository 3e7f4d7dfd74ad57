//! Parent-death signals: processes that do not outlive their parent.

use std::os::unix::process::CommandExt;
use std::process::Command;

pub use rustix::process::Signal;

/// Makes the kernel send a signal to the process of a command when the thread that starts it ends,
/// for whatever reason.
pub fn end_with_us(command: &mut Command, signal: Signal) -> &mut Command {
    // SAFETY: one system call, which is safe between fork and exec.
    unsafe {
        command
            .pre_exec(move || Ok(rustix::process::set_parent_process_death_signal(Some(signal))?))
    }
}

/// This program again, for a run of its own: it is stopped in order if this one ends before it.
pub fn this_program() -> Command {
    let mut command = Command::new("/proc/self/exe");
    end_with_us(&mut command, Signal::INT);
    command
}
