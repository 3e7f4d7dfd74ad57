//! Peer: a started component, requests to it, and its end.

use super::process_tree::end_tree;
use std::os::unix::process::ExitStatusExt;
use std::process::Child;
use std::sync::mpsc::Sender;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tremie_channels::memory::{Room, SHARED_MEMORY};
use tremie_messages::Role;
use tremie_messages::start::Request;

/// A started component.
pub struct Peer {
    /// Its name in the run.
    pub name: String,
    /// Role that it takes.
    pub role: Role,
    /// `None` once the orchestrator has hung up.
    to: Option<Sender<Request>>,
    body: Body,
    /// Its line has closed.
    pub closed: bool,
}

/// Signal that ends a process which touches memory that the system does not have (SIGBUS).
const BUS_ERROR: i32 = signal_hook::consts::SIGBUS;

/// Signal that ends a process at once (SIGKILL).
const KILL: i32 = signal_hook::consts::SIGKILL;

/// Least time for a launcher to end what it has started, on other hosts too.
const LAUNCHER_GRACE: Duration = Duration::from_secs(1);

pub(super) enum Body {
    Process(Child),
    /// A program that has started the component, and more of it.
    Launcher(Child),
    Thread(Option<JoinHandle<()>>),
}

impl Peer {
    pub(super) fn new(name: &str, role: Role, to: Sender<Request>, body: Body) -> Self {
        Self { name: name.to_string(), role, to: Some(to), body, closed: false }
    }

    /// Sends a request; never waits. A component that is gone does not get it; its end arrives by
    /// itself.
    pub fn send(&mut self, request: Request) {
        if let Some(to) = &self.to {
            let _ = to.send(request);
        }
    }

    /// Closes the line to the component, as when the orchestrator is gone.
    pub fn hang_up(&mut self) {
        self.to = None;
    }

    /// Process id, if the component is a process.
    pub fn process_id(&self) -> Option<u32> {
        match &self.body {
            Body::Process(child) | Body::Launcher(child) => Some(child.id()),
            Body::Thread(_) => None,
        }
    }

    /// Tells the component to quit, gives it `grace`, then ends it by force. Returns a few words on
    /// how it ended.
    ///
    /// A thread cannot be ended from outside. A thread that does not end is left behind, and the
    /// words say so.
    pub fn end(&mut self, grace: Duration) -> String {
        self.quit();
        self.end_by(Instant::now() + grace)
    }

    fn quit(&mut self) {
        self.send(Request::Quit {});
        self.hang_up();
    }

    fn end_by(&mut self, deadline: Instant) -> String {
        match &mut self.body {
            Body::Process(child) => reap(child, deadline),
            Body::Launcher(child) => reap(child, deadline.max(Instant::now() + LAUNCHER_GRACE)),
            Body::Thread(handle) => join(handle, deadline),
        }
    }
}

/// Tells all `peers` to quit, gives them `grace` together, then ends the others by force.
pub fn end_all<'a>(peers: impl IntoIterator<Item = &'a mut Peer>, grace: Duration) {
    let mut peers: Vec<&mut Peer> = peers.into_iter().collect();
    // All get the request before any is waited for: they end at the same time.
    peers.iter_mut().for_each(|peer| peer.quit());
    let deadline = Instant::now() + grace;
    for peer in peers {
        peer.end_by(deadline);
    }
}

fn reap(child: &mut Child, deadline: Instant) -> String {
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return describe(status),
            Ok(None) if Instant::now() < deadline => std::thread::sleep(Duration::from_millis(1)),
            Ok(None) => {
                end_tree(child.id());
                // A killed process stays a zombie until it is waited for.
                let _ = child.wait();
                return "did not exit and had to be killed".into();
            }
            Err(error) => return error.to_string(),
        }
    }
}

fn join(handle: &mut Option<JoinHandle<()>>, deadline: Instant) -> String {
    while handle.as_ref().is_some_and(|h| !h.is_finished()) && Instant::now() < deadline {
        std::thread::sleep(Duration::from_millis(1));
    }
    match handle.take() {
        Some(thread) if thread.is_finished() => {
            thread.join().map_or_else(|_| "panicked".into(), |()| "ended".into())
        }
        _ => "did not end".into(),
    }
}

fn describe(status: std::process::ExitStatus) -> String {
    match (status.code(), status.signal()) {
        (Some(code), _) => format!("exited with code {code}"),
        (_, Some(BUS_ERROR)) => {
            let room = Room::ask().map_or(String::new(), |room| {
                format!(", of which {} kB are free", room.free / 1000)
            });
            format!(
                "was ended by signal {BUS_ERROR}, as happens where something else fills {SHARED_MEMORY}{room}: make it larger"
            )
        }
        (_, Some(KILL)) => format!(
            "was ended by signal {KILL}, as a user may do, and the system where its memory runs out (`dmesg` says so)"
        ),
        (_, Some(signal)) => format!("was ended by signal {signal}"),
        _ => "ended".into(),
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        if let Body::Process(child) | Body::Launcher(child) = &mut self.body {
            // The number of one that was waited for may be another process's by now.
            if matches!(child.try_wait(), Ok(None)) {
                end_tree(child.id());
            }
            let _ = child.wait();
        }
    }
}
