//! Processes that a process has started, and those that they have started: all that a launcher leaves on this host.

use rustix::process::{Pid, Signal, kill_process};
use std::collections::HashMap;

/// Most looks for processes that were started while others were stopped.
const LOOKS: usize = 8;

/// Ends a child of this process by force, and all that it and its processes have started.
///
/// All are stopped before any is killed. A stopped process starts no other and collects none, so that no number
/// becomes another process's meanwhile. What a process has left to the system, as a daemon, is not found.
pub(super) fn end_tree(root: u32) {
    let mut stopped: Vec<u32> = Vec::new();
    for _ in 0..LOOKS {
        let children = children();
        let new: Vec<u32> =
            tree_of(root, &children).into_iter().filter(|id| !stopped.contains(id)).collect();
        if new.is_empty() {
            break;
        }
        new.iter().for_each(|&id| send(id, Signal::STOP));
        stopped.extend(new);
    }
    // A process before the one that would collect it.
    stopped.iter().rev().for_each(|&id| send(id, Signal::KILL));
}

fn send(id: u32, signal: Signal) {
    if let Some(id) = i32::try_from(id).ok().and_then(Pid::from_raw) {
        // It may have ended by itself.
        let _ = kill_process(id, signal);
    }
}

/// Children of each process of this host.
fn children() -> HashMap<u32, Vec<u32>> {
    let mut children: HashMap<u32, Vec<u32>> = HashMap::new();
    let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    for id in entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok()) {
        let status = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
        if let Some(parent) = parent_in(&status) {
            children.entry(parent).or_default().push(id);
        }
    }
    children
}

/// Number of the parent in a process's status. The name before it may hold anything.
fn parent_in(status: &str) -> Option<u32> {
    status.rsplit(") ").next()?.split(' ').nth(1)?.parse().ok()
}

/// A process and all below it.
fn tree_of(root: u32, children: &HashMap<u32, Vec<u32>>) -> Vec<u32> {
    let mut tree = vec![root];
    let mut next = 0;
    while let Some(id) = tree.get(next) {
        tree.extend(children.get(id).into_iter().flatten());
        next += 1;
    }
    tree
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};

    #[test]
    fn a_parent_is_found_behind_any_name() {
        assert_eq!(parent_in("12 (a) b) (c) S 7 12 12 0"), Some(7));
        assert_eq!(parent_in(""), None);
    }

    /// A process starts another in a group and a session of its own, as launchers do; both end.
    #[test]
    fn what_a_process_has_started_ends_with_it() {
        let words = "setsid sh -c 'echo $$; sleep 1000; true' & wait";
        let mut child =
            Command::new("sh").args(["-c", words]).stdout(Stdio::piped()).spawn().unwrap();
        let mut output = BufReader::new(child.stdout.take().unwrap());
        let mut id = String::new();
        output.read_line(&mut id).unwrap();
        let inner: u32 = id.trim().parse().unwrap();
        end_tree(child.id());
        assert!(!child.wait().unwrap().success());
        // All that could write there have ended, or this waits for a thousand seconds.
        assert_eq!(output.read_line(&mut id).unwrap(), 0);
        let status = std::fs::read_to_string(format!("/proc/{inner}/stat")).unwrap_or_default();
        assert!(status.is_empty() || status.contains(") Z "), "{status}");
    }
}
