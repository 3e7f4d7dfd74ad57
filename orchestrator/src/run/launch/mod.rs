//! Launcher of components, as processes or as threads, and of the threads that carry their lines.

mod lines;
mod own_program;
mod peer;
mod process_tree;
mod program;
mod with_us;

pub use own_program::{Interpreted, interpreted_by, own_words};
pub use peer::{Peer, end_all};
pub use program::{MissingProgram, Program};
pub use with_us::{Signal, end_with_us, this_program};

use crate::registry::built_in;
use lines::{forward_log, forward_replies, write_requests};
use own_program::{command_of, own_command};
use peer::Body;
use std::io::BufReader;
use std::os::unix::process::CommandExt;
use std::process::{Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::time::Duration;
use tremie_messages::start::{INTERFACE_VARIABLE, Reply, Request};
use tremie_messages::{INTERFACE_VERSION, Role};
use tremie_sdk::ControlPipe;
use with_us::ends_by_us;

/// Arrival from a component: a reply, a line, or its end.
#[derive(Debug)]
pub enum ComponentEvent {
    /// A reply on its line.
    Reply(Box<Reply>),
    /// A line on its standard output that is no reply.
    Garbage(String),
    /// A line on its standard error.
    Log(String),
    /// Its line is closed: the process or thread has ended, or is about to.
    Closed,
}

/// Arrival with the index of its component in the list of peers.
pub type PeerEvent = (usize, ComponentEvent);

/// Most arrivals under way. A component that writes faster than the orchestrator reads waits, as it
/// would for a slow terminal.
const EVENT_DEPTH: usize = 1024;

/// Longest wait for the last words of a component whose replies have ended.
const LAST_WORDS: Duration = Duration::from_millis(50);

/// How soon a daemon of Open MPI, of version 4 and of version 5, finds that the host of its launcher is out of reach, and
/// ends with its ranks: after 10 s without a word, and 5 questions of 2 s each. Its own default is 8 minutes.
const KEEP_ALIVE: [(&str, &str); 6] = [
    ("OMPI_MCA_oob_tcp_keepalive_time", "10"),
    ("OMPI_MCA_oob_tcp_keepalive_intvl", "2"),
    ("OMPI_MCA_oob_tcp_keepalive_probes", "5"),
    ("PRTE_MCA_oob_tcp_keepalive_time", "10"),
    ("PRTE_MCA_oob_tcp_keepalive_intvl", "2"),
    ("PRTE_MCA_oob_tcp_keepalive_probes", "5"),
];

/// Starts components and collects their arrivals on one channel.
pub struct Launcher {
    post: SyncSender<PeerEvent>,
    in_process: bool,
}

impl Launcher {
    /// A launcher of processes, or of threads of this one, and the channel of arrivals.
    pub fn new(in_process: bool) -> (Self, Receiver<PeerEvent>) {
        let (post, news) = sync_channel(EVENT_DEPTH);
        (Self { post, in_process }, news)
    }

    /// Starts `program` as component number `index`; behind the words of `launch`, if there are some.
    ///
    /// Must be called from a thread that outlives the run: a component dies with the thread that
    /// started it (parent-death signal).
    ///
    /// # Errors
    /// A sentence, if it cannot be started.
    pub fn start(
        &self,
        index: usize,
        name: &str,
        role: Role,
        (launch, program): (&[String], &Program),
    ) -> Result<Peer, String> {
        let (to, body) = match program {
            Program::BuiltIn(built) if self.in_process => self.start_thread(index, name, built)?,
            Program::BuiltIn(built) => {
                let mut command = own_command();
                command.arg("component").arg(built);
                self.start_process((index, false), command)?
            }
            Program::File(file) if self.in_process => {
                return Err(format!(
                    "{} is a program of its own and cannot run inside this process; leave out --in-process",
                    file.display()
                ));
            }
            Program::File(file) => {
                let command = launched(launch, command_of(file));
                self.start_process((index, !launch.is_empty()), command)?
            }
        };
        Ok(Peer::new(name, role, to, body))
    }

    fn start_process(
        &self,
        (index, is_launched): (usize, bool),
        mut command: Command,
    ) -> Result<(Sender<Request>, Body), String> {
        let shown = format!("{:?}", command.get_program());
        command
            .env(INTERFACE_VARIABLE, INTERFACE_VERSION.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            // Ctrl-C in a terminal goes to the orchestrator alone, which ends the run in order.
            .process_group(0);
        end_with_us(&mut command, Signal::KILL);
        ends_by_us(&mut command);
        let mut child = command.spawn().map_err(|e| format!("cannot start {shown}: {e}"))?;
        let (log_open, log_closed) = channel::<()>();
        if let Some(errors) = child.stderr.take() {
            let post = self.post.clone();
            thread(move || {
                forward_log(BufReader::new(errors), index, &post);
                drop(log_open);
            })?;
        }
        if let Some(output) = child.stdout.take() {
            let post = self.post.clone();
            thread(move || {
                forward_replies(BufReader::new(output), (index, is_launched), &post);
                // Its last words say why it ended, and must come first. Another process that it
                // started may keep the line open.
                let _ = log_closed.recv_timeout(LAST_WORDS);
                let _ = post.send((index, ComponentEvent::Closed));
            })?;
        }
        let (to, requests) = channel();
        if let Some(input) = child.stdin.take() {
            thread(move || write_requests(input, requests))?;
        }
        Ok((to, if is_launched { Body::Launcher(child) } else { Body::Process(child) }))
    }

    fn start_thread(
        &self,
        index: usize,
        name: &str,
        built: &str,
    ) -> Result<(Sender<Request>, Body), String> {
        let component = built_in(built).ok_or_else(|| format!("{built} is not built in"))?;
        let (line, to, from) = ControlPipe::in_memory();
        let (post, errors) = (self.post.clone(), self.post.clone());
        thread(move || {
            for reply in from {
                let _ = post.send((index, ComponentEvent::Reply(Box::new(reply))));
            }
            let _ = post.send((index, ComponentEvent::Closed));
        })?;
        let handle = std::thread::Builder::new()
            .name(name.to_string())
            .spawn(move || {
                if let Err(message) = (component.run)(line) {
                    let _ = errors.send((index, ComponentEvent::Log(message)));
                }
            })
            .map_err(no_thread)?;
        Ok((to, Body::Thread(Some(handle))))
    }
}

/// A command that is started by a program for that, as `mpiexec -n 4`.
fn launched(launch: &[String], command: Command) -> Command {
    let [launcher, words @ ..] = launch else { return command };
    let mut all = Command::new(launcher);
    all.args(words).arg(command.get_program()).args(command.get_args());
    for (name, value) in KEEP_ALIVE.iter().filter(|(name, _)| std::env::var_os(name).is_none()) {
        all.env(name, value);
    }
    all
}

fn thread(work: impl FnOnce() + Send + 'static) -> Result<(), String> {
    std::thread::Builder::new().spawn(work).map(drop).map_err(no_thread)
}

fn no_thread(error: std::io::Error) -> String {
    format!("cannot start a thread: {error}; `ulimit -u` says how many a user may have")
}
