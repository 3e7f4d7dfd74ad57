//! Starts components, as processes or as threads, and carries their lines.

use crate::registry::{BuiltIn, built_in};
use std::io::{BufRead, BufReader, Write};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tremie_messages::start::{INTERFACE_VARIABLE, Reply, Request};
use tremie_messages::{INTERFACE_VERSION, Role};
use tremie_sdk::Line;

/// Something that a component said or did.
#[derive(Debug)]
pub enum News {
    /// A reply on its line.
    Reply(Box<Reply>),
    /// A line on its standard output that is no reply.
    Garbage(String),
    /// A line on its standard error.
    Log(String),
    /// Its line is closed: the process or thread has ended, or is about to.
    Closed,
}

/// News of a component, by its index in the list of peers.
pub type Post = (usize, News);

/// What runs a component.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Program {
    /// A component of this executable.
    BuiltIn(&'static str),
    /// Another program.
    File(PathBuf),
}

/// A program that a manifest names could not be found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no component \"{name}\": not built in, and no program at {}", looked.join(", "))]
pub struct MissingProgram {
    /// What the manifest says.
    pub name: String,
    /// Where it was looked for.
    pub looked: Vec<String>,
}

impl Program {
    /// Finds the program that a manifest in `folder` calls `name`: a built-in component; else a path
    /// from the manifest's folder; else a program beside this one; else one on the search path.
    ///
    /// # Errors
    /// [`MissingProgram`], with the places that were looked at.
    pub fn find(name: &str, folder: &Path) -> Result<Self, MissingProgram> {
        if let Some(BuiltIn { name, .. }) = built_in(name) {
            return Ok(Self::BuiltIn(name));
        }
        let mut places = vec![folder.join(name)];
        if !name.contains('/') {
            let own = std::env::current_exe().ok();
            places.extend(own.as_deref().and_then(Path::parent).map(|beside| beside.join(name)));
            let path = std::env::var_os("PATH").unwrap_or_default();
            places.extend(std::env::split_paths(&path).map(|folder| folder.join(name)));
        }
        match places.iter().find(|place| place.is_file()) {
            Some(file) => {
                Ok(Self::File(std::path::absolute(file).unwrap_or_else(|_| file.clone())))
            }
            None => {
                let mut looked: Vec<_> =
                    places.iter().take(2).map(|p| p.display().to_string()).collect();
                if places.len() > 2 {
                    looked.push("the search path".into());
                }
                Err(MissingProgram { name: name.to_string(), looked })
            }
        }
    }
}

/// A started component.
pub struct Peer {
    /// Its name in the run.
    pub name: String,
    /// What it stands for.
    pub role: Role,
    to: ToPeer,
    body: Body,
    /// Whether its line has closed.
    pub closed: bool,
}

enum ToPeer {
    Process(Option<ChildStdin>),
    Thread(Option<Sender<Request>>),
}

enum Body {
    Process(Child),
    Thread(Option<JoinHandle<()>>),
}

/// Starts components and collects their news in one place.
pub struct Launcher {
    post: Sender<Post>,
    in_process: bool,
}

impl Launcher {
    /// A launcher of processes, or of threads of this one, and where news arrive.
    pub fn new(in_process: bool) -> (Self, Receiver<Post>) {
        let (post, news) = channel();
        (Self { post, in_process }, news)
    }

    /// Starts `program` as component number `index`.
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
        program: &Program,
    ) -> Result<Peer, String> {
        let (to, body) = match program {
            Program::BuiltIn(built) if self.in_process => self.start_thread(index, name, built)?,
            Program::BuiltIn(built) => {
                let mut command = Command::new("/proc/self/exe");
                command.arg("component").arg(built);
                self.start_process(index, command)?
            }
            Program::File(file) if self.in_process => {
                return Err(format!(
                    "{} is a program of its own and cannot run inside this process; leave out --in-process",
                    file.display()
                ));
            }
            Program::File(file) => self.start_process(index, Command::new(file))?,
        };
        Ok(Peer { name: name.to_string(), role, to, body, closed: false })
    }

    fn start_process(&self, index: usize, mut command: Command) -> Result<(ToPeer, Body), String> {
        let shown = format!("{:?}", command.get_program());
        command
            .env(INTERFACE_VARIABLE, INTERFACE_VERSION.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            // Ctrl-C in a terminal goes to the orchestrator alone, which ends the run in order.
            .process_group(0);
        // SAFETY: one system call, which is safe between fork and exec.
        unsafe {
            command.pre_exec(|| {
                let kill = rustix::process::Signal::KILL;
                Ok(rustix::process::set_parent_process_death_signal(Some(kill))?)
            });
        }
        let mut child = command.spawn().map_err(|e| format!("cannot start {shown}: {e}"))?;
        if let Some(output) = child.stdout.take() {
            let post = self.post.clone();
            std::thread::spawn(move || forward_replies(BufReader::new(output), index, &post));
        }
        if let Some(errors) = child.stderr.take() {
            let post = self.post.clone();
            std::thread::spawn(move || {
                for line in lines(BufReader::new(errors)) {
                    let _ = post.send((index, News::Log(line)));
                }
            });
        }
        let input = child.stdin.take();
        Ok((ToPeer::Process(input), Body::Process(child)))
    }

    fn start_thread(
        &self,
        index: usize,
        name: &str,
        built: &str,
    ) -> Result<(ToPeer, Body), String> {
        let component = built_in(built).ok_or_else(|| format!("{built} is not built in"))?;
        let (line, to, from) = Line::in_memory();
        let (post, errors) = (self.post.clone(), self.post.clone());
        std::thread::spawn(move || {
            for reply in from {
                let _ = post.send((index, News::Reply(Box::new(reply))));
            }
            let _ = post.send((index, News::Closed));
        });
        let handle = std::thread::Builder::new()
            .name(name.to_string())
            .spawn(move || {
                if let Err(message) = (component.run)(line) {
                    let _ = errors.send((index, News::Log(message)));
                }
            })
            .map_err(|e| format!("cannot start a thread: {e}"))?;
        Ok((ToPeer::Thread(Some(to)), Body::Thread(Some(handle))))
    }
}

