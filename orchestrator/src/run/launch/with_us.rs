//! When processes end: they do not outlive their parent, and leave it to the parent to end them.

use super::own_program::own_command;
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

/// Makes the process of a command ignore what asks a program to end. A scheduler, or the system as it goes
/// down, asks each process of a run; the orchestrator then ends them in order.
pub fn ends_by_us(command: &mut Command) -> &mut Command {
    // SAFETY: system calls, which are safe between fork and exec. What is ignored stays so beyond exec.
    unsafe {
        command.pre_exec(|| {
            for signal in [libc::SIGTERM, libc::SIGINT, libc::SIGHUP] {
                if libc::signal(signal, libc::SIG_IGN) == libc::SIG_ERR {
                    return Err(std::io::Error::last_os_error());
                }
            }
            Ok(())
        })
    }
}

/// This program again, for a run of its own: it is stopped in order if this one ends before it.
pub fn this_program() -> Command {
    let mut command = own_command();
    end_with_us(&mut command, Signal::INT);
    command
}
