//! Commands in a place of their own, where other file systems can be mounted.

use std::process::{Command, Output};

/// Exit code of a script whose mount was refused.
const REFUSED: i32 = 99;

/// Runs a script where its mounts are seen by nobody else; `None`, said, where mounting is not
/// permitted. `mount` comes first, `script` after it; `$1` and so on are the arguments.
pub fn with_mount<A: AsRef<std::ffi::OsStr>>(
    mount: &str,
    script: &str,
    arguments: &[A],
) -> Option<Output> {
    let script = format!("{mount} || exit {REFUSED}; {script}");
    // Root may mount; others may in a name space in which they are root.
    for way in ["-m", "-rm"] {
        let mut command = Command::new("unshare");
        command.args([way, "sh", "-c", &script, "sh"]).args(arguments);
        let Ok(run) = command.output() else { break };
        let said = String::from_utf8_lossy(&run.stderr);
        if run.status.code() != Some(REFUSED) && !said.starts_with("unshare: ") {
            return Some(run);
        }
    }
    println!("skipped: nothing can be mounted here: {mount}");
    None
}