/// Lines of text, whatever bytes are in them: a component's pipe must be read to its end.
fn lines(mut from: impl BufRead) -> impl Iterator<Item = String> {
    std::iter::from_fn(move || {
        let mut bytes = Vec::new();
        match from.read_until(b'\n', &mut bytes) {
            Ok(0) | Err(_) => None,
            Ok(_) => Some(String::from_utf8_lossy(&bytes).trim_end().to_string()),
        }
    })
}

fn forward_replies(output: impl BufRead, index: usize, post: &Sender<Post>) {
    for line in lines(output) {
        let news = match serde_json::from_str(&line) {
            Ok(reply) => News::Reply(Box::new(reply)),
            Err(_) => News::Garbage(line),
        };
        let _ = post.send((index, news));
    }
    let _ = post.send((index, News::Closed));
}

impl Peer {
    /// Sends a request. A component that is gone does not hear it; its end is news of its own.
    pub fn send(&mut self, request: Request) {
        match &mut self.to {
            ToPeer::Thread(Some(to)) => {
                let _ = to.send(request);
            }
            ToPeer::Process(Some(input)) => {
                if let Ok(mut text) = serde_json::to_string(&request) {
                    text.push('\n');
                    let _ = input.write_all(text.as_bytes()).and_then(|()| input.flush());
                }
            }
            _ => {}
        }
    }

    /// Closes the line to the component, as when the orchestrator is gone.
    pub fn hang_up(&mut self) {
        self.to = match self.to {
            ToPeer::Process(_) => ToPeer::Process(None),
            ToPeer::Thread(_) => ToPeer::Thread(None),
        };
    }

    /// Process id, if the component is a process.
    pub fn process_id(&self) -> Option<u32> {
        match &self.body {
            Body::Process(child) => Some(child.id()),
            Body::Thread(_) => None,
        }
    }

    /// Tells the component to quit, gives it `grace`, then ends it. Returns how it ended.
    ///
    /// A thread cannot be ended from outside; one that does not heed is left behind, and said so.
    pub fn end(&mut self, grace: Duration) -> String {
        self.send(Request::Quit {});
        self.hang_up();
        let deadline = Instant::now() + grace;
        match &mut self.body {
            Body::Process(child) => reap(child, deadline),
            Body::Thread(handle) => {
                while handle.as_ref().is_some_and(|h| !h.is_finished()) && Instant::now() < deadline
                {
                    std::thread::sleep(Duration::from_millis(1));
                }
                match handle.take() {
                    Some(thread) if thread.is_finished() => {
                        thread.join().map_or_else(|_| "panicked".into(), |()| "ended".into())
                    }
                    _ => "did not end".into(),
                }
            }
        }
    }
}

fn reap(child: &mut Child, deadline: Instant) -> String {
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return describe(status),
            Ok(None) if Instant::now() < deadline => std::thread::sleep(Duration::from_millis(1)),
            Ok(None) => {
                let _ = child.kill();
                return child.wait().map_or_else(|e| e.to_string(), describe);
            }
            Err(error) => return error.to_string(),
        }
    }
}

fn describe(status: std::process::ExitStatus) -> String {
    match (status.code(), status.signal()) {
        (Some(code), _) => format!("exited with code {code}"),
        (_, Some(signal)) => format!("was ended by signal {signal}"),
        _ => "ended".into(),
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        if let Body::Process(child) = &mut self.body {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
