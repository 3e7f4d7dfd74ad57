//! A program while it runs: its output, its children, signals to it.

use std::io::{BufRead, BufReader, Lines, Read};
use std::os::unix::fs::MetadataExt;
use std::path::PathBuf;
use std::process::{Child, ChildStdout, Command};
use std::time::{Duration, Instant};

pub use tremie_test_support::until;

/// A running program that is killed if the test fails before it ends.
pub struct Running {
    child: Child,
    lines: Option<Lines<BufReader<ChildStdout>>>,
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Running {
    /// Starts `command`.
    pub fn start(command: &mut Command) -> Self {
        let mut child = command.spawn().unwrap();
        let lines = child.stdout.take().map(|output| BufReader::new(output).lines());
        Self { child, lines }
    }

    /// Process id.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Waits for a line on standard output that holds `word`.
    #[track_caller]
    pub fn says(&mut self, word: &str) -> String {
        let lines = self.lines.as_mut().unwrap();
        let said = lines.map_while(Result::ok).find(|line| line.contains(word));
        said.unwrap_or_else(|| panic!("it ended without a word of {word}"))
    }

    /// Sends a signal, as `-INT`.
    pub fn send(&self, signal: &str) {
        send(self.id(), signal);
    }

    /// True once it has ended.
    pub fn has_ended(&mut self) -> bool {
        self.child.try_wait().unwrap().is_some()
    }

    /// Waits for the end; returns the exit code.
    #[track_caller]
    pub fn wait(&mut self, limit: Duration) -> Option<i32> {
        let begin = Instant::now();
        while begin.elapsed() < limit {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status.code();
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        panic!("it did not end within {limit:?}");
    }

    /// Text on its standard error, once it has ended.
    pub fn errors(&mut self) -> String {
        let mut text = String::new();
        self.child.stderr.take().unwrap().read_to_string(&mut text).unwrap();
        text
    }
}

/// Sends a signal, as `-INT`, to a process.
pub fn send(id: u32, signal: &str) {
    assert!(kill(signal, id).status().unwrap().success());
}

/// The command that sends a signal, as `-INT`: the shell's own, because a small system lacks the program.
pub fn kill(signal: &str, id: u32) -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", "kill $0 $1", signal, &id.to_string()]);
    command
}

/// Child processes of a process.
pub fn children_of(id: u32) -> Vec<u32> {
    let path = format!("/proc/{id}/task/{id}/children");
    let children = std::fs::read_to_string(path).unwrap_or_default();
    children.split_whitespace().map(|id| id.parse().unwrap()).collect()
}

/// The folder with the private folders of all runs.
pub fn places() -> PathBuf {
    let user = std::fs::metadata("/proc/self").unwrap().uid();
    PathBuf::from(format!("/tmp/tremie-{user}"))
}

/// Id of the run whose private folder a process has open; `None` if there is none yet.
pub fn run_of(process: u32) -> Option<String> {
    let links = std::fs::read_dir(format!("/proc/{process}/fd")).ok()?.flatten();
    let mut open = links.filter_map(|link| std::fs::read_link(link.path()).ok());
    open.find_map(|path| {
        let rest = path.strip_prefix(places()).ok()?;
        let name = rest.components().next()?.as_os_str().to_str()?;
        // A name with a dot is that of a folder that is not ready.
        (!name.starts_with('.')).then(|| name.to_string())
    })
}

/// True if a process is there and has not ended.
pub fn is_alive(id: u32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
    // A zombie has ended; somebody only has to collect it.
    !status.is_empty() && !status.contains(") Z ")
}

/// The processor's ticks from the machine's start until now, by which processes count their own.
pub fn now() -> u64 {
    let text = std::fs::read_to_string("/proc/uptime").unwrap();
    let seconds: f64 = text.split(' ').next().unwrap().parse().unwrap();
    // Linux counts a hundred of them a second, whatever the kernel's own rate.
    (100.0 * seconds) as u64
}

/// Start of a process, in ticks from the machine's start; `None` if there is no such process.
pub fn started(id: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    // The name before may hold anything; the state after it is the third field, the start the 22nd.
    status.rsplit(") ").next()?.split(' ').nth(22 - 3)?.parse().ok()
}
