//! Round of questions: every component was asked something, and each answers in its own time.

use crate::run::last_words::LastWords;
use crate::run::launch::{ComponentEvent, Peer, PeerEvent};
use crate::run::startup_log::EarlyLog;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};
use tremie_messages::start::Reply;

/// Interval at which the wait for answers looks at the user's interrupts.
const LOOK: Duration = Duration::from_millis(20);

/// Components that were asked something, and bounds of the wait for their answers.
pub struct Round<'a> {
    /// The components.
    pub peers: &'a mut [Peer],
    /// Channel on which their answers arrive.
    pub news: &'a Receiver<PeerEvent>,
    /// Startup log, for lines of their standard error.
    pub early: &'a mut EarlyLog,
    /// True if no component has answered anything yet.
    pub is_first: bool,
    /// Longest time for all to answer.
    pub within: Duration,
    /// Number of the user's interrupts.
    pub interrupts: &'a AtomicUsize,
}

/// Reason why not every component answered as it should.
#[derive(Debug, PartialEq, Eq)]
pub enum Unanswered {
    /// The user asked for the end.
    Interrupted,
    /// The components that failed, each with a reason.
    Failed(Vec<(usize, String)>),
}

/// Progress of the round.
struct Answers {
    open: Vec<bool>,
    /// The last line that each wrote to standard error.
    words: Vec<LastWords>,
    failed: Vec<(usize, String)>,
}

impl Round<'_> {
    /// Waits until each component has given a reply that `take` accepts.
    ///
    /// # Errors
    /// See [`Unanswered`]. Those that failed do not keep the others from answering.
    pub fn collect(
        &mut self,
        mut take: impl FnMut(usize, Reply) -> Result<(), String>,
    ) -> Result<(), Unanswered> {
        let count = self.peers.len();
        let mut answers = Answers {
            open: vec![true; count],
            words: vec![LastWords::default(); count],
            failed: Vec::new(),
        };
        let deadline = Instant::now() + self.within;
        while answers.open.iter().any(|open| *open) {
            if self.interrupts.load(Ordering::Relaxed) > 0 {
                return Err(Unanswered::Interrupted);
            }
            // Before the answers: a component that never stops talking must not stop the clock.
            let left = deadline.saturating_duration_since(Instant::now());
            match self.news.recv_timeout(left.min(LOOK)) {
                _ if left.is_zero() => answers.give_up_waiting(self.within),
                Ok((index, news)) => self.hear(&mut answers, index, news, &mut take),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => answers.give_up_waiting(self.within),
            }
        }
        if answers.failed.is_empty() { Ok(()) } else { Err(Unanswered::Failed(answers.failed)) }
    }

    fn hear(
        &mut self,
        answers: &mut Answers,
        index: usize,
        news: ComponentEvent,
        take: &mut impl FnMut(usize, Reply) -> Result<(), String>,
    ) {
        match news {
            ComponentEvent::Reply(reply) => match take(index, *reply) {
                Ok(()) => answers.open[index] = false,
                Err(why) => answers.fail(index, why),
            },
            ComponentEvent::Log(text) => {
                answers.words[index].hear(&text, false);
                self.early.push(index, text);
            }
            ComponentEvent::Garbage(text) => answers.fail(
                index,
                format!(
                    "it wrote a line on standard output that is no reply, which belongs on standard error: {text}"
                ),
            ),
            ComponentEvent::Closed => self.hear_end(answers, index),
        }
    }

    /// Takes the end of a component, also of one that had answered: it may end while others are
    /// still at it.
    fn hear_end(&mut self, answers: &mut Answers, index: usize) {
        self.peers[index].closed = true;
        let how = self.peers[index].end(Duration::from_secs(1));
        // A component that has answered with a refusal leaves in good order.
        if !answers.open[index] && (how == "exited with code 0" || how == "ended") {
            return;
        }
        let last = answers.words[index].text();
        let words = match last {
            Some(text) => {
                format!("; its last words: {text}{}", advice(text).unwrap_or_default())
            }
            None if self.is_first && how == "exited with code 0" => {
                format!(" before it said a word; {FORGOTTEN}")
            }
            None => String::new(),
        };
        answers.fail(index, format!("it {how}{words}"));
    }
}

/// What the author of a component may have forgotten.
const FORGOTTEN: &str = "a component ends with tremie.main(ITS_CLASS) in Python, and with a call of the sdk's main in Rust and C";

/// What to do about a component's last words, where that is known.
fn advice(words: &str) -> Option<&'static str> {
    let lacks_module = words.contains("ModuleNotFoundError");
    lacks_module.then_some(
        ". Run it with the `tremie` of the Python package, which knows its own Python (pip install ./interfaces/python), or \
         install the module for `python3`",
    )
}

impl Answers {
    /// Component `index` failed; the first reason counts.
    fn fail(&mut self, index: usize, why: String) {
        self.open[index] = false;
        if !self.failed.iter().any(|(other, _)| *other == index) {
            self.failed.push((index, why));
        }
    }

    fn give_up_waiting(&mut self, within: Duration) {
        let late = (0..self.open.len()).filter(|index| self.open[*index]).collect::<Vec<_>>();
        for index in late {
            let seconds = within.as_secs_f64();
            self.fail(index, format!("it did not answer within {seconds} s (run.start_within)"));
        }
    }
}
