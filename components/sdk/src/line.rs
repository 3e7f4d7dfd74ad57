//! The line between a component and the orchestrator: requests in, replies out, one JSON document
//! a line. Over standard input and output for a process, over memory for a thread.

use std::io::{BufRead, Write};
use std::os::fd::AsFd;
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use tremie_messages::start::{Reply, Request};

/// The line is closed: the orchestrator is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the orchestrator closed the line")]
pub struct Closed;

/// A component's end of the line.
pub struct ControlPipe {
    input: Input,
    replier: Replier,
}

/// The way for replies; threads of a component may share it.
#[derive(Clone)]
pub struct Replier(Arc<Mutex<Output>>);

enum Input {
    Text(Box<dyn BufRead + Send>),
    Memory(mpsc::Receiver<Request>),
}

enum Output {
    Text(Box<dyn Write + Send>),
    Memory(mpsc::Sender<Reply>),
}

impl ControlPipe {
    /// The line of a process: standard input and output.
    ///
    /// Standard output becomes standard error for everything else: what a component prints, or a
    /// library that it calls, is the run's log and no reply.
    pub fn of_process() -> Self {
        Self {
            input: Input::Text(Box::new(std::io::BufReader::new(std::io::stdin()))),
            replier: Replier::over(Output::Text(own_output())),
        }
    }

    /// The line of a thread, and the orchestrator's ends of it.
    pub fn in_memory() -> (Self, mpsc::Sender<Request>, mpsc::Receiver<Reply>) {
        let (to_component, input) = mpsc::channel();
        let (output, from_component) = mpsc::channel();
        let replier = Replier::over(Output::Memory(output));
        let line = Self { input: Input::Memory(input), replier };
        (line, to_component, from_component)
    }

    /// Waits for the next request.
    ///
    /// # Errors
    /// A sentence: the line is closed, or what came is not a request.
    pub fn next_request(&mut self) -> Result<Request, String> {
        match &mut self.input {
            Input::Memory(receiver) => receiver.recv().map_err(|_| Closed.to_string()),
            Input::Text(reader) => {
                let mut text = String::new();
                match reader.read_line(&mut text) {
                    Ok(0) | Err(_) => Err(Closed.to_string()),
                    Ok(_) => serde_json::from_str(&text).map_err(|e| {
                        format!("the orchestrator sent a line that is no request: {e}")
                    }),
                }
            }
        }
    }

    /// Sends a reply.
    ///
    /// # Errors
    /// [`Closed`].
    pub fn reply(&mut self, reply: &Reply) -> Result<(), Closed> {
        self.replier.reply(reply)
    }

    /// The way for replies.
    pub fn replier(&self) -> Replier {
        self.replier.clone()
    }
}

impl Replier {
    fn over(output: Output) -> Self {
        Self(Arc::new(Mutex::new(output)))
    }

    /// Sends a reply.
    ///
    /// # Errors
    /// [`Closed`].
    pub fn reply(&self, reply: &Reply) -> Result<(), Closed> {
        // A thread that panicked wrote a whole line, or the line is closed.
        match &mut *self.0.lock().unwrap_or_else(PoisonError::into_inner) {
            Output::Memory(sender) => sender.send(reply.clone()).map_err(|_| Closed),
            Output::Text(writer) => {
                let mut text = serde_json::to_string(reply).map_err(|_| Closed)?;
                text.push('\n');
                writer.write_all(text.as_bytes()).and_then(|()| writer.flush()).map_err(|_| Closed)
            }
        }
    }
}

/// The process's standard output, for replies alone; without a spare descriptor it stays as it is.
fn own_output() -> Box<dyn Write + Send> {
    let shared = std::io::stdout();
    let Ok(line) = shared.as_fd().try_clone_to_owned() else { return Box::new(shared) };
    match rustix::stdio::dup2_stdout(rustix::stdio::stderr()) {
        Ok(()) => Box::new(std::fs::File::from(line)),
        Err(_) => Box::new(shared),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn over(text: &'static str) -> ControlPipe {
        ControlPipe {
            input: Input::Text(Box::new(text.as_bytes())),
            replier: Replier::over(Output::Text(Box::new(Vec::new()))),
        }
    }

    #[test]
    fn requests_are_read_line_by_line_to_the_end() {
        let mut line = over("{\"quit\":{}}\n{\"quit\":{}}\n");
        assert_eq!(line.next_request(), Ok(Request::Quit {}));
        assert_eq!(line.next_request(), Ok(Request::Quit {}));
        assert_eq!(line.next_request(), Err(Closed.to_string()));
    }

    #[test]
    fn what_is_no_request_is_said() {
        assert!(over("hello\n").next_request().unwrap_err().contains("no request"));
    }

    #[test]
    fn a_line_in_memory_carries_both_ways_and_closes() {
        let (mut line, to, from) = ControlPipe::in_memory();
        to.send(Request::Quit {}).unwrap();
        assert_eq!(line.next_request(), Ok(Request::Quit {}));
        line.reply(&Reply::Ready {}).unwrap();
        assert_eq!(from.recv(), Ok(Reply::Ready {}));
        drop((to, from));
        assert!(line.next_request().is_err());
        assert_eq!(line.reply(&Reply::Ready {}), Err(Closed));
    }
}
